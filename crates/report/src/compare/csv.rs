//! A comparison as CSV: a row a scan, for spreadsheets.

use scanbound_measured::Comparison;
use std::fmt::Write as _;

/// Each scan with its time, the bound, and whether it lies above. The column of times is called what they are.
#[must_use]
pub fn render(found: &Comparison) -> String {
    let kind = if found.measured.emulated { "emulated" } else { "measured" };
    let bound = found.bounds.upper;
    let mut text = format!("scan,{kind}_us,bound_us,above\n");
    for (scan, time) in found.measured.times.iter().enumerate() {
        let above = u8::from(*time > bound);
        let _ = writeln!(text, "{},{},{},{above}", scan + 1, time.us_text(), bound.us_text());
    }
    text
}
