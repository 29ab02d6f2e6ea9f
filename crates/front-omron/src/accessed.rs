//! Finds the cells and word bits that the operands of an instruction access, on which the time of the instruction
//! depends. They are known even if the instruction's effects are only "any value".

use super::catalog::{Amount, Extent, Role};
use super::extent::length;
use super::memory::Memory;
use super::operand::Operand;
use super::resolve::Item;
use scanbound_front::operand_spans;
use scanbound_ir::{AccessedDevices, Cell, Device, Region};
use std::sync::Arc;

/// Stands for an unknown number of cells: twice as many cells as the instruction processes units, but at least 8, are
/// then charged.
const MANY: u32 = u32::MAX / 2;

/// The operands of an instruction that are devices, each with its byte range in the instruction's text.
pub(super) fn operands(item: &Item<'_>) -> Arc<[scanbound_ir::Operand]> {
    let spans = operand_spans(&item.raw.text, &item.raw.operands);
    let named = item.operands.iter().zip(spans).filter_map(|(operand, (start, end))| {
        let device = device(operand)?;
        Some(scanbound_ir::Operand { start, end, device })
    });
    named.collect()
}

/// The device that an operand names: a word, a flag or a bit of a word. `None` for constants, texts and computed
/// addresses.
pub(super) fn device(operand: &Operand) -> Option<Device> {
    match *operand {
        Operand::Word(cell) | Operand::Flag(cell) => Some(Device { cell, bit: None }),
        Operand::Bit(cell, bit) => Some(Device { cell, bit: Some(bit) }),
        _ => None,
    }
}

/// The devices that an instruction reads and writes, for times that depend on the memory area. An operand that is both
/// read and written counts twice.
pub(super) fn touched(item: &Item<'_>, memory: Memory) -> AccessedDevices {
    let mut touched = AccessedDevices::default();
    for (at, operand) in item.operands.iter().enumerate() {
        let slot = item.row.and_then(|row| row.operands.get(at));
        let words = match slot.map(|slot| (slot.role, slot.extent)) {
            // A block that is copied has the same length as its destination.
            Some((Role::Source, Extent::Words(Amount::Unknown))) => item.row.and_then(|row| {
                row.operands.iter().find_map(|slot| match slot.written_words() {
                    Some(amount @ Amount::Counted { .. }) => length(memory, item, amount),
                    _ => None,
                })
            }),
            // An operand that is only an address is not accessed.
            Some((Role::Address | Role::Number, _)) => continue,
            Some((Role::Extra(_), _)) => Some(1),
            Some((_, Extent::Words(amount))) => length(memory, item, amount),
            _ => Some(1),
        };
        let count = words.map_or(MANY, |words| words.min(MANY));
        // What is both read and written counts as two accesses.
        let changed = slot.is_some_and(|slot| slot.role == Role::ReadWrite);
        for _ in 0..1 + usize::from(changed) {
            let mut range = |first: Cell, count: u32| {
                touched.regions.push(Region::Range { first, count });
            };
            match operand {
                Operand::Word(first) => range(*first, count),
                Operand::Flag(cell) => range(*cell, 1),
                Operand::Bit(cell, _) => {
                    range(*cell, 1);
                    touched.word_bits += 1;
                }
                Operand::Within(areas) => {
                    areas.iter().for_each(|&area| range(Cell { area, index: 0 }, count));
                }
                _ => {}
            }
        }
    }
    touched
}
