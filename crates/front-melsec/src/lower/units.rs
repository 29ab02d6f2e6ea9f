//! The number of units (words, digits, characters) that an application instruction processes.

use super::state::Lowering;
use crate::catalog::{Amount, Entry, Extent, InstructionEffect, Role};
use crate::memory::{DeviceType, Family};
use crate::operand::{Operand, Place};
use crate::source::RawInstruction;
use scanbound_ir::{Approximated, Counted, Units, WordSource};

/// The longest string of a PLC, in characters.
pub(super) const LONGEST_TEXT: u64 = 16_383;

/// Instructions whose number of words is at most `FX_MAX` on the FX.
const FX_SHORT: [&str; 20] = [
    "BMOV", "FMOV", "DFMOV", "MEAN", "DMEAN", "SER", "DSER", "HEX", "ASCI", "CCD", "CRC", "DIS",
    "UNI", "WSFR", "WSFL", "SFWR", "SFRD", "ABSD", "DABSD", "INCD",
];
/// The largest number of words in a block of the instructions in `FX_SHORT`.
const FX_MAX: i64 = 512;
/// The largest number of devices of one type in any CPU. A larger number of units is an operation error, and nothing is
/// executed.
const MAX_DEVICES: i64 = 0x100_0000;

impl Lowering<'_> {
    /// The number of units of a catalog instruction, by which its time per unit is multiplied: the count of its
    /// counting operand; else the devices in its range (ZRST and similar); else the largest number that its catalog row
    /// gives; else the characters of its constant texts; else the length of its longest operand. Classes without a time
    /// per unit have no units.
    pub(super) fn units(&mut self, raw: &RawInstruction, entry: &Entry) -> Units {
        if let Some(operand) = entry.units {
            let (low, high, _) = self.block_count(raw, entry, operand);
            let most = u64::try_from(high).unwrap_or(0);
            if low == high {
                return Units::Exactly(most.saturating_mul(entry.unit_size));
            }
            return match self.count_words(raw, entry, operand) {
                Some(words) => Units::Counted(Counted {
                    words,
                    each: entry.unit_size,
                    most,
                    executes_up_to: self.executable_count(raw, entry, operand),
                }),
                None => Units::AtMost(most.saturating_mul(entry.unit_size)),
            };
        }
        if entry.meaning == InstructionEffect::ClearRange {
            return self.units_of_range(raw, entry);
        }
        if let Some(most) = entry.most_units {
            return Units::AtMost(most);
        }
        match entry.class {
            "block" | "string" | "search" | "module" | "table" | "dedicated" => self
                .constant_texts(raw, entry)
                .map_or_else(|| self.units_of_operands(raw, entry), Units::Exactly),
            _ => Units::None,
        }
    }

    /// The words that hold the number of units. `None` if these are not one or two plain word cells.
    pub(super) fn count_words(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
        operand: usize,
    ) -> Option<Vec<WordSource>> {
        let is_long = entry.operands[operand].extent == Extent::Words(Amount::Fixed(2));
        let words = self.read_words(&raw.operands[operand], if is_long { 2 } else { 1 })?;
        words.iter().all(|word| matches!(word, WordSource::Cell(_))).then_some(words)
    }

    /// The largest count with which the instruction surely executes: everything that it accesses exists in each CPU of
    /// the family. 0 if unknown.
    fn executable_count(&mut self, raw: &RawInstruction, entry: &Entry, counting: usize) -> u64 {
        let mut all = None;
        for (text, operand) in raw.operands.iter().zip(&entry.operands) {
            let (Extent::Bits(amount) | Extent::Words(amount) | Extent::Devices(amount)) =
                operand.extent
            else {
                continue;
            };
            if amount.counter() != Some(counting) {
                continue;
            }
            let Amount::Counted { unit, .. } = amount else { return 0 };
            let room = match self.parsed(text) {
                Ok(Operand::Device(device)) => match device.place {
                    Place::At(kind @ DeviceType::Word(_), index) => {
                        kind.cell(index).and_then(|cell| {
                            self.points(cell.area, device.name)?.checked_sub(cell.index)
                        })
                    }
                    _ => None,
                },
                // A constant in place of a block has no end that a count could exceed.
                Ok(Operand::Constant(_)) if operand.role == Role::Source => continue,
                _ => None,
            };
            let words = matches!(operand.extent, Extent::Words(_));
            let Some(room) = room.filter(|_| words && unit > 0) else { return 0 };
            let most = u64::from(room / unit);
            all = Some(all.map_or(most, |all: u64| all.min(most)));
        }
        all.unwrap_or(0).min(self.most_elements().into())
    }

    /// The total number of characters of all texts that the instruction reads. `None` if it reads no text, or if some
    /// text is not a constant.
    fn constant_texts(&self, raw: &RawInstruction, entry: &Entry) -> Option<u64> {
        if !entry
            .operands
            .iter()
            .any(|operand| operand.extent == Extent::Text && operand.role != Role::Destination)
        {
            return None;
        }
        let mut characters = 0;
        for (text, operand) in raw.operands.iter().zip(&entry.operands) {
            if operand.extent == Extent::Text && operand.role != Role::Destination {
                match self.parsed(text) {
                    Ok(Operand::Text(text)) => characters += text.chars().count() as u64,
                    _ => return None,
                }
            }
        }
        Some(characters)
    }

    /// The number of units of an instruction that works on all devices from the first operand to the second; at most
    /// the largest count if these devices are unknown.
    fn units_of_range(&mut self, raw: &RawInstruction, entry: &Entry) -> Units {
        if let (Some(first), Some(last)) =
            (self.device(&raw.operands[0]), self.device(&raw.operands[1]))
            && let (Place::At(kind, from), Place::At(other, to)) = (first.place, last.place)
            && kind.cell(0).is_some()
            && kind.cell(0) == other.cell(0)
        {
            return Units::Exactly(u64::from(to.saturating_sub(from)) + 1);
        }
        Units::AtMost(self.most_counted(entry) as u64)
    }

    /// The number of units of an instruction without a counting operand: the length of its longest operand, or an upper
    /// limit if a length is unknown.
    fn units_of_operands(&self, raw: &RawInstruction, entry: &Entry) -> Units {
        let mut most = 1;
        for operand in &entry.operands {
            if operand.extent == Extent::Text {
                match operand.role {
                    Role::Destination => continue,
                    _ => return Units::AtMost(LONGEST_TEXT),
                }
            }
            most = most.max(match operand.extent.amount() {
                Amount::Fixed(count) => u64::from(count),
                Amount::Counted { unit, operand } => match self.constant(&raw.operands[operand]) {
                    Some(count) if count >= 0 => count.unsigned_abs() * u64::from(unit).max(1),
                    _ => {
                        return Units::AtMost(
                            self.most_counted(entry) as u64 * u64::from(unit).max(1),
                        );
                    }
                },
                Amount::Power { .. } | Amount::Unknown if matches!(operand.role, Role::Address) => {
                    1
                }
                Amount::Power { operand } => match self.constant(&raw.operands[operand]) {
                    Some(power) => 1 << power.clamp(0, 16),
                    None => 1 << 8,
                },
                Amount::UpTo { .. } | Amount::Unknown => {
                    return Units::AtMost(self.most_counted(entry) as u64);
                }
            });
        }
        Units::Exactly(most)
    }

    /// The largest number of units that the instruction can process when a word gives the count: 512 for certain
    /// instructions of the FX, otherwise 65,535.
    fn most_counted(&self, entry: &Entry) -> i64 {
        let is_short = self.family == Family::Fx && FX_SHORT.contains(&&*entry.mnemonic);
        if is_short { FX_MAX } else { 65_535 }
    }

    /// The smallest and largest count of words or bits in a counting operand, and whether it is a constant. Counts are
    /// unsigned, so a negative number is a large count.
    pub(super) fn block_count(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
        operand: usize,
    ) -> (i64, i64, bool) {
        let text = &raw.operands[operand];
        let is_long = entry.operands[operand].extent == Extent::Words(Amount::Fixed(2));
        if is_long && self.constant(text).is_none() {
            // A stated range is about the lower word only.
            self.approximate(Approximated::UnknownCount {
                word: text.as_str().into(),
                most: MAX_DEVICES,
                can_be_stated: false,
            });
            return (0, MAX_DEVICES, false);
        }
        let (low, high, known) = self.count_range(text, self.most_counted(entry));
        if low < 0 { (0, high.max(0xFFFF), known) } else { (low, high, known) }
    }
}
