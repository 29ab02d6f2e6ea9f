//! What the user states of words: their ranges where the scan starts, and what is written through indirect addresses.

use super::{DecodeOptions, Emitter};
use crate::memory::{Family, Kind, area};
use crate::operand::{Device, Operand, Place, parse, upper};
use crate::source::RawInstruction;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Part;
use scanbound_front::absent;
use scanbound_ir::{Approximated, Cell, Effect, Region, StartRange, Write};

/// More faults than this are counted, not listed.
const MOST_FAULTS: usize = 100;

/// What may be read and written of the devices that a text names: one, or all from the first to the last. Where the block
/// of the file register is switched, `R` may be any of its words.
pub(super) fn written(text: &str, family: Family, switches: bool) -> Option<Vec<Region>> {
    let (kind, first, count) = devices(text, family)?;
    let is_switched = switches && upper(text.trim()).starts_with('R');
    let region = |area| match is_switched {
        true => Region::Area(area),
        false => Region::Range { first: Cell { area, index: first }, count },
    };
    Some(match kind {
        Kind::Bit(area) | Kind::Word(area) => vec![region(area)],
        Kind::Timed(timed) => timed.areas().map(region).collect(),
        // Some of the FX's special registers are its index registers.
        Kind::VolatileWord if family == Family::Fx => {
            [area("Z"), area("V index ")].map(Region::Area).to_vec()
        }
        Kind::VolatileBit | Kind::VolatileWord => Vec::new(),
    })
}

/// The devices that a text names: one, or all from the first to the last. Their kind, the first, and how many.
fn devices(text: &str, family: Family) -> Option<(Kind, u32, u32)> {
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

/// The same where an address names them: timers and counters have none of one sort.
fn addressed(text: &str, family: Family, switches: bool) -> Option<Vec<Region>> {
    let (kind, ..) = devices(text, family)?;
    let has_one = matches!(kind, Kind::Bit(_) | Kind::Word(_));
    written(text, family, switches).filter(|_| has_one)
}

/// All that may be written through indirect addresses, if that is stated; what is no device is a fault later.
pub(super) fn indirect(options: &DecodeOptions<'_>, switches: bool) -> Option<Vec<Region>> {
    let stated = options.facts.indirect.as_ref()?;
    let regions = stated.iter().filter_map(|text| addressed(text, options.family, switches));
    Some(regions.flatten().collect())
}

impl Emitter<'_> {
    /// The effects of the instruction under way, kept to what indirect addresses are stated to reach.
    pub(super) fn pointed(&self, effects: Vec<Effect>) -> Vec<Effect> {
        let is_indirect = |raw: &&RawInstruction| {
            raw.operands.iter().any(|operand| operand.trim_start().starts_with('@'))
        };
        let (Some(indirect), Some(_)) = (&self.indirect, self.now.raw.filter(is_indirect)) else {
            return effects;
        };
        let mut kept = Vec::with_capacity(effects.len());
        for effect in effects {
            match effect.write {
                Write::Havoc(Region::Everything, choice) => {
                    kept.extend(indirect.iter().map(|&region| Effect {
                        when: effect.when,
                        write: Write::Havoc(region, choice),
                    }));
                }
                _ => kept.push(effect),
            }
        }
        kept
    }

    /// The least and largest value of a count that stands in an operand, and whether it is a constant. What a word can
    /// hold there is found later: here it is 0 to `largest`.
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

    /// The cell of a plain word device.
    fn word(&self, text: &str) -> Option<Cell> {
        let Ok(Operand::Device(device)) = self.parsed(text) else { return None };
        let Place::At(kind @ Kind::Word(_), index) = device.place else { return None };
        kind.cell(index)
    }

    /// Makes the user's stated ranges of words constraints on the scan's start. Faults are those of what is no
    /// word, and those that leave open whether one word or two are meant.
    pub(super) fn start_ranges(&mut self) -> Vec<Diagnostic> {
        let facts = self.options.facts;
        let mut faults = absent::faults(facts, |text| written(text, self.family, false));
        for text in facts.indirect.iter().flatten() {
            if addressed(text, self.family, false).is_none() {
                faults.push(facts.fault(
                    ["index", "indirect"],
                    Part::Value,
                    Code::Fact,
                    format!("'{text}' is not a device or a device range"),
                    "write \"ZR1000-ZR1999\" or \"D500\": devices as in the program, the lowest number first",
                ));
            }
        }
        let mut dropped = 0;
        let mut fault = |device: &str, part: Part, message: String, help: &str| {
            if faults.len() < MOST_FAULTS {
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
                    format!("a range is stated for '{text}', which is no word"),
                    "write the word as in the program, such as D100",
                ),
                // One unsigned word or two signed ones: that is not said.
                Some(_) if !wide && high > 0x7FFF => fault(
                    text,
                    Part::Value,
                    format!("the range of '{text}' reaches to {high}, past a signed word's 32767"),
                    "ranges are of signed words, or of double words from 65536 on: state a smaller one",
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
            let message = format!("and {dropped} further stated ranges with faults, not listed");
            faults.push(Diagnostic::file(Code::Fact, "", message, "mend those listed first"));
        }
        faults
    }
}
