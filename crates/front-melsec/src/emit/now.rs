//! The instruction that is being emitted, with its operands as they were read.

use super::Emitter;
use super::overflow::OverflowHavoc;
use crate::operand::{Operand, parse};
use crate::resolve::Item;
use crate::source::RawInstruction;
use scanbound_ir::Logic;

/// The instruction that is being emitted.
#[derive(Default)]
pub(super) struct Now<'a> {
    /// Its file.
    pub file: usize,
    /// Its place among all items.
    pub item: usize,
    /// It as it was read; none before a file's first.
    pub raw: Option<&'a RawInstruction>,
    /// Faults are not reported: a reading is only tried.
    pub quiet: bool,
    /// When it is an operation error.
    pub errors: Vec<Logic>,
    /// What it havocs if it overflows.
    pub on_overflow: Option<OverflowHavoc>,
    /// What its operands say, or why they say nothing.
    pub operands: &'a [Result<Operand, String>],
}

impl<'a> Now<'a> {
    /// Before the first instruction of a file.
    pub fn of(file: usize) -> Now<'a> {
        Now { file, ..Now::default() }
    }

    /// Goes on to an item of the file.
    pub fn begin(&mut self, at: usize, item: &'a Item<'_>) {
        (self.item, self.raw, self.operands) = (at, Some(item.raw), &item.operands);
        self.errors.clear();
    }
}

impl Emitter<'_> {
    /// What the text of an operand says, or why it says nothing. It is the instruction's own nearly always.
    pub(super) fn parsed(&self, text: &str) -> Result<Operand, String> {
        let own = self.now.raw.map_or(&[][..], |raw| &raw.operands);
        match own.iter().position(|own| own == text) {
            Some(at) => self.now.operands[at].clone(),
            None => parse(text, self.family),
        }
    }
}
