//! The concrete interpreter: runs one scan on given values and adds up what it costs, apart from the analysis.
//!
//! It follows the page of [`program`](crate::program) and shares nothing with the symbolic execution, so that
//! a scan which both price alike is a scan that can happen.

mod machine;
mod state;

#[cfg(test)]
mod control_tests;
#[cfg(test)]
mod value_tests;

use crate::program::{AreaKind, Cell, ChoiceKey, Frame, Program, Witness};
use crate::time::Picos;
use std::sync::Arc;

/// One execution of one instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// Index into `Program::instructions`.
    pub instruction: usize,
    /// Calls and loop turns on the way there, outermost first.
    pub frames: Arc<[Frame]>,
    /// Whether it fired. For a charge of a loop taken in bulk: whether its on-time is the dearer.
    pub fired: bool,
    /// What it cost; for a charge of a loop taken in bulk, all its repetitions.
    pub cost: Picos,
}

/// One scan as it was run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replay {
    /// What the scan costs, without the table's scan-level terms.
    pub total: Picos,
    /// What was executed, in order.
    pub events: Vec<Event>,
    /// Indices into `Program::ranges` that the start values which the scan read cannot meet: such a scan is
    /// not one of those that the user's statements allow.
    pub broken_ranges: Vec<usize>,
    /// Indices into `Program::invariants` that the start values do not meet: no scan starts so.
    pub broken_invariants: Vec<usize>,
    /// The `Step::Unbounded` at which the scan was given up, if it came to one.
    pub unbounded: Option<usize>,
}

/// Who gives the values that a program leaves free. The same question gets the same answer throughout a scan.
pub trait Free {
    /// The cell's value at the start of the scan; bit 0 counts if the kind is `Bit`.
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16;
    /// The choice's value; bit 0 counts if the kind is `Bit`. The kind is no part of the question.
    fn choice(&mut self, key: &ChoiceKey, kind: AreaKind) -> u16;
}

impl Free for &Witness {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        self.start.get(&cell).copied().unwrap_or(0)
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        self.choices.get(key).copied().unwrap_or(0)
    }
}

/// Runs one scan of the program on the witness's values. `times` gives each instruction's on-time and
/// off-time and is parallel to `Program::instructions`.
#[must_use]
pub fn replay(program: &Program, times: &[(Picos, Picos)], witness: &Witness) -> Replay {
    replay_with(program, times, witness)
}

/// Runs one scan, asking `free` for every value that the program leaves free at the moment it is needed.
#[must_use]
pub fn replay_with(program: &Program, times: &[(Picos, Picos)], free: impl Free) -> Replay {
    machine::Machine::new(program, times, free).scan()
}
