//! The results of running a scan.

use scanbound_base::time::Picos;
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{AreaId, Cell, Frame};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// One execution of one instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// Index into `Program::instructions`.
    pub instruction: usize,
    /// The call context: the calls, loop iterations and interrupt runs on the path to the instruction, outermost first.
    pub frames: Arc<[Frame]>,
    /// Whether the instruction fired; true for an instruction that fires whenever it is reached. For a loop that is not
    /// followed: whether its on-time is the larger of the two.
    pub fired: bool,
    /// Whether it is unknown if the instruction fired. `fired` is then what
    /// [`ScanControl::may_have_fired`](scanbound_ir::ScanControl::may_have_fired) says.
    pub is_uncertain: bool,
    /// The time of the execution. For a loop that is not followed: the time of all repetitions.
    pub cost: Picos,
}

/// The result of running one scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replay {
    /// The sum of the times of all executed instructions, without the overhead of a scan.
    pub total: Picos,
    /// The executed instructions, in order.
    pub events: Vec<Event>,
    /// Indices into `Program::stated_ranges` of the ranges that the start values violate. Only cells that the scan read
    /// count. If the list is not empty, the ranges exclude this scan.
    pub broken_ranges: Vec<usize>,
    /// Indices into `Program::invariants` of the invariants that the start values violate. If the list is not empty, no
    /// scan starts with these values. In a real run, higher indices stand for the conditions of
    /// `PowerUp::certain_invariants`.
    pub broken_invariants: Vec<usize>,
    /// The `Step::Unbounded` that the scan reached, if any. The run stops there.
    pub unbounded: Option<usize>,
}

/// Why a real run stopped before the end of the scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// What happens next depends on a value that is unknown because of the instruction with this index.
    Unknown(usize),
    /// The user's statements, or the largest number of iterations of a loop, exclude this scan.
    Excluded,
    /// An operation error occurs that stops the CPU.
    Error,
    /// The scan executed more instructions than the limit.
    TooLong,
}

/// Where and why a real run stopped before the end of the scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stopped {
    /// The instruction, an index into `Program::instructions`.
    pub at: usize,
    /// The call context: the calls, loop iterations and interrupt runs on the path to the instruction, outermost first.
    pub frames: Arc<[Frame]>,
    /// The reason why the run stopped.
    pub reason: StopReason,
}

/// A real run: one scan executed as on a PLC, as far as all values on its path are known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RealRun {
    /// The executed part of the scan. Its `total` is a lower bound on the scan's time: instructions after a stop are
    /// not counted, and an instruction counts with its smaller time if it is unknown whether it fires.
    pub replay: Replay,
    /// Where and why the run stopped. `None` if it reached the end of the scan, or an unbounded loop
    /// ([`Replay::unbounded`]).
    pub stopped: Option<Stopped>,
    /// The operations that the run executed, each with the values that it read and its result.
    pub learned: Knowledge,
    /// Ranges that hold at the start of the scan and not at its end: the index into `Program::stated_ranges` and the
    /// value at the end. Empty if the run stopped early.
    pub range_violations: Vec<(usize, i64)>,
    /// The pairs of `Program::stated_exclusions` (indices into `Program::invariants`) that hold at the start of the
    /// scan and certainly not at its end. Empty if the run stopped early.
    pub exclusion_violations: Vec<usize>,
    /// The numbers of the readings ([`ChoiceKind::Reading`](scanbound_ir::meaning::ChoiceKind::Reading)) on which this
    /// run and its other cases depend.
    pub readings: BTreeSet<u32>,
    /// Writes of operations to cells that the effects of their instruction do not declare: instruction and cell. Any
    /// entry is an error in the analysis.
    pub undeclared_writes: Vec<(usize, Cell)>,
    /// For each area of which the run accessed more devices than `Program::certain_devices` says: how many it needs. A
    /// PLC with fewer does not make this scan.
    pub needed_devices: BTreeMap<AreaId, u32>,
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
