//! Stated facts about devices: the ranges of words at the start of a scan, and the devices written through indirect
//! addresses.

use super::state::Lowering;
use crate::memory::{DeviceType, Family, area};
use crate::operand::{Device, Operand, Place, parse, upper};
use crate::resolve::DecodeOptions;
use crate::source::RawInstruction;
use crate::structure::Structure;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Part;
use scanbound_front::absent;
use scanbound_ir::{Approximated, Cell, Effect, Region, StartRange, Write};
use std::ops::RangeInclusive;

/// The numbers of the special registers of the FX that are its index registers: Z0 and V0, then Z1 to V7.
pub(super) const INDEX_REGISTERS: [RangeInclusive<u32>; 2] = [8028..=8029, 8182..=8195];
/// If so many errors are listed, further errors in stated ranges are only counted.
const MAX_FAULTS: usize = 100;

/// The regions that may change if the device or device range that `text` names is written. `None` if `text` names none;
/// empty if its devices have no cells. If the program switches file register blocks (`switches`), `R` may be any word
/// of the file register.
pub(super) fn written(text: &str, family: Family, switches: bool) -> Option<Vec<Region>> {
    let (kind, first, count) = devices(text, family)?;
    let is_switched = switches && upper(text.trim()).starts_with('R');
    let region = |area| match is_switched {
        true => Region::Area(area),
        false => Region::Range { first: Cell { area, index: first }, count },
    };
    Some(match kind {
        DeviceType::Bit(area) | DeviceType::Word(area) => vec![region(area)],
        DeviceType::Timed(timed) => timed.areas().map(region).collect(),
        DeviceType::VolatileWord
            if family == Family::Fx
                && INDEX_REGISTERS
                    .iter()
                    .any(|own| first <= *own.end() && *own.start() < first + count) =>
        {
            [area("Z"), area("V index ")].map(Region::Area).to_vec()
        }
        DeviceType::VolatileBit | DeviceType::VolatileWord => Vec::new(),
    })
}

/// Whether the device or device range that `text` names contains the special device of this name.
pub(super) fn has_special(text: &str, special: &str, family: Family) -> bool {
    let (Some((kind, first, count)), Some((other, number, _))) =
        (devices(text, family), devices(special, family))
    else {
        return false;
    };
    kind == other && (first..first + count).contains(&number)
}

/// Whether a missing routine or another station writes a device or device range that `is_one` accepts. A routine whose
/// writes are not stated may write anything.
pub(super) fn others_write(
    structure: &Structure,
    options: &DecodeOptions<'_>,
    is_one: impl Fn(&String) -> bool,
) -> bool {
    let stated = |name: &String| options.facts.calls.get(name).and_then(|one| one.writes.as_ref());
    let mut missing = structure.missing_routines();
    missing.any(|name| stated(name).is_none_or(|writes| writes.iter().any(&is_one)))
        || options.facts.external.iter().any(is_one)
}

/// Parses a device (`D500`) or a device range (`ZR1000-ZR1999`): its type, the first number, and the number of devices.
/// `None` if it is neither.
fn devices(text: &str, family: Family) -> Option<(DeviceType, u32, u32)> {
    let place = |text: &str| match parse(text.trim(), family) {
        Ok(Operand::Device(Device { place: Place::At(kind, number), .. })) => Some((kind, number)),
        _ => None,
    };
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let ((kind, first), (other, last)) = (place(first)?, place(last)?);
    if kind != other || first > last {
        return None;
    }
    Some((kind, first, last - first + 1))
}

/// As [`written`], but `None` for timers, counters and devices without cells, to which an indirect address does not
/// point.
fn addressed(text: &str, family: Family, switches: bool) -> Option<Vec<Region>> {
    let (kind, ..) = devices(text, family)?;
    let has_one = matches!(kind, DeviceType::Bit(_) | DeviceType::Word(_));
    written(text, family, switches).filter(|_| has_one)
}

/// The regions that may be written through indirect addresses, as the facts state them; `None` if they do not. Invalid
/// devices are left out here and reported later.
pub(super) fn indirect(options: &DecodeOptions<'_>, switches: bool) -> Option<Vec<Region>> {
    let stated = options.facts.indirect.as_ref()?;
    let regions = stated.iter().filter_map(|text| addressed(text, options.family, switches));
    Some(regions.flatten().collect())
}

