//! What reports show for an instruction: the devices of its operands, and device comments.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::memory::{DeviceType, Family, area};
use crate::operand::{self, Operand as Written, Place, parse};
use crate::source::RawInstruction;
use scanbound_front::operand_spans;
use scanbound_ir::{Cell, Device, Operand};

/// The operands of an instruction that are devices with a number, and where they are in its text.
pub(super) fn operands(raw: &RawInstruction, parsed: &[Result<Written, String>]) -> Arc<[Operand]> {
    let spans = operand_spans(&raw.text, &raw.operands);
    let named = parsed.iter().zip(spans).filter_map(|(operand, (start, end))| {
        let Ok(Written::Device(device)) = operand else { return None };
        Some(Operand { start, end, device: named(device)? })
    });
    named.collect()
}

/// The device that an operand names; with an index, the device before the index is added. `None` if it has no cell.
fn named(device: &operand::Device) -> Option<Device> {
    let of = |kind: DeviceType, number: u32, bit: Option<u8>| {
        let cell = match kind {
            // A direct input (DX) is an input (X).
            DeviceType::VolatileBit if device.name == "DX" => {
                Cell { area: area("X"), index: number }
            }
            _ => kind.cell(number)?,
        };
        Some(Device { cell, bit })
    };
    match device.place {
        Place::At(kind, number) | Place::Digits(kind, number, _) => of(kind, number, None),
        Place::BitOf(kind, number, bit) => of(kind, number, Some(bit)),
        Place::Indexed(kind, _) | Place::IndexedDigits(kind, _) => {
            let index = device.index?;
            of(kind, index.number, index.bit)
        }
        Place::Indirect | Place::Foreign(_) | Place::Fixed(_) | Place::FirstScan(_) => None,
    }
}

/// The comments by device. A comment of a timer or counter belongs to its contact, coil and present value.
pub(super) fn comments(
    written: &BTreeMap<String, String>,
    family: Family,
) -> BTreeMap<Device, String> {
    let mut comments = BTreeMap::new();
    for (name, comment) in written {
        let comment = comment.trim();
        let Ok(Written::Device(device)) = parse(name, family) else { continue };
        let Some(first) = named(&device).filter(|_| !comment.is_empty()) else { continue };
        comments.insert(first, comment.to_owned());
        if let Place::At(DeviceType::Timed(timed), index) = device.place {
            for area in [timed.coil, timed.value] {
                let cell = Cell { area, index };
                comments.insert(Device { cell, bit: None }, comment.to_owned());
            }
        }
    }
    comments
}
