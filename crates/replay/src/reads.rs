//! Reads of sources: what a traced run records of them, and sources that do not change within a scan.

use super::state::State;
use super::trace::TracedRead;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{BitSource, ChoiceKey, Source, WordSource};

impl State<'_> {
    /// Begins to read a source. Returns whether the read is traced: not within an operation, nor within another read.
    pub(super) fn begin_read(&mut self) -> bool {
        let Some(trace) = &mut self.trace else { return false };
        if trace.is_reading || self.reading.is_some() {
            return false;
        }
        trace.is_reading = true;
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
        trace.current.push(TracedRead { source, outside, value });
    }

    /// The value of a source that does not change within the scan. What an operation learns depends on the choice that
    /// is read, and not on the cells of the source.
    pub(super) fn stable(&mut self, source: Source) -> u16 {
        let reading = self.reading.take();
        let value = match source {
            Source::Bit(bit) => self.bit(bit).into(),
            Source::Word(word) => self.word(word),
        };
        self.changing |= self.interrupting && reading.is_some();
        self.reading = reading;
        value
    }
}
