//! Evaluates numbers, conditions and operations in an abstract state.

use super::condition::{Condition, Literal, WordFact};
use super::integers::Integers;
use super::reach::Reach;
use super::state::{State, Tracked};
use super::value::Value;
use scanbound_base::word_interval::WordInterval;
use scanbound_ir::meaning::{
    Address, ChoiceKind, Count, IntegerFormat, Meaning, Operation, OperationInput, Unary,
};
use scanbound_ir::{
    BitSource, ChoiceId, Compare, IndexedWrite, Length, Logic, Number, NumberFormat, Program,
    Relation, WordSource,
};
use std::cell::Cell as Shared;

/// An abstract state in which expressions of an instruction are evaluated.
pub struct Evaluation<'a> {
    pub program: &'a Program,
    pub followed: &'a Tracked,
    pub state: &'a State,
    /// Literals that are assumed to be true where the expressions are evaluated.
    pub holds: &'a [Literal],
    /// The last stamp that was used: stamps number the writes and the results of contacts and comparisons.
    pub stamp: &'a Shared<u32>,
}

impl Evaluation<'_> {
    /// The possible values of a word.
    pub fn word(&self, word: WordSource) -> Value {
        match word {
            WordSource::Const(value) => Value::constant(value),
            WordSource::Cell(cell) => {
                let slot = self.followed.words.slot(cell);
                slot.map_or(Value::TOP, |slot| self.state.value_where(slot, self.holds))
            }
            WordSource::Bits { count, .. } => Value::range(0, (1i64 << count) - 1),
            WordSource::Free(choice) => self.choice(choice),
        }
    }

    fn choice(&self, choice: ChoiceId) -> Value {
        match self.program.kinds.get(&choice) {
            Some(ChoiceKind::Exact(meaning)) => {
                let found = self.operation(meaning);
                found.and_then(|results| results.first()?.first().copied()).unwrap_or(Value::TOP)
            }
            Some(ChoiceKind::PresentValue { setting, .. }) => Value::range(0, i64::from(*setting)),
            _ => Value::TOP,
        }
    }

    /// The possible values of each of a number's words, low word first.
    pub fn number(&self, number: &Number) -> Vec<Value> {
        match number {
            Number::Words(words) => words.iter().map(|word| self.word(*word)).collect(),
            Number::Add(a, b) | Number::Sub(a, b) => {
                let subtract = matches!(number, Number::Sub(..));
                let [left, right] = [a, b].map(|one| self.number(one));
                if let ([left], [right]) = (&left[..], &right[..]) {
                    return vec![left.add(if subtract { right.negated() } else { *right })];
                }
                let words = left.len();
                self.integers(number).map_or(vec![Value::TOP; words], |sum| sum.words(words))
            }
            Number::And(a, b) => self.by_word(a, b, Value::and),
            Number::Or(a, b) => self.by_word(a, b, |a, b| a.or(b, false)),
            Number::Xor(a, b) => self.by_word(a, b, |a, b| a.or(b, true)),
        }
    }

    /// The possible values of a signed number of one or two words, as integers, because the values of the separate
    /// words do not show which of them occur together. `None` if they are not known as integers.
    fn integers(&self, number: &Number) -> Option<Integers> {
        if let Some(word) = sign_extended(number) {
            return Some(Integers::word(&self.word(word), true));
        }
        let found = match number {
            Number::Add(a, b) => self.integers(a)?.add(&self.integers(b)?)?,
            Number::Sub(a, b) => self.integers(a)?.add(&self.integers(b)?.negated()?)?,
            other => Integers::signed(&self.number(other))?,
        };
        Some(found).filter(|found| found.fits(2))
    }

    fn by_word(&self, a: &Number, b: &Number, how: impl Fn(Value, Value) -> Value) -> Vec<Value> {
        let (a, b) = (self.number(a), self.number(b));
        a.into_iter().zip(b).map(|(a, b)| how(a, b)).collect()
    }

    fn with_literal(&self, condition: Condition) -> Condition {
        condition.with_literal(|| {
            self.stamp.set(self.stamp.get() + 1);
            self.stamp.get()
        })
    }

    /// What is known about a Boolean expression; `condition` is the value of [`Logic::Condition`]. A value that is not
    /// constant gets a literal.
    pub fn logic(&self, logic: &Logic, condition: &Condition) -> Condition {
        let found = match logic {
            Logic::Condition => condition.clone(),
            Logic::Const(value) => Condition::constant(*value),
            Logic::Bit(bit) => self.bit(*bit, true),
            Logic::Not(inner) => match &**inner {
                Logic::Compare(compare) => self.compare(compare, compare.relation.negated()),
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
        self.with_literal(found)
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
        let signed = match compare.format {
            NumberFormat::Signed => true,
            NumberFormat::Unsigned => false,
            NumberFormat::Real(_) => return Condition::default(),
        };
        let sides = [&compare.left, &compare.right].map(|number| {
            let words = self.number(number);
            let whole = (signed && words.len() == 2).then(|| self.integers(number)).flatten();
            whole.or_else(|| Integers::read(&words, signed))
        });
        let [Some(left), Some(right)] = sides else { return Condition::default() };
        let known = |relation| self.facts_of_comparison(compare, relation, &left, &right, signed);
        let (surely, never) =
            (holds(&left, &right, relation), holds(&left, &right, relation.negated()));
        if surely || never {
            return Condition::constant(surely).with_facts(known(relation));
        }
        Condition::default()
            .with_facts(known(relation))
            .with_facts_if_false(known(relation.negated()), self.holds)
    }

    /// What is known about the words on both sides of a comparison if it is true.
    fn facts_of_comparison(
        &self,
        compare: &Compare,
        relation: Relation,
        left: &Integers,
        right: &Integers,
        signed: bool,
    ) -> impl Iterator<Item = WordFact> {
        let mut found = Vec::new();
        let sides = [
            (&compare.left, left, right, relation),
            (&compare.right, right, left, relation.mirrored()),
        ];
        for (number, own, other, relation) in sides {
            let Number::Words(words) = number else { continue };
            let Some(lies) = values_if_true(own, other, relation, words.len(), signed) else {
                continue;
            };
            for (word, lies) in words.iter().zip(lies) {
                if let WordSource::Cell(cell) = word
                    && let Some(slot) = self.followed.words.slot(*cell)
                    && lies != Value::TOP
                {
                    found.push(WordFact { slot, stamp: self.state.stamp(slot), value: lies });
                }
            }
        }
        found.into_iter()
    }

    /// The cells that an indexed write may reach; `None` if unknown.
    pub fn reach(&self, indexed: &IndexedWrite) -> Option<Reach> {
        let mut index: Option<Integers> = None;
        for reading in &indexed.indices {
            let words: Vec<Value> = reading.iter().map(|word| self.word(*word)).collect();
            let read = Integers::signed(&words)?;
            index = Some(index.map_or_else(|| read.clone(), |index| index.join(&read)));
        }
        let mut index = index?;
        if let Some((least, largest)) = indexed.stated {
            // If no possible index is in the stated range, no scan reaches this.
            index = index.within(least, largest).unwrap_or(Integers::range(least, largest));
        }
        let length = match indexed.length {
            Length::Exactly(count) => i64::from(count),
            // Counts are unsigned.
            Length::Counted(word, unit) => self.word(word).unsigned().1 * i64::from(unit),
            Length::Unknown => return None,
        };
        let cells = index.add(&Integers::constant(indexed.first.index.into()))?;
        Reach::of(&cells, length.max(1))
    }

    /// The results of an operation, each as a list of words. `None` if the operation is not followed here, or it may
    /// give no results.
    pub fn operation(&self, meaning: &Meaning) -> Option<Vec<Vec<Value>>> {
        let Meaning { operation, inputs, .. } = meaning;
        let input = |n: usize| self.operand(inputs.get(n)?);
        let integer = |n: usize| self.integer(inputs.get(n)?);
        match operation {
            Operation::Copy => inputs.iter().map(|input| self.operand(input)).collect(),
            Operation::WithFlags { operation, .. } => {
                let inner = Meaning { operation: (**operation).clone(), ..meaning.clone() };
                let mut found = self.operation(&inner)?;
                found.extend([vec![Value::range(0, 1)], vec![Value::range(0, 1)]]);
                Some(found)
            }
            Operation::Multiply { signed: true } => {
                let words = input(0)?.len() + input(1)?.len();
                Some(vec![integer(0)?.multiply(&integer(1)?)?.words(words)])
            }
            Operation::Divide { signed } | Operation::DivideJoined { signed } => {
                let words = input(0)?.len();
                let number = |n: usize| match signed {
                    true => integer(n),
                    false => Integers::read(&input(n)?, false),
                };
                // Only positive divisors are supported.
                let results = number(0)?.divided(&number(1)?)?;
                let results = results.map(|number| number.words(words));
                Some(match operation {
                    Operation::Divide { .. } => results.to_vec(),
                    _ => vec![results.concat()],
                })
            }
            Operation::Resize(words @ 1..=4) => {
                let number = integer(0)?;
                let words = usize::from(*words);
                number.fits(words).then(|| vec![number.words(words)])
            }
            Operation::Shift { left, signed } => {
                let (value, places) = (input(0)?, input(1)?);
                let ([_], [places]) = (&value[..], &places[..]) else { return None };
                let by = 1i64 << places.as_constant().filter(|places| *places < 16)?;
                let number = Integers::read(&value, *signed && !left)?;
                let by = Integers::constant(by);
                // Arithmetic shifts to the right round down, not towards zero.
                let moved = match left {
                    true => number.multiply(&by)?,
                    false if number.low < 0 => return None,
                    false => number.divided(&by)?[0].clone(),
                };
                Some(vec![moved.words(1), vec![Value::range(0, 1)]])
            }
            Operation::PickBit => Some(vec![vec![Value::range(0, 1)]]),
            Operation::CountBits(1) => {
                let most = 16 * input(0)?.len() as i64;
                Some(vec![vec![Value::range(0, most)]])
            }
            Operation::Find { .. } => {
                let (of, list) = (input(0)?.len(), input(1)?.len());
                let most = (list / of.max(1)) as i64;
                Some(vec![vec![Value::range(0, most), Value::range(0, most)]])
            }
            Operation::Limit => {
                let (low, high) = (integer(0)?.as_constant()?, integer(1)?.as_constant()?);
                Some(vec![integer(2)?.limited(low, high)?.words(input(2)?.len())])
            }
            Operation::Each(Unary::Negate) => match input(0)?[..] {
                [word] => Some(vec![vec![word.negated()]]),
                _ => None,
            },
            Operation::Each(Unary::ToBcd) => match input(0)?[..] {
                [word] => {
                    let (low, high) = word.signed();
                    let few = word.list().map(|few| few.iter().map(|&one| bcd(one.into()) as u16));
                    let some = few.and_then(Value::of_values);
                    let found = some.unwrap_or(Value::range(bcd(low.max(0)), bcd(high)));
                    (low >= 0 && high <= 9999).then(|| vec![vec![found]])
                }
                _ => None,
            },
            _ => None,
        }
    }

    /// The possible values of an operand that is a signed number. `None` if they are not known as integers.
    fn integer(&self, operand: &OperationInput) -> Option<Integers> {
        let words = self.operand(operand)?;
        match operand {
            OperationInput::Number(number) if words.len() == 2 => self.integers(number),
            _ => Integers::signed(&words),
        }
    }

    /// The possible values of the words of an operand. `None` if it may be invalid or is not followed.
    fn operand(&self, operand: &OperationInput) -> Option<Vec<Value>> {
        match operand {
            OperationInput::Words(words) => {
                Some(words.iter().map(|word| self.word(*word)).collect())
            }
            OperationInput::Bits(bits) => Some(vec![Value::range(0, 1); bits.len()]),
            OperationInput::Number(number) => Some(self.number(number)),
            OperationInput::Truth(_) => Some(vec![Value::range(0, 1)]),
            OperationInput::Run(address, _, Count::Exactly(1)) => {
                self.read(address).map(|word| vec![word])
            }
            OperationInput::Run(..) => None,
        }
    }

    /// The possible values of the word at a computed address. `None` if it may be a word that is not tracked.
    fn read(&self, address: &Address) -> Option<Value> {
        let mut sum = Integers::constant(address.base);
        for term in &address.terms {
            let words: Vec<Value> = term.words.iter().map(|word| self.word(*word)).collect();
            let is_signed = match term.format {
                IntegerFormat::Signed => true,
                IntegerFormat::Unsigned => false,
                IntegerFormat::Bcd | IntegerFormat::Address => return None,
            };
            let number =
                Integers::read(&words, is_signed)?.multiply(&Integers::constant(term.factor))?;
            sum = sum.add(&number)?;
        }
        let cell = |at: i64| {
            let stretch = address.ranges.iter().find(|stretch| {
                at >= stretch.from && at < stretch.from + i64::from(stretch.count)
            })?;
            Some(stretch.first.plus(u32::try_from(at - stretch.from).ok()?))
        };
        let mut found: Option<Value> = None;
        for &at in sum.list()? {
            let value = self.state.value_where(self.followed.words.slot(cell(at)?)?, self.holds);
            found = Some(found.map_or(value, |found| found.join(value)));
        }
        found
    }
}

/// The word of which a number of two words is the sign extension, `(word ^ 0x8000) - 0x8000`; `None` for any other
/// number.
pub fn sign_extended(number: &Number) -> Option<WordSource> {
    const SIGN: [WordSource; 2] = [WordSource::Const(0x8000), WordSource::Const(0)];
    let Number::Sub(flipped, sign) = number else { return None };
    let (Number::Xor(own, by), Number::Words(sign)) = (&**flipped, &**sign) else { return None };
    match (&**own, &**by) {
        (Number::Words(own), Number::Words(by)) => match own[..] {
            [word, WordSource::Const(0)] => (by[..] == SIGN && sign[..] == SIGN).then_some(word),
            _ => None,
        },
        _ => None,
    }
}

/// Whether a comparison is true for every pair of numbers of the two sets.
fn holds(left: &Integers, right: &Integers, relation: Relation) -> bool {
    match relation {
        Relation::Equal => left.as_constant().is_some() && left == right,
        Relation::NotEqual => left.is_disjoint(right),
        Relation::Less => left.high < right.low,
        Relation::LessOrEqual => left.high <= right.low,
        Relation::Greater => left.low > right.high,
        Relation::GreaterOrEqual => left.low >= right.high,
    }
}

/// The possible values of a number's words if its comparison with another number is true. `None` if the comparison says
/// nothing about them, or cannot be true.
fn values_if_true(
    number: &Integers,
    other: &Integers,
    relation: Relation,
    words: usize,
    signed: bool,
) -> Option<Vec<Value>> {
    let bits = 16 * words as u32;
    let (least, largest) =
        if signed { (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) } else { (0, (1i64 << bits) - 1) };
    let (low, high) = match relation {
        Relation::Equal => return Some(other.words(words)),
        Relation::NotEqual => {
            let is_here = |but: &i64| words == 1 && (least..=largest).contains(but);
            let but = other.as_constant().filter(is_here)? as u16;
            return Some(vec![Value::of(WordInterval::all_except(but, but))]);
        }
        Relation::Less => (least, other.high - 1),
        Relation::LessOrEqual => (least, other.high),
        Relation::Greater => (other.low + 1, largest),
        Relation::GreaterOrEqual => (other.low, largest),
    };
    match words {
        1 => Some(vec![Value::range(low, high)]).filter(|_| low <= high),
        _ => number.within(low, high).map(|number| number.words(words)),
    }
}

fn bcd(number: i64) -> i64 {
    (0..4).map(|place| (number / 10i64.pow(place) % 10) << (4 * place)).sum()
}
