//! How operands are read and written: cells, bits of words, digits, and whatever is only known to be somewhere.

use super::Emitter;
use crate::memory::{FUNCTION_WORDS, Family, Kind, area, has_own_clock, kind};
use crate::operand::{Device, HOW_TO_WRITE, Operand, Place};
use scanbound_base::code::Code;
use scanbound_ir::{
    AreaId, BitSource, BitTarget, Cell, ChoiceId, Logic, Number, Region, WordSource, WordTarget,
};

/// Where a bit is written.
#[derive(Debug, Clone, Copy)]
pub enum BitPlace {
    /// A bit.
    One(BitTarget),
    /// Some bit of these.
    Somewhere(Region),
    /// No memory of the program's.
    Nowhere,
}

/// Where words are written.
#[derive(Debug, Clone)]
pub enum WordPlace {
    /// These words.
    All(Vec<WordTarget>),
    /// Some words of these.
    Somewhere(Region),
    /// No memory of the program's.
    Nowhere,
}

/// A count of cells that reaches to the end of any area, and to which an index can be added.
pub(super) const REST: u32 = u32::MAX / 2;

impl Emitter<'_> {
    /// A new choice.
    pub fn choice(&mut self) -> ChoiceId {
        self.out.choice()
    }

    /// A bit of any value.
    pub fn free_bit(&mut self) -> Logic {
        self.out.free_bit()
    }

    /// A word of any value.
    pub fn free_word(&mut self) -> WordSource {
        self.out.free_word()
    }

    /// Reads an operand's text; a fault is noted.
    pub fn operand(&mut self, text: &str) -> Option<Operand> {
        match self.parsed(text) {
            Ok(operand) => {
                self.name_words(&operand);
                let is_link = text.starts_with(['J', 'j'])
                    && matches!(&operand, Operand::Device(device) if matches!(device.place, Place::Foreign(_)));
                if is_link {
                    let next = self.out.program.instructions.len();
                    self.out.program.first_direct_access.get_or_insert(next);
                }
                Some(operand)
            }
            Err(message) => {
                self.fault(Code::Operand, text, message, HOW_TO_WRITE);
                None
            }
        }
    }

    /// Names the words of a function register, of which the area has several each.
    fn name_words(&mut self, operand: &Operand) {
        let Operand::Device(device) = operand else { return };
        if let (
            Place::At(Kind::Word(area), first) | Place::BitOf(Kind::Word(area), first, _),
            "FD",
        ) = (device.place, device.name)
        {
            for n in 0..FUNCTION_WORDS {
                let word = if n == 0 { String::new() } else { format!(", word {}", n + 1) };
                let name = format!("FD{}{word}", first / FUNCTION_WORDS);
                self.out.program.names.insert(Cell { area, index: first + n }, name);
            }
        }
    }

    /// A device operand; a fault is noted where it is none.
    pub fn device(&mut self, text: &str) -> Option<Device> {
        match self.operand(text)? {
            Operand::Device(device) => Some(device),
            _ => {
                self.fault(Code::Operand, text, format!("`{text}` is no device"), "name a device");
                None
            }
        }
    }

    fn no_bit<T>(&mut self, text: &str) -> Option<T> {
        let help = "name a bit device, or a bit of a word such as D100.A";
        self.fault(Code::Operand, text, format!("`{text}` is no bit"), help);
        None
    }

    fn no_number<T>(&mut self, text: &str) -> Option<T> {
        let help = "name a word device, digits such as K4M0, or a constant";
        self.fault(Code::Operand, text, format!("`{text}` is no number"), help);
        None
    }

    /// Whether `R` may be any `ZR`: the block of the file register is switched.
    pub(super) fn is_switched(&self, name: &str) -> bool {
        name == "R" && self.quirks.switches_file_register
    }

    /// What a bit operand says where it is read; a fault is noted. Timers and counters give their contact.
    pub fn read_bit(&mut self, text: &str) -> Option<Logic> {
        let device = self.device(text)?;
        Some(match device.place {
            Place::At(Kind::Bit(area), index) => Logic::cell(Cell { area, index }),
            Place::At(Kind::Timed(_), _) if self.runs_in_interrupts(&device) => {
                self.unknown_bit(text)
            }
            Place::At(Kind::Timed(timed), index) => {
                Logic::cell(Cell { area: timed.contact, index })
            }
            Place::BitOf(Kind::Word(_), ..) if self.is_switched(device.name) => {
                self.unknown_bit(text)
            }
            Place::BitOf(Kind::Word(area), index, bit) => {
                Logic::Bit(BitSource::WordBit(Cell { area, index }, bit))
            }
            Place::Fixed(value) => Logic::Const(value),
            Place::FirstScan(first) => {
                let (name, index) =
                    if self.family == Family::Fx { ("M", 8002) } else { ("SM", 402) };
                let cell = Logic::cell(Cell { area: area(name), index });
                if first { cell } else { cell.not() }
            }
            Place::At(Kind::VolatileBit, _)
            | Place::BitOf(Kind::VolatileWord, ..)
            | Place::Foreign(true) => {
                self.approximate(format!(
                    "{text} may change at any time: it is taken as any value wherever it is read"
                ));
                match self.clock(&device) {
                    Some(clock) => clock,
                    None if self.is_world(&device) => self.world_bit(),
                    None => self.register_bit(&device),
                }
            }
            Place::Indexed(Kind::Bit(_) | Kind::Timed(_) | Kind::VolatileBit, false)
            | Place::Indexed(Kind::Word(_) | Kind::VolatileWord, true) => self.unknown_bit(text),
            _ => return self.no_bit(text),
        })
    }

    /// A bit of any value, and which relay it is where the CPU sets it by itself.
    fn register_bit(&mut self, device: &Device) -> Logic {
        let bit = self.free_bit();
        if let (Logic::Bit(BitSource::Free(choice)), Place::At(Kind::VolatileBit, index)) =
            (&bit, device.place)
        {
            self.out.program.registers.insert(*choice, (device.name.to_owned(), index));
        }
        bit
    }

    fn unknown_bit(&mut self, text: &str) -> Logic {
        self.approximate(format!(
            "{text} is one of many: it is taken as any value where it is read"
        ));
        let device = self.device(text);
        match device.and_then(|device| self.indexed_bit(&device)) {
            Some(bit) => bit,
            None => self.free_bit(),
        }
    }

    /// Where a bit operand is written; a fault is noted. Timers and counters give their contact.
    pub fn bit_place(&mut self, text: &str) -> Option<BitPlace> {
        let device = self.device(text)?;
        let somewhere = |emitter: &mut Self, area, letters: &str| {
            emitter.one_of_many(text, letters);
            BitPlace::Somewhere(Region::Area(area))
        };
        Some(match device.place {
            Place::At(Kind::Bit(area), index) => {
                BitPlace::One(BitTarget::Cell(Cell { area, index }))
            }
            Place::At(Kind::Timed(timed), index) => {
                BitPlace::One(BitTarget::Cell(Cell { area: timed.contact, index }))
            }
            Place::BitOf(Kind::Word(area), ..) if self.is_switched(device.name) => {
                somewhere(self, area, "R")
            }
            Place::BitOf(Kind::Word(area), index, bit) => {
                BitPlace::One(BitTarget::WordBit(Cell { area, index }, bit))
            }
            Place::Indexed(Kind::Bit(area), false) | Place::Indexed(Kind::Word(area), true) => {
                somewhere(self, area, device.name)
            }
            Place::Indexed(Kind::Timed(timed), false) => {
                somewhere(self, timed.contact, device.name)
            }
            Place::Fixed(_)
            | Place::FirstScan(_)
            | Place::At(Kind::VolatileBit, _)
            | Place::BitOf(Kind::VolatileWord, ..)
            | Place::Indexed(Kind::VolatileBit, false)
            | Place::Indexed(Kind::VolatileWord, true)
            | Place::Foreign(true) => BitPlace::Nowhere,
            _ => return self.no_bit(text),
        })
    }

    /// The number of an operand, `words` words long, the lowest first; a fault is noted.
    pub fn read_words(&mut self, text: &str, words: usize) -> Option<Vec<WordSource>> {
        let operand = self.operand(text)?;
        let device = match operand {
            Operand::Constant(value) => return self.constant_words(text, value, words),
            Operand::Real(bits) if words == 2 => {
                return Some(vec![
                    WordSource::Const(bits as u16),
                    WordSource::Const((bits >> 16) as u16),
                ]);
            }
            // Whether a constant is made from the text or from a single is not known.
            Operand::Real(_) | Operand::Double if words == 4 => {
                self.approximate(format!("{text} is taken as any value where it is read"));
                return Some((0..words).map(|_| self.free_word()).collect());
            }
            Operand::Device(device) => device,
            _ => return self.no_number(text),
        };
        if self.is_long(&device)
            || self.runs_in_interrupts(&device)
            || self.reaches_special(&device, words)
        {
            self.approximate(format!(
                "{text} changes by itself: it is taken as any value where it is read"
            ));
            return Some((0..words).map(|_| self.free_word()).collect());
        }
        let family = self.family;
        let cells = |area, index: u32| {
            word_cells(family, area, index, words).into_iter().map(WordSource::Cell).collect()
        };
        Some(match device.place {
            Place::At(Kind::Word(area), index) if !self.is_switched(device.name) => {
                cells(area, index)
            }
            Place::At(Kind::Timed(timed), index) => cells(timed.value, index),
            Place::Digits(kind, index, digits) if usize::from(digits) <= 4 * words.max(1) => {
                match kind.cell(index) {
                    Some(first) => digit_words(first, digits, words)
                        .map(|part| {
                            part.map_or(WordSource::Const(0), |(first, count)| WordSource::Bits {
                                first,
                                count,
                            })
                        })
                        .collect(),
                    None => self.unknown_words(text, words),
                }
            }
            Place::Digits(..) | Place::IndexedDigits(..)
                if !self.digits_fit(text, &device, words) =>
            {
                return None;
            }
            Place::At(Kind::Word(_) | Kind::VolatileWord, _)
            | Place::Indexed(Kind::Word(_) | Kind::Timed(_) | Kind::VolatileWord, false)
            | Place::IndexedDigits(..)
            | Place::Indirect
            | Place::Foreign(_) => self.unknown_words(text, words),
            _ => return self.no_number(text),
        })
    }

    /// Whether the value stands in two words of its own, as with the FX's 32-bit counters and the long timers and
    /// counters of iQ-R: it is not followed.
    fn is_long(&self, device: &Device) -> bool {
        match device.place {
            Place::At(_, _) if matches!(device.name, "LT" | "LST" | "LC") => true,
            Place::At(_, 200..) => self.family == Family::Fx && matches!(device.name, "C" | "CN"),
            _ => false,
        }
    }

    /// Whether a timer runs on wherever the scan is, as the FX's for subroutines and its 1 ms timers do.
    pub(super) fn runs_in_interrupts(&self, device: &Device) -> bool {
        self.family == Family::Fx
            && device.name == "T"
            && matches!(device.place, Place::At(Kind::Timed(_), timer) if has_own_clock(timer))
    }

    /// Whether a number of `words` words that begins with ordinary devices of the FX reaches special ones, which change
    /// by themselves.
    fn reaches_special(&self, device: &Device, words: usize) -> bool {
        let (first, count) = match device.place {
            Place::At(Kind::Word(_) | Kind::Timed(_), first) => (first, words as u32),
            Place::Digits(Kind::Bit(_) | Kind::Timed(_), first, digits) => {
                (first, 4 * u32::from(digits))
            }
            _ => return false,
        };
        let is_digits = matches!(device.place, Place::Digits(..));
        let changes = |index: u32| match kind(device.name, index, self.family) {
            Some(Kind::Timed(_)) if device.name == "T" => has_own_clock(index),
            Some(Kind::Timed(_)) => !is_digits && index >= 200,
            Some(Kind::VolatileBit | Kind::VolatileWord) => true,
            _ => false,
        };
        self.family == Family::Fx && (first..first.saturating_add(count)).any(changes)
    }

    fn unknown_words(&mut self, text: &str, words: usize) -> Vec<WordSource> {
        self.approximate(format!("{text} is taken as any value where it is read"));
        let device = self.device(text);
        if device.is_some_and(|device| self.is_world(&device)) {
            return (0..words).map(|_| self.world_word()).collect();
        }
        if let Some(found) = device.and_then(|device| self.indexed_words(&device, words)) {
            return found;
        }
        (0..words).map(|at| self.register_word(device, at)).collect()
    }

    /// A word of any value, and which register it is where the CPU sets it by itself.
    fn register_word(&mut self, device: Option<Device>, at: usize) -> WordSource {
        let word = self.free_word();
        if let (WordSource::Free(choice), Some(device)) = (word, device)
            && let (Place::At(Kind::VolatileWord, first), Ok(at)) =
                (device.place, u32::try_from(at))
        {
            let register = (device.name.to_owned(), first + at);
            self.out.program.registers.insert(choice, register);
        }
        word
    }

    fn digits_fit(&mut self, text: &str, device: &Device, words: usize) -> bool {
        let (Place::Digits(_, _, digits) | Place::IndexedDigits(_, digits)) = device.place else {
            return true;
        };
        let fit = usize::from(digits) <= 4 * words;
        if !fit {
            let message = format!(
                "`{text}` has more than the {} digits that this instruction takes",
                4 * words
            );
            self.fault(
                Code::Operand,
                text,
                message,
                "use K1 to K4 with 16-bit instructions, K1 to K8 with 32-bit ones",
            );
        }
        fit
    }

    fn constant_words(&mut self, text: &str, value: i64, words: usize) -> Option<Vec<WordSource>> {
        let bits = 16 * words.min(2) as u32;
        if !(-(1i64 << (bits - 1))..1i64 << bits).contains(&value) {
            let help = format!("write a constant of {bits} bits");
            self.fault(Code::Operand, text, format!("`{text}` does not fit {bits} bits"), &help);
            return None;
        }
        Some((0..words).map(|n| WordSource::Const((value >> (16 * n.min(3))) as u16)).collect())
    }

    /// A constant operand, if it is one.
    pub fn constant(&self, text: &str) -> Option<i64> {
        match self.parsed(text) {
            Ok(Operand::Constant(value)) => Some(value),
            _ => None,
        }
    }

    /// Where a number of `words` words is written, the lowest first; a fault is noted.
    pub fn word_place(&mut self, text: &str, words: usize) -> Option<WordPlace> {
        let device = self.device(text)?;
        if !self.digits_fit(text, &device, words) {
            return None;
        }
        if self.is_long(&device) {
            return Some(WordPlace::Nowhere);
        }
        if is_index_register(&device, words as u32, self.family) {
            return Some(self.anywhere(text, "device", Region::Everything));
        }
        let family = self.family;
        let cells = |area, index: u32| {
            let cells = word_cells(family, area, index, words);
            WordPlace::All(cells.into_iter().map(WordTarget::Cell).collect())
        };
        Some(match device.place {
            Place::At(Kind::Word(area), _) if self.is_switched(device.name) => {
                self.anywhere(text, "R", Region::Area(area))
            }
            Place::At(Kind::Word(area), index) => cells(area, index),
            Place::At(Kind::Timed(timed), index) => cells(timed.value, index),
            Place::Digits(kind, index, digits) => match kind.cell(index) {
                Some(first) => WordPlace::All(
                    digit_words(first, digits, words)
                        .map(|part| {
                            part.map_or(WordTarget::Discard, |(first, count)| WordTarget::Bits {
                                first,
                                count,
                            })
                        })
                        .collect(),
                ),
                None => WordPlace::Nowhere,
            },
            Place::Indexed(Kind::Word(area), false) => {
                self.anywhere(text, device.name, Region::Area(area))
            }
            Place::Indexed(Kind::Timed(timed), false) => {
                self.anywhere(text, device.name, Region::Area(timed.value))
            }
            Place::IndexedDigits(Kind::Bit(area), _) => {
                self.anywhere(text, device.name, Region::Area(area))
            }
            Place::IndexedDigits(Kind::Timed(timed), _) => {
                self.anywhere(text, device.name, Region::Area(timed.contact))
            }
            Place::Indirect => self.anywhere(text, "device", Region::Everything),
            Place::At(Kind::VolatileWord, _)
            | Place::Indexed(Kind::VolatileWord, false)
            | Place::IndexedDigits(..)
            | Place::Foreign(_) => WordPlace::Nowhere,
            _ => {
                self.fault(
                    Code::Operand,
                    text,
                    format!("`{text}` is no word"),
                    "name a word device, or digits such as K4M0",
                );
                return None;
            }
        })
    }

    fn anywhere(&mut self, text: &str, letters: &str, region: Region) -> WordPlace {
        self.one_of_many(text, letters);
        WordPlace::Somewhere(region)
    }

    /// Lists that a write may have hit any device of these letters.
    fn one_of_many(&mut self, text: &str, letters: &str) {
        let stated = if text.starts_with('@') && self.indirect.is_some() {
            " that is stated of them"
        } else {
            ""
        };
        self.approximate(format!(
            "{text} is one of many: any {letters}{stated} may have been written"
        ));
    }

    /// All that `count` cells from an operand on may be; `None` counts to the area's end. Words for word
    /// devices, bits for bit devices; nothing for constants and foreign memory.
    pub fn regions(&mut self, text: &str, count: Option<u32>) -> Option<Vec<Region>> {
        let Operand::Device(device) = self.operand(text)? else { return Some(Vec::new()) };
        if is_index_register(&device, count.unwrap_or(REST), self.family) {
            return Some(vec![Region::Everything]);
        }
        let index_areas = const { [area("Z"), area("V index ")] };
        let range = |area, index| Region::Range {
            first: Cell { area, index },
            count: count.unwrap_or(REST),
        };
        Some(match device.place {
            Place::At(Kind::Word(area), _) | Place::BitOf(Kind::Word(area), ..)
                if self.is_switched(device.name) =>
            {
                vec![Region::Area(area)]
            }
            Place::At(Kind::Word(area), _)
                if self.family == Family::Fx && index_areas.contains(&area) && count != Some(1) =>
            {
                index_areas.map(Region::Area).to_vec()
            }
            Place::At(Kind::Bit(area) | Kind::Word(area), index) => vec![range(area, index)],
            Place::At(Kind::Timed(timed), index) => {
                timed.areas().map(|area| range(area, index)).collect()
            }
            Place::BitOf(Kind::Word(area), index, _) => {
                // Bits from here on: no more words than bits.
                vec![range(area, index)]
            }
            Place::Digits(kind, index, digits) => match kind.cell(index) {
                // Digits of a block: so many times the digits' bits, or to the end.
                Some(first) => {
                    let bits = count.map_or(REST, |count| {
                        count.saturating_mul(4 * u32::from(digits)).min(REST)
                    });
                    vec![Region::Range { first, count: bits }]
                }
                None => Vec::new(),
            },
            Place::Indexed(kind, _) | Place::IndexedDigits(kind, _) => match kind {
                Kind::Bit(area) | Kind::Word(area) => vec![Region::Area(area)],
                Kind::Timed(timed) => timed.areas().map(Region::Area).collect(),
                Kind::VolatileBit | Kind::VolatileWord => Vec::new(),
            },
            Place::Indirect => vec![Region::Everything],
            Place::At(Kind::VolatileBit | Kind::VolatileWord, _)
            | Place::BitOf(..)
            | Place::Foreign(_)
            | Place::Fixed(_)
            | Place::FirstScan(_) => Vec::new(),
        })
    }

    /// A number of an operand.
    pub fn number(&mut self, text: &str, words: usize) -> Option<Number> {
        self.read_words(text, words).map(Number::Words)
    }
}

