//! Prints a chart in the textual form of IEC 61131-3.

use super::{Chart, Target};
use crate::show;
use crate::{Body, Named};
use std::fmt::Write;

/// The text of a chart, with the actions that are given and those written in action blocks. Only actions with
/// statements are printed.
#[must_use]
pub fn chart(chart: &Chart, actions: &[Named]) -> String {
    let mut text = String::new();
    for step in &chart.steps {
        let word = if step.initial { "INITIAL_STEP" } else { "STEP" };
        let _ = writeln!(text, "  {word} {}:", step.name);
        for block in &step.blocks {
            let time = block.time.as_ref().map(|time| format!(", {}", show::expr(time)));
            let (qualifier, time) = (block.qualifier.name(), time.unwrap_or_default());
            let _ = writeln!(text, "    {}({qualifier}{time});", block.target.name());
        }
        text += "  END_STEP\n";
    }
    for transition in &chart.transitions {
        let names = |steps: &[usize]| {
            let names: Vec<&str> =
                steps.iter().map(|&step| chart.steps[step].name.as_str()).collect();
            if names.len() == 1 { names[0].to_owned() } else { format!("({})", names.join(", ")) }
        };
        let name = transition.name.as_ref().map(|name| format!("{name} ")).unwrap_or_default();
        let (from, to) = (names(&transition.from), names(&transition.to));
        let _ = writeln!(text, "  TRANSITION {name}FROM {from} TO {to}");
        let _ = writeln!(text, "    := {};\n  END_TRANSITION", show::expr(&transition.condition));
    }
    for action in actions {
        write_action(&mut text, &action.name, &action.body);
    }
    for block in chart.steps.iter().flat_map(|step| &step.blocks) {
        if let Target::Inline(name, body) = &block.target {
            write_action(&mut text, name, body);
        }
    }
    text
}

fn write_action(text: &mut String, name: &str, body: &Body) {
    if let Body::Code(_, statements) = body {
        let _ = writeln!(text, "  ACTION {name}:");
        *text += &show::statements(statements, 2);
        *text += "  END_ACTION\n";
    }
}
