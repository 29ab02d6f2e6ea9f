//! The longest scan that was found: under which conditions, and how a PLC comes to it.

use super::words::{capped, count, heading, more, named, wrapped};
use crate::columns::{Cell, fitted, left, right};
use crate::format::{Detail, Extent};
use scanbound_audit::{Audit, FreeValue, Value};
use scanbound_base::time::Picos;
use scanbound_base::time_text::{about, at_least};
use std::cmp::Reverse;

/// The conditions of the longest scan found, those first that add most to it.
pub(super) fn conditions(audit: &Audit, extent: Extent) -> String {
    let mut matter: Vec<&FreeValue> = audit.witness.iter().filter(|free| free.matters).collect();
    if matter.is_empty() {
        return String::new();
    }
    matter.sort_by_key(|free| Reverse(free.worth));
    let found = audit.possible();
    let which = match audit.proved() == Some(found) {
        true => "The longest scan",
        false => "The longest scan found",
    };
    let weighed = match audit.weighed == found {
        true => "it".to_owned(),
        false => {
            format!("the model's scan with the same start ({})", about(audit.weighed))
        }
    };
    let title = format!(
        "{which} ({}) and its conditions, by what {weighed} would lose without each",
        at_least(found)
    );
    let row = |free: &&FreeValue| -> Vec<Cell> {
        let name = named(&free.name, &free.comment);
        let state = match free.value {
            Value::Word(number) => format!("{name} = {number}"),
            Value::Bit(true) => format!("{name} is on"),
            Value::Bit(false) => format!("{name} is off"),
        };
        let when = if free.at_start { "" } else { " (while the scan runs)" };
        let worth = match free.worth {
            Picos::ZERO => "-".to_owned(),
            worth => about(worth),
        };
        vec![right(worth), left(format!("{state}{when}"))]
    };
    let shown =
        if extent.detail == Detail::Full { matter.len() } else { extent.top.min(matter.len()) };
    if shown == 0 {
        return String::new();
    }
    let rows: Vec<Vec<Cell>> = matter.iter().take(shown).map(row).collect();
    let free = match audit.witness.len() - matter.len() {
        0 => String::new(),
        rest => format!("  {} may be anything\n", count(rest, "other value", "other values")),
    };
    heading(&title, extent)
        + &fitted(2, &rows, extent.width)
        + &more(matter.len(), shown, "condition that adds no more", "conditions that add no more")
        + &free
}

/// The run from power-up to the scan, if one was found.
pub(super) fn run(audit: &Audit, extent: Extent) -> String {
    let scans = &audit.witness_run;
    if scans.is_empty() {
        return String::new();
    }
    let mut text = heading("How a PLC with cleared memory comes to it, from power-up", extent);
    let mut before = 0;
    for scan in scans {
        let label = match scan.number - before {
            1 => format!("scan {:<2}", scan.number),
            later => format!("{} scans later", thousands(later)),
        };
        before = scan.number;
        let inputs = scan.inputs.iter().map(|(name, value)| match value {
            Value::Word(number) => format!("{name} = {number}"),
            Value::Bit(_) => name.clone(),
        });
        let inputs: Vec<String> = inputs.collect();
        let inputs = match inputs.is_empty() {
            true => vec!["none on".to_owned()],
            false => capped(&inputs, extent.values),
        };
        let title = format!("  {label} {}  inputs  ", at_least(scan.took));
        text += &wrapped(&title, &inputs, extent);
    }
    text
}

/// A number with its thousands apart.
fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let places = digits.char_indices().flat_map(|(at, digit)| {
        let comma = at > 0 && (digits.len() - at).is_multiple_of(3);
        comma.then_some(',').into_iter().chain([digit])
    });
    places.collect()
}
