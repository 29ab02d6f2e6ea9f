//! The worst time from an input's edge to an output's.

use super::Audit;
use crate::base::time::Picos;
use crate::timing::table::{Evidence, Row};

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
    pub(super) fn of_row(row: &Row) -> Delay {
        Delay { time: row.on, evidence: row.evidence, source: row.source.clone() }
    }

    fn stated(time: Picos) -> Delay {
        Delay { time, evidence: Evidence::Stated, source: "stated on the command line".to_owned() }
    }
}

/// How many scans an edge takes at most: one that it has just missed, and the one that works with it.
pub const SCANS: u64 = 2;

/// The worst time from an input's edge to the output's that follows from it, where the program takes it to the
/// output within one scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Response {
    /// From the terminal to where a scan's input latch sees it.
    pub input: Delay,
    /// From the end of a scan to the terminal.
    pub output: Delay,
    /// The longest scan.
    pub scan: Picos,
    /// All together.
    pub total: Picos,
}

impl Response {
    /// The response of an audited program. Delays that are given take the place of the table's.
    ///
    /// # Errors
    /// The sides, `input` and `output`, of which no delay is known.
    pub fn of(
        audit: &Audit,
        input: Option<Picos>,
        output: Option<Picos>,
    ) -> Result<Response, Vec<&'static str>> {
        let known = |given: Option<Picos>, table: &Option<Delay>| {
            given.map(Delay::stated).or_else(|| table.clone())
        };
        let input = known(input, &audit.table.input_delay);
        let output = known(output, &audit.table.output_delay);
        match (input, output) {
            (Some(input), Some(output)) => {
                let scan = audit.bound.upper;
                let total = input.time + scan.times(SCANS) + output.time;
                Ok(Response { input, output, scan, total })
            }
            (input, output) => {
                let sides = [("input", input.is_none()), ("output", output.is_none())];
                Err(sides.into_iter().filter(|side| side.1).map(|side| side.0).collect())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::fixture::fixture;

    #[test]
    fn an_edge_waits_for_a_scan_and_takes_another() {
        let audit = fixture();
        let response = Response::of(&audit, Some(Picos(10)), Some(Picos(1))).expect("delays");
        assert_eq!(response.total, audit.bound.upper.times(2) + Picos(11));
        assert_eq!(Response::of(&audit, None, Some(Picos(1))), Err(vec!["input"]));
        assert_eq!(Response::of(&audit, None, None), Err(vec!["input", "output"]));
    }

    #[test]
    fn the_tables_delays_are_taken_unless_others_are_given() {
        let mut audit = fixture();
        let table =
            Delay { time: Picos(5), evidence: Evidence::Published, source: "manual".to_owned() };
        audit.table.input_delay = Some(table.clone());
        audit.table.output_delay = Some(table.clone());
        let response = Response::of(&audit, None, Some(Picos(7))).expect("delays");
        assert_eq!(response.input, table);
        assert_eq!((response.output.time, response.output.evidence), (Picos(7), Evidence::Stated));
    }
}
