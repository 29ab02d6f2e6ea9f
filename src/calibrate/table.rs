//! The timing table that a calibration gives.

use super::fit::{Fit, Found, Interval, MARGIN};
use super::plan::Plan;
use crate::base::time::Picos;

/// What a table says of its origin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// The day, as `2026-11-21`.
    pub date: String,
    /// The CPU's serial number; may be empty.
    pub serial: String,
}

/// The time with the margin for data.
fn with_margin(time: Picos, by_data: bool) -> Picos {
    let percent = if by_data { 100 + MARGIN } else { 100 };
    let whole = u128::from(time.0) * u128::from(percent);
    Picos(u64::try_from(whole.div_ceil(100)).unwrap_or(u64::MAX))
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// The table as a file: the upper ends of what was found, over the built-in table.
#[must_use]
pub fn write(plan: &Plan, fit: &Fit, origin: &Origin) -> String {
    let mut text = "instruction,on_us,off_us,per_unit_us,unit,evidence,source\n".to_owned();
    text += &format!("@base,{},,,,,\n", plan.table);
    text += &format!("@title,{},,,,,\n", quoted(&format!("{}, measured", plan.cpu)));
    text += &format!("@date,{},,,,,\n", origin.date);
    text += "@note,\"measured is not proved: the table holds the upper ends of what was measured\",,,,,\n";
    for found in &fit.rows {
        text += &row(plan, found, origin);
    }
    text
}

fn row(plan: &Plan, found: &Found, origin: &Origin) -> String {
    let Found { row, on, off, per_unit, by_data, lines, repeated: [copies, loops] } = found;
    let us = |time: &Interval| with_margin(time.high, *by_data).us_text();
    let serial = match origin.serial.as_str() {
        "" => String::new(),
        serial => format!(" serial {serial}"),
    };
    let margin =
        if *by_data { format!(", {MARGIN} % added for other data") } else { String::new() };
    let source = format!(
        "{} on {}{serial}: {} to {} us on, {} to {} us off; {copies} copies {loops} times in {} scans{margin}; {}",
        origin.date,
        plan.cpu,
        on.low.us_text(),
        on.high.us_text(),
        off.low.us_text(),
        off.high.us_text(),
        plan.scans,
        lines.join("; "),
    );
    let units = per_unit.as_ref().map(&us).unwrap_or_default();
    let unit = if per_unit.is_some() { "unit" } else { "" };
    let off = with_margin(off.high, false).us_text();
    format!("{},{},{off},{units},{unit},measured,{}\n", quoted(row), us(on), quoted(&source))
}
