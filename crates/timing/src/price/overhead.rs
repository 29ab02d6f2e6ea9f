//! What a scan is charged besides its instructions.

use crate::table::{Evidence, Row, Table};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;

/// One kind of overhead: a time that each scan takes in addition to its instructions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OverheadTerm {
    /// The name of the term in reports.
    pub name: String,
    /// The time, including the table's factor.
    pub time: Picos,
    /// The evidence for the row of the table that gives the time.
    pub evidence: Evidence,
    /// How the time was calculated.
    pub why: String,
}

/// The time of an overhead row, multiplied by `times` and the table's factor. `Err` if it is too large.
pub(super) fn charged(table: &Table, row: &Row, times: u64) -> Result<Picos, Vec<Diagnostic>> {
    let time = row.on.0.checked_mul(times).and_then(|time| table.scaled(Picos(time)));
    time.ok_or_else(|| {
        let message = format!("the time of {} in one scan is too large", row.name);
        let help = "check the times in the table";
        vec![Diagnostic::file(Code::NoTime, &row.table, message, help)]
    })
}
