//! How far operands reach: how many words they stand for, and whether these lie within their area.

use super::catalog::{Extent, Role};
use super::memory::Memory;
use super::resolve::Item;
use crate::program::Cell;

/// Blocks of more words are havocked rather than followed.
pub(super) const MOST_WORDS: u32 = 256;

/// How many words an operand reaches over; `None` if that is not known.
pub(super) fn length(memory: Memory, item: &Item<'_>, extent: Extent) -> Option<u32> {
    match extent {
        Extent::Words(count) => Some(count),
        Extent::Counted(at) => item.operands.get(at)?.count(memory.family),
        Extent::UpTo(at) => {
            let last = item.operands.get(at)?.word()?;
            let role = item
                .row?
                .operands
                .iter()
                .position(|role| matches!(role, Role::Target(Extent::UpTo(_))))?;
            let first = item.operands.get(role)?.word()?;
            (first.area == last.area && first.index <= last.index)
                .then(|| last.index - first.index + 1)
        }
        Extent::Unknown => None,
    }
}

/// Whether so many words lie within their area: an instruction that reaches beyond ends in an error.
pub(super) fn fits(memory: Memory, first: Cell, count: u32) -> bool {
    first.index.checked_add(count).is_some_and(|end| end <= memory.size(first.area))
}
