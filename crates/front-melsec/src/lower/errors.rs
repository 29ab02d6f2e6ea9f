//! Operation errors: invalid operands, blocks that exceed their area, nesting that is too deep. Most CPUs stop at such
//! an error by default; those of MELSEC-F record it and continue.

use super::state::Lowering;
use crate::catalog::{Amount, Entry, Extent};
use crate::memory::{DeviceType, Family};
use crate::operand::{Device, Operand, Place};
use crate::source::RawInstruction;
use scanbound_ir::errors::{is_above, is_below, is_invalid_bcd, is_outside, is_zero};
use scanbound_ir::meaning::{
    ChoiceKind, Count, IntegerFormat, Meaning, Operation, OperationInput as Input, Term, Unary,
};
use scanbound_ir::{
    BitSource, Compare, Logic, Number, NumberFormat, Program, Relation, Step, WordSource, flow,
};
use std::collections::{BTreeMap, BTreeSet};

/// The maximum nesting depth of FOR loops, and of calls, at which a CPU does not stop.
const DEEPEST: usize = 16;
/// The maximum nesting depth of FOR loops, and of calls, on MELSEC-F. It does not start a program with more levels.
const DEEPEST_FX: usize = 5;
/// The bit pattern of the IEEE 754 single 1.0.
const ONE: i64 = 0x3F80_0000;
/// The bit pattern of the largest IEEE 754 single below 2^15.
const LARGEST_WORD: i64 = 0x46FF_FFFF;
/// The bit pattern of the largest IEEE 754 single below 2^31.
const LARGEST_DOUBLE: i64 = 0x4EFF_FFFF;

