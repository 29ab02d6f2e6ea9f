//! The conditions under which an operation's operands are invalid, which most CPUs report as an operation error.

use super::meaning::{
    Address, Count, IntegerFormat, Meaning, Operation, OperationInput, Shape, Target, Unary,
};
use super::{Compare, Logic, Number, NumberFormat, Relation, WordSource};

/// The bits of one BCD digit.
const DIGIT: u16 = 0xF;

impl Meaning {
    /// The condition under which the operands are invalid: a divisor of 0, invalid BCD digits, a lower limit above the
    /// upper limit, a result that cannot be represented, an address outside its area. `None` if the operation has no
    /// such case, or if none of them can be written as an expression.
    #[must_use]
    pub fn operand_error(&self) -> Option<Logic> {
        let of_operands = of_operation(&self.operation, &self.inputs);
        let reads = self.inputs.iter().filter_map(|input| match input {
            OperationInput::Run(address, shape, count) => outside(address, *shape, length(count)),
            _ => None,
        });
        let writes = self.outputs.iter().filter_map(|output| match output {
            Target::Run(address, shape) => outside(address, *shape, self.written()),
            _ => None,
        });
        any(of_operands.into_iter().chain(reads).chain(writes))
    }

    /// A number of words that the operation certainly writes: all of them for copies and repetitions of known length,
    /// otherwise 1.
    fn written(&self) -> u32 {
        let fill = match (&self.operation, &self.inputs[..]) {
            (Operation::Repeat, [OperationInput::Number(value), OperationInput::Words(times)]) => {
                let times = match times[..] {
                    [WordSource::Const(times)] => times.into(),
                    _ => 1,
                };
                words_of(value)
                    .and_then(|words| u32::try_from(words.len()).ok()?.checked_mul(times))
            }
            (Operation::Copy, [OperationInput::Run(_, _, count)]) => Some(length(count)),
            (Operation::Copy, [OperationInput::Words(words)]) => u32::try_from(words.len()).ok(),
            (Operation::Copy, [OperationInput::Number(value)]) => {
                words_of(value).and_then(|words| u32::try_from(words.len()).ok())
            }
            _ => None,
        };
        fill.unwrap_or(1)
    }
}

fn of_operation(operation: &Operation, inputs: &[OperationInput]) -> Option<Logic> {
    let number = |at: usize| inputs.get(at).and_then(number_of);
    match operation {
        Operation::Divide { .. } | Operation::DivideJoined { .. } => Some(is_zero(&number(1)?)),
        Operation::WithFlags { operation, .. } => of_operation(operation, inputs),
        Operation::DecimalSum { .. } | Operation::DecimalMultiply => {
            any([number(0), number(1)].into_iter().flatten().filter_map(|one| is_invalid_bcd(&one)))
        }
        Operation::DecimalDivide => {
            let numbers = [number(0), number(1)];
            let digits = numbers.iter().flatten().filter_map(is_invalid_bcd);
            any(digits.chain(number(1).as_ref().map(is_zero)))
        }
        Operation::Each(Unary::ToBcd) => {
            let value = number(0)?;
            let most = match words_of(&value)?.len() {
                1 => 9_999,
                2 => 99_999_999,
                _ => return None,
            };
            Some(is_outside(&value, 0, most))
        }
        Operation::Each(Unary::FromBcd) => is_invalid_bcd(&number(0)?),
        Operation::Each(Unary::ToGray | Unary::FromGray) => Some(is_below(&number(0)?, 0)),
        Operation::EachWord(unary @ (Unary::ToBcd | Unary::FromBcd)) => {
            let OperationInput::Words(words) = inputs.first()? else { return None };
            any(words.iter().filter_map(|&word| {
                let one = OperationInput::Words(vec![word]);
                of_operation(&Operation::Each(*unary), &[one])
            }))
        }
        Operation::Encode => match inputs.first()? {
            OperationInput::Bits(bits) => {
                Some(Logic::Any(bits.iter().map(|&bit| Logic::Bit(bit)).collect()).not())
            }
            _ => None,
        },
        Operation::Limit | Operation::Band | Operation::Zone => {
            Some(compare(Relation::Greater, NumberFormat::Signed, &number(0)?, number(1)?))
        }
        Operation::Resize(1) => match words_of(&number(0)?)?.len() {
            2 => Some(is_outside(&number(0)?, i16::MIN.into(), i16::MAX.into())),
            _ => None,
        },
        _ => None,
    }
}

