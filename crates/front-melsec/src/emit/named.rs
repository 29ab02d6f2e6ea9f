//! What an instruction's operands name, for the price: their kinds, and the cells and bits of words behind them,
//! also where its meaning shows none because it is taken as any value.

use super::Emitter;
use super::access::REST;
use crate::catalog::{Amount, Extent, Role};
use crate::memory::{Kind, area};
use crate::mnemonic::Sort;
use crate::operand::{Device, Modifiers, Operand, Place, Pointer};
use crate::resolve::Category;
use crate::source::RawInstruction;
use scanbound_ir::{AccessedDevices, AreaId, Cell, Region, TimingKey};

/// An operand is priced for so many bits of words at most, also where how many it has is not known.
const MOST_WORD_BITS: u32 = 65_536;
/// Indirect access reads its address from two words.
const ADDRESS_WORDS: u32 = 2;

/// A device among an instruction's operands.
struct Named {
    device: Device,
    extent: Extent,
    /// It is both read and written.
    changes: bool,
}

impl Emitter<'_> {
    /// Completes the key of the instruction under way: names with the kinds of its operands, and what it touches.
    pub(super) fn with_operands(&self, mut key: TimingKey) -> TimingKey {
        let Some(raw) = self.now.raw else { return key };
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
        for Named { device, extent, changes } in &devices {
            // What is changed is accessed twice.
            for _ in 0..1 + usize::from(*changes) {
                touch(&mut key.accessed, device, self.units_of(raw, *extent));
            }
        }
        key
    }

    /// The devices among the operands.
    fn devices(&self) -> Vec<Named> {
        let item = &self.resolved.items[self.now.item];
        let compared = match &item.category {
            Category::Comparison { sort, .. } => Some(match *sort {
                Sort::Integer { words, .. } | Sort::Real { words } => {
                    Extent::Words(Amount::Fixed(words as u32))
                }
                Sort::Text => Extent::Text,
                Sort::Clock => Extent::Words(Amount::Fixed(3)),
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
                Some(Named { device, extent, changes })
            })
            .collect()
    }

    /// How many units an extent has, and whether they are words. Where it is not known it is `REST`: then the price
    /// counts by the instruction's units.
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

/// The kinds of operands that have rows of their own, in the order in which these are looked for.
fn kinds(devices: &[Named]) -> Vec<&'static str> {
    let all = devices.iter().map(|named| named.device.modifiers);
    let all = all.fold(Modifiers::default(), Modifiers::or);
    let kinds = [("module", all.module), ("indexed", all.indexed), ("digits", all.digits)];
    kinds.into_iter().filter(|(_, has)| *has).map(|(kind, _)| kind).collect()
}

/// Notes what a device operand of so many units touches. Timers and counters have no rows by area.
fn touch(touched: &mut AccessedDevices, device: &Device, (units, is_words): (u32, bool)) {
    if device.modifiers.word_bit {
        touched.word_bits += u64::from(units.min(MOST_WORD_BITS));
    }
    let mut range = |area: AreaId, index: u32, count: u32| {
        touched.regions.push(Region::Range { first: Cell { area, index }, count });
    };
    // What stands behind an index is not known: the number alone counts.
    let somewhere = 0;
    let bits_of = |digits: u8| units.saturating_mul(4 * u32::from(digits)).min(REST);
    if let Some(Pointer { kind: Kind::Word(area), first }) = device.pointer {
        range(area, first.unwrap_or(somewhere), ADDRESS_WORDS);
    }
    match device.place {
        Place::At(Kind::Word(area), index) => range(area, index, units),
        Place::Indexed(Kind::Word(area), false) => range(area, somewhere, units),
        Place::At(Kind::Bit(area), index) => {
            range(area, index, if is_words { units.saturating_mul(16).min(REST) } else { units });
        }
        Place::Indexed(Kind::Bit(area), _) => range(area, somewhere, units),
        Place::Digits(Kind::Bit(area), index, digits) => range(area, index, bits_of(digits)),
        Place::IndexedDigits(Kind::Bit(area), digits) => range(area, somewhere, bits_of(digits)),
        Place::BitOf(Kind::Word(area), index, _) => range(area, index, 1),
        Place::Indexed(Kind::Word(area), true) => range(area, somewhere, 1),
        // A direct input is one of the inputs.
        Place::At(Kind::VolatileBit, index) if device.name == "DX" => {
            range(area("X"), index, units);
        }
        Place::Digits(Kind::VolatileBit, index, digits) if device.name == "DX" => {
            range(area("X"), index, bits_of(digits));
        }
        _ => {}
    }
}
