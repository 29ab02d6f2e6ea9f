//! The worst time from an input's edge to an output's.

use super::failure::Failure;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_ir::Program;
use scanbound_timing::table::{Evidence, Row, Table};

/// A delay outside the scan, and how it is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delay {
    /// How long.
    pub time: Picos,
    /// How well founded.
    pub evidence: Evidence,
    /// Where it comes from.
    pub source: String,
}

impl Delay {
    /// A table's row.
    fn of_row(row: &Row) -> Delay {
        Delay { time: row.on, evidence: row.evidence, source: row.source.clone() }
    }

    fn stated(time: Picos) -> Delay {
        Delay { time, evidence: Evidence::Stated, source: "stated on the command line".to_owned() }
    }
}

/// How many scans an edge takes at least at its worst: one that it has just missed, and the one that works with it.
const SCANS: u64 = 2;

/// The worst time from an input's edge to the output's that follows from it, where each relay on the way changes as soon as
/// what it is worked out from has: no timer, counter or step of a sequence waits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Response {
    /// From the terminal to where a scan's input latch sees it.
    pub input: Delay,
    /// From the end of a scan to the terminal.
    pub output: Delay,
    /// How many scans it takes at most: one that it has just missed, the one that works with it, and one more for each relay
    /// on the way that is read before it is written.
    pub scans: u64,
    /// The longest scan.
    pub scan: Picos,
    /// All together.
    pub total: Picos,
}

/// What the user gave in place of the table's delays.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Given {
    /// From an input terminal to the scan.
    pub input: Option<Picos>,
    /// From the scan to an output terminal.
    pub output: Option<Picos>,
}

/// The delays on both sides of the scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delays {
    input: Delay,
    output: Delay,
    scans: u64,
}

impl Delays {
    /// Those that are given, else the table's.
    ///
    /// # Errors
    /// That one of them is not known, or that no response time is known for programs of this kind.
    pub(super) fn of(given: Given, program: &Program, table: &Table) -> Result<Delays, Failure> {
        if program.shows_path {
            let message = "no response time is known for a program of which not every pass asks for every input";
            let help = "leave --response out";
            let file = program.files.first().map_or("", |file| &file.name);
            return Err(Failure::from(Diagnostic::file(Code::NoResponse, file, message, help)));
        }
        let side = |name: &str, given: Option<Picos>| {
            let known = table.row(&format!("@{name}-delay")).map(Delay::of_row);
            given.map(Delay::stated).or(known).ok_or_else(|| unknown(&table.name, name))
        };
        match (side("input", given.input), side("output", given.output)) {
            (Ok(input), Ok(output)) => {
                let scans = SCANS + super::lag::further_scans(program);
                Ok(Delays { input, output, scans })
            }
            (input, output) => {
                Err(Failure::Input(input.err().into_iter().chain(output.err()).collect()))
            }
        }
    }

    /// The response of a program whose longest scan is this.
    pub(super) fn around(self, scan: Picos) -> Response {
        let Delays { input, output, scans } = self;
        let total = input.time + scan.times(scans) + output.time;
        Response { input, output, scans, scan, total }
    }
}

fn unknown(table: &str, side: &str) -> Diagnostic {
    let message = format!("the table does not say how long an {side} takes (@{side}-delay)");
    let help = format!(
        "give it with --{side}-delay, such as --{side}-delay 10ms: the module's manual has it"
    );
    Diagnostic::file(Code::NoDelay, table, message, help)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The delays by a table with these further rows; if they are not known, the findings' texts.
    fn delays(rows: &str, given: Given) -> Result<Delays, Vec<String>> {
        let text =
            format!("instruction,on_us,off_us,evidence,source\nLD,1,1,published,manual\n{rows}");
        let table = Table::parse("t.csv", text.as_bytes()).expect("a table").table;
        Delays::of(given, &Program::default(), &table).map_err(|failure| match failure {
            Failure::Input(faults) => faults.into_iter().map(|fault| fault.message).collect(),
            Failure::Internal(told) => vec![told],
        })
    }

    #[test]
    fn an_edge_waits_for_a_scan_and_takes_another() {
        let given = Given { input: Some(Picos(10)), output: Some(Picos(1)) };
        let response = delays("", given).expect("delays").around(Picos(1000));
        assert_eq!((response.scan, response.total), (Picos(1000), Picos(2011)));
    }

    #[test]
    fn what_is_not_known_is_told_of_both_sides() {
        let sides = |given| delays("", given).expect_err("unknown").len();
        assert_eq!(sides(Given { output: Some(Picos(1)), ..Given::default() }), 1);
        assert_eq!(sides(Given::default()), 2);
    }

    #[test]
    fn the_tables_delays_are_taken_unless_others_are_given() {
        let rows = "@input-delay,5,,published,manual\n@output-delay,5,,published,manual\n";
        let given = Given { output: Some(Picos(7)), ..Given::default() };
        let Delays { input, output, .. } = delays(rows, given).expect("delays");
        assert_eq!((input.time, input.evidence), (Picos(5_000_000), Evidence::Published));
        assert_eq!((output.time, output.evidence), (Picos(7), Evidence::Stated));
    }
}