/// An operand as a number. `None` if it is not a number of words.
fn number_of(operand: &OperationInput) -> Option<Number> {
    match operand {
        OperationInput::Number(number) => Some(number.clone()),
        OperationInput::Words(words) => Some(Number::Words(words.clone())),
        OperationInput::Bits(_) | OperationInput::Truth(_) | OperationInput::Run(..) => None,
    }
}

/// The words of a number. `None` if the number is computed (a sum, difference or bitwise combination).
fn words_of(number: &Number) -> Option<&[WordSource]> {
    match number {
        Number::Words(words) => Some(words),
        _ => None,
    }
}

/// The number of words of a number.
fn size(number: &Number) -> usize {
    match number {
        Number::Words(words) => words.len(),
        Number::Add(one, _)
        | Number::Sub(one, _)
        | Number::And(one, _)
        | Number::Or(one, _)
        | Number::Xor(one, _) => size(one),
    }
}

fn any(all: impl IntoIterator<Item = Logic>) -> Option<Logic> {
    let mut all: Vec<Logic> = all.into_iter().collect();
    match all.len() {
        0 | 1 => all.pop(),
        _ => Some(Logic::Any(all)),
    }
}

fn compare(relation: Relation, format: NumberFormat, left: &Number, right: Number) -> Logic {
    Logic::Compare(Box::new(Compare { relation, format, left: left.clone(), right }))
}

/// A constant number of this many words, in two's complement, low word first.
fn constant(value: i64, words: usize) -> Number {
    Number::Words(
        (0..words).map(|n| WordSource::Const((value >> (16 * n.min(3))) as u16)).collect(),
    )
}

/// The condition that the number is 0.
#[must_use]
pub fn is_zero(number: &Number) -> Logic {
    compare(Relation::Equal, NumberFormat::Signed, number, constant(0, size(number)))
}

/// The condition that the signed number is less than `low`.
#[must_use]
pub fn is_below(number: &Number, low: i64) -> Logic {
    compare(Relation::Less, NumberFormat::Signed, number, constant(low, size(number)))
}

/// The condition that the signed number is greater than `high`.
#[must_use]
pub fn is_above(number: &Number, high: i64) -> Logic {
    compare(Relation::Greater, NumberFormat::Signed, number, constant(high, size(number)))
}

/// The condition that the signed number is outside `low..=high`.
#[must_use]
pub fn is_outside(number: &Number, low: i64, high: i64) -> Logic {
    Logic::Any(vec![is_below(number, low), is_above(number, high)])
}

/// The condition that a digit of the BCD number is above 9; `None` if the number is computed, not read from words.
#[must_use]
pub fn is_invalid_bcd(number: &Number) -> Option<Logic> {
    let digit = |word: WordSource, place: u16| {
        let part = |value: u16| Box::new(Number::Words(vec![WordSource::Const(value << place)]));
        let digit = Number::And(Box::new(Number::Words(vec![word])), part(DIGIT));
        compare(Relation::Greater, NumberFormat::Unsigned, &digit, *part(9))
    };
    let words = words_of(number)?.iter();
    any(words.flat_map(|&word| [0, 4, 8, 12].map(|place| digit(word, place))))
}

/// The least number of words of a list: 1 for a text.
fn length(count: &Count) -> u32 {
    match count {
        Count::Exactly(count) => *count,
        Count::Of { least, .. } => *least,
        Count::Text(_) => 1,
    }
}

