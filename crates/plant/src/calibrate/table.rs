//! Writes the timing table of a calibration.

use super::fit::{Fit, Interval, MARGIN, RowTimes};
use super::forms::ENDS;
use super::plan::Plan;
use scanbound_base::time::Picos;
use scanbound_timing::table::Table;

/// The origin of the times, for the table.
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

/// The table as a file: the upper ends of the measured intervals, as an amendment of the built-in table. `fitted` says
/// whether the measured scan contains the refresh of inputs and outputs, because the modules are unchanged.
#[must_use]
pub fn write(plan: &Plan, fit: &Fit, origin: &Origin, fitted: bool) -> String {
    let mut text = "instruction,on_us,off_us,per_unit_us,unit,evidence,source\n".to_owned();
    text += &format!("@base,{},,,,,\n", plan.table);
    text += &format!("@title,{},,,,,\n", quoted(&format!("{}, measured", plan.cpu)));
    text += &format!("@date,{},,,,,\n", origin.date);
    text += "@note,\"measured is not proved: the table contains the upper ends of the measured intervals\",,,,,\n";
    text += &scan_rows(plan, fit, origin, fitted);
    for found in &fit.rows {
        text += &row(plan, found, origin);
    }
    text
}

/// The rows for the overhead of a scan: all of it is contained in the empty scan.
fn scan_rows(plan: &Plan, fit: &Fit, origin: &Origin, fitted: bool) -> String {
    let (Some(base), Some(empty)) = (Table::builtin(&plan.table), fit.empty) else {
        return String::new();
    };
    let on = |name: &str| base.row(name).map_or(0, |row| row.on.0);
    let [low, high] = [empty.low, empty.high].map(Picos::us_text);
    let measured = format!(
        "{}: an empty scan takes {low} to {high} us; this contains the start of one program, its END, the refresh of the \
         installed I/O modules, and the latch processing set in the CPU's parameters",
        measured_on(plan, origin)
    );
    let mut text = format!("@end,{high},,,,measured,{}\n", quoted(&measured));
    let contained = |name: &str| format!("{name},0,,,,measured,contained in @end\n");
    // Each further program also has an END.
    let further = Picos(on("@program") + on("END").max(on("FEND"))).us_text();
    text += &contained("@program");
    text += &format!(
        "@further-program,{further},,,,assumed,the start and the END of a program as assumed\n"
    );
    for end in ENDS.iter().filter(|name| base.row(name).is_some()) {
        text += &contained(end);
    }
    for row in base.rows() {
        let refresh = ["@input", "@output"].iter().any(|kind| row.name.starts_with(kind))
            && !row.name.ends_with("-delay");
        if row.name == "@end:latch" || (fitted && refresh) {
            text += &contained(&row.name);
        }
    }
    if fitted {
        text += "@note,\"@end contains the refresh of the modules present during the measurement: if they change, measure again\",,,,,\n";
    }
    text
}

/// When and where it was measured.
fn measured_on(plan: &Plan, origin: &Origin) -> String {
    let serial = match origin.serial.as_str() {
        "" => String::new(),
        serial => format!(" serial {serial}"),
    };
    format!("{} on {}{serial}", origin.date, plan.cpu)
}

fn row(plan: &Plan, found: &RowTimes, origin: &Origin) -> String {
    let RowTimes { row, on, off, per_unit, by_data, lines, repeated: [copies, loops] } = found;
    let us = |time: &Interval| with_margin(time.high, *by_data).us_text();
    let margin =
        if *by_data { format!(", {MARGIN} % added for other data") } else { String::new() };
    let source = format!(
        "{}: {} to {} us on, {} to {} us off; {copies} copies {loops} times in {} scans{margin}; {}",
        measured_on(plan, origin),
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
