//! What the time of an instruction depends on besides its name: the types of its operands, and the cells and word bits
//! that it accesses. This is known even if the instruction's effects are only "any value".

use super::access::REST;
use super::state::Lowering;
use crate::catalog::{Amount, Extent, Role};
use crate::memory::{DeviceType, area};
use crate::mnemonic::OperandType;
use crate::operand::{AddressWords, Device, Modifiers, Operand, Place};
use crate::resolve::Category;
use crate::source::RawInstruction;
use scanbound_ir::{AccessedDevices, AreaId, Cell, Region, TimingKey};

/// The largest number of accesses to bits of words (`D0.3`) that is counted for one operand; more only result from an
/// unknown length.
const MAX_WORD_BITS: u32 = 65_536;
/// The number of words that hold an indirect address.
const ADDRESS_WORDS: u32 = 2;

/// A device operand of an instruction, and how the instruction accesses it.
struct AccessedDevice {
    device: Device,
    extent: Extent,
    /// Whether the instruction both reads and writes the device.
    changes: bool,
}

impl Lowering<'_> {
    /// Adds to the timing key of the current instruction the names of the table rows for its operand types
    /// (`MOV:module`, tried before `MOV`), and the devices that it accesses.
    pub(super) fn with_operands(&self, mut key: TimingKey) -> TimingKey {
        let Some(raw) = self.current.raw else { return key };
        let devices = self.devices();
        let kinds = kinds(&devices);
        if !kinds.is_empty() {
            let mut names: Vec<String> = Vec::new();
            let mut last = String::new();
            for name in key.names {
                let base = name.split_once(':').map_or(name.as_str(), |(base, _)| base);
                if base != last {
                    names.extend(kinds.iter().map(|kind| format!("{base}:{kind}")));
                    last = base.to_owned();
                }
                names.push(name);
            }
            key.names = names;
        }
        for AccessedDevice { device, extent, changes } in &devices {
            // What is both read and written counts as two accesses.
            for _ in 0..1 + usize::from(*changes) {
                touch(&mut key.accessed, device, self.units_of(raw, *extent));
            }
        }
        key
    }

    /// The devices that the operands of the current instruction name, except operands that are only addresses.
    fn devices(&self) -> Vec<AccessedDevice> {
        let item = &self.resolved.items[self.current.item];
        let compared = match &item.category {
            Category::Comparison { sort, .. } => Some(match *sort {
                OperandType::Integer { words, .. } | OperandType::Real { words } => {
                    Extent::Words(Amount::Fixed(words as u32))
                }
                OperandType::Text => Extent::Text,
                OperandType::Clock => Extent::Words(Amount::Fixed(3)),
            }),
            _ => None,
        };
        let row = match &item.category {
            Category::Listed(found) => &found.entry.operands[..],
            _ => &[],
        };
        let operands = item.operands.iter().enumerate();
        operands
            .filter_map(|(n, operand)| {
                let listed = row.get(n);
                if listed.is_some_and(|operand| operand.role == Role::Address) {
                    return None;
                }
                let &Ok(Operand::Device(device)) = operand else { return None };
                let one = Extent::Devices(Amount::Fixed(1));
                let extent = compared.or(listed.map(|operand| operand.extent)).unwrap_or(one);
                let changes = item.name == "FF"
                    || listed.is_some_and(|operand| operand.role == Role::ReadWrite);
                Some(AccessedDevice { device, extent, changes })
            })
            .collect()
    }

    /// The number of units of an extent, and whether they are words. If the number is unknown it is [`REST`]; twice the
    /// units of the instruction, but at least 8, are then charged.
    fn units_of(&self, raw: &RawInstruction, extent: Extent) -> (u32, bool) {
        let counted = |operand: usize| {
            let count = raw.operands.get(operand).and_then(|text| self.constant(text));
            count.and_then(|count| u32::try_from(count).ok())
        };
        let units = match extent.amount() {
            Amount::Fixed(units) => Some(units),
            Amount::Counted { unit, operand } => {
                counted(operand).and_then(|count| count.checked_mul(unit))
            }
            Amount::Power { operand } => {
                counted(operand).filter(|&power| power <= 16).map(|power| 1 << power)
            }
            Amount::UpTo { .. } | Amount::Unknown => None,
        };
        (units.map_or(REST, |units| units.min(REST)), matches!(extent, Extent::Words(_)))
    }
}

/// The types among the operands that have table rows of their own (`module`, `indexed`, `digits`), in the order in
/// which these rows are tried.
fn kinds(devices: &[AccessedDevice]) -> Vec<&'static str> {
    let all = devices.iter().map(|named| named.device.modifiers);
    let all = all.fold(Modifiers::default(), Modifiers::or);
    let kinds = [("module", all.module), ("indexed", all.indexed), ("digits", all.digits)];
    kinds.into_iter().filter(|(_, has)| *has).map(|(kind, _)| kind).collect()
}

/// Adds the access to a device operand with this many units (words if `is_words`). Timers and counters are left out,
/// because they have no table rows by area.
fn touch(touched: &mut AccessedDevices, device: &Device, (units, is_words): (u32, bool)) {
    if device.modifiers.word_bit {
        touched.word_bits += u64::from(units.min(MAX_WORD_BITS));
    }
    let mut range = |area: AreaId, index: u32, count: u32| {
        touched.regions.push(Region::Range { first: Cell { area, index }, count });
    };
    // With an index the device is unknown: only the number of units counts.
    let somewhere = 0;
    let bits_of = |digits: u8| units.saturating_mul(4 * u32::from(digits)).min(REST);
    if let Some(AddressWords { kind: DeviceType::Word(area), first }) = device.address {
        range(area, first.unwrap_or(somewhere), ADDRESS_WORDS);
    }
    match device.place {
        Place::At(DeviceType::Word(area), index) => range(area, index, units),
        Place::Indexed(DeviceType::Word(area), false) => range(area, somewhere, units),
        Place::At(DeviceType::Bit(area), index) => {
            range(area, index, if is_words { units.saturating_mul(16).min(REST) } else { units });
        }
        Place::Indexed(DeviceType::Bit(area), _) => range(area, somewhere, units),
        Place::Digits(DeviceType::Bit(area), index, digits) => range(area, index, bits_of(digits)),
        Place::IndexedDigits(DeviceType::Bit(area), digits) => {
            range(area, somewhere, bits_of(digits))
        }
        Place::BitOf(DeviceType::Word(area), index, _) => range(area, index, 1),
        Place::Indexed(DeviceType::Word(area), true) => range(area, somewhere, 1),
        // A direct input (DX) is an input (X).
        Place::At(DeviceType::VolatileBit, index) if device.name == "DX" => {
            range(area("X"), index, units);
        }
        Place::Digits(DeviceType::VolatileBit, index, digits) if device.name == "DX" => {
            range(area("X"), index, bits_of(digits));
        }
        _ => {}
    }
}
