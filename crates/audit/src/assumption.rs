//! Values of words and relays at the start of a scan that the audit derived because only the program writes them, with
//! the writing instructions.

use super::solved_bound::SolvedBound;
use scanbound_base::location::Location;
use scanbound_ir::Program;
use std::sync::Arc;

/// A statement about one word or several relays that the audit derived and used: it is true whenever a scan starts
/// after power-up, provided that only the program writes them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assumption {
    /// The name of the word, or the names of the relays.
    pub devices: Vec<String>,
    /// The word's smallest and largest value, signed. `None` for relays.
    pub range: Option<(i64, i64)>,
    /// The only values that the word may have, if they are fewer than those of the range. Otherwise empty.
    pub values: Vec<u16>,
    /// For relays: the largest number of them that can be on at once. 0: all are off in a scan before which memory was
    /// cleared. Also 0 for a word.
    pub most: usize,
    /// All instructions that write the word or the relays, with their text: the evidence.
    pub written: Vec<(Location, Arc<str>)>,
    /// The bound of an audit without this assumption, if that was requested.
    pub without: Option<SolvedBound>,
}

impl Assumption {
    /// The names of all devices of the assumption, joined.
    #[must_use]
    pub fn name(&self) -> String {
        self.devices.join(", ")
    }

    /// The only values that the word may have, signed and ascending, if they are fewer than those of the range.
    /// Otherwise empty.
    #[must_use]
    pub fn values(&self) -> Vec<i64> {
        let mut values: Vec<i64> =
            self.values.iter().map(|value| value.cast_signed().into()).collect();
        values.sort_unstable();
        values
    }

    /// The assumptions of a program: its trusted ranges, then its mutually exclusive relays.
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
        let exclusive = program.mutually_exclusive.iter().map(|one| {
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
        trusted.chain(exclusive).collect()
    }
}
