//! The values of a program that users see: bits, bits of words, and numbers.

use crate::devices;
use scanbound_ir::tags::{SimpleValue, ValueForm};
use scanbound_ir::{
    AreaKind, BitSource, BitTarget, Cell, Program, Region, Role, Source, Type, WordSource,
    WordTarget, Write, flow,
};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The cells of a larger region that an instruction accesses are not listed by name.
const MAX_CELLS: u32 = 64;

/// Where a signal has its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// A bit of its own.
    Bit(Cell),
    /// A bit of a word, 0 to 15.
    WordBit(Cell, u8),
    /// A number of this many words from a cell on, low word first.
    Words(Cell, u32, ValueForm),
}

/// A value that users see under a name of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signal {
    /// The name of the device or variable.
    pub name: String,
    /// Where the value is.
    pub place: Place,
}

/// The value of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// The result of an instruction that is not modelled.
    Unknown,
    /// A bit, or a whole number.
    Whole(i128),
    /// A floating-point number.
    Real(f32),
    /// A time, the number of half milliseconds.
    Time(i64),
}

impl fmt::Display for Value {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Value::Unknown => write!(out, "?"),
            Value::Whole(value) => write!(out, "{value}"),
            Value::Real(value) => write!(out, "{value:?}"),
            Value::Time(halves) => {
                let sign = if halves < 0 { "-" } else { "" };
                let (whole, half) = (halves.unsigned_abs() / 2, halves.unsigned_abs() % 2);
                write!(out, "{sign}{whole}{}ms", if half == 1 { ".5" } else { "" })
            }
        }
    }
}

impl Value {
    /// The value in a CSV: as in text, but a time is the number of its milliseconds, and an unknown value is empty.
    #[must_use]
    pub fn csv(&self) -> String {
        match self {
            Value::Unknown => String::new(),
            _ => self.to_string().trim_end_matches("ms").to_owned(),
        }
    }
}

impl Place {
    /// The name of a device at this place.
    fn name(self, program: &Program) -> String {
        match self {
            Place::Bit(cell) | Place::Words(cell, ..) => program.cell_name(cell),
            Place::WordBit(cell, bit) => program.bit_name(BitTarget::WordBit(cell, bit)),
        }
    }

    /// The cells that hold the value, low word first.
    pub fn cells(self) -> impl Iterator<Item = Cell> {
        let (first, count) = match self {
            Place::Bit(cell) | Place::WordBit(cell, _) => (cell, 1),
            Place::Words(first, count, _) => (first, count),
        };
        (0..count).map(move |n| first.plus(n))
    }

    /// The value, given that of each cell.
    pub fn value(self, word: impl Fn(Cell) -> Option<u16>) -> Value {
        let Some(words) = self.cells().map(word).collect::<Option<Vec<u16>>>() else {
            return Value::Unknown;
        };
        let bits = words.iter().rev().fold(0u64, |all, &word| all << 16 | u64::from(word));
        let unused = 64 - 16 * u32::try_from(words.len().min(4)).unwrap_or(4);
        let signed = (bits << unused).cast_signed() >> unused;
        match self {
            Place::Bit(_) => Value::Whole((bits & 1).into()),
            Place::WordBit(_, bit) => Value::Whole((bits >> bit & 1).into()),
            Place::Words(.., ValueForm::Signed) => Value::Whole(signed.into()),
            Place::Words(.., ValueForm::Unsigned) => Value::Whole(bits.into()),
            Place::Words(.., ValueForm::Real) => Value::Real(f32::from_bits(bits as u32)),
            Place::Words(.., ValueForm::Time) => Value::Time(signed),
            Place::Words(.., ValueForm::Opaque) => Value::Unknown,
        }
    }

    /// The words of a value as users write it: a number; for a time, its milliseconds. `None` if it is none that the
    /// signal can have.
    #[must_use]
    pub fn parse(self, text: &str) -> Option<Vec<u16>> {
        let whole = |least: i128, most: i128| {
            text.parse::<i128>().ok().filter(|value| (least..=most).contains(value))
        };
        let bits: u64 = match self {
            Place::Bit(_) | Place::WordBit(..) => whole(0, 1)? as u64,
            Place::Words(_, count, ValueForm::Signed | ValueForm::Unsigned) => {
                let size = 1i128 << (16 * count.min(4));
                whole(-size / 2, size - 1)? as u64
            }
            Place::Words(.., ValueForm::Real) => text.parse::<f32>().ok()?.to_bits().into(),
            Place::Words(.., ValueForm::Time) => {
                let whole = text.strip_suffix(".5").unwrap_or(text);
                let halves = 2 * whole.parse::<u32>().ok().map(u64::from)?;
                let halves = halves + u64::from(whole.len() < text.len());
                Some(halves).filter(|&halves| i32::try_from(halves).is_ok())?
            }
            Place::Words(.., ValueForm::Opaque) => return None,
        };
        Some(self.cells().zip(0..).map(|(_, n)| (bits >> (16 * n)) as u16).collect())
    }
}

/// The signals of a program.
pub struct Signals<'p> {
    program: &'p Program,
    /// The cells that instructions name.
    cells: BTreeSet<Cell>,
    /// The single bits of words that instructions read or write.
    bits: BTreeMap<Cell, BTreeSet<u8>>,
    /// The words that instructions read or write as a whole.
    words: BTreeSet<Cell>,
    /// The bits that say which steps of charts are active and which actions are on.
    active: BTreeSet<Cell>,
}

