//! What words and relays hold between scans because the program alone writes them, shown with the lines that write them.

use super::solved_bound::SolvedBound;
use scanbound_base::location::Location;
use scanbound_ir::Program;
use std::sync::Arc;

/// What words or relays hold whenever a scan starts, which excludes scans.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assumption {
    /// The word, or several relays, by their names.
    pub devices: Vec<String>,
    /// The word's least value, signed, and its largest one.
    pub range: Option<(i64, i64)>,
    /// Its only values, where these are not all of the range; else empty.
    pub values: Vec<u16>,
    /// Of relays, how many of them are ever on at once: one, or all but one; 0: all are off in the first scan.
    pub most: usize,
    /// All instructions that write them, with their texts: the evidence.
    pub written: Vec<(Location, Arc<str>)>,
    /// The bound of an audit in which these may hold anything, where that was asked for.
    pub without: Option<SolvedBound>,
}

impl Assumption {
    /// All of them in one text.
    #[must_use]
    pub fn name(&self) -> String {
        self.devices.join(", ")
    }

    /// Its only values in order, if not all of the range are.
    #[must_use]
    pub fn values(&self) -> Vec<i64> {
        let mut values: Vec<i64> =
            self.values.iter().map(|value| value.cast_signed().into()).collect();
        values.sort_unstable();
        values
    }

    /// All of a program.
    pub(super) fn all(program: &Program) -> Vec<Assumption> {
        let written = |at: &usize| {
            let instruction = &program.instructions[*at];
            (instruction.place, instruction.text.clone())
        };
        let trusted = program.trusted_ranges.iter().map(|one| Assumption {
            devices: vec![program.cell_name(one.cell)],
            range: Some((one.low, one.high)),
            values: one.values.clone(),
            most: 0,
            written: one.writers.iter().map(written).collect(),
            without: None,
        });
        let apart = program.mutually_exclusive.iter().map(|one| {
            let devices = one.bits.iter().map(|&bit| program.bit_name(bit)).collect();
            let written = one.writers.iter().map(written).collect();
            Assumption {
                devices,
                range: None,
                values: Vec::new(),
                most: one.max_on,
                written,
                without: None,
            }
        });
        trusted.chain(apart).collect()
    }
}
