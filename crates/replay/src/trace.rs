//! What a real run read and wrote, instruction by instruction, for a search that changes the start of the run.

use rustc_hash::FxHashMap;
use scanbound_ir::{Cell, ChoiceKey, Region, Source};

/// A value that an instruction read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TracedRead {
    /// What was read, as it stands in the instruction.
    pub source: Source,
    /// For a choice: the cell from which its value comes, and the bits that were read. `None` if it comes from
    /// elsewhere.
    pub cell: Option<(Cell, u16)>,
    /// For a choice that something outside the program determines: its key.
    pub outside: Option<ChoiceKey>,
    /// The value that was read; of a bit 0 or 1.
    pub value: u16,
}

/// What a run read and wrote. Events are counted as in [`Replay::events`](super::Replay::events).
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// What each event read outside of operations.
    pub reads: Vec<Vec<TracedRead>>,
    /// The events that wrote a cell or may have written it, in order.
    pub writes: FxHashMap<Cell, Vec<usize>>,
    /// The regions that events havocked, in order.
    pub havocs: Vec<(usize, Region)>,
    /// The havocked cells whose values come from outside the program, with the keys of these.
    pub delivered: FxHashMap<Cell, ChoiceKey>,
    /// What the current event has read so far.
    pub(super) current: Vec<TracedRead>,
    /// The number of the current event.
    pub(super) event: usize,
    /// Whether a value is being read.
    pub(super) is_reading: bool,
    /// The cell that the choice being read has its value from.
    pub(super) cell: Option<(Cell, u16)>,
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