impl Lowering<'_> {
    /// Whether the CPU stops at an operation error: as the facts state, otherwise on all families but the FX.
    pub(super) fn stops_on_error(&self) -> bool {
        self.options.facts.stops_on_error.unwrap_or(self.family != Family::Fx)
    }

    /// Records a condition under which the current instruction causes an operation error; `None` records nothing.
    pub(super) fn note_error(&mut self, error: Option<Logic>) {
        if let Some(error) = error
            && !self.current.errors.contains(&error)
        {
            self.current.errors.push(error);
        }
    }

    /// Records the conditions under which a catalog instruction causes an operation error that its exact meaning does
    /// not report. Does nothing if the CPU continues after errors.
    pub(super) fn note_errors(&mut self, raw: &RawInstruction, entry: &Entry) {
        if !self.stops_on_error() {
            return;
        }
        // Errors in its operands were already reported.
        self.current.quiet = true;
        let error = self.operand_error(raw, entry);
        self.note_error(error);
        for (text, operand) in raw.operands.iter().zip(&entry.operands) {
            let error = self.block_error(raw, entry, text, operand.extent);
            self.note_error(error);
        }
        self.current.quiet = false;
    }

    /// The condition under which an operand has a value that the instruction refuses. `None` if it refuses none, or if
    /// this is not modelled.
    fn operand_error(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Logic> {
        let texts: Vec<&str> = raw.operands.iter().map(String::as_str).collect();
        let name = entry.mnemonic.strip_suffix("_U").unwrap_or(&entry.mnemonic);
        let double = name.strip_prefix('D').filter(|rest| !rest.is_empty());
        match (name, &texts[..]) {
            ("DECO" | "ENCO", [.., power]) => self.power_error(power),
            // Whether other CPUs than the FX reset a range whose first device is above its last one is unknown.
            ("ZRST", [first, last]) if self.family != Family::Fx => {
                let number = |text: &str| match self.parsed(text) {
                    Ok(Operand::Device(Device { place: Place::At(_, number), .. })) => Some(number),
                    _ => None,
                };
                let ends = number(first).zip(number(last));
                ends.is_some_and(|(first, last)| first > last).then_some(Logic::Const(true))
            }
            ("DIS" | "UNI", [.., count]) => match self.constant(count) {
                Some(count) => (!(0..=4).contains(&count)).then_some(Logic::Const(true)),
                None => Some(is_outside(&self.number(count, 1)?, 0, 4)),
            },
            ("E/" | "EDIV" | "DEDIV", [.., divisor, _]) => {
                Some(is_zero(&magnitude(self.read_words(divisor, 2)?)))
            }
            ("SQR" | "ESQR" | "DESQR" | "ESQRT", [root, _]) => {
                Some(is_below(&self.number(root, 2)?, 0))
            }
            ("SQRD" | "EDSQRT", [root, _]) => Some(is_below(&self.number(root, 4)?, 0)),
            ("BDSQR", [root, _]) => is_invalid_bcd(&self.number(root, 2)?),
            ("LOG" | "LOG10" | "DLOGE" | "DLOG10", [number, _]) => {
                Some(is_above(&self.number(number, 2)?, 0).not())
            }
            ("ASIN" | "ACOS" | "DASIN" | "DACOS", [number, _]) => {
                Some(is_above(&magnitude(self.read_words(number, 2)?), ONE))
            }
            ("INT" | "DINT", [number, _]) if self.family != Family::Fx5 => {
                let most = if name == "INT" { LARGEST_WORD } else { LARGEST_DOUBLE };
                Some(is_above(&magnitude(self.read_words(number, 2)?), most))
            }
            _ => {
                let (plain, words) = match double.filter(|_| name != "DIV") {
                    Some(plain) => (plain, 2),
                    None => (name, 1),
                };
                let (operation, read) = match plain {
                    "BCD" => (Operation::Each(Unary::ToBcd), 1),
                    "BIN" | "BSQR" => (Operation::Each(Unary::FromBcd), 1),
                    "/" | "DIV" => (Operation::Divide { signed: true }, 2),
                    "B/" => (Operation::DecimalDivide, 2),
                    "B+" | "B-" | "B*" => (Operation::DecimalMultiply, 2),
                    "LIMIT" | "BAND" | "ZONE" if !entry.mnemonic.ends_with("_U") => {
                        (Operation::Limit, 2)
                    }
                    _ => return None,
                };
                let inputs = texts.iter().take(read).map(|text| self.number(text, words));
                let inputs =
                    inputs.map(|number| number.map(Input::Number)).collect::<Option<_>>()?;
                Meaning { operation, inputs, outputs: Vec::new() }.operand_error()
            }
        }
    }

    fn power_error(&mut self, power: &str) -> Option<Logic> {
        match self.constant(power) {
            Some(power) => (!(0..=8).contains(&power)).then_some(Logic::Const(true)),
            None => Some(is_outside(&self.number(power, 1)?, 0, 8)),
        }
    }

    /// The condition under which the block that begins at an operand exceeds the end of its area. `None` if it cannot,
    /// or if the size is unknown. For indirect access it is a bit with any value.
    fn block_error(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
        text: &str,
        extent: Extent,
    ) -> Option<Logic> {
        let Ok(Operand::Device(device)) = self.parsed(text) else { return None };
        if let Place::Indirect = device.place {
            return Some(self.indirect_error(raw, entry, &device, extent));
        }
        let (Extent::Words(amount) | Extent::Devices(amount) | Extent::Bits(amount)) = extent
        else {
            return None;
        };
        let is_words = matches!(extent, Extent::Words(_));
        let (area, first, each) = match device.place {
            Place::At(DeviceType::Word(area), first) if !matches!(extent, Extent::Bits(_)) => {
                (area, first, 1)
            }
            Place::At(DeviceType::Bit(area), first) => (area, first, if is_words { 16 } else { 1 }),
            Place::Digits(DeviceType::Bit(area), first, digits) if is_words => {
                (area, first, 4 * u32::from(digits))
            }
            _ => return None,
        };
        let room = self.room(area, first)?;
        let (unit, operand) = match amount {
            Amount::Fixed(units) => {
                let is_short =
                    !matches!(device.place, Place::Digits(..)) && units.saturating_mul(each) > room;
                return is_short.then_some(Logic::Const(true));
            }
            Amount::Counted { unit, operand } => (unit, operand),
            Amount::Power { .. } | Amount::UpTo { .. } | Amount::Unknown => return None,
        };
        let most = i64::from(room / unit.saturating_mul(each).max(1));
        match self.constant(&raw.operands[operand]) {
            Some(count) => (count > most).then_some(Logic::Const(true)),
            None => {
                let words = self.count_words(raw, entry, operand)?;
                let (left, right) = (Number::Words(words.clone()), limit(most, words.len())?);
                let (relation, format) = (Relation::Greater, NumberFormat::Unsigned);
                Some(Logic::Compare(Box::new(Compare { relation, format, left, right })))
            }
        }
    }

    /// The bit that says whether a block at an indirect address exceeds its area. It may have any value if that is not
    /// modelled.
    fn indirect_error(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
        device: &Device,
        extent: Extent,
    ) -> Logic {
        let count = match extent {
            Extent::Words(Amount::Fixed(words)) => Some(Count::Exactly(words)),
            Extent::Words(Amount::Counted { unit, operand }) => {
                match self.constant(&raw.operands[operand]) {
                    Some(count) => u32::try_from(count)
                        .ok()
                        .and_then(|count| count.checked_mul(unit))
                        .map(Count::Exactly),
                    None => self.count_words(raw, entry, operand).map(|words| Count::Of {
                        term: Term { words, factor: unit.into(), format: IntegerFormat::Unsigned },
                        least: 0,
                        most: u32::MAX,
                    }),
                }
            }
            _ => None,
        };
        let bit = self.free_bit();
        if let (Logic::Bit(BitSource::Free(choice)), Some(count), Some(address)) =
            (&bit, count, self.indirect_address(device))
        {
            let list = Box::new((address, count));
            self.out.program.kinds.insert(*choice, ChoiceKind::Unreachable(list));
        }
        bit
    }

    /// Records an operation error at each loop and call that is nested too deeply. Does nothing if the CPU continues
    /// after errors, except on the FX, which does not start such a program.
    pub(super) fn note_nesting(&mut self) {
        let is_fx = self.family == Family::Fx;
        if self.stops_on_error() || is_fx {
            let deepest = if is_fx { DEEPEST_FX } else { DEEPEST };
            let deep = too_deep(&self.out.program, deepest);
            let errors = &mut self.out.program.errors;
            errors.extend(deep.into_iter().map(|at| (at, Logic::Const(true))));
        }
    }
}