impl<'p> Signals<'p> {
    /// Finds the signals of a program.
    #[must_use]
    pub fn of(program: &'p Program) -> Signals<'p> {
        let active = program.charts.active.iter().copied().collect();
        let (cells, bits, words) = (BTreeSet::new(), BTreeMap::new(), BTreeSet::new());
        let mut signals = Signals { program, cells, bits, words, active };
        for (at, instruction) in program.instructions.iter().enumerate() {
            let named = instruction.operands.iter().map(|operand| operand.device.cell);
            signals.cells.extend(named);
            instruction.each_read(&mut |source| {
                signals.note_region(source.region());
                match source {
                    Source::Bit(BitSource::WordBit(cell, bit)) => signals.note_bit(cell, bit),
                    Source::Word(WordSource::Cell(cell)) => _ = signals.words.insert(cell),
                    Source::Bit(_) | Source::Word(_) => {}
                }
            });
            flow::written(program, at)
                .into_iter()
                .for_each(|region| signals.note_region(Some(region)));
            for effect in &instruction.effects {
                match &effect.write {
                    Write::Bit(BitTarget::WordBit(cell, bit), _) => signals.note_bit(*cell, *bit),
                    Write::Words(targets, _) => {
                        let cell = |target: &WordTarget| match target {
                            WordTarget::Cell(cell) => Some(*cell),
                            WordTarget::Bits { .. } | WordTarget::Discard => None,
                        };
                        signals.words.extend(targets.iter().filter_map(cell));
                    }
                    Write::Bit(BitTarget::Cell(_), _) | Write::Havoc(..) => {}
                }
            }
        }
        signals
    }

    fn note_region(&mut self, region: Option<Region>) {
        if let Some(Region::Range { first, count: count @ ..=MAX_CELLS }) = region {
            self.cells.extend((0..count).map(|n| first.plus(n)));
        }
    }

    fn note_bit(&mut self, cell: Cell, bit: u8) {
        self.bits.entry(cell).or_default().insert(bit);
    }

    /// The value of a cell at power-up.
    pub(super) fn initial_value(&self, cell: Cell) -> Option<u16> {
        Some(self.program.power_up.initial_value(cell))
    }

    /// The signals to which a cell belongs. None if it is internal.
    #[must_use]
    pub fn of_cell(&self, cell: Cell) -> Vec<Signal> {
        let program = self.program;
        let area = program.area(cell.area);
        if area.role == Role::Internal {
            return Vec::new();
        }
        if let Some(value) = program.tags.value(cell) {
            let is_chart = program.charts.areas.contains(&cell.area);
            let place = tag_place(cell, &value);
            return match place {
                Some(Place::Bit(bit)) if is_chart && !self.active.contains(&bit) => Vec::new(),
                Some(place) => vec![Signal { name: value.name, place }],
                None => Vec::new(),
            };
        }
        let bits = self.bits.get(&cell).into_iter().flatten();
        let mut places: Vec<Place> = bits.map(|&bit| Place::WordBit(cell, bit)).collect();
        if area.kind == AreaKind::Bit {
            places.push(Place::Bit(cell));
        } else if places.is_empty() || self.words.contains(&cell) {
            places.push(Place::Words(cell, 1, ValueForm::Signed));
        }
        let signal = |place: Place| Signal { name: place.name(program), place };
        places.into_iter().map(signal).collect()
    }

    /// The inputs that the program names: bits and numbers.
    #[must_use]
    pub fn inputs(&self) -> Vec<Signal> {
        let inputs = &self.program.power_up.inputs;
        let is_input = |cell: &&Cell| inputs.iter().any(|region| region.contains(**cell));
        self.cells.iter().filter(is_input).flat_map(|&cell| self.of_cell(cell)).collect()
    }

    /// The signal of a device or variable as users write it. `None` if there is none, or if several variables have this
    /// name.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<Signal> {
        let name = name.trim();
        let program = self.program;
        let is_named = |signal: &Signal| signal.name.eq_ignore_ascii_case(name);
        let signals = || self.cells.iter().flat_map(|&cell| self.of_cell(cell));
        if let Some(signal) = signals().find(is_named) {
            return Some(signal);
        }
        // A variable without the name of its program, if only one has this name.
        let is_ending = |signal: &Signal| {
            let path = signal.name.len().checked_sub(name.len());
            let parts = path.and_then(|path| signal.name.split_at_checked(path));
            parts.is_some_and(|(path, end)| path.ends_with('.') && end.eq_ignore_ascii_case(name))
        };
        let mut ending: Vec<Signal> = signals().filter(is_ending).collect();
        ending.dedup();
        if let [only] = &ending[..] {
            return Some(only.clone());
        }
        let (cell, bit) = match devices::bit_of_word(program, name) {
            Some((word, bit)) => (word, Some(bit)),
            None => (devices::cell(program, name)?, None),
        };
        let place = match (bit, program.area(cell.area).kind) {
            (Some(bit), _) => Place::WordBit(cell, bit),
            (None, AreaKind::Bit) => Place::Bit(cell),
            (None, AreaKind::Word) => Place::Words(cell, 1, ValueForm::Signed),
        };
        Some(Signal { name: place.name(program), place })
    }
}

/// Where the value of a tag is. `None` if its words do not hold it.
fn tag_place(cell: Cell, value: &SimpleValue<'_>) -> Option<Place> {
    let Type::Words(count, form) = value.of else { return Some(Place::Bit(cell)) };
    let first = Cell { index: cell.index - value.word, ..cell };
    let is_read = *count <= 4 && *form != ValueForm::Opaque;
    is_read.then_some(Place::Words(first, *count, *form))
}
