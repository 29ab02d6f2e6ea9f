//! Reads and writes of operands: cells, bits of words, digit designations, and unknown cells of an area.

use super::state::Lowering;
use crate::memory::{DeviceType, FUNCTION_WORDS, Family, area, has_own_clock, kind};
use crate::operand::{Device, HOW_TO_WRITE, Operand, Place};
use scanbound_base::code::Code;
use scanbound_ir::meaning::{Address, Count, Meaning, OperationInput, Shape};
use scanbound_ir::{
    AreaId, BitSource, BitTarget, Cell, ChoiceId, Logic, Number, Region, WordSource, WordTarget,
};

/// The place that a bit operand writes.
#[derive(Debug, Clone, Copy)]
pub enum BitPlace {
    /// This bit.
    One(BitTarget),
    /// One bit of this region, but it is unknown which one.
    Somewhere(Region),
    /// A bit outside the program's memory, such as one of a module, or one that only the CPU changes. The write has no
    /// effect.
    Nowhere,
}

/// The place that a word operand writes.
#[derive(Debug, Clone)]
pub enum WordPlace {
    /// These words, the lowest first.
    All(Vec<WordTarget>),
    /// Words of this region, but it is unknown which ones.
    Somewhere(Region),
    /// Words outside the program's memory, such as those of a module, or words that only the CPU changes. The write has
    /// no effect.
    Nowhere,
}

/// A number of cells that is larger than any area, and small enough that adding an index does not overflow.
pub(super) const REST: u32 = u32::MAX / 2;

