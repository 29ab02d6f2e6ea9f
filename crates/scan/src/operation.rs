//! Results of operations with symbolic operands, and the conditions under which these results are defined.

use super::derived::{Function, ShiftKind};
use super::word::{Word, Words};
use scanbound_ir::Relation;
use scanbound_ir::meaning::{Operation, Unary};
use scanbound_model::{Circuit, Lit};

/// The result of an operation, low word first, and the literal that says whether it is defined. `wanted` limits the
/// words of a product. `None` if the operation, or the size of its operands, is not supported here.
pub fn results(
    words: &mut Words,
    circuit: &mut Circuit,
    operation: &Operation,
    inputs: &[Vec<Word>],
    wanted: usize,
) -> Option<(Vec<Word>, Lit)> {
    let (first, rest) = inputs.split_first()?;
    let second = rest.first().unwrap_or(first);
    if !(1..=2).contains(&first.len()) || second.is_empty() {
        return None;
    }
    let count = first.len();
    let mut of = |function, wanted: usize| words.derived(function, first, second, wanted);
    match operation {
        Operation::Multiply { signed } if second.len() == count => {
            let product = of(Function::Product { signed: *signed }, wanted.min(2 * count));
            Some((product, Lit::TRUE))
        }
        Operation::DivideJoined { signed } if second.len() == count => {
            let mut both = of(Function::Quotient { signed: *signed }, count);
            both.extend(of(Function::Remainder { signed: *signed }, count));
            let fits = can_be_divided(words, circuit, first, second, *signed);
            Some((both, fits))
        }
        Operation::Shift { .. } | Operation::Rotate { through: false, .. } => {
            let way = match operation {
                Operation::Shift { left: true, .. } => ShiftKind::Left,
                Operation::Shift { signed: false, .. } => ShiftKind::Right,
                Operation::Shift { signed: true, .. } => ShiftKind::SignedRight,
                Operation::Rotate { left: true, .. } => ShiftKind::RoundLeft,
                _ => ShiftKind::RoundRight,
            };
            let places = vec![second[0]; count];
            let moved = words.derived(Function::Moved(way), first, &places, count);
            Some((moved, places_fit(words, circuit, second[0], count)))
        }
        Operation::Limit => {
            let [low, high, number] = inputs else { return None };
            if [high, number].iter().any(|one| one.len() != count) {
                return None;
            }
            let mut is = |relation, one: &[Word], other: &[Word]| {
                super::number::compare(words, circuit, relation, true, one, other)
            };
            let below = is(Relation::Less, number, low);
            let above = is(Relation::Greater, number, high);
            let crossed = is(Relation::Greater, low, high);
            let remaining = (0..count).map(|at| {
                let inside = words.either(below, low[at], number[at]);
                words.either(above, high[at], inside)
            });
            Some((remaining.collect(), !crossed))
        }
        Operation::Each(Unary::FromBcd) => {
            let number = of(Function::FromDecimal, count);
            let bits: Vec<Lit> = bits_of(words, circuit, first);
            let wrong: Vec<Lit> = bits
                .chunks(4)
                .map(|digit| {
                    let low = circuit.or(digit[1], digit[2]);
                    circuit.and(digit[3], low)
                })
                .collect();
            let wrong = circuit.any(wrong);
            Some((number, !wrong))
        }
        Operation::Each(Unary::ToBcd) => {
            let digits = of(Function::ToDecimal, count);
            let most: u32 = if count == 1 { 9999 } else { 99_999_999 };
            let most: Vec<Word> =
                (0..count).map(|at| words.constant((most >> (16 * at)) as u16)).collect();
            let relation = Relation::LessOrEqual;
            let fits = super::number::compare(words, circuit, relation, false, first, &most);
            Some((digits, fits))
        }
        _ => None,
    }
}

/// The literal that says whether a number of shifted places is at most the number of bits of `count` words.
fn places_fit(words: &mut Words, circuit: &mut Circuit, places: Word, count: usize) -> Lit {
    let most = if count == 1 { 16 } else { 32 };
    words.in_range(circuit, places, 0, most)
}

/// The literal that says whether a division is defined: the divisor is not 0 and the quotient fits.
fn can_be_divided(
    words: &mut Words,
    circuit: &mut Circuit,
    first: &[Word],
    second: &[Word],
    signed: bool,
) -> Lit {
    let mut is = |number: &[Word], low: u16, high: u16| {
        let all: Vec<Lit> = number
            .iter()
            .enumerate()
            .map(|(at, &word)| {
                let value = if at + 1 == number.len() { high } else { low };
                words.in_range(circuit, word, value, value)
            })
            .collect();
        circuit.all(all)
    };
    let zero = is(second, 0, 0);
    let overflows = match signed {
        true => {
            let least = is(first, 0, 0x8000);
            let minus = is(second, u16::MAX, u16::MAX);
            circuit.and(least, minus)
        }
        false => Lit::FALSE,
    };
    let unsettled = circuit.or(zero, overflows);
    !unsettled
}

