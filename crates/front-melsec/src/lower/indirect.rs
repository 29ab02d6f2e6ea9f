//! Indirect access: `ADRSET D100 D0` stores the address of D100 in D0 and D1, and `@D0` is the device at this address.
//!
//! Manuals do not say which numbers addresses are. They say that 32-bit additions to an address take the place of index
//! modification, so that consecutive words have consecutive addresses (MELSEC-Q/L programming manual, common
//! instructions, indirect specification). A real run follows an address only where ADRSET, moves and additions of known
//! numbers determine the device.

use super::state::Lowering;
use crate::memory::{DeviceType, Family, area};
use crate::operand::{Device, Modifiers, Operand, Place};
use scanbound_ir::meaning::{Address, AddressRange, ChoiceKind, IntegerFormat, Term};
use scanbound_ir::{AreaId, Cell, WordSource};

/// The word devices to which an address may lead.
const ADDRESSED: [&str; 3] = ["D", "W", "ZR"];
/// The distance between the numbers that stand for the first addresses of two areas.
const PAGE: i64 = 1 << 24;

/// The number that stands for the address of the first cell of an area.
fn page(cells: AreaId) -> i64 {
    (i64::from(cells.0) + 1) * PAGE
}

impl Lowering<'_> {
    /// The address that an indirect operand (`@D0`) means. `None` for other operands, and for those whose address is
    /// not in two plain word devices.
    pub(super) fn indirect_address(&self, device: &Device) -> Option<Address> {
        let is_large = matches!(self.family, Family::Q | Family::L);
        let is_word = device.modifiers == Modifiers { indexed: true, ..Modifiers::default() };
        let (Place::Indirect, true, Some(words)) =
            (device.place, is_large && is_word, device.address)
        else {
            return None;
        };
        let (DeviceType::Word(area), Some(first)) = (words.kind, words.first) else { return None };
        if self.modes.switches_file_register && area == self::area("ZR") {
            return None;
        }
        let word = |index| WordSource::Cell(Cell { area, index });
        let term = Term {
            words: vec![word(first), word(first + 1)],
            format: IntegerFormat::Address,
            factor: 1,
        };
        let ranges = ADDRESSED.iter().flat_map(|letters| self.pages(letters)).collect();
        Some(Address { base: 0, terms: vec![term], ranges })
    }

    /// The ranges of addresses of the devices with these letters: of data and link registers those of the default
    /// number and those beyond.
    fn pages(&self, letters: &str) -> Vec<AddressRange> {
        let cells = area(letters);
        let range = |base: u32| {
            let found = self.device_address((cells, letters), base.into(), Vec::new())?;
            found.ranges.first().copied()
        };
        let mut found: Vec<AddressRange> = range(0).into_iter().collect();
        found.extend(range(u32::MAX >> 8).filter(|more| !found.contains(more)));
        for one in &mut found {
            one.from += page(cells);
        }
        found
    }

    /// What ADRSET stores for the operand. `None` if it is not a device to which an address may lead.
    pub(super) fn address_of(&self, text: &str) -> Option<ChoiceKind> {
        let Ok(Operand::Device(device)) = self.parsed(text) else { return None };
        let Place::At(DeviceType::Word(cells), index) = device.place else { return None };
        if !ADDRESSED.contains(&device.name) {
            return None;
        }
        let number = page(cells) + i64::from(index);
        let holds = |range: &AddressRange| {
            (range.from..range.from + i64::from(range.chosen)).contains(&number)
        };
        let range = self.pages(device.name).into_iter().find(holds)?;
        Some(ChoiceKind::AddressOf { number: u32::try_from(number).ok()?, first: range.first })
    }
}
