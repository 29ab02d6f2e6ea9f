//! The concrete interpreter: runs one scan on given values and adds up the times of its instructions.
//!
//! It implements the meaning that [`scanbound_ir`] states and shares no code with the symbolic execution. If both give
//! the same time for a scan, neither has an error that the other lacks.

pub mod emulated;
mod exact;
mod lists;
mod machine;
mod memory;
mod operation;
pub mod run;
mod state;
mod timed;
mod words;

#[cfg(test)]
mod control_tests;
#[cfg(test)]
mod real_tests;
#[cfg(test)]
mod value_tests;

use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::timed::Timed;
use scanbound_ir::{AreaKind, Cell, ChoiceId, ChoiceKey, Frame, Program, Settled, Witness};
use std::sync::Arc;
use timed::TimedInputs;

/// One execution of one instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// Index into `Program::instructions`.
    pub instruction: usize,
    /// The call context: the calls and loop iterations on the path to it, outermost first.
    pub frames: Arc<[Frame]>,
    /// Whether it fired. For a charge of a loop summary: whether its on-time is the larger of the two.
    pub fired: bool,
    /// Its time. For a charge of a loop summary: the time of all its repetitions.
    pub cost: Picos,
}

/// The result of running one scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replay {
    /// The sum of the times of all instructions, without the overhead of a scan.
    pub total: Picos,
    /// The executed instructions, in order.
    pub events: Vec<Event>,
    /// Indices into `Program::ranges` of the user's ranges that the start values violate. Only cells that the scan read
    /// count. If the list is not empty, the user's statements exclude this scan.
    pub broken_ranges: Vec<usize>,
    /// Indices into `Program::invariants` of the invariants that the start values violate. If the list is not empty, no
    /// scan starts with these values. In a real run, the conditions of `PowerUp::in_every_reading` follow behind the
    /// invariants.
    pub broken_invariants: Vec<usize>,
    /// The `Step::Unbounded` that the scan reached, if any. The run stops there.
    pub unbounded: Option<usize>,
}

/// Supplies the values that the program leaves free. Within a scan, the same question must get the same answer.
pub trait FreeValues {
    /// The value of the cell at the start of the scan. For a bit cell, only bit 0 counts.
    fn start(&mut self, cell: Cell, kind: AreaKind) -> u16;
    /// A mask of the bits of the start value that are unknown.
    fn unknown(&mut self, _cell: Cell) -> u16 {
        0
    }
    /// The value of the choice. For `Bit`, only bit 0 counts. The answer must not depend on `kind`.
    fn choice(&mut self, key: &ChoiceKey, kind: AreaKind) -> u16;
    /// Whether all values from outside the program are unknown.
    fn outside_is_unknown(&self) -> bool {
        false
    }
    /// The value of the CPU's register that this choice reads, if it is known.
    fn register(&mut self, _choice: ChoiceId) -> Option<u16> {
        None
    }
    /// The flag and the present value after a timer or counter was executed, if time is simulated.
    fn timed(&mut self, _timed: &Timed, _found: &TimedInputs) -> Option<(bool, u16)> {
        None
    }
    /// Whether time is simulated. Then timers and counters are executed as instructions, and none runs out between two
    /// instructions.
    fn simulates_time(&self) -> bool {
        false
    }
    /// Whether the elapsed time of a timer is derived from the earlier scans.
    fn counts_time(&self) -> bool {
        false
    }
    /// How long the timer with this memory cell has been running when the scan begins: the least and the greatest
    /// possible time. `None` if only a single scan is run.
    fn ran_for(&mut self, _memory: Cell) -> Option<(Picos, Picos)> {
        None
    }
    /// What the analysis resolved while it followed this scan.
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

/// Runs one scan of the program on the witness's values. `times` holds each instruction's on-time and off-time,
/// parallel to `Program::instructions`.
#[must_use]
pub fn replay(program: &Program, times: &[Times], witness: &Witness) -> Replay {
    replay_with(program, times, witness)
}

/// How nondeterministic values are treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// As in the analysis: every choice may have any value.
    Model,
    /// As on a PLC, with exact results of operations: a real run, see [`scanbound_ir::meaning`].
    Real,
}

/// Why a real run stopped before the end of the scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// The path depends on an unknown value: the result of the instruction with this index.
    Unknown(usize),
    /// The user's statements exclude this scan.
    Excluded,
    /// An operation error occurs that stops the CPU.
    Error,
    /// It executed more instructions than the limit.
    TooLong,
}

/// Where and why a real run stopped before the end of the scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stopped {
    /// The instruction, an index into `Program::instructions`.
    pub at: usize,
    /// The call context: the calls and loop iterations on the path to it.
    pub frames: Arc<[Frame]>,
    /// The reason.
    pub reason: StopReason,
}

/// A real run: one scan executed as on a PLC, as far as all values on its path are known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RealRun {
    /// The executed part of the scan. Its `total` is a lower bound on the scan's time: instructions after a stop are
    /// not counted, and an instruction counts with its smaller time if it is unknown whether it fires.
    pub replay: Replay,
    /// Where and why the run stopped, if it did not reach the end of the scan.
    pub stopped: Option<Stopped>,
    /// The results of operations that the run computed.
    pub learned: Knowledge,
    /// Ranges that hold at the start of the scan and not at its end: the index into `Program::ranges` and the value at
    /// the end. Empty if the run stopped early.
    pub range_violations: Vec<(usize, i64)>,
    /// Those of `Program::exclusive` that hold at the start and certainly not at the end. Empty if the run stopped
    /// early.
    pub exclusion_violations: Vec<usize>,
    /// Writes of operations to cells that the effects of their instruction do not declare: instruction and cell. Any
    /// entry is an error in the analysis.
    pub undeclared_writes: Vec<(usize, Cell)>,
}

impl RealRun {
    /// Whether a CPU can make this scan: the start values and counts satisfy the user's statements, and no operation
    /// error stops the CPU.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        let excluded =
            |stopped: &Stopped| matches!(stopped.reason, StopReason::Excluded | StopReason::Error);
        self.replay.broken_ranges.is_empty()
            && self.replay.broken_invariants.is_empty()
            && !self.stopped.as_ref().is_some_and(excluded)
    }
}

/// Makes a real run of at most `most` instructions. If the manuals do not say whether a loop makes one iteration or
/// none, both cases are run, and the result is the shortest run. Each call of `free` must give the same values again.
#[must_use]
pub fn real<F: FreeValues>(
    program: &Program,
    times: &[Times],
    mut free: impl FnMut() -> F,
    most: u64,
) -> RealRun {
    let mut best: Option<RealRun> = None;
    let mut learned = Knowledge::new();
    // For each such loop met: whether it makes one iteration. All cases are tried in depth-first order.
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
        // A run that is not possible is the result only if there is no other.
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

/// Runs one scan of the program on the witness's values, with what real runs showed about operations.
#[must_use]
pub fn replay_knowing(
    program: &Program,
    times: &[Times],
    knowledge: &Knowledge,
    witness: &Witness,
) -> Replay {
    machine::Machine::new(program, times, witness, Mode::Model).knowing(knowledge).scan()
}

/// Runs one scan and asks `free` for each free value when it is needed.
#[must_use]
pub fn replay_with(program: &Program, times: &[Times], free: impl FreeValues) -> Replay {
    machine::Machine::new(program, times, free, Mode::Model).scan()
}
