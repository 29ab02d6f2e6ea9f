//! What a real run read and wrote, instruction by instruction, for a search that changes the start of the run.

use rustc_hash::FxHashMap;
use scanbound_ir::{Cell, ChoiceId, ChoiceKey, Region, Source};

/// A value that an instruction read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TracedRead {
    /// What was read, as it stands in the instruction.
    pub source: Source,
    /// For a choice that something outside the program determines: its key.
    pub outside: Option<ChoiceKey>,
    /// The value that was read; of a bit 0 or 1.
    pub value: u16,
}

/// An operation that an instruction executed.
#[derive(Debug, Clone, Default)]
pub struct TracedOperation {
    /// The values of the inputs.
    pub inputs: Vec<Vec<u16>>,
    /// For each input that is a list at an address: the first cell of the list.
    pub from: Vec<Option<Cell>>,
    /// For each output that goes to an address: the first cell to which it goes.
    pub to: Vec<Option<Cell>>,
}

/// What a run read and wrote. Events are counted as in [`Replay::events`](super::Replay::events).
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// What each event read outside of operations. If the run stopped, the instruction that stopped it comes last.
    pub reads: Vec<Vec<TracedRead>>,
    /// The events that wrote a cell or may have written it, in order.
    pub writes: FxHashMap<Cell, Vec<usize>>,
    /// The regions that events havocked, in order.
    pub havocs: Vec<(usize, Region)>,
    /// The operations that events executed, by the choices that they determine.
    pub operations: FxHashMap<(usize, ChoiceId), TracedOperation>,
    /// The havocked cells whose values come from outside the program, with the keys of these.
    pub delivered: FxHashMap<Cell, ChoiceKey>,
    /// What the current event has read so far.
    pub(super) current: Vec<TracedRead>,
    /// The number of the current event.
    pub(super) event: usize,
    /// Whether a value is being read.
    pub(super) is_reading: bool,
    /// The operation that is being executed, or the targets of its results (then in `from`).
    pub(super) operation: TracedOperation,
}

impl Trace {
    /// The last event before `event` that wrote the cell or may have written it.
    #[must_use]
    pub fn last_write(&self, cell: Cell, event: usize) -> Option<usize> {
        let writes = self.writes.get(&cell).map_or(&[][..], Vec::as_slice);
        let written = writes[..writes.partition_point(|&at| at < event)].last().copied();
        let before = self.havocs.partition_point(|&(at, _)| at < event);
        let lost = self.havocs[..before].iter().rev().find(|(_, region)| region.contains(cell));
        written.max(lost.map(|&(at, _)| at))
    }
}
