//! What a real run read and wrote, instruction by instruction, for a search that changes the start of the run.

use super::free::FreeValues;
use super::state::State;
use rustc_hash::FxHashMap;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{BitSource, Cell, ChoiceKey, Region, Source, WordSource};

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

impl<F: FreeValues> State<'_, F> {
    /// Begins to read a source. Returns whether the read is traced: not within an operation, nor within another read.
    pub(super) fn begin_read(&mut self) -> bool {
        let Some(trace) = &mut self.trace else { return false };
        if trace.is_reading || self.reading.is_some() {
            return false;
        }
        (trace.is_reading, trace.cell) = (true, None);
        true
    }

    pub(super) fn end_read(&mut self, source: Source, value: u16) {
        let outside = match source {
            Source::Bit(BitSource::Free(choice)) | Source::Word(WordSource::Free(choice)) => {
                let is_outside = self.program.kinds.get(&choice) == Some(&ChoiceKind::External);
                let frames = || self.frames().to_vec();
                is_outside.then(|| ChoiceKey { frames: frames(), choice, cell: None })
            }
            _ => None,
        };
        let Some(trace) = &mut self.trace else { return };
        trace.is_reading = false;
        let cell = trace.cell.take();
        trace.current.push(TracedRead { source, cell, outside, value });
    }

    /// The value of a source that does not change within the scan. What an operation learns depends on the choice that
    /// is read, and not on the cells of the source.
    pub(super) fn stable(&mut self, source: Source) -> u16 {
        let reading = self.reading.take();
        let value = match source {
            Source::Bit(bit) => self.bit(bit).into(),
            Source::Word(word) => self.word(word),
        };
        if let (Some(trace), Some(Region::Range { first, count: 1 })) =
            (&mut self.trace, source.region())
        {
            let mask = match source {
                Source::Bit(BitSource::WordBit(_, bit)) => 1 << bit,
                _ => u16::MAX,
            };
            trace.cell = Some((first, mask));
        }
        self.changing |= self.interrupting && reading.is_some();
        self.reading = reading;
        value
    }
}
