//! What numbers, conditions and operations come to, by what words may hold.

use super::condition::{Condition, Known, Literal};
use super::state::{Followed, State};
use crate::base::ring::{Ring, ends};
use crate::program::meaning::{
    Address, ChoiceKind, Count, Digits, Meaning, Operand, Operation, Unary,
};
use crate::program::{
    BitSource, ChoiceId, Compare, Indexed, Length, Logic, Number, Program, Reading, Relation,
    WordSource,
};
use std::cell::Cell as Shared;

/// What is asked of a program's expressions in a state.
pub struct Evaluation<'a> {
    pub program: &'a Program,
    pub followed: &'a Followed,
    pub state: &'a State,
    /// What is true where it is asked.
    pub holds: &'a [Literal],
    /// The last stamp that was given.
    pub stamp: &'a Shared<u32>,
}

impl Evaluation<'_> {
    /// A word.
    pub fn word(&self, word: WordSource) -> Ring {
        match word {
            WordSource::Const(value) => Ring::constant(value),
            WordSource::Cell(cell) => {
                let slot = self.followed.words.slot(cell);
                slot.map_or(Ring::TOP, |slot| self.state.value_where(slot, self.holds))
            }
            WordSource::Bits { count, .. } => Ring::of(0, (1i64 << count) - 1),
            WordSource::Free(choice) => self.choice(choice),
        }
    }

    fn choice(&self, choice: ChoiceId) -> Ring {
        match self.program.kinds.get(&choice) {
            Some(ChoiceKind::Exact(meaning)) => {
                let found = self.operation(meaning);
                found.and_then(|results| results.first()?.first().copied()).unwrap_or(Ring::TOP)
            }
            Some(ChoiceKind::Present { setting, .. }) => Ring::of(0, i64::from(*setting)),
            _ => Ring::TOP,
        }
    }

    /// A number's words.
    pub fn number(&self, number: &Number) -> Vec<Ring> {
        match number {
            Number::Words(words) => words.iter().map(|word| self.word(*word)).collect(),
            Number::Add(a, b) => sum(&self.number(a), &self.number(b), false),
            Number::Sub(a, b) => sum(&self.number(a), &self.number(b), true),
            Number::And(a, b) => self.by_word(a, b, and),
            Number::Or(a, b) => {
                self.by_word(a, b, |a, b| or(a, b, a.unsigned().0.max(b.unsigned().0)))
            }
            Number::Xor(a, b) => self.by_word(a, b, |a, b| or(a, b, 0)),
        }
    }

    fn by_word(&self, a: &Number, b: &Number, how: impl Fn(Ring, Ring) -> Ring) -> Vec<Ring> {
        let (a, b) = (self.number(a), self.number(b));
        a.into_iter().zip(b).map(|(a, b)| how(a, b)).collect()
    }

    fn seen(&self, condition: Condition) -> Condition {
        condition.seen(|| {
            self.stamp.set(self.stamp.get() + 1);
            self.stamp.get()
        })
    }

    /// A truth value; `condition` is the instruction's. What is not decided has a literal.
    pub fn logic(&self, logic: &Logic, condition: &Condition) -> Condition {
        let found = match logic {
            Logic::Condition => condition.clone(),
            Logic::Const(value) => Condition::constant(*value),
            Logic::Bit(bit) => self.bit(*bit, true),
            Logic::Not(inner) => match &**inner {
                Logic::Compare(compare) => self.compare(compare, opposite(compare.relation)),
                Logic::Bit(bit) => self.bit(*bit, false),
                inner => self.logic(inner, condition).negation(),
            },
            Logic::All(parts) => {
                let parts = parts.iter().map(|part| self.logic(part, condition));
                parts.fold(Condition::always(), |all, part| all.and(&part))
            }
            Logic::Any(parts) => {
                let parts = parts.iter().map(|part| self.logic(part, condition));
                parts.fold(Condition::constant(false), |any, part| any.or(&part))
            }
            Logic::Compare(compare) => self.compare(compare, compare.relation),
        };
        self.seen(found)
    }

    fn bit(&self, bit: BitSource, on: bool) -> Condition {
        match bit {
            BitSource::Const(value) => Condition::constant(value == on),
            BitSource::Cell(cell) => match self.followed.bits.slot(cell) {
                Some(slot) => self.state.bit(slot, on),
                None => Condition::default(),
            },
            BitSource::WordBit(..) | BitSource::Free(_) => Condition::default(),
        }
    }

    fn compare(&self, compare: &Compare, relation: Relation) -> Condition {
        let signed = match compare.reading {
            Reading::Signed => true,
            Reading::Unsigned => false,
            Reading::Real(_) => return Condition::default(),
        };
        let (left, right) = (self.number(&compare.left), self.number(&compare.right));
        let ([left], [right]) = (&left[..], &right[..]) else { return Condition::default() };
        let range = |value: &Ring| if signed { value.signed() } else { value.unsigned() };
        let ((l, lh), (r, rh)) = (range(left), range(right));
        let (surely, never) = match relation {
            Relation::Equal => (l == lh && r == rh && l == r, lh < r || rh < l),
            Relation::NotEqual => (lh < r || rh < l, l == lh && r == rh && l == r),
            Relation::Less => (lh < r, l >= rh),
            Relation::LessOrEqual => (lh <= r, l > rh),
            Relation::Greater => (l > rh, lh <= r),
            Relation::GreaterOrEqual => (l >= rh, lh < r),
        };
        let (least, largest) = if signed { (-32_768, 32_767) } else { (0, 65_535) };
        // What the left side lies within if it holds, then the right one.
        let (on_left, on_right) = match relation {
            Relation::Equal => ((r, rh), (l, lh)),
            Relation::NotEqual => ((least, largest), (least, largest)),
            Relation::Less => ((least, rh - 1), (l + 1, largest)),
            Relation::LessOrEqual => ((least, rh), (l, largest)),
            Relation::Greater => ((r + 1, largest), (least, lh - 1)),
            Relation::GreaterOrEqual => ((r, largest), (least, lh)),
        };
        let known = [(&compare.left, on_left), (&compare.right, on_right)];
        let known = known.into_iter().filter_map(|(number, (low, high))| {
            let Number::Words(words) = number else { return None };
            let [WordSource::Cell(cell)] = words[..] else { return None };
            let slot = self.followed.words.slot(cell)?;
            Some(Known { slot, stamp: self.state.stamp(slot), signed, low, high })
        });
        if surely || never {
            return Condition::constant(surely).knowing(known);
        }
        Condition::default().knowing(known)
    }

    /// The cells that an indexed write may reach: the least number and the largest.
    pub fn reach(&self, indexed: &Indexed) -> Option<(u32, u32)> {
        let (mut low, mut high) = (i64::MAX, i64::MIN);
        for reading in &indexed.readings {
            let words: Vec<Ring> = reading.iter().map(|word| self.word(*word)).collect();
            let (least, largest) = ends(&words)?;
            (low, high) = (low.min(least), high.max(largest));
        }
        if let Some((least, largest)) = indexed.stated {
            (low, high) = (low.max(least), high.min(largest).max(low.max(least)));
        }
        let more = match indexed.length {
            Length::Exactly(count) => i64::from(count),
            // Counts are unsigned.
            Length::Counted(word, unit) => self.word(word).unsigned().1 * i64::from(unit),
            Length::Unknown => return None,
        };
        let first = i64::from(indexed.first.index);
        let last = first.checked_add(high)?.checked_add(more.max(1) - 1)?;
        Some((u32::try_from(first.checked_add(low)?).ok()?, u32::try_from(last).ok()?))
    }

    /// What an operation gives, if it surely gives something: its results, each its words.
    pub fn operation(&self, meaning: &Meaning) -> Option<Vec<Vec<Ring>>> {
        let Meaning { operation, inputs, .. } = meaning;
        let input = |n: usize| self.operand(inputs.get(n)?);
        match operation {
            Operation::Copy => inputs.iter().map(|input| self.operand(input)).collect(),
            Operation::Judged { operation, .. } => {
                let inner = Meaning { operation: (**operation).clone(), ..meaning.clone() };
                let mut found = self.operation(&inner)?;
                found.extend([vec![Ring::of(0, 1)], vec![Ring::of(0, 1)]]);
                Some(found)
            }
            Operation::Multiply { signed: true } => {
                let ((a, ah), (b, bh)) = (ends(&input(0)?)?, ends(&input(1)?)?);
                let all = [
                    a.checked_mul(b)?,
                    a.checked_mul(bh)?,
                    ah.checked_mul(b)?,
                    ah.checked_mul(bh)?,
                ];
                let (low, high) = (all.into_iter().min()?, all.into_iter().max()?);
                let mut product = split(low, high);
                if input(0)?.len() == 2 {
                    // A product of four words, of which the upper two hold the sign if the lower two can hold the number.
                    let upper = match (product[..] != [Ring::TOP; 2], low >= 0, high < 0) {
                        (true, true, _) => Ring::constant(0),
                        (true, _, true) => Ring::constant(u16::MAX),
                        _ => Ring::TOP,
                    };
                    product.extend([upper; 2]);
                }
                Some(vec![product])
            }
            Operation::Divide { signed: true } => {
                let (a, b) = (input(0)?, input(1)?);
                let words = a.len();
                let ((a, ah), (b, bh)) = (ends(&a)?, ends(&b)?);
                // Only by one positive number.
                if b != bh || b <= 0 {
                    return None;
                }
                let rest = (b - 1).min(a.abs().max(ah.abs()));
                let remainder = (if a < 0 { -rest } else { 0 }, if ah > 0 { rest } else { 0 });
                let of = |(low, high)| {
                    if words == 1 { vec![Ring::of(low, high)] } else { split(low, high) }
                };
                Some(vec![of((a / b, ah / b)), of(remainder)])
            }
            Operation::Resize(2) => {
                let (low, high) = ends(&input(0)?)?;
                Some(vec![split(low, high)])
            }
            Operation::PickBit => Some(vec![vec![Ring::of(0, 1)]]),
            Operation::CountBits(1) => {
                let most = 16 * input(0)?.len() as i64;
                Some(vec![vec![Ring::of(0, most)]])
            }
            Operation::Find { .. } => {
                let (of, list) = (input(0)?.len(), input(1)?.len());
                let most = (list / of.max(1)) as i64;
                Some(vec![vec![Ring::of(0, most), Ring::of(0, most)]])
            }
            Operation::Limit => {
                let [low, high] = [input(0)?, input(1)?].map(|words| match words[..] {
                    [word] => word.as_constant().map(u16::cast_signed),
                    _ => None,
                });
                let (low, high) = (i64::from(low?), i64::from(high?));
                let [value] = input(2)?[..] else { return None };
                let (least, largest) = value.signed();
                let within = (low <= high)
                    .then(|| Ring::of(least.clamp(low, high), largest.clamp(low, high)));
                Some(vec![vec![within?]])
            }
            Operation::Each(Unary::ToBcd) => match input(0)?[..] {
                [word] => {
                    let (low, high) = word.signed();
                    (low >= 0 && high <= 9999).then(|| vec![vec![Ring::of(0, bcd(high))]])
                }
                _ => None,
            },
            _ => None,
        }
    }

    /// An operation's operand, if it is surely there.
    fn operand(&self, operand: &Operand) -> Option<Vec<Ring>> {
        match operand {
            Operand::Words(words) => Some(words.iter().map(|word| self.word(*word)).collect()),
            Operand::Bits(bits) => Some(vec![Ring::of(0, 1); bits.len()]),
            Operand::Number(number) => Some(self.number(number)),
            Operand::Truth(_) => Some(vec![Ring::of(0, 1)]),
            Operand::Run(address, _, Count::Exactly(1)) => {
                self.read(address).map(|word| vec![word])
            }
            Operand::Run(..) => None,
        }
    }

    /// The word at an address, if it is surely one of words that matter.
    fn read(&self, address: &Address) -> Option<Ring> {
        const FEW: i64 = 64;
        let (mut low, mut high) = (address.base, address.base);
        for term in &address.terms {
            let words: Vec<Ring> = term.words.iter().map(|word| self.word(*word)).collect();
            let (least, largest) = match (term.reading, &words[..]) {
                (Digits::Signed, words) => ends(words)?,
                (Digits::Unsigned, [word]) => word.unsigned(),
                _ => return None,
            };
            let ends = [least * term.times, largest * term.times];
            low += ends[0].min(ends[1]);
            high += ends[0].max(ends[1]);
        }
        if high - low > FEW {
            return None;
        }
        let cell = |at: i64| {
            let stretch = address.stretches.iter().find(|stretch| {
                at >= stretch.from && at < stretch.from + i64::from(stretch.count)
            })?;
            Some(stretch.first.plus(u32::try_from(at - stretch.from).ok()?))
        };
        let mut found: Option<Ring> = None;
        for at in low..=high {
            let value = self.state.value_where(self.followed.words.slot(cell(at)?)?, self.holds);
            found = Some(found.map_or(value, |found| found.join(value)));
        }
        found
    }
}