/// The condition that a list of at least `words` words at this address begins below the lowest address of the area or
/// ends above the highest one. `None` if this cannot happen, or cannot be written as an expression (several terms,
/// BCD).
fn outside(address: &Address, shape: Shape, words: u32) -> Option<Logic> {
    let cells = match shape {
        Shape::Cells => words,
        Shape::WordBits(first) => (u32::from(first) + words.max(1) - 1) / 16 + 1,
        Shape::Packed(last) => 16 * words.saturating_sub(1) + u32::from(last),
    };
    let low = address.ranges.iter().map(|one| one.from).min()?;
    let end = address.ranges.iter().map(|one| one.from + i64::from(one.chosen)).max()?;
    let (low, high) = (low - address.base, end - i64::from(cells) - address.base);
    let [term] = &address.terms[..] else {
        let is_inside = (low..=high).contains(&0);
        return (address.terms.is_empty() && !is_inside).then_some(Logic::Const(true));
    };
    if term.factor < 1 || term.words.len() > 2 {
        return None;
    }
    let bits = 16 * term.words.len();
    let (format, least, most) = match term.format {
        // See `ChoiceKind::Unreachable`.
        IntegerFormat::Address => return None,
        IntegerFormat::Signed => {
            (NumberFormat::Signed, -(1_i64 << (bits - 1)), (1_i64 << (bits - 1)) - 1)
        }
        IntegerFormat::Unsigned => (NumberFormat::Unsigned, 0, (1_i64 << bits) - 1),
        IntegerFormat::Bcd => return None,
    };
    let low = low.div_euclid(term.factor) + i64::from(low.rem_euclid(term.factor) > 0);
    let high = high.div_euclid(term.factor);
    let value = Number::Words(term.words.clone());
    let is = |relation, limit| compare(relation, format, &value, constant(limit, term.words.len()));
    let below = (low > least).then(|| match low > most {
        true => Logic::Const(true),
        false => is(Relation::Less, low),
    });
    let above = (high < most).then(|| match high < least {
        true => Logic::Const(true),
        false => is(Relation::Greater, high),
    });
    any(below.into_iter().chain(above))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meaning::Term;
    use crate::{AreaId, Cell};

    const CELL: Cell = Cell { area: AreaId(0), index: 0 };

    #[test]
    fn an_address_is_outside_below_its_area_and_where_its_last_word_is_beyond() {
        let word = WordSource::Cell(CELL);
        let address = |base| Address::within(CELL, 100, base, vec![Term::signed(word)]);
        let value = Number::Words(vec![word]);
        let want = |low, high| Some(is_outside(&value, low, high));
        assert_eq!(outside(&address(0), Shape::Cells, 1), want(0, 99));
        assert_eq!(outside(&address(10), Shape::Cells, 20), want(-10, 70));
        assert_eq!(outside(&address(0), Shape::Packed(4), 1), want(0, 96));
        let fixed = |base| Address::within(CELL, 100, base, Vec::new());
        assert_eq!(outside(&fixed(80), Shape::Cells, 20), None);
        assert_eq!(outside(&fixed(81), Shape::Cells, 20), Some(Logic::Const(true)));
        // Elements of three words in 99: element 32 is the last that fits.
        let wide = Term { factor: 3, ..Term::signed(word) };
        let wide = Address::within(CELL, 99, 0, vec![wide]);
        assert_eq!(outside(&wide, Shape::Cells, 3), want(0, 32));
    }

    #[test]
    fn what_takes_all_operands_is_no_error() {
        let one = |operation| {
            let inputs = vec![OperationInput::Words(vec![WordSource::Cell(CELL)])];
            Meaning { operation, inputs, outputs: Vec::new() }.operand_error()
        };
        assert_eq!(one(Operation::Each(Unary::SwapBytes)), None);
        assert_eq!(one(Operation::Copy), None);
        assert!(one(Operation::Each(Unary::FromBcd)).is_some());
        assert!(one(Operation::Each(Unary::ToGray)).is_some());
    }
}
