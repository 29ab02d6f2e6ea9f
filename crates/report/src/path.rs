//! The path of the worst scan through a program that does not run everything once, and its endless loops, as text.

use super::columns::{Cell, columns, left, right};
use scanbound_audit::{Audit, LoopUse};
use scanbound_base::time::Picos;

/// The loops that a scan can go round for ever; empty if there are none.
pub fn loops(audit: &Audit) -> String {
    let line = |one: &LoopUse| {
        format!(
            "  {}:{} `{}` to line {} `{}`\n",
            one.from.of(&audit.files),
            one.from.line,
            one.begins,
            one.to.line,
            one.ends
        )
    };
    match audit.unbounded.as_slice() {
        [] => String::new(),
        loops => {
            let lines: String = loops.iter().map(line).collect();
            let title = match audit.is_endless() {
                true => "Loops that can run without end in one scan",
                false => "Loops of which nothing is known that ends them",
            };
            format!("\n{title}\n{lines}")
        }
    }
}

/// The path instruction by instruction; empty if the audit has none.
pub fn path(audit: &Audit) -> String {
    if audit.path.is_empty() {
        return String::new();
    }
    let mut via: &[String] = &[];
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for step in &audit.path {
        if step.via != via {
            via = &step.via;
            let name = via.last().map_or("back in the main routine", String::as_str);
            rows.push(vec![left(""), left(""), left(name)]);
        }
        rows.push(vec![
            right(us(step.cost)),
            left(format!("line {}", step.at.line)),
            left(&*step.instruction),
            left(if step.held { "" } else { "no" }),
        ]);
    }
    format!("\nIts path through the program\n{}", columns(2, &rows))
}

fn us(time: Picos) -> String {
    format!("{} us", time.us_text())
}
