//! The worst-case response time: from an input's edge to the output's edge.

use super::failure::Failure;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_ir::Program;
use scanbound_timing::table::{Evidence, Row, Table};

/// A delay of an input or output module outside the scan, and its evidence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delay {
    /// The length of the delay.
    pub time: Picos,
    /// The evidence for the delay.
    pub evidence: Evidence,
    /// The document that gives the delay, or that it was stated on the command line.
    pub source: String,
}

impl Delay {
    /// The delay that a row of the timing table gives.
    fn of_row(row: &Row) -> Delay {
        Delay { time: row.on, evidence: row.evidence, source: row.source.clone() }
    }

    fn stated(time: Picos) -> Delay {
        Delay { time, evidence: Evidence::Stated, source: "stated on the command line".to_owned() }
    }
}

/// The number of scans that an edge needs in the worst case if no relay delays it: one that it just missed, and the one
/// that processes it.
const SCANS: u64 = 2;

/// The worst-case time from an input's edge to the resulting edge of an output. It assumes that each relay on the way
/// changes as soon as the values that it is computed from have changed: no timer, counter or step of a sequence waits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Response {
    /// The delay from the input terminal until a scan reads the input.
    pub input: Delay,
    /// The delay from the end of a scan to the output terminal.
    pub output: Delay,
    /// The largest number of scans: one that the edge just missed, the one that processes it, and one more for each
    /// relay on the way that is read before it is written.
    pub scans: u64,
    /// The upper bound on the time of a scan.
    pub scan: Picos,
    /// The response time: both delays, and `scans` times `scan`.
    pub total: Picos,
}

/// Delays that the user gave on the command line. They replace the delays of the table. Where one is `None`, the delay
/// of the table is used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Given {
    /// The delay from an input terminal to the scan. `None` if not given.
    pub input: Option<Picos>,
    /// The delay from the scan to an output terminal. `None` if not given.
    pub output: Option<Picos>,
}

/// The delays before and after the scan, and the number of scans between them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delays {
    input: Delay,
    output: Delay,
    scans: u64,
}

impl Delays {
    /// The given delays, otherwise the table's (`@input-delay`, `@output-delay`).
    ///
    /// # Errors
    /// If one of them is unknown, or no response time can be computed for this kind of program.
    pub(super) fn of(given: Given, program: &Program, table: &Table) -> Result<Delays, Failure> {
        if program.shows_path {
            let message = "the response time of this program is unknown, because not every pass of the program reads every input";
            let help = "omit --response";
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

    /// The response time of a program if this is the upper bound on its scan.
    pub(super) fn response_time(self, scan: Picos) -> Response {
        let Delays { input, output, scans } = self;
        let total = input.time + scan.times(scans) + output.time;
        Response { input, output, scans, scan, total }
    }
}

fn unknown(table: &str, side: &str) -> Diagnostic {
    let message = format!("the table does not give the delay of an {side} (@{side}-delay)");
    let help = format!(
        "give the delay with --{side}-delay, such as --{side}-delay 10ms: the module's manual states it"
    );
    Diagnostic::file(Code::NoDelay, table, message, help)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The delays by a table with these additional rows, or the messages if they are unknown.
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
        let response = delays("", given).expect("delays").response_time(Picos(1000));
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
