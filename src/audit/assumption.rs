//! What words and relays hold between scans because the program alone writes them, shown with the lines that write them.

use crate::base::location::Location;
use crate::program::Program;
use std::sync::Arc;

/// What words or relays hold whenever a scan starts, which excludes scans.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assumption {
    /// The word, or several relays.
    pub name: String,
    /// The word's least value, signed, and its largest one; of relays no two are ever on.
    pub range: Option<(i64, i64)>,
    /// All instructions that write them, with their texts: the evidence.
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
            name: program.cell_name(one.cell),
            range: Some((one.low, one.high)),
            written: one.written.iter().map(written).collect(),
        });
        let apart = program.apart.iter().map(|one| {
            let names: Vec<String> =
                one.cells.iter().map(|&cell| program.cell_name(cell)).collect();
            let written = one.written.iter().map(written).collect();
            Assumption { name: names.join(", "), range: None, written }
        });
        trusted.chain(apart).collect()
    }
}
