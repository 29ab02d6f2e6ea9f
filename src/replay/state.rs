//! The memory of one scan and the values worked out from it.

use super::Free;
use crate::program::{
    AreaKind, BitSource, BitTarget, Cell, ChoiceId, ChoiceKey, Compare, Frame, Logic, Number,
    Program, Reading, Region, Relation, StartRange, WordSource, WordTarget, Write,
};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A region that took any value at one moment.
#[derive(Clone)]
struct Forgotten {
    region: Region,
    choice: ChoiceId,
    frames: Arc<[Frame]>,
}

/// A cell's value and how much of its area had been forgotten when it got it.
struct Held {
    value: u16,
    forgotten: usize,
}

/// The cells, and the frames that say which moment it is.
pub(super) struct State<'p, F> {
    program: &'p Program,
    free: F,
    cells: BTreeMap<Cell, Held>,
    /// By area, in order.
    forgotten: Vec<Vec<Forgotten>>,
    started: BTreeMap<Cell, u16>,
    frames: Arc<[Frame]>,
}

impl<'p, F: Free> State<'p, F> {
    pub(super) fn new(program: &'p Program, free: F) -> Self {
        State {
            program,
            free,
            cells: BTreeMap::new(),
            forgotten: vec![Vec::new(); program.areas.len()],
            started: BTreeMap::new(),
            frames: Arc::from([]),
        }
    }

    /// The calls and turns that are open, outermost first.
    pub(super) fn frames(&self) -> &Arc<[Frame]> {
        &self.frames
    }

    pub(super) fn enter(&mut self, frame: Frame) {
        self.frames = self.frames.iter().copied().chain([frame]).collect();
    }

    pub(super) fn leave(&mut self) {
        self.frames = self.frames[..self.frames.len() - 1].into();
    }

    pub(super) fn choose(&mut self, choice: ChoiceId, kind: AreaKind) -> u16 {
        self.free.choice(&ChoiceKey { frames: self.frames.to_vec(), choice, cell: None }, kind)
    }

    pub(super) fn choose_bit(&mut self, choice: ChoiceId) -> bool {
        self.choose(choice, AreaKind::Bit) & 1 == 1
    }

    /// The cell's value now. A value that comes from outside is kept, so that it is asked for once.
    fn read(&mut self, cell: Cell) -> u16 {
        let held = self.cells.get(&cell);
        let since = held.map_or(0, |held| held.forgotten);
        let forgotten = &self.forgotten[usize::from(cell.area.0)];
        let lost = forgotten[since..].iter().rev().find(|lost| lost.region.holds(cell));
        let kind = self.program.areas[usize::from(cell.area.0)].kind;
        let value = match (lost, held) {
            (Some(lost), _) => {
                let frames = lost.frames.to_vec();
                self.free.choice(&ChoiceKey { frames, choice: lost.choice, cell: Some(cell) }, kind)
            }
            (None, Some(held)) => held.value,
            (None, None) => {
                let value = self.free.start(cell, kind);
                self.started.insert(cell, value);
                value
            }
        };
        let value = if kind == AreaKind::Bit { value & 1 } else { value };
        self.hold(cell, value);
        value
    }

    fn hold(&mut self, cell: Cell, value: u16) {
        let forgotten = self.forgotten[usize::from(cell.area.0)].len();
        self.cells.insert(cell, Held { value, forgotten });
    }

    fn read_bit(&mut self, cell: Cell) -> bool {
        self.read(cell) & 1 == 1
    }

    fn bit(&mut self, source: BitSource) -> bool {
        match source {
            BitSource::Const(value) => value,
            BitSource::Cell(cell) => self.read_bit(cell),
            BitSource::WordBit(cell, bit) => self.read(cell) >> bit & 1 == 1,
            BitSource::Free(choice) => self.choose_bit(choice),
        }
    }

    pub(super) fn word(&mut self, source: WordSource) -> u16 {
        match source {
            WordSource::Const(value) => value,
            WordSource::Cell(cell) => self.read(cell),
            WordSource::Bits { first, count } => (0..count)
                .map(|n| u16::from(self.read_bit(first.plus(u32::from(n)))) << n)
                .fold(0, |word, bit| word | bit),
            WordSource::Free(choice) => self.choose(choice, AreaKind::Word),
        }
    }

    /// The number's words, least first.
    fn number(&mut self, number: &Number) -> Vec<u16> {
        match number {
            Number::Words(sources) => sources.iter().map(|&source| self.word(source)).collect(),
            Number::Add(a, b) => add(&self.number(a), &self.number(b), false),
            Number::Sub(a, b) => {
                let (a, b) = (self.number(a), self.number(b));
                // Two's complement: the difference is the sum with the inverse and one.
                add(&a, &b.iter().map(|word| !word).collect::<Vec<_>>(), true)
            }
            Number::And(a, b) => zip(&self.number(a), &self.number(b), |a, b| a & b),
            Number::Or(a, b) => zip(&self.number(a), &self.number(b), |a, b| a | b),
            Number::Xor(a, b) => zip(&self.number(a), &self.number(b), |a, b| a ^ b),
        }
    }