/// The two words of a single-precision number, without the sign bit.
fn magnitude(words: Vec<WordSource>) -> Number {
    let mask = [u16::MAX, 0x7FFF].map(WordSource::Const).to_vec();
    Number::And(Box::new(Number::Words(words)), Box::new(Number::Words(mask)))
}

/// An unsigned constant of one or two words; a larger value becomes the largest that fits. `None` if it is negative or
/// has more words.
fn limit(value: i64, words: usize) -> Option<Number> {
    let value = u32::try_from(value).ok()?.min(if words == 1 { u16::MAX.into() } else { u32::MAX });
    let parts = [value as u16, (value >> 16) as u16].map(WordSource::Const);
    parts.get(..words).map(|parts| Number::Words(parts.to_vec()))
}

/// The instructions that begin a loop inside `deepest` loops, or call a routine inside `deepest` calls. Loops and calls
/// are counted separately.
fn too_deep(program: &Program, deepest: usize) -> BTreeSet<usize> {
    let loops = flow::loops(program);
    let depth =
        |at: usize| loops.iter().filter(|(begin, end)| (*begin..=*end).contains(&at)).count();
    let deep_loops = loops.iter().filter(|(begin, _)| depth(*begin) > deepest);
    let mut found: BTreeSet<usize> = deep_loops.map(|(begin, _)| *begin).collect();
    // The largest number of nested calls that lead to a routine. Recursive calls are refused elsewhere.
    let calls = flow::calls(program);
    let extents: BTreeMap<usize, usize> = calls
        .iter()
        .filter_map(|&(_, target)| Some((target, flow::routine_end(program, target)?)))
        .collect();
    let called_in = |&(at, target): &(usize, usize)| {
        let around = extents.iter().filter(move |(entry, end)| (**entry..=**end).contains(&at));
        (around.map(|(entry, _)| *entry).collect::<Vec<_>>(), target)
    };
    let called_in: Vec<(Vec<usize>, usize)> = calls.iter().map(called_in).collect();
    let mut level: BTreeMap<usize, usize> = BTreeMap::new();
    for _ in 0..=deepest + 1 {
        for (around, target) in &called_in {
            let outer = around.iter().filter_map(|entry| level.get(entry)).max().copied();
            let own = level.entry(*target).or_default();
            *own = (*own).max(outer.unwrap_or(0) + 1);
        }
    }
    for &(at, target) in &calls {
        if level[&target] > deepest && matches!(program.instructions[at].step, Step::Call { .. }) {
            found.insert(at);
        }
    }
    found
}