fn bits_of(words: &mut Words, circuit: &mut Circuit, number: &[Word]) -> Vec<Lit> {
    number.iter().flat_map(|&word| words.bits(circuit, word)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_model::{Assignment, VarId};

    const VALUES: [u16; 14] =
        [0, 1, 2, 3, 7, 10, 99, 0x1234, 0x9999, 0x7FFF, 0x8000, 0x8001, 0xFFFE, 0xFFFF];

    /// Compares the result of an operation on free operands, and when it is defined, with a function of two numbers.
    fn check(
        operation: &Operation,
        size: usize,
        wanted: usize,
        meaning: impl Fn(u32, u32) -> Option<u64>,
    ) {
        for constant in [None, Some(0), Some(1), Some(3), Some(10), Some(0xFFFF)] {
            let (mut words, mut circuit) = (Words::default(), Circuit::default());
            let free: Vec<Word> = (0..4).map(|at| words.free(VarId(at))).collect();
            let first = free[..size].to_vec();
            let second = match constant {
                None => free[2..2 + size].to_vec(),
                Some(value) => {
                    (0..size).map(|at| words.constant(if at == 0 { value } else { 0 })).collect()
                }
            };
            let inputs = [first, second];
            let (result, settled) =
                results(&mut words, &mut circuit, operation, &inputs, wanted).expect("followed");
            let bits = bits_of(&mut words, &mut circuit, &result);
            for a in VALUES {
                for b in VALUES {
                    // The high words have other values than the low words.
                    let assignment = [a, b ^ 0x0101, b, a];
                    let values = circuit.evaluate(&Assignment(assignment.to_vec()));
                    let number = |low: u16, high: u16| match size {
                        1 => u32::from(low),
                        _ => u32::from(high) << 16 | u32::from(low),
                    };
                    let x = number(assignment[0], assignment[1]);
                    let y = match constant {
                        None => number(assignment[2], assignment[3]),
                        Some(value) => value.into(),
                    };
                    let want = meaning(x, y);
                    assert_eq!(values.get(settled), want.is_some(), "{operation:?} {x:x} {y:x}");
                    let Some(want) = want else { continue };
                    let got = bits
                        .iter()
                        .enumerate()
                        .fold(0u64, |sum, (at, &bit)| sum | u64::from(values.get(bit)) << at);
                    assert_eq!(got, want, "{operation:?} {x:x} {y:x}");
                }
            }
        }
    }

    fn signed(value: u32, size: usize) -> i64 {
        if size == 1 { i64::from(value as u16 as i16) } else { i64::from(value as i32) }
    }

    fn low(value: i64, words: usize) -> u64 {
        let value = value.cast_unsigned();
        if words >= 4 { value } else { value & ((1 << (16 * words)) - 1) }
    }

    #[test]
    fn products_are_those_of_integers() {
        for size in [1, 2] {
            for wanted in [size, 2 * size] {
                let product = |signed| Operation::Multiply { signed };
                check(&product(true), size, wanted, |a, b| {
                    Some(low(signed(a, size).wrapping_mul(signed(b, size)), wanted))
                });
                check(&product(false), size, wanted, |a, b| {
                    let product = u64::from(a).wrapping_mul(b.into());
                    Some(low(product.cast_signed(), wanted))
                });
            }
        }
    }

    #[test]
    fn quotients_go_towards_zero_and_are_open_where_there_is_none() {
        for size in [1, 2] {
            let joined = |quotient: i64, rest: i64| {
                low(quotient, size) | low(rest, size).checked_shl(16 * size as u32).unwrap_or(0)
            };
            let divide = |signed| Operation::DivideJoined { signed };
            check(&divide(true), size, 2 * size, |a, b| {
                let (a, b) = (signed(a, size), signed(b, size));
                let quotient = a.checked_div(b)?;
                let fits = signed(low(quotient, size) as u32, size) == quotient;
                fits.then(|| joined(quotient, a % b))
            });
            check(&divide(false), size, 2 * size, |a, b| {
                Some(joined(a.checked_div(b)?.into(), (a % b).into()))
            });
        }
    }

    #[test]
    fn bits_move_up_to_as_many_places_as_there_are() {
        for size in [1, 2] {
            let count = 16 * size as u32;
            let places = |b: u32| Some(b & 0xFFFF).filter(|&places| places <= count);
            let all = if size == 1 { 0xFFFF } else { u32::MAX };
            let up = |a: u32, by: u32| a.checked_shl(by).unwrap_or(0) & all;
            let down = |a: u32, by: u32| a.checked_shr(by).unwrap_or(0);
            let shift = |left, signed| Operation::Shift { left, signed };
            check(&shift(true, false), size, size, |a, b| Some(up(a, places(b)?).into()));
            check(&shift(false, false), size, size, |a, b| Some(down(a, places(b)?).into()));
            check(&shift(false, true), size, size, |a, b| {
                Some(low(signed(a, size) >> places(b)?.min(63), size))
            });
            let rotate = |left| Operation::Rotate { left, through: false };
            check(&rotate(true), size, size, |a, b| {
                let by = places(b)? % count;
                Some((up(a, by) | down(a, count - by)).into())
            });
            check(&rotate(false), size, size, |a, b| {
                let by = places(b)? % count;
                Some((down(a, by) | up(a, count - by)).into())
            });
        }
    }

    #[test]
    fn decimal_digits_are_read_and_written() {
        for size in [1, 2] {
            let digits = 4 * size as u32;
            check(&Operation::Each(Unary::FromBcd), size, size, |a, _| {
                let digit = |at: u32| Some(a >> (4 * at) & 0xF).filter(|&digit| digit < 10);
                (0..digits).rev().try_fold(0u64, |sum, at| Some(sum * 10 + u64::from(digit(at)?)))
            });
            check(&Operation::Each(Unary::ToBcd), size, size, |a, _| {
                let most = 10u32.pow(digits) - 1;
                let digit = |at: u32| u64::from(a / 10u32.pow(at) % 10) << (4 * at);
                (a <= most).then(|| (0..digits).map(digit).sum())
            });
        }
    }
}
