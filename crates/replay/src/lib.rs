//! The concrete interpreter: runs one scan on given values and adds up what it costs, apart from the analysis.
//!
//! It follows the page of [`program`](scanbound_ir) and shares nothing with the symbolic execution, so that
//! a scan which both price alike is a scan that can happen.

mod clockwork;
pub mod emulated;
mod exact;
mod lists;
mod machine;
mod memory;
mod operation;
pub mod run;
mod state;
mod words;

#[cfg(test)]
mod control_tests;
#[cfg(test)]
mod real_tests;
#[cfg(test)]
mod value_tests;

use clockwork::Found;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::timed::Timed;
use scanbound_ir::{AreaKind, Cell, ChoiceId, ChoiceKey, Frame, Program, Settled, Witness};
use std::sync::Arc;

/// One execution of one instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// Index into `Program::instructions`.
    pub instruction: usize,
    /// The call context: calls and loop iterations on the path there, outermost first.
    pub frames: Arc<[Frame]>,
    /// Whether it fired. For a charge of a summarised loop: whether its on-time is the dearer.
    pub fired: bool,
    /// What it cost; for a charge of a summarised loop, all its repetitions.
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
    /// Indices into `Program::invariants` that the start values do not meet: no scan starts so. In a real run what holds in
    /// every reading of the manuals is counted behind them.
    pub broken_invariants: Vec<usize>,
    /// The `Step::Unbounded` at which the scan was given up, if it came to one.
    pub unbounded: Option<usize>,
}

/// Gives the values that a program leaves free. The same question gets the same answer throughout a scan.
pub trait FreeValues {
    /// The cell's value at the start of the scan; bit 0 counts if the kind is `Bit`.
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16;
    /// The bits of that value that nobody knows.
    fn unknown(&mut self, _cell: Cell) -> u16 {
        0
    }
    /// The choice's value; bit 0 counts if the kind is `Bit`. The kind is no part of the question.
    fn choice(&mut self, key: &ChoiceKey, kind: AreaKind) -> u16;
    /// Whether nothing is known of what the outside gives.
    fn is_unseen(&self) -> bool {
        false
    }
    /// What the register of the CPU holds that this choice reads, where that is known.
    fn register(&mut self, _choice: ChoiceId) -> Option<u16> {
        None
    }
    /// The flag and the present value's word that a timer's or counter's execution leaves, where time goes by.
    fn timed(&mut self, _timed: &Timed, _found: &Found) -> Option<(bool, u16)> {
        None
    }
    /// Whether time goes by: then timers and counters are executed, and nothing runs out between instructions.
    fn keeps_time(&self) -> bool {
        false
    }
    /// Whether a timer is over, and how long it has run, follows from the scans before.
    fn counts_time(&self) -> bool {
        false
    }
    /// How long the timer with this memory has been running when the scan begins, at least and at most, where time passes
    /// from scan to scan. `None` where only one scan is looked at.
    fn ran_for(&mut self, _memory: Cell) -> Option<(Picos, Picos)> {
        None
    }
    /// What the analysis settled in a scan that it found.
    fn settled(&self) -> Option<&Settled> {
        None
    }
}

impl FreeValues for &Witness {
    fn start(&mut self, cell: Cell, _kind: AreaKind) -> u16 {
        self.start.get(&cell).copied().unwrap_or(0)
    }

    fn choice(&mut self, key: &ChoiceKey, _kind: AreaKind) -> u16 {
        self.choices.get(key).copied().unwrap_or(0)
    }

    fn settled(&self) -> Option<&Settled> {
        Some(&self.settled)
    }
}

/// Runs one scan of the program on the witness's values. `times` gives each instruction's on-time and
/// off-time and is parallel to `Program::instructions`.
#[must_use]
pub fn replay(program: &Program, times: &[Times], witness: &Witness) -> Replay {
    replay_with(program, times, witness)
}

/// How a program is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// As the analysis follows it: every choice is any value.
    Model,
    /// As a PLC does it, a real run: see [`scanbound_ir::meaning`].
    Real,
}

