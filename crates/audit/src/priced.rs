//! The second stage: every instruction has its time.

use super::failure::Failure;
use super::request::{Progress, Request};
use super::stated;
use super::understood::Understood;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_ir::Program;
use scanbound_timing::price::{self, Prices};
use scanbound_timing::table::{Evidence, Factor, Override, Table};
use std::collections::BTreeSet;

/// A decoded program with the times of its instructions.
pub struct Priced {
    pub program: Program,
    pub table: Table,
    pub prices: Prices,
    /// All warnings. Those of the request come first.
    pub warnings: Vec<Diagnostic>,
}

impl Priced {
    /// Prices the program, and warns of stated times and facts that have no effect. Removes what later stages do not
    /// need: timing keys without counted units, and ranges of words that the program does not use.
    pub fn of(understood: Understood, request: &Request<'_>) -> Result<Priced, Failure> {
        (request.progress)(Progress::Stage("pricing"));
        let Understood { mut program, table, warnings, .. } = understood;
        let prices = price::price(&program, &table, request.facts)?;
        let unused = unused_times(request.times, &program, &prices);
        let odd = stated::questionable(&program, &table, request.facts);
        stated::forget_unnamed(&mut program);
        let warnings = [request.warnings, &warnings, &unused, &odd].concat();
        if request.strict_times {
            refuse_assumed(&program, &prices)?;
        }
        // After pricing, later stages need only the words that count units.
        for instruction in &mut program.instructions {
            instruction.timing = instruction.timing.take().filter(|key| key.counted().is_some());
        }
        Ok(Priced { program, table, prices, warnings })
    }
}

/// Warns of stated times for instructions that the program does not have, perhaps because of a typing error, and of
/// those that do not apply to all instructions of the name because the table's rows take precedence for some.
fn unused_times(times: &[Override], program: &Program, prices: &Prices) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    for Override { name, .. } in times {
        let stated = |row: &str| times.iter().any(|time| time.name.eq_ignore_ascii_case(row));
        let (mut used, mut others) = (false, BTreeSet::new());
        for (instruction, price) in program.instructions.iter().zip(&prices.instructions) {
            let Some(price) = price else { continue };
            used |= price.row.split(" + ").any(|row| row.eq_ignore_ascii_case(name));
            let row = price.row.split(" + ").next().unwrap_or_default();
            let names = instruction.timing.iter().flat_map(|key| &key.names);
            if !stated(row) && names.into_iter().any(|other| other.eq_ignore_ascii_case(name)) {
                others.insert(row);
            }
        }
        let rows = others.into_iter().collect::<Vec<_>>().join(", ");
        let (message, help) = match (used, rows.is_empty()) {
            (true, true) => continue,
            (_, false) => (
                format!(
                    "--time {name} is not used for the table rows {rows}: the times of these rows are larger, or come from your own table"
                ),
                "to change the times of these rows too, give a --time for each row",
            ),
            (false, true) => (
                format!(
                    "--time {name}: no instruction of the program takes its time from a row of this name"
                ),
                "give the name of a row of the timing table, as reports show it, such as MOV or OUT:T",
            ),
        };
        warnings.push(Diagnostic::file(Code::UnusedTime, "", message, help).warning());
    }
    warnings
}

/// Refuses a program whose time needs an assumed row, overhead term or factor (`--strict-times`).
///
/// # Errors
/// Each assumed row with the first instruction that it prices, each assumed overhead term, and the assumed factor.
pub fn refuse_assumed(program: &Program, prices: &Prices) -> Result<(), Failure> {
    let mut first: std::collections::BTreeMap<&str, (usize, usize)> =
        std::collections::BTreeMap::new();
    for (index, price) in prices.instructions.iter().enumerate() {
        if let Some(price) = price
            && price.evidence == Evidence::Assumed
        {
            first.entry(&price.row).or_insert((index, 0)).1 += 1;
        }
    }
    let help = "give a time with --time or in your own table (--table), or omit --strict-times";
    let mut faults: Vec<Diagnostic> = first
        .into_iter()
        .map(|(row, (index, count))| {
            let more =
                if count > 1 { format!(" ({count} instructions take it)") } else { String::new() };
            let message = format!("the time of row {row} is assumed{more}");
            program.fault(&program.instructions[index], Code::AssumedTime, message, help)
        })
        .collect();
    for term in prices.overhead.iter().filter(|term| term.evidence == Evidence::Assumed) {
        let message = format!(
            "the time of the overhead '{}' is assumed; its origin: {}",
            term.name, term.why
        );
        faults.push(Diagnostic::file(Code::AssumedTime, "", message, help));
    }
    if let Some(Factor { text, source, .. }) =
        prices.factor.as_ref().filter(|factor| factor.evidence == Evidence::Assumed)
    {
        let message =
            format!("the factor {text} on the whole scan is assumed; its origin: {source}");
        faults.push(Diagnostic::file(Code::AssumedTime, "", message, help));
    }
    if faults.is_empty() { Ok(()) } else { Err(Failure::Input(faults)) }
}
