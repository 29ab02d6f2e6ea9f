//! The ladder as the page's script reads it: lists without names, since there are tens of thousands of them.

use scanbound_audit::Audit;
use scanbound_audit::ladder::{DrawnRung, Notes};
use scanbound_ir::ladder::{Drawing, Element, Path, Symbol};
use serde_json::{Value, json};

/// A list for each rung: number, file, line, elements, paths.
pub(super) fn ladder(audit: &Audit) -> Vec<Value> {
    audit.ladder.iter().flat_map(|ladder| &ladder.rungs).map(rung).collect()
}

fn rung(drawn: &DrawnRung) -> Value {
    let rung = &drawn.rung;
    let elements: Vec<Value> =
        rung.elements.iter().zip(&drawn.notes).map(|(one, notes)| element(one, notes)).collect();
    let paths: Vec<Value> = rung.paths.iter().map(path).collect();
    json!([rung.number, rung.file, rung.elements.first().map(|one| one.at.line), elements, paths])
}

/// Symbol, text, label, line, comments, executions that have a time, those reached, those that run, part in the bound,
/// most.
fn element(one: &Element, notes: &Notes) -> Value {
    let uses = notes.uses;
    json!([
        symbol(one.symbol),
        &*one.text,
        one.label(),
        one.at.line,
        notes.comments,
        uses.timed,
        uses.reached,
        uses.runs,
        uses.share.0,
        uses.most.0
    ])
}

fn symbol(symbol: Symbol) -> &'static str {
    match symbol {
        Symbol::Contact => "no",
        Symbol::Negated => "nc",
        Symbol::Condition => "if",
        Symbol::Coil => "out",
        Symbol::Set => "set",
        Symbol::Reset => "rst",
        Symbol::Box => "box",
        Symbol::Link => "link",
    }
}

/// From where, the conditions, what is driven.
fn path(path: &Path) -> Value {
    json!([path.from, drawing(&path.conditions), path.driven])
}

/// An element's number, or a list: 0 for a series, 1 for branches, then the drawings.
fn drawing(drawn: &Drawing) -> Value {
    let list = |kind: u8, all: &[Drawing]| {
        Value::from_iter([Value::from(kind)].into_iter().chain(all.iter().map(drawing)))
    };
    match drawn {
        Drawing::One(element) => Value::from(*element),
        Drawing::Series(all) => list(0, all),
        Drawing::Parallel(all) => list(1, all),
    }
}