impl Lowering<'_> {
    /// A new choice: a value that the program does not determine and that may be any.
    pub fn choice(&mut self) -> ChoiceId {
        self.out.choice()
    }

    /// A bit that may have any value: a new choice.
    pub fn free_bit(&mut self) -> Logic {
        self.out.free_bit()
    }

    /// A word that may have any value: a new choice.
    pub fn free_word(&mut self) -> WordSource {
        self.out.free_word()
    }

    /// Parses an operand; reports an error and returns `None` if it is invalid. Also records the first instruction with
    /// a link access (`J1\W5`), and the names of function registers.
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

    /// Names the cells of a function register (FD), which has several words, for reports.
    fn name_words(&mut self, operand: &Operand) {
        let Operand::Device(device) = operand else { return };
        if let (
            Place::At(DeviceType::Word(area), first)
            | Place::BitOf(DeviceType::Word(area), first, _),
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

    /// Parses a device operand; reports an error and returns `None` if it is not a device.
    pub fn device(&mut self, text: &str) -> Option<Device> {
        match self.operand(text)? {
            Operand::Device(device) => Some(device),
            _ => {
                self.fault(
                    Code::Operand,
                    text,
                    format!("`{text}` is not a device"),
                    "write a device",
                );
                None
            }
        }
    }

    fn no_bit<T>(&mut self, text: &str) -> Option<T> {
        let help = "write a bit device, or a bit of a word such as D100.A";
        self.fault(Code::Operand, text, format!("`{text}` is not a bit"), help);
        None
    }

    fn no_number<T>(&mut self, text: &str) -> Option<T> {
        let help = "write a word device, a digit designation such as K4M0, or a constant";
        self.fault(Code::Operand, text, format!("`{text}` is not a number"), help);
        None
    }

    /// Whether a device with these letters may be any `ZR`: it is an `R`, and the program switches the file register
    /// block.
    pub(super) fn is_switched(&self, name: &str) -> bool {
        name == "R" && self.modes.switches_file_register
    }

    /// The value of a bit operand when it is read; of timers and counters it is the contact. If the bit is unknown or
    /// changes without the program, it is a new choice, and an over-approximation is recorded. Reports an error and
    /// returns `None` if the operand is not a bit.
    pub fn read_bit(&mut self, text: &str) -> Option<Logic> {
        let device = self.device(text)?;
        Some(match device.place {
            Place::At(DeviceType::Bit(area), index) => Logic::cell(Cell { area, index }),
            Place::At(DeviceType::Timed(_), _) if self.runs_in_interrupts(&device) => {
                self.unknown_bit(text)
            }
            Place::At(DeviceType::Timed(timed), index) => {
                Logic::cell(Cell { area: timed.contact, index })
            }
            Place::BitOf(DeviceType::Word(_), ..) if self.is_switched(device.name) => {
                self.unknown_bit(text)
            }
            Place::BitOf(DeviceType::Word(area), index, bit) => {
                Logic::Bit(BitSource::WordBit(Cell { area, index }, bit))
            }
            Place::Fixed(value) => Logic::Const(value),
            Place::FirstScan(first) => {
                let (name, index) =
                    if self.family == Family::Fx { ("M", 8002) } else { ("SM", 402) };
                let cell = Logic::cell(Cell { area: area(name), index });
                if first { cell } else { cell.not() }
            }
            Place::At(DeviceType::VolatileBit, 700)
                if device.name == "SM" && self.carry.is_some() =>
            {
                self.carry.map_or(Logic::Const(false), Logic::cell)
            }
            Place::At(DeviceType::VolatileBit, _)
            | Place::BitOf(DeviceType::VolatileWord, ..)
            | Place::Foreign(true) => {
                self.approximate(format!(
                    "{text} may change at any time: any value is assumed at each read of it"
                ));
                match self.known_in_runs(&device) {
                    // With the default parameters, the CPU stops where this relay is on.
                    Some(on) if matches!(device.place, Place::At(_, 60 | 61)) => {
                        Logic::All(vec![on, self.register_bit(&device)])
                    }
                    Some(on) => on,
                    None if self.is_external(&device) => self.external_bit(),
                    None => self.register_bit(&device),
                }
            }
            Place::Indexed(
                DeviceType::Bit(_) | DeviceType::Timed(_) | DeviceType::VolatileBit,
                false,
            )
            | Place::Indexed(DeviceType::Word(_) | DeviceType::VolatileWord, true) => {
                self.unknown_bit(text)
            }
            _ => return self.no_bit(text),
        })
    }

    /// A bit that may have any value. For relays that the CPU sets itself, it records which relay it is.
    fn register_bit(&mut self, device: &Device) -> Logic {
        let bit = self.free_bit();
        if let (Logic::Bit(BitSource::Free(choice)), Place::At(DeviceType::VolatileBit, index)) =
            (&bit, device.place)
        {
            self.out.program.registers.insert(*choice, (device.name.to_owned(), index));
        }
        bit
    }

    fn unknown_bit(&mut self, text: &str) -> Logic {
        self.approximate(format!(
            "it is unknown which device {text} is: any value is assumed for {text}"
        ));
        let device = self.device(text);
        match device.and_then(|device| self.indexed_bit(&device)) {
            Some(bit) => bit,
            None => self.free_bit(),
        }
    }

    /// The place that a bit operand writes; for timers and counters it is the contact. Reports an error and returns
    /// `None` if the operand is not a bit.
    pub fn bit_place(&mut self, text: &str) -> Option<BitPlace> {
        let device = self.device(text)?;
        let somewhere = |emitter: &mut Self, area, letters: &str| {
            emitter.one_of_many(text, letters);
            BitPlace::Somewhere(Region::Area(area))
        };
        Some(match device.place {
            Place::At(DeviceType::Bit(area), index) => {
                BitPlace::One(BitTarget::Cell(Cell { area, index }))
            }
            Place::At(DeviceType::Timed(timed), index) => {
                BitPlace::One(BitTarget::Cell(Cell { area: timed.contact, index }))
            }
            Place::BitOf(DeviceType::Word(area), ..) if self.is_switched(device.name) => {
                somewhere(self, area, "R")
            }
            Place::BitOf(DeviceType::Word(area), index, bit) => {
                BitPlace::One(BitTarget::WordBit(Cell { area, index }, bit))
            }
            Place::Indexed(DeviceType::Bit(area), false)
            | Place::Indexed(DeviceType::Word(area), true) => somewhere(self, area, device.name),
            Place::Indexed(DeviceType::Timed(timed), false) => {
                somewhere(self, timed.contact, device.name)
            }
            Place::Fixed(_)
            | Place::FirstScan(_)
            | Place::At(DeviceType::VolatileBit, _)
            | Place::BitOf(DeviceType::VolatileWord, ..)
            | Place::Indexed(DeviceType::VolatileBit, false)
            | Place::Indexed(DeviceType::VolatileWord, true)
            | Place::Foreign(true) => BitPlace::Nowhere,
            _ => return self.no_bit(text),
        })
    }

    /// The words of a numeric operand (device, digit designation or constant), the lowest first. Words that are unknown
    /// or change without the program are new choices, and an over-approximation is recorded. Reports an error and
    /// returns `None` if the operand is invalid or too large for `words` words.
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
            // Whether the CPU converts the constant from its text or from a single is unknown.
            Operand::Real(_) | Operand::Double if words == 4 => {
                self.approximate(format!(
                    "any value is assumed for {text}, which this instruction reads"
                ));
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
                "{text} is a long timer or counter, or includes devices that change without the program: any value is assumed where this instruction reads it"
            ));
            return Some((0..words).map(|_| self.free_word()).collect());
        }
        let family = self.family;
        let cells = |area, index: u32| {
            word_cells(family, area, index, words).into_iter().map(WordSource::Cell).collect()
        };
        Some(match device.place {
            Place::At(DeviceType::Word(area), index) if !self.is_switched(device.name) => {
                cells(area, index)
            }
            Place::At(DeviceType::Timed(timed), index) => cells(timed.value, index),
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
            Place::At(DeviceType::Word(_) | DeviceType::VolatileWord, _)
            | Place::Indexed(
                DeviceType::Word(_) | DeviceType::Timed(_) | DeviceType::VolatileWord,
                false,
            )
            | Place::IndexedDigits(..)
            | Place::Indirect
            | Place::Foreign(_) => self.unknown_words(text, words),
            _ => return self.no_number(text),
        })
    }

    /// Whether the present value of a timer or counter has two words, as in 32-bit counters of the FX and long timers
    /// and counters. These values are not modelled.
    fn is_long(&self, device: &Device) -> bool {
        match device.place {
            Place::At(_, _) if matches!(device.name, "LT" | "LST" | "LC") => true,
            Place::At(_, 200..) => self.family == Family::Fx && matches!(device.name, "C" | "CN"),
            _ => false,
        }
    }

    /// Whether the timer's value changes while the scan runs, as that of timers of the FX for subroutines, and of its
    /// retentive and 1 ms timers from T246 on.
    pub(super) fn runs_in_interrupts(&self, device: &Device) -> bool {
        self.family == Family::Fx
            && device.name == "T"
            && matches!(device.place, Place::At(DeviceType::Timed(_), timer) if has_own_clock(timer))
    }

    /// Whether a number of `words` words that begins in ordinary devices of the FX extends into special ones, which
    /// change by themselves.
    fn reaches_special(&self, device: &Device, words: usize) -> bool {
        let (first, count) = match device.place {
            Place::At(DeviceType::Word(_) | DeviceType::Timed(_), first) => (first, words as u32),
            Place::Digits(DeviceType::Bit(_) | DeviceType::Timed(_), first, digits) => {
                (first, 4 * u32::from(digits))
            }
            _ => return false,
        };
        let is_digits = matches!(device.place, Place::Digits(..));
        let changes = |index: u32| match kind(device.name, index, self.family) {
            Some(DeviceType::Timed(_)) if device.name == "T" => has_own_clock(index),
            Some(DeviceType::Timed(_)) => !is_digits && index >= 200,
            Some(DeviceType::VolatileBit | DeviceType::VolatileWord) => true,
            _ => false,
        };
        self.family == Family::Fx && (first..first.saturating_add(count)).any(changes)
    }

    fn unknown_words(&mut self, text: &str, words: usize) -> Vec<WordSource> {
        self.approximate(format!("any value is assumed for {text}, which this instruction reads"));
        let device = self.device(text);
        if device.is_some_and(|device| self.is_external(&device)) {
            return (0..words).map(|_| self.external_word()).collect();
        }
        if let Some(found) = device.and_then(|device| self.indexed_words(&device, words)) {
            return found;
        }
        if let Some(address) = device.and_then(|device| self.indirect_address(&device)) {
            let one = |n: i64| {
                let address = Address { base: address.base + n, ..address.clone() };
                Meaning::of(OperationInput::Run(address, Shape::Cells, Count::Exactly(1)))
            };
            let all = (0..words as i64).map(|n| WordSource::Free(self.define(one(n))));
            return all.collect();
        }
        (0..words).map(|at| self.register_word(device, at)).collect()
    }

    /// A word that may have any value. For registers that the CPU sets itself, it records which register it is.
    fn register_word(&mut self, device: Option<Device>, at: usize) -> WordSource {
        let word = self.free_word();
        if let (WordSource::Free(choice), Some(device)) = (word, device)
            && let (Place::At(DeviceType::VolatileWord, first), Ok(at)) =
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
                "`{text}` has more digits than the {} that this instruction takes",
                4 * words
            );
            self.fault(
                Code::Operand,
                text,
                message,
                "use K1 to K4 for 16-bit instructions, K1 to K8 for 32-bit ones",
            );
        }
        fit
    }

    fn constant_words(&mut self, text: &str, value: i64, words: usize) -> Option<Vec<WordSource>> {
        let bits = 16 * words.min(2) as u32;
        if !(-(1i64 << (bits - 1))..1i64 << bits).contains(&value) {
            let help = format!("write a constant of {bits} bits");
            self.fault(
                Code::Operand,
                text,
                format!("the constant `{text}` does not fit in {bits} bits"),
                &help,
            );
            return None;
        }
        Some((0..words).map(|n| WordSource::Const((value >> (16 * n.min(3))) as u16)).collect())
    }

    /// The value of an integer constant. `None` for other operands.
    pub fn constant(&self, text: &str) -> Option<i64> {
        match self.parsed(text) {
            Ok(Operand::Constant(value)) => Some(value),
            _ => None,
        }
    }

    /// The place that a number of `words` words, the lowest first, is written to. Reports an error and returns `None`
    /// if the operand is not a word or has more digits than the number.
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
            Place::At(DeviceType::Word(area), _) if self.is_switched(device.name) => {
                self.anywhere(text, "R", Region::Area(area))
            }
            Place::At(DeviceType::Word(area), index) => cells(area, index),
            Place::At(DeviceType::Timed(timed), index) => cells(timed.value, index),
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
            Place::Indexed(DeviceType::Word(area), false) => {
                self.anywhere(text, device.name, Region::Area(area))
            }
            Place::Indexed(DeviceType::Timed(timed), false) => {
                self.anywhere(text, device.name, Region::Area(timed.value))
            }
            Place::IndexedDigits(DeviceType::Bit(area), _) => {
                self.anywhere(text, device.name, Region::Area(area))
            }
            Place::IndexedDigits(DeviceType::Timed(timed), _) => {
                self.anywhere(text, device.name, Region::Area(timed.contact))
            }
            Place::Indirect => self.anywhere(text, "device", Region::Everything),
            Place::At(DeviceType::VolatileWord, _)
            | Place::Indexed(DeviceType::VolatileWord, false)
            | Place::IndexedDigits(..)
            | Place::Foreign(_) => WordPlace::Nowhere,
            _ => {
                self.fault(
                    Code::Operand,
                    text,
                    format!("`{text}` is not a word"),
                    "write a word device, or a digit designation such as K4M0",
                );
                return None;
            }
        })
    }

    fn anywhere(&mut self, text: &str, letters: &str, region: Region) -> WordPlace {
        self.one_of_many(text, letters);
        WordPlace::Somewhere(region)
    }

    /// Records that a write to this operand may change any device with these letters.
    fn one_of_many(&mut self, text: &str, letters: &str) {
        let stated = if text.starts_with('@') && self.indirect.is_some() {
            " within the stated range"
        } else {
            ""
        };
        self.approximate(format!(
            "it is unknown which device {text} is: any {letters}{stated} may have been written"
        ));
    }

    /// The regions that `count` cells from an operand on may occupy; a count of `None` means up to the end of the area.
    /// Empty for constants, for memory of modules, and for devices without cells. `None` after an error in the operand.
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
            Place::At(DeviceType::Word(area), _) | Place::BitOf(DeviceType::Word(area), ..)
                if self.is_switched(device.name) =>
            {
                vec![Region::Area(area)]
            }
            Place::At(DeviceType::Word(area), _)
                if self.family == Family::Fx && index_areas.contains(&area) && count != Some(1) =>
            {
                index_areas.map(Region::Area).to_vec()
            }
            Place::At(DeviceType::Bit(area) | DeviceType::Word(area), index) => {
                vec![range(area, index)]
            }
            Place::At(DeviceType::Timed(timed), index) => {
                timed.areas().map(|area| range(area, index)).collect()
            }
            Place::BitOf(DeviceType::Word(area), index, _) => {
                // At most as many words as bits follow.
                vec![range(area, index)]
            }
            Place::Digits(kind, index, digits) => match kind.cell(index) {
                // A block of digit designations: `count` times its bits, or up to the end.
                Some(first) => {
                    let bits = count.map_or(REST, |count| {
                        count.saturating_mul(4 * u32::from(digits)).min(REST)
                    });
                    vec![Region::Range { first, count: bits }]
                }
                None => Vec::new(),
            },
            Place::Indexed(kind, _) | Place::IndexedDigits(kind, _) => match kind {
                DeviceType::Bit(area) | DeviceType::Word(area) => vec![Region::Area(area)],
                DeviceType::Timed(timed) => timed.areas().map(Region::Area).collect(),
                DeviceType::VolatileBit | DeviceType::VolatileWord => Vec::new(),
            },
            Place::Indirect => vec![Region::Everything],
            Place::At(DeviceType::VolatileBit | DeviceType::VolatileWord, _)
            | Place::BitOf(..)
            | Place::Foreign(_)
            | Place::Fixed(_)
            | Place::FirstScan(_) => Vec::new(),
        })
    }

    /// The value of a numeric operand of `words` words. Reports an error and returns `None` if the operand is invalid.
    pub fn number(&mut self, text: &str, words: usize) -> Option<Number> {
        self.read_words(text, words).map(Number::Words)
    }
}

