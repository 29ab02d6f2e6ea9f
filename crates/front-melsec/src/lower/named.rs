//! Which devices the source names, with the blocks of constant length that begin at them.

use crate::catalog::{Amount, Extent};
use crate::memory::DeviceType;
use crate::operand::{Device, Operand, Place};
use crate::resolve::{Category, Item};
use scanbound_ir::AreaId;
use std::collections::BTreeMap;

/// The numbers of devices that the source shows.
pub(super) struct NamedDevices {
    /// For each area: the number of devices that the CPU has at least, since an operand names the highest one.
    pub(super) highest: BTreeMap<AreaId, u32>,
    /// As `highest`, with the blocks of constant length that begin at these operands.
    pub(super) with_blocks: BTreeMap<AreaId, u32>,
}

impl NamedDevices {
    pub(super) fn of(items: &[Item<'_>]) -> NamedDevices {
        let mut highest: BTreeMap<AreaId, u32> = BTreeMap::new();
        let mut with_blocks: BTreeMap<AreaId, u32> = BTreeMap::new();
        for item in items {
            for (at, operand) in item.operands.iter().enumerate() {
                let Ok(Operand::Device(device)) = operand else { continue };
                let Some((area, first, bits)) = first_cell(device) else { continue };
                let raise = |known: &mut BTreeMap<AreaId, u32>, count: u32| {
                    let end = known.entry(area).or_default();
                    *end = (*end).max(first.saturating_add(count));
                };
                raise(&mut highest, bits);
                raise(&mut with_blocks, block(item, at, bits).unwrap_or(0).max(bits));
            }
        }
        NamedDevices { highest, with_blocks }
    }
}

/// The area of a device with a known or indexed number, that number, and how many cells its text names: one, or the
/// bits of a digit designation. `None` for timers, counters and devices without cells.
fn first_cell(device: &Device) -> Option<(AreaId, u32, u32)> {
    let (kind, number, cells) = match device.place {
        Place::At(kind, number) | Place::BitOf(kind, number, _) => (kind, number, 1),
        Place::Digits(kind, number, digits) => (kind, number, 4 * u32::from(digits)),
        Place::Indexed(kind, _) => (kind, device.index?.number, 1),
        Place::IndexedDigits(kind, digits) => (kind, device.index?.number, 4 * u32::from(digits)),
        Place::Indirect | Place::Foreign(_) | Place::Fixed(_) | Place::FirstScan(_) => return None,
    };
    match kind {
        DeviceType::Bit(area) | DeviceType::Word(area) => Some((area, number, cells)),
        DeviceType::Timed(_) | DeviceType::VolatileBit | DeviceType::VolatileWord => None,
    }
}

/// The number of cells of the block of constant length that begins at operand `at`, if there is one. `cells` are those
/// of one element.
fn block(item: &Item<'_>, at: usize, cells: u32) -> Option<u32> {
    let Category::Listed(listed) = &item.category else { return None };
    let Ok(Operand::Device(device)) = &item.operands[at] else { return None };
    let (Extent::Words(amount) | Extent::Devices(amount)) = listed.entry.operands.get(at)?.extent
    else {
        return None;
    };
    let units = match amount {
        Amount::Fixed(units) => units,
        Amount::Counted { unit, operand } => match item.operands.get(operand)? {
            Ok(Operand::Constant(count)) => u32::try_from(*count).ok()?.checked_mul(unit)?,
            _ => return None,
        },
        Amount::Power { .. } | Amount::UpTo { .. } | Amount::Unknown => return None,
    };
    let is_words = matches!(listed.entry.operands.get(at)?.extent, Extent::Words(_));
    let each = match device.place {
        Place::At(DeviceType::Bit(_), _) if is_words => 16,
        _ => cells,
    };
    units.checked_mul(each)
}