impl Lowering<'_> {
    /// Limits the current instruction's effects through an indirect address to the devices that the user stated.
    pub(super) fn limit_indirect(&self, effects: Vec<Effect>) -> Vec<Effect> {
        let is_indirect = |raw: &&RawInstruction| {
            raw.operands.iter().any(|operand| operand.trim_start().starts_with('@'))
        };
        let (Some(indirect), Some(_)) = (&self.indirect, self.current.raw.filter(is_indirect))
        else {
            return effects;
        };
        let mut limited = Vec::with_capacity(effects.len());
        for effect in effects {
            match effect.write {
                Write::Havoc(Region::Everything, choice) => {
                    limited.extend(indirect.iter().map(|&region| Effect {
                        when: effect.when,
                        write: Write::Havoc(region, choice),
                    }));
                }
                _ => limited.push(effect),
            }
        }
        limited
    }

    /// The smallest and largest count in an operand, and whether it is a constant. For any other operand it is 0 to
    /// `largest`, which is recorded as an over-approximation; later analysis may find a smaller count.
    pub fn count_range(&mut self, text: &str, largest: i64) -> (i64, i64, bool) {
        if let Some(value) = self.constant(text) {
            return (value, value, true);
        }
        self.approximate(Approximated::UnknownCount {
            word: text.into(),
            most: largest,
            can_be_stated: true,
        });
        (0, largest, false)
    }

    /// The cell of an operand that is a word device without an index. `None` for other operands.
    fn word(&self, text: &str) -> Option<Cell> {
        let Ok(Operand::Device(device)) = self.parsed(text) else { return None };
        let Place::At(kind @ DeviceType::Word(_), index) = device.place else { return None };
        kind.cell(index)
    }

    /// Adds the stated ranges of words as constraints on the start of the scan. Returns the errors in these facts: a
    /// text that is not a word, a range that could mean one word or two, and wrong devices among those of indirect
    /// access and missing routines. Errors in ranges are listed only until the list has 100 entries; the others are
    /// counted.
    pub(super) fn start_ranges(&mut self) -> Vec<Diagnostic> {
        let facts = self.options.facts;
        let mut faults = absent::faults(facts, |text| written(text, self.family, false));
        for text in facts.indirect.iter().flatten() {
            if addressed(text, self.family, false).is_none() {
                faults.push(facts.fault(
                    ["index", "indirect"],
                    Part::Value,
                    Code::Fact,
                    format!("'{text}' under [index] indirect is not a device or a device range"),
                    "write \"ZR1000-ZR1999\" or \"D500\": devices as in the program, the lowest number first",
                ));
            }
        }
        let mut dropped = 0;
        let mut fault = |device: &str, part: Part, message: String, help: &str| {
            if faults.len() < MAX_FAULTS {
                faults.push(facts.fault(["ranges", device], part, Code::Fact, message, help));
            } else {
                dropped += 1;
            }
        };
        for (text, &(low, high)) in &self.options.facts.ranges {
            let wide = low < -0x8000 || high > 0xFFFF;
            match self.word(text) {
                None => fault(
                    text,
                    Part::Key,
                    format!(
                        "'{text}' has a stated range, but is not a word whose range can be stated"
                    ),
                    "write a word device without an index, such as D100: ranges of bits and special registers cannot be stated",
                ),
                // The range could be of one unsigned word or of two signed ones.
                Some(_) if !wide && high > 0x7FFF => fault(
                    text,
                    Part::Value,
                    format!(
                        "the range of '{text}' ends at {high}, above 32767, the largest signed word"
                    ),
                    "state a range that ends at most at 32767 (a signed word), or above 65535 (a double word)",
                ),
                Some(first) => {
                    let count = if wide { 2 } else { 1 };
                    let cells = (0..count).map(|n| first.plus(n)).collect();
                    self.out.program.stated_ranges.push(StartRange {
                        cells,
                        low,
                        high,
                        values: Vec::new(),
                    });
                }
            }
        }
        if dropped > 0 {
            let message = format!("{dropped} more stated ranges have errors, which are not listed");
            faults.push(Diagnostic::file(
                Code::Fact,
                "",
                message,
                "correct the listed errors first",
            ));
        }
        faults
    }
}
