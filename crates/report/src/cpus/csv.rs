//! One program by every table of its family as CSV: a row a table, the highest bound first.

use crate::sheet::Sheet;
use scanbound_audit::Share;
use scanbound_audit::cpus::CpuComparison;
use std::io::{self, Write};

const HEADS: [&str; 10] = [
    "table",
    "cpus",
    "upper_us",
    "lower_us",
    "upper_with_all_points_us",
    "limit_us",
    "of_limit_percent",
    "assumed_percent",
    "verdict",
    "without_time",
];

/// Writes the choice.
///
/// # Errors
/// Where what is written to takes no more.
pub fn write(choice: &CpuComparison, out: &mut dyn Write) -> io::Result<()> {
    let mut sheet = Sheet::new(out)?;
    sheet.put(&HEADS)?;
    for one in &choice.candidates {
        let found = one.outcome.as_ref().ok();
        let check = found.and_then(|found| found.check.as_ref());
        let us = |time: Option<scanbound_base::time::Picos>| {
            time.map_or(String::new(), |time| time.us_text())
        };
        let faults = one.outcome.as_ref().err().into_iter().flatten();
        let faults: Vec<&str> = faults.map(|fault| fault.message.as_str()).collect();
        let share = check.map(|check| percent(Share::of(check.upper, check.limit)));
        sheet.put(&[
            one.table.clone(),
            one.cpus.join(" "),
            us(found.and_then(|found| found.upper)),
            us(found.map(|found| found.lower)),
            us(found.and_then(|found| found.all_points)),
            us(check.map(|check| check.limit)),
            share.unwrap_or_default(),
            found.map(|found| percent(found.assumed)).unwrap_or_default(),
            check.map(|check| check.verdict.name()).unwrap_or_default().to_owned(),
            faults.join("; "),
        ])?;
    }
    sheet.finish()
}

/// A share as a number of percent.
fn percent(share: Share) -> String {
    format!("{}.{}", share.0 / 10, share.0 % 10)
}
