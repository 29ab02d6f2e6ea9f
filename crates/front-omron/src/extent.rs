//! The length of operands in words, and whether they exceed their area.

use super::catalog::Amount;
use super::memory::Memory;
use super::resolve::Item;
use scanbound_ir::Cell;

/// The largest number of words of a block that is modelled exactly; a larger block is havocked.
pub(super) const MAX_WORDS: u32 = 256;

/// The number of words that an operand with this amount in the catalog covers. `None` if it is unknown, or depends on a
/// word whose value is only known at run time.
pub(super) fn length(memory: Memory, item: &Item<'_>, amount: Amount) -> Option<u32> {
    match amount {
        Amount::Fixed(count) => Some(count),
        Amount::Counted { unit, operand } => {
            item.operands.get(operand)?.count(memory.family)?.checked_mul(unit)
        }
        Amount::UpTo { operand } => {
            let last = item.operands.get(operand)?.word()?;
            let is_first = |amount| matches!(amount, Some(Amount::UpTo { .. }));
            let mut slots = item.row?.operands.iter();
            let from = slots.position(|slot| is_first(slot.written_words()))?;
            let first = item.operands.get(from)?.word()?;
            (first.area == last.area && first.index <= last.index)
                .then(|| last.index - first.index + 1)
        }
        Amount::Power { .. } | Amount::Unknown => None,
    }
}

/// Whether `count` words from `first` on are within their area. Otherwise the instruction is an error.
pub(super) fn fits(memory: Memory, first: Cell, count: u32) -> bool {
    first.index.checked_add(count).is_some_and(|end| end <= memory.size(first.area))
}