/// Why a real run is followed no further.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// The further path depends on what is not known: this instruction's result.
    Unknown(usize),
    /// What the user stated excludes this scan.
    Excluded,
    /// An operation error occurs, from which the CPU does not go on.
    Error,
    /// It has more instructions than are followed.
    TooLong,
}

/// Where a real run is followed no further.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stopped {
    /// The instruction.
    pub at: usize,
    /// The call context: calls and loop iterations on the path there.
    pub frames: Arc<[Frame]>,
    /// Why.
    pub reason: StopReason,
}

/// A real run: one scan as a PLC makes it, as far as it is known what that does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RealRun {
    /// What was run. It takes at least `total`: what follows a stop is not counted, and of an instruction of which it is
    /// not known whether it fires the lesser time.
    pub replay: Replay,
    /// Where it is followed no further.
    pub stopped: Option<Stopped>,
    /// What was learned about exact choices.
    pub learned: Knowledge,
    /// Indices into `Program::ranges` that the start keeps and the scan's end does not, and what the words hold then; empty
    /// where it is not followed to its end.
    pub range_violations: Vec<(usize, i64)>,
    /// Those of `Program::exclusive` that the start keeps and the scan's end surely does not; empty likewise.
    pub exclusion_violations: Vec<usize>,
    /// Writes of operations that their instruction's effects do not allow: instruction and cell. There must be none.
    pub undeclared_writes: Vec<(usize, Cell)>,
}

impl RealRun {
    /// Whether the CPU makes this scan: the user's statements allow it, those of start values and those of counts within it,
    /// and no operation error ends it.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        let excluded =
            |stopped: &Stopped| matches!(stopped.reason, StopReason::Excluded | StopReason::Error);
        self.replay.broken_ranges.is_empty()
            && self.replay.broken_invariants.is_empty()
            && !self.stopped.as_ref().is_some_and(excluded)
    }
}

/// Makes a real run of at most `most` instructions. Where loops make one iteration or none and manuals do not say which,
/// each case is run, and the cheapest is the result. Each call of `free` gives the same values from the beginning.
#[must_use]
pub fn real<F: FreeValues>(
    program: &Program,
    times: &[Times],
    mut free: impl FnMut() -> F,
    most: u64,
) -> RealRun {
    let mut best: Option<RealRun> = None;
    let mut learned = Knowledge::new();
    // For each such loop met whether it makes one iteration: all cases, in depth-first order.
    let mut once: Vec<bool> = Vec::new();
    loop {
        let machine = machine::Machine::new(program, times, free(), Mode::Real);
        let (mut found, asked) = machine.real(most, once.clone());
        for (moment, facts) in std::mem::take(&mut found.learned) {
            let known = learned.entry(moment).or_default();
            for fact in facts {
                if !known.contains(&fact) {
                    known.push(fact);
                }
            }
        }
        // A run that is not possible is taken only if there is no other.
        let rank = |one: &RealRun| (!one.is_possible(), one.replay.total);
        if best.as_ref().is_none_or(|old| rank(&found) < rank(old)) {
            best = Some(found);
        }
        once.resize(asked, false);
        while once.last() == Some(&true) {
            once.pop();
        }
        match (once.last_mut(), best.take()) {
            (Some(last), best_so_far) => {
                *last = true;
                best = best_so_far;
            }
            (None, Some(mut best)) => {
                best.learned = learned;
                return best;
            }
            // The loop above leaves a run in `best`.
            (None, None) => {}
        }
    }
}

/// Runs one scan of the program on the witness's values where something was learned of exact choices.
#[must_use]
pub fn replay_knowing(
    program: &Program,
    times: &[Times],
    knowledge: &Knowledge,
    witness: &Witness,
) -> Replay {
    machine::Machine::new(program, times, witness, Mode::Model).knowing(knowledge).scan()
}

/// Runs one scan, asking `free` for every value that the program leaves free at the moment it is needed.
#[must_use]
pub fn replay_with(program: &Program, times: &[Times], free: impl FreeValues) -> Replay {
    machine::Machine::new(program, times, free, Mode::Model).scan()
}
