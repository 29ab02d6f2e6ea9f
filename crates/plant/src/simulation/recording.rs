//! What a simulated run did, and how it is shown as text and as CSV.

use super::signals::{Signal, Value};
use crate::minasec::trace::SCAN_TIME;
use scanbound_base::time::Picos;
use std::io::{self, Write};

/// Why the simulation ended before the scans that were asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The program's path depends on the result of this instruction, which is unknown.
    Unknown(usize),
    /// An operation error at this instruction stops the CPU.
    Error(usize),
    /// The scan does not end: it stays in a loop at this instruction, or executes too many instructions.
    Endless(usize),
}

/// The values of signals over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Recording {
    /// The signals, each with its value at power-up.
    pub signals: Vec<(Signal, Value)>,
    /// The scans from power-up on.
    pub scans: Vec<Scan>,
    /// Why the run ended before the scans that were asked for; the last scan is then not complete and not recorded.
    pub end: Option<End>,
}

/// A scan, with the signals that changed: indices into [`Recording::signals`] and the new values.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// The time since power-up at which the scan began.
    pub start: Picos,
    /// The time that the scan took.
    pub time: Picos,
    /// What was set from outside before it.
    pub before: Vec<(usize, Value)>,
    /// What it changed.
    pub after: Vec<(usize, Value)>,
}

impl Scan {
    fn is_quiet(&self) -> bool {
        self.before.is_empty() && self.after.is_empty()
    }
}

impl Recording {
    /// The longest scan and its number, from 1. Of several, the first. `None` if there are no scans.
    #[must_use]
    pub fn longest(&self) -> Option<(usize, Picos)> {
        let times = self.scans.iter().map(|scan| scan.time).enumerate();
        let (at, time) = times.reduce(|best, one| if one.1 > best.1 { one } else { best })?;
        Some((at + 1, time))
    }

    fn changes(&self, changes: &[(usize, Value)], before: &str) -> String {
        let text = |(number, value): &(usize, Value)| {
            format!("{before}{}={value}", self.signals[*number].0.name)
        };
        changes.iter().map(text).collect::<Vec<_>>().join("  ")
    }

    /// A line for each scan that changes something, and one for each series of scans that change nothing. What is set
    /// from outside has a `>` before it.
    #[must_use]
    pub fn text(&self) -> String {
        let line = |scan: &str, begins: &str, takes: &str, changes: &str| {
            let line = format!("{scan:>7}  {begins:>14}  {takes:>12}  {changes}");
            format!("{}\n", line.trim_end())
        };
        let mut text = line("scan", "begins at", "takes", "changes");
        let mut at = 0;
        while let Some(scan) = self.scans.get(at) {
            let (number, begins) = ((at + 1).to_string(), scan.start.to_string());
            let quiet = self.scans[at..].iter().take_while(|scan| scan.is_quiet()).count();
            if quiet > 1 {
                let times = self.scans[at..at + quiet].iter().map(|scan| scan.time);
                let most = times.max().unwrap_or(Picos::ZERO).to_string();
                let changes = format!("none up to scan {}", at + quiet);
                text += &line(&number, &begins, &most, &changes);
                at += quiet;
                continue;
            }
            let changes = [self.changes(&scan.before, ">"), self.changes(&scan.after, "")];
            let changes: Vec<String> = changes.into_iter().filter(|one| !one.is_empty()).collect();
            text += &line(&number, &begins, &scan.time.to_string(), &changes.join("  "));
            at += 1;
        }
        text
    }

    /// Writes a row for each scan: when it began, how long it took, and the signals after it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        let mut rows = csv::Writer::from_writer(out);
        let names = self.signals.iter().map(|(signal, _)| signal.name.clone());
        let head = ["scan", "start_us", SCAN_TIME].map(str::to_owned);
        rows.write_record(head.into_iter().chain(names))?;
        let mut values: Vec<Value> = self.signals.iter().map(|(_, first)| *first).collect();
        for (scan, number) in self.scans.iter().zip(1..) {
            for &(at, value) in scan.before.iter().chain(&scan.after) {
                values[at] = value;
            }
            let own = [format!("{number}"), scan.start.us_text(), scan.time.us_text()];
            rows.write_record(own.into_iter().chain(values.iter().map(Value::csv)))?;
        }
        rows.flush()
    }
}
