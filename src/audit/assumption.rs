//! What words hold between scans because the program alone writes them, shown with the lines that write them.

use crate::base::location::Location;
use crate::program::Program;
use std::sync::Arc;

/// A word's range whenever a scan starts that lowers counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assumption {
    /// The word.
    pub word: String,
    /// The least value, signed.
    pub low: i64,
    /// The largest one.
    pub high: i64,
    /// All instructions that write it, with their texts: the evidence.
    pub written: Vec<(Location, Arc<str>)>,
}

impl Assumption {
    /// All of a program.
    pub(super) fn all(program: &Program) -> Vec<Assumption> {
        let written = |at: &usize| {
            let instruction = &program.instructions[*at];
            (instruction.place, instruction.text.clone())
        };
        let trusted = program.trusted.iter().map(|one| Assumption {
            word: program.cell_name(one.cell),
            low: one.low,
            high: one.high,
            written: one.written.iter().map(written).collect(),
        });
        trusted.collect()
    }
}