/// A number of two words within these ends.
fn split(low: i64, high: i64) -> Vec<Ring> {
    if low < i64::from(i32::MIN) || high > i64::from(i32::MAX) {
        return vec![Ring::TOP; 2];
    }
    let (upper, uppermost) = (low >> 16, high >> 16);
    let lower = if upper == uppermost { Ring::of(low & 0xFFFF, high & 0xFFFF) } else { Ring::TOP };
    vec![lower, Ring::of(upper, uppermost)]
}

fn sum(left: &[Ring], right: &[Ring], subtract: bool) -> Vec<Ring> {
    let (Some((a, ah)), Some((b, bh))) = (ends(left), ends(right)) else {
        return vec![Ring::TOP; left.len()];
    };
    let (low, high) = if subtract { (a - bh, ah - b) } else { (a + b, ah + bh) };
    if left.len() == 1 { vec![Ring::of(low, high)] } else { split(low, high) }
}

fn and(a: Ring, b: Ring) -> Ring {
    match (a.as_constant(), b.as_constant()) {
        (Some(a), Some(b)) => Ring::constant(a & b),
        _ => Ring::of(0, a.unsigned().1.min(b.unsigned().1)),
    }
}

/// What may have the bits of both and no higher ones, from `low` on.
fn or(a: Ring, b: Ring, low: i64) -> Ring {
    let high = a.unsigned().1.max(b.unsigned().1);
    Ring::of(low, (high.unsigned_abs() + 1).next_power_of_two() as i64 - 1)
}

fn bcd(number: i64) -> i64 {
    (0..4).map(|place| (number / 10i64.pow(place) % 10) << (4 * place)).sum()
}

fn opposite(relation: Relation) -> Relation {
    match relation {
        Relation::Equal => Relation::NotEqual,
        Relation::NotEqual => Relation::Equal,
        Relation::Less => Relation::GreaterOrEqual,
        Relation::LessOrEqual => Relation::Greater,
        Relation::Greater => Relation::LessOrEqual,
        Relation::GreaterOrEqual => Relation::Less,
    }
}