/// Whether a block of `words` special registers from this device on may contain index registers of the FX: D8028 is Z0,
/// D8029 is V0, and from D8182 on follow Z1, V1 and so on.
fn is_index_register(device: &Device, words: u32, family: Family) -> bool {
    family == Family::Fx
        && device.name == "D"
        && match device.place {
            Place::At(DeviceType::Word(_) | DeviceType::VolatileWord, first)
            | Place::BitOf(DeviceType::VolatileWord, first, _) => {
                [(8028, 8029), (8182, 8195)]
                    .iter()
                    .any(|&(low, high)| first <= high && first.saturating_add(words) > low)
                    && (words < REST || first >= 8000)
            }
            Place::Indexed(DeviceType::VolatileWord, _) => true,
            _ => false,
        }
}

/// The cells of a number of `words` words that begins at this index, low word first. On the FX, a 32-bit number in an
/// index register has Z as its lower half and V as its upper half.
fn word_cells(family: Family, first: AreaId, index: u32, words: usize) -> Vec<Cell> {
    let low = Cell { area: first, index };
    if family == Family::Fx && first == const { area("Z") } && words == 2 {
        return vec![low, Cell { area: area("V index "), index }];
    }
    (0..words as u32).map(|n| low.plus(n)).collect()
}

/// The words of a digit designation: for each word, its first bit and the number of bits, or `None` beyond the
/// designation.
fn digit_words(first: Cell, digits: u8, words: usize) -> impl Iterator<Item = Option<(Cell, u8)>> {
    (0..words as u32).map(move |n| {
        let bits = (4 * u32::from(digits)).saturating_sub(16 * n).min(16);
        (bits > 0).then(|| (first.plus(16 * n), bits as u8))
    })
}