    fn compare(&mut self, compare: &Compare) -> bool {
        let (left, right) = (self.number(&compare.left), self.number(&compare.right));
        let order = match compare.reading {
            Reading::Signed => signed(&left).cmp(&signed(&right)),
            Reading::Unsigned => left.iter().rev().cmp(right.iter().rev()),
            Reading::Real(choice) => match real(&left).zip(real(&right)) {
                Some((left, right)) => {
                    left.partial_cmp(&right).expect("numbers that are ordinary have an order")
                }
                None => return self.choose_bit(choice),
            },
        };
        match compare.relation {
            Relation::Equal => order == Ordering::Equal,
            Relation::NotEqual => order != Ordering::Equal,
            Relation::Less => order == Ordering::Less,
            Relation::LessOrEqual => order != Ordering::Greater,
            Relation::Greater => order == Ordering::Greater,
            Relation::GreaterOrEqual => order != Ordering::Less,
        }
    }

    /// The truth value in this state, `condition` being the instruction's.
    pub(super) fn logic(&mut self, logic: &Logic, condition: bool) -> bool {
        match logic {
            Logic::Condition => condition,
            Logic::Const(value) => *value,
            Logic::Bit(source) => self.bit(*source),
            Logic::Not(inner) => !self.logic(inner, condition),
            Logic::All(parts) => parts.iter().all(|part| self.logic(part, condition)),
            Logic::Any(parts) => parts.iter().any(|part| self.logic(part, condition)),
            Logic::Compare(compare) => self.compare(compare),
        }
    }

    pub(super) fn write(&mut self, write: &Write, condition: bool) {
        match write {
            Write::Bit(target, value) => {
                let value = self.logic(value, condition);
                match *target {
                    BitTarget::Cell(cell) => self.hold(cell, u16::from(value)),
                    BitTarget::WordBit(cell, bit) => {
                        let rest = self.read(cell) & !(1 << bit);
                        self.hold(cell, rest | u16::from(value) << bit);
                    }
                }
            }
            Write::Words(targets, number) => {
                let words = self.number(number);
                for (target, word) in targets.iter().zip(words) {
                    match *target {
                        WordTarget::Cell(cell) => self.hold(cell, word),
                        WordTarget::Bits { first, count } => {
                            for n in 0..count {
                                self.hold(first.plus(u32::from(n)), word >> n & 1);
                            }
                        }
                        WordTarget::Discard => {}
                    }
                }
            }
            Write::Forget(region, choice) => self.forget(*region, *choice),
        }
    }

    pub(super) fn forget(&mut self, region: Region, choice: ChoiceId) {
        let lost = Forgotten { region, choice, frames: self.frames.clone() };
        match region {
            Region::Range { first, .. } => self.forgotten[usize::from(first.area.0)].push(lost),
            Region::Area(area) => self.forgotten[usize::from(area.0)].push(lost),
            Region::Everything => {
                self.forgotten.iter_mut().for_each(|area| area.push(lost.clone()));
            }
        }
    }

    /// The stated ranges that no values of the cells not read could meet.
    pub(super) fn broken_ranges(&self) -> Vec<usize> {
        let ranges = self.program.ranges.iter().enumerate();
        ranges.filter(|(_, range)| !self.meets(range)).map(|(index, _)| index).collect()
    }

    fn meets(&self, range: &StartRange) -> bool {
        let read: Vec<Option<u16>> =
            range.cells.iter().map(|cell| self.started.get(cell).copied()).collect();
        let within = |value: i64| (range.low..=range.high).contains(&value);
        match read[..] {
            [Some(word)] => within(i64::from(word.cast_signed())),
            [Some(low), Some(high)] => within(double(low, high)),
            [Some(low), None] => (0..=u16::MAX).any(|high| within(double(low, high))),
            [None, Some(high)] => {
                range.low <= double(u16::MAX, high) && double(0, high) <= range.high
            }
            _ => true,
        }
    }
}

fn double(low: u16, high: u16) -> i64 {
    i64::from((u32::from(high) << 16 | u32::from(low)).cast_signed())
}

fn zip(a: &[u16], b: &[u16], mut join: impl FnMut(u16, u16) -> u16) -> Vec<u16> {
    a.iter().zip(b).map(|(&a, &b)| join(a, b)).collect()
}

/// The sum, wrapped around, with a carry into the least word.
fn add(a: &[u16], b: &[u16], carry: bool) -> Vec<u16> {
    let mut carry = u32::from(carry);
    zip(a, b, |a, b| {
        let sum = u32::from(a) + u32::from(b) + carry;
        carry = sum >> 16;
        (sum & 0xFFFF) as u16
    })
}

/// The words, most significant first, such that their order is the order of the signed numbers.
fn signed(words: &[u16]) -> Vec<u16> {
    let mut ordered: Vec<u16> = words.iter().rev().copied().collect();
    if let Some(top) = ordered.first_mut() {
        *top ^= 0x8000;
    }
    ordered
}

/// The IEEE 754 single if it is a normal number or plain +0.
fn real(words: &[u16]) -> Option<f32> {
    let &[low, high] = words else { return None };
    let bits = u32::from(high) << 16 | u32::from(low);
    let value = f32::from_bits(bits);
    (bits == 0 || value.is_normal()).then_some(value)
}