/// Whether some of the special registers from one on are the FX's index registers: D8028 is Z0, D8029 V0, then
/// Z1, V1 and so on from D8182 on.
fn is_index_register(device: &Device, words: u32, family: Family) -> bool {
    family == Family::Fx
        && device.name == "D"
        && match device.place {
            Place::At(Kind::Word(_) | Kind::VolatileWord, first)
            | Place::BitOf(Kind::VolatileWord, first, _) => {
                [(8028, 8029), (8182, 8195)]
                    .iter()
                    .any(|&(low, high)| first <= high && first.saturating_add(words) > low)
                    && (words < REST || first >= 8000)
            }
            Place::Indexed(Kind::VolatileWord, _) => true,
            _ => false,
        }
}

/// The words of a number. The FX's index registers hold 32 bits in pairs, Z the lower half and V the upper one.
fn word_cells(family: Family, first: AreaId, index: u32, words: usize) -> Vec<Cell> {
    let low = Cell { area: first, index };
    if family == Family::Fx && first == const { area("Z") } && words == 2 {
        return vec![low, Cell { area: area("V index "), index }];
    }
    (0..words as u32).map(|n| low.plus(n)).collect()
}

/// The words that digits of bits make: for each where its bits begin and how many there are, if any.
fn digit_words(first: Cell, digits: u8, words: usize) -> impl Iterator<Item = Option<(Cell, u8)>> {
    (0..words as u32).map(move |n| {
        let bits = (4 * u32::from(digits)).saturating_sub(16 * n).min(16);
        (bits > 0).then(|| (first.plus(16 * n), bits as u8))
    })
}
