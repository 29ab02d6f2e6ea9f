//! What the bound is founded on: assumed times, what was stated, and what is trusted.

use super::style::FAINT;
use super::words::{count, heading, list, more, place};
use crate::columns::{Cell, fitted, left, right};
use crate::format::Extent;
use scanbound_audit::{Assumption, Audit, Fact, Minor, SolvedBound, Status};
use scanbound_base::time_text::{about, at_most};
use scanbound_ir::range_or_values;

/// So many of the instructions that write a word are named.
const MAX_WRITERS: usize = 4;

pub(super) fn assumed(audit: &Audit, extent: Extent) -> String {
    let table = &audit.table;
    if table.assumed.is_empty() {
        return String::new();
    }
    let open = match audit.is_settled() {
        true => String::new(),
        false => format!(" at most, with the {} that the search left open", about(audit.open())),
    };
    let title = format!(
        "Assumed times: {} of the bound{open}; the part of each in the bound",
        audit.assumed_share()
    );
    let rows: Vec<Vec<Cell>> = table
        .assumed
        .iter()
        .take(extent.values)
        .map(|one| {
            let used = match one.count {
                0 if one.row == "@factor" => {
                    "on the whole scan: what it adds to other times".to_owned()
                }
                0 => "a term of the scan".to_owned(),
                1 => "once in the program".to_owned(),
                n => format!("{n} times in the program"),
            };
            let class = if one.by_class {
                format!(", priced by its class {}", one.row)
            } else {
                String::new()
            };
            vec![left(&one.name), right(about(one.part)), left(used + &class).styled(FAINT)]
        })
        .collect();
    heading(&title, extent)
        + &fitted(2, &rows, extent.width)
        + &more(table.assumed.len(), extent.values, "assumed time", "assumed times")
}

/// The words that are trusted, what for, and which scans that leaves out.
pub(super) fn trusted(audit: &Audit, extent: Extent) -> String {
    let shown = audit.assumptions.iter().take(extent.values);
    let mut lines: Vec<String> = shown.map(|one| assumption(audit, one)).collect();
    if let Some(rest) = audit.assumptions.len().checked_sub(extent.values).filter(|&rest| rest > 0)
    {
        lines.push(format!(
            "and {} (-v)",
            count(rest, "word or set of relays", "words or sets of relays")
        ));
    }
    if let Some(Minor { count: n, without }) = audit.what_if.as_ref().and_then(|one| one.minor) {
        let others = if lines.is_empty() { "" } else { "further " };
        let words = count(n, "word or set of relays", "words or sets of relays");
        lines.push(format!(
            "{others}{words}, none of which lowers the bound by 0.1 % alone: without all of them the bound is {}",
            bound_without(without)
        ));
    }
    if !lines.is_empty() && audit.what_if.is_none() {
        lines.push("--what-if solves what each is worth: the bound without it".to_owned());
    }
    if !lines.is_empty() {
        lines.push(
            "not covered: the first scans after a download or a change in RUN, when memory may hold anything; what a CPU's parameters latch or give another value at power-up: name it in [external]"
                .to_owned(),
        );
    }
    let title =
        "What is trusted: only the program writes these (--trust none does without)".to_owned();
    let order = if audit.what_if.is_some() { ", the largest time first" } else { "" };
    list(&(title + order), &lines, extent)
}

/// What is trusted of a word or of relays, and the lines that write them.
fn assumption(audit: &Audit, one: &Assumption) -> String {
    let mut by = one
        .written
        .iter()
        .take(MAX_WRITERS)
        .map(|(at, instruction)| format!("`{instruction}` ({})", place(audit, *at)))
        .collect::<Vec<_>>()
        .join(", ");
    if one.written.len() > MAX_WRITERS {
        by += &format!(" and {} more", one.written.len() - MAX_WRITERS);
    }
    let without =
        one.without.map(|bound| format!("; without that the bound is {}", bound_without(bound)));
    let without = without.unwrap_or_default();
    match one.range {
        Some(range) => {
            let (name, range) = (one.name(), range_or_values(range, &one.values));
            format!("{name} is {range} whenever a scan starts: written by {by}{without}")
        }
        None if one.most == 0 => {
            let names = one.name();
            format!(
                "in the first scan, because memory was cleared before it, these are off: {names}: written by {by}{without}"
            )
        }
        None if one.most != 1 => {
            let names = one.name();
            format!("{names} are never all on when a scan starts: written by {by}{without}")
        }
        None => {
            let names = one.name();
            format!("of {names} no two are on when a scan starts: written by {by}{without}")
        }
    }
}

fn bound_without(bound: SolvedBound) -> String {
    at_most(bound.upper) + bound.note()
}

/// What was stated, and whether the program keeps it.
pub(super) fn facts(audit: &Audit) -> Vec<String> {
    let told = |fact: &Fact| match fact.status() {
        Status::Kept => match fact {
            Fact::Exclusive { .. } => format!("{fact}: the program never leaves two of them on"),
            _ => format!("{fact}: the program writes nothing else into it"),
        },
        Status::Unproved => format!("{fact}: nothing here proves it"),
        Status::Stated => fact.to_string(),
    };
    audit.facts.iter().map(told).collect()
}
