//! The instruction that is being lowered, with its parsed operands.

use super::Lowering;
use super::overflow::OverflowHavoc;
use crate::operand::{Operand, parse};
use crate::resolve::Item;
use crate::source::RawInstruction;
use scanbound_ir::Logic;

/// The instruction that is being lowered.
#[derive(Default)]
pub(super) struct CurrentInstruction<'a> {
    /// The index of its file.
    pub file: usize,
    /// Its index among all items.
    pub item: usize,
    /// Its source form; `None` before the first instruction of a file.
    pub raw: Option<&'a RawInstruction>,
    /// Whether errors are suppressed, because an operand is only tried.
    pub quiet: bool,
    /// The conditions under which it is an operation error.
    pub errors: Vec<Logic>,
    /// What it havocs on overflow.
    pub on_overflow: Option<OverflowHavoc>,
    /// Its parsed operands, or why one is invalid.
    pub operands: &'a [Result<Operand, String>],
}

impl<'a> CurrentInstruction<'a> {
    /// The state before the first instruction of a file.
    pub fn of(file: usize) -> CurrentInstruction<'a> {
        CurrentInstruction { file, ..CurrentInstruction::default() }
    }

    /// Moves to the next item of the file.
    pub fn begin(&mut self, at: usize, item: &'a Item<'_>) {
        (self.item, self.raw, self.operands) = (at, Some(item.raw), &item.operands);
        self.errors.clear();
    }
}

impl Lowering<'_> {
    /// Parses an operand's text. It is nearly always one of the instruction's own operands, which are parsed already.
    pub(super) fn parsed(&self, text: &str) -> Result<Operand, String> {
        let own = self.current.raw.map_or(&[][..], |raw| &raw.operands);
        match own.iter().position(|own| own == text) {
            Some(at) => self.current.operands[at].clone(),
            None => parse(text, self.family),
        }
    }
}
