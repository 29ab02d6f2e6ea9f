//! The devices that an instruction of the FX and FX5 may write, and what it may move to index registers.

use crate::catalog::{Amount, Extent, Role};
use crate::memory::Family;
use crate::operand::{Device, Operand, Place};
use crate::resolve::{Category, Control, Item};
use std::collections::BTreeMap;

/// The largest number of devices that one instruction writes from an operand on: 65,535 double words.
pub(super) const LONGEST_BLOCK: u32 = 2 * 65_535;

/// The largest number of index registers of one letter.
const INDEX_REGISTERS: u32 = 24;

/// The device operands that the instruction may write.
pub(super) fn written(item: &Item<'_>) -> Vec<Device> {
    let is_target = |operand: usize| match &item.category {
        Category::Coil => operand == 0,
        Category::User | Category::Unknown { .. } => true,
        Category::Listed(found) => {
            found.entry.operands.get(operand).is_none_or(|one| is_written(one.role))
        }
        // It writes the number of iterations that are left.
        Category::Control(Control::Break) => operand == 0,
        // It copies results back into the arguments behind the label.
        Category::Control(Control::Call) => operand > 0,
        Category::Control(_)
        | Category::Contact { .. }
        | Category::Comparison { .. }
        | Category::ProgramCheck(_)
        | Category::Block
        | Category::Branch
        | Category::Result => false,
    };
    let operands = item.operands.iter().enumerate();
    let device = |(at, operand): (usize, &Result<Operand, String>)| match operand {
        Ok(Operand::Device(device)) if is_target(at) => Some(*device),
        _ => None,
    };
    operands.filter_map(device).collect()
}

/// The largest number of successive devices that an instruction may write, beginning at one of its operands, from 1 to
/// [`LONGEST_BLOCK`]; 512 is assumed for user-defined and unknown instructions.
pub(super) fn block_length(item: &Item<'_>, family: Family) -> u32 {
    let most = match unpulsed(&item.name) {
        // A larger count in a word is an operation error; what an instruction of the user's writes is assumed.
        "BMOV" | "FMOV" if family == Family::Fx => 512,
        _ if matches!(item.category, Category::User | Category::Unknown { .. }) => 512,
        _ => LONGEST_BLOCK,
    };
    known_length(item).map_or(most, |length| length.clamp(1, LONGEST_BLOCK))
}

/// The largest number of successive devices that an instruction writes, beginning at one of its operands; 1 for coils
/// and others that are lowered without the catalog. `None` if a word or the end of an area decides the number, and for
/// user-defined and unknown instructions.
pub(super) fn known_length(item: &Item<'_>) -> Option<u32> {
    let found = match &item.category {
        Category::Listed(found) => found,
        Category::User | Category::Unknown { .. } => return None,
        _ => return Some(1),
    };
    let constant = |operand: usize| match item.operands.get(operand) {
        Some(Ok(Operand::Constant(value))) => u32::try_from(*value).ok(),
        _ => None,
    };
    let length = |extent: Extent| match extent.amount() {
        Amount::Fixed(count) => Some(count),
        Amount::Counted { unit, operand } => Some(unit.saturating_mul(constant(operand)?)),
        Amount::Power { operand } => 1_u32.checked_shl(constant(operand)?),
        _ => None,
    };
    let written = found.entry.operands.iter().filter(|one| is_written(one.role));
    // A count in a word may have any value.
    let lengths: Option<Vec<u32>> = written.map(|one| length(one.extent)).collect();
    Some(lengths?.into_iter().max().unwrap_or(1))
}

/// Whether an instruction writes an operand with this role.
fn is_written(role: Role) -> bool {
    matches!(role, Role::Destination | Role::ReadWrite | Role::ReadWriteIfDevice)
}

/// For each index register that the program writes, by its letters (`Z` or `V`) and number: 0 and the constants that it
/// moves there. `None` if it writes other values.
pub(super) fn index_values(items: &[Item<'_>]) -> BTreeMap<(&'static str, u32), Option<Vec<i64>>> {
    let mut found: BTreeMap<(&'static str, u32), Option<Vec<i64>>> = BTreeMap::new();
    for item in items {
        for device in written(item) {
            let (true, Place::At(_, first)) = (matches!(device.name, "Z" | "V"), device.place)
            else {
                continue;
            };
            let constant = match item.operands.first() {
                Some(Ok(Operand::Constant(value))) if unpulsed(&item.name) == "MOV" => Some(*value),
                _ => None,
            };
            if let Some(value) = constant {
                let values = found.entry((device.name, first)).or_insert_with(|| Some(vec![0]));
                values.iter_mut().for_each(|values| values.push(value));
                continue;
            }
            // The high word of a double word in Z is in V on the FX.
            for register in first..first + INDEX_REGISTERS {
                found.insert(("Z", register), None);
                found.insert(("V", register), None);
            }
        }
    }
    found
}

/// The mnemonic without the suffix P of its pulse form.
pub(super) fn unpulsed(name: &str) -> &str {
    name.strip_suffix('P').unwrap_or(name)
}
