//! Arithmetic on numbers of one or more symbolic words: sums, bitwise operations, comparisons.

use super::word::{Carry, Gate, Word, Words};
use scanbound_ir::Relation;
use scanbound_model::{Circuit, Lit};

/// The sum (with `subtract`, the difference) of two numbers, low word first, with wraparound.
pub fn add(words: &mut Words, a: &[Word], b: &[Word], subtract: bool) -> Vec<Word> {
    let constant = |words: &Words, n: &[Word]| {
        n.iter().map(|&w| words.as_constant(w)).collect::<Option<Vec<u16>>>()
    };
    let (a, addend) = match (constant(words, a), constant(words, b)) {
        (_, Some(addend)) => (a, if subtract { negate(&addend) } else { addend }),
        (Some(addend), None) if !subtract => (b, addend),
        _ => {
            let mut carry = Carry::NONE;
            let b: Vec<Word> = if subtract {
                // Two's complement: a - b = a + !b + 1.
                carry = Carry::ALWAYS;
                let ones = words.constant(u16::MAX);
                b.iter().map(|&word| words.bitwise(Gate::Xor, word, ones)).collect()
            } else {
                b.to_vec()
            };
            let mut each = |(&x, y)| {
                let (sum, over) = words.sum(x, y, carry);
                carry = over;
                sum
            };
            return a.iter().zip(b).map(&mut each).collect();
        }
    };
    let mut carry = Carry::NONE;
    let mut each = |(&word, addend)| {
        let (sum, over) = words.plus_carried(word, addend, carry);
        carry = over;
        sum
    };
    a.iter().zip(addend).map(&mut each).collect()
}

fn negate(number: &[u16]) -> Vec<u16> {
    let mut carry = true;
    number
        .iter()
        .map(|&word| {
            let (word, overflow) = (!word).overflowing_add(u16::from(carry));
            carry = overflow;
            word
        })
        .collect()
}

/// The words of a bitwise operation on two numbers of equal length.
pub fn bitwise(words: &mut Words, a: &[Word], b: &[Word], gate: Gate) -> Vec<Word> {
    a.iter().zip(b).map(|(&x, &y)| words.bitwise(gate, x, y)).collect()
}

/// The literal that says whether the number in these words, low word first, lies in `low..=high`.
pub fn within(
    words: &mut Words,
    circuit: &mut Circuit,
    value: &[Word],
    signed: bool,
    low: i64,
    high: i64,
) -> Lit {
    let bits = 16 * value.len() as u32;
    let (least, largest) = match signed {
        true => (-(1i64 << (bits - 1)), (1i64 << (bits - 1)) - 1),
        false => (0, (1i64 << bits) - 1),
    };
    if low > largest || high < least || low > high {
        return Lit::FALSE;
    }
    let limits =
        [(low.max(least), Relation::GreaterOrEqual), (high.min(largest), Relation::LessOrEqual)];
    limits.into_iter().fold(Lit::TRUE, |all, (limit, relation)| {
        let limit: Vec<Word> =
            (0..value.len()).map(|i| words.constant((limit >> (16 * i)) as u16)).collect();
        let holds = compare(words, circuit, relation, signed, value, &limit);
        circuit.and(all, holds)
    })
}

/// The literal that says whether `a` and `b`, integers of equally many words, low word first, are in this relation.
pub fn compare(
    words: &mut Words,
    circuit: &mut Circuit,
    relation: Relation,
    signed: bool,
    a: &[Word],
    b: &[Word],
) -> Lit {
    match relation {
        Relation::Equal => equal(words, circuit, a, b),
        Relation::NotEqual => !equal(words, circuit, a, b),
        Relation::Less => less(words, circuit, signed, a, b),
        Relation::GreaterOrEqual => !less(words, circuit, signed, a, b),
        Relation::Greater => less(words, circuit, signed, b, a),
        Relation::LessOrEqual => !less(words, circuit, signed, b, a),
    }
}

fn equal(words: &mut Words, circuit: &mut Circuit, a: &[Word], b: &[Word]) -> Lit {
    let mut result = Lit::TRUE;
    for (&x, &y) in a.iter().zip(b) {
        let same = equal_word(words, circuit, x, y);
        result = circuit.and(result, same);
    }
    result
}

fn equal_word(words: &mut Words, circuit: &mut Circuit, a: Word, b: Word) -> Lit {
    if a == b {
        return Lit::TRUE;
    }
    match (words.as_constant(a), words.as_constant(b)) {
        (_, Some(c)) => words.in_range(circuit, a, c, c),
        (Some(c), _) => words.in_range(circuit, b, c, c),
        _ => {
            let (x, y) = (words.bits(circuit, a), words.bits(circuit, b));
            let differences: Vec<Lit> = (0..16).map(|i| circuit.xor(x[i], y[i])).collect();
            !circuit.any(differences)
        }
    }
}

/// The literal that says whether `a < b`. It is built from the low word up, because each higher word decides over the
/// lower ones.
fn less(words: &mut Words, circuit: &mut Circuit, signed: bool, a: &[Word], b: &[Word]) -> Lit {
    let mut result = Lit::FALSE;
    for (i, (&x, &y)) in a.iter().zip(b).enumerate() {
        let sign = signed && i + 1 == a.len();
        let smaller = less_word(words, circuit, sign, x, y);
        let lower_words = match result {
            Lit::FALSE => Lit::FALSE,
            _ => {
                let same = equal_word(words, circuit, x, y);
                circuit.and(same, result)
            }
        };
        result = circuit.or(smaller, lower_words);
    }
    result
}

fn less_word(words: &mut Words, circuit: &mut Circuit, signed: bool, a: Word, b: Word) -> Lit {
    if a == b {
        return Lit::FALSE;
    }
    match (words.as_constant(a), words.as_constant(b)) {
        (_, Some(c)) => below(words, circuit, signed, a, c),
        // c < b is the negation of b < c + 1, one range test. The same test occurs where a count is compared with c.
        (Some(c), _) => {
            let greatest = if signed { 0x7FFF } else { 0xFFFF };
            if c == greatest {
                Lit::FALSE
            } else {
                !below(words, circuit, signed, b, c.wrapping_add(1))
            }
        }
        _ => {
            let (mut x, mut y) = (words.bits(circuit, a), words.bits(circuit, b));
            if signed {
                // Signed order is unsigned order with inverted sign bits.
                (x[15], y[15]) = (!x[15], !y[15]);
            }
            bits_less(circuit, &x, &y)
        }
    }
}

/// The literal that says whether a word is less than a constant.
fn below(words: &mut Words, circuit: &mut Circuit, signed: bool, word: Word, constant: u16) -> Lit {
    const LEAST: u16 = 0x8000;
    match constant {
        0 if !signed => Lit::FALSE,
        LEAST if signed => Lit::FALSE,
        c if !signed => words.in_range(circuit, word, 0, c - 1),
        // Signed, and the constant is not positive: from the least number to just below the constant.
        c if c == 0 || c > LEAST => words.in_range(circuit, word, LEAST, c.wrapping_sub(1)),
        c => {
            let not_between = words.in_range(circuit, word, c, LEAST - 1);
            !not_between
        }
    }
}

/// The literal that says whether `a < b`, for unsigned numbers with the same number of bits, least significant bit
/// first.
fn bits_less(circuit: &mut Circuit, a: &[Lit], b: &[Lit]) -> Lit {
    let mut result = Lit::FALSE;
    for (&x, &y) in a.iter().zip(b) {
        let smaller = circuit.and(!x, y);
        let differ = circuit.xor(x, y);
        result = circuit.ite(differ, smaller, result);
    }
    result
}

/// The literal that says whether two IEEE 754 singles are in this relation. If one is neither normal nor +0, the result
/// is `special`.
pub fn compare_real(
    words: &mut Words,
    circuit: &mut Circuit,
    relation: Relation,
    a: &[Word],
    b: &[Word],
    special: Lit,
) -> Lit {
    let a = real_bits(words, circuit, a);
    let b = real_bits(words, circuit, b);
    let plain_a = is_plain(circuit, &a);
    let plain_b = is_plain(circuit, &b);
    let plain = circuit.and(plain_a, plain_b);
    let same = {
        let differences: Vec<Lit> = a.iter().zip(&b).map(|(&x, &y)| circuit.xor(x, y)).collect();
        !circuit.any(differences)
    };
    let less = real_less(circuit, &a, &b);
    let greater = real_less(circuit, &b, &a);
    let ordered = match relation {
        Relation::Equal => same,
        Relation::NotEqual => !same,
        Relation::Less => less,
        Relation::GreaterOrEqual => !less,
        Relation::Greater => greater,
        Relation::LessOrEqual => !greater,
    };
    circuit.ite(plain, ordered, special)
}

fn real_bits(words: &mut Words, circuit: &mut Circuit, number: &[Word]) -> Vec<Lit> {
    number.iter().flat_map(|&word| words.bits(circuit, word)).collect()
}

/// The literal that says whether a single is normal (exponent neither all zeros nor all ones) or +0.
fn is_plain(circuit: &mut Circuit, bits: &[Lit]) -> Lit {
    let exponent = &bits[23..31];
    let some_one = circuit.any(exponent.iter().copied());
    let all_ones = circuit.all(exponent.iter().copied());
    let normal = circuit.and(some_one, !all_ones);
    let nothing = circuit.any(bits.iter().copied());
    circuit.or(normal, !nothing)
}

/// The literal that says whether `a < b`, for normal numbers and +0: by sign, then by magnitude, reversed for negative
/// numbers.
fn real_less(circuit: &mut Circuit, a: &[Lit], b: &[Lit]) -> Lit {
    let (sign_a, sign_b) = (a[31], b[31]);
    let smaller = bits_less(circuit, &a[..31], &b[..31]);
    let larger = bits_less(circuit, &b[..31], &a[..31]);
    let same_sign = circuit.ite(sign_a, larger, smaller);
    let differ = circuit.xor(sign_a, sign_b);
    circuit.ite(differ, sign_a, same_sign)
}

/// Splits a number into weighted literals: its value is the sum of the weights of the literals that are true. The
/// number is `most` if `over` is true; otherwise it has these bits, least significant first, and must be at most
/// `most`. All weights add up to `most`, so that the solver has nothing to search where the maximum is possible.
pub fn in_parts(circuit: &mut Circuit, bits: &[Lit], over: Lit, most: u64) -> Vec<(Lit, u64)> {
    let places = (u64::BITS - most.leading_zeros()) as usize;
    let is_one = |number: u64, place: usize| Lit::constant(number >> place & 1 == 1);
    let mut number: Vec<Lit> = (0..places)
        .map(|place| {
            let bit = bits.get(place).copied().unwrap_or(Lit::FALSE);
            circuit.ite(over, is_one(most, place), bit)
        })
        .collect();
    let Some(&top) = number.last() else { return Vec::new() };
    // The weight of the highest literal. The other literals express the remainder, or the whole number if the highest
    // is false.
    let highest = most - ((1 << (places - 1)) - 1);
    if highest != 1 << (places - 1) {
        let mut carry = Lit::FALSE;
        for (place, bit) in number.iter_mut().enumerate().take(places - 1) {
            // Add the complement of the weight that was subtracted.
            let other = is_one((1 << places) - highest, place);
            let half = circuit.xor(*bit, other);
            let less = circuit.xor(half, carry);
            let (both, passed) = (circuit.and(*bit, other), circuit.and(half, carry));
            carry = circuit.or(both, passed);
            *bit = circuit.ite(top, less, *bit);
        }
    }
    let counts = (0..places - 1).map(|place| 1 << place).chain([highest]);
    number.into_iter().zip(counts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_model::{Assignment, VarId};

    const VALUES: [u16; 11] =
        [0, 1, 2, 0x3F80, 0x7F7F, 0x7F80, 0x7FFF, 0x8000, 0x8001, 0xBF80, 0xFFFF];
    const RELATIONS: [Relation; 6] = [
        Relation::Equal,
        Relation::NotEqual,
        Relation::Less,
        Relation::LessOrEqual,
        Relation::Greater,
        Relation::GreaterOrEqual,
    ];

    fn holds<T: PartialOrd>(relation: Relation, a: T, b: T) -> bool {
        match relation {
            Relation::Equal => a == b,
            Relation::NotEqual => a != b,
            Relation::Less => a < b,
            Relation::LessOrEqual => a <= b,
            Relation::Greater => a > b,
            Relation::GreaterOrEqual => a >= b,
        }
    }

    fn double(low: u16, high: u16) -> u32 {
        u32::from(high) << 16 | u32::from(low)
    }

    #[test]
    fn free_numbers_compare_as_integers_do() {
        for relation in RELATIONS {
            for signed in [false, true] {
                let (mut words, mut circuit) = (Words::default(), Circuit::default());
                let free: Vec<Word> = (0..4).map(|v| words.free(VarId(v))).collect();
                let single =
                    compare(&mut words, &mut circuit, relation, signed, &free[..1], &free[1..2]);
                let pair =
                    compare(&mut words, &mut circuit, relation, signed, &free[..2], &free[2..]);
                for a in VALUES {
                    for b in VALUES {
                        let values = circuit.evaluate(&Assignment(vec![a, b, b, a]));
                        let want = if signed {
                            holds(relation, a as i16, b as i16)
                        } else {
                            holds(relation, a, b)
                        };
                        assert_eq!(values.get(single), want, "{a:x} {relation} {b:x} {signed}");
                        let (x, y) = (double(a, b), double(b, a));
                        let want = if signed {
                            holds(relation, x as i32, y as i32)
                        } else {
                            holds(relation, x, y)
                        };
                        assert_eq!(values.get(pair), want, "{x:x} {relation} {y:x} {signed}");
                    }
                }
            }
        }
    }

    #[test]
    fn constants_compare_as_integers_do_on_either_side() {
        for relation in RELATIONS {
            for signed in [false, true] {
                for (low, high) in
                    VALUES.into_iter().zip(VALUES.into_iter().rev()).chain(VALUES.map(|v| (v, v)))
                {
                    let (mut words, mut circuit) = (Words::default(), Circuit::default());
                    let free: Vec<Word> = (0..2).map(|v| words.free(VarId(v))).collect();
                    let constant: Vec<Word> = [low, high].map(|v| words.constant(v)).to_vec();
                    let right =
                        compare(&mut words, &mut circuit, relation, signed, &free, &constant);
                    let left =
                        compare(&mut words, &mut circuit, relation, signed, &constant, &free);
                    let c = double(low, high);
                    for a in VALUES {
                        for b in VALUES {
                            let x = double(a, b);
                            let values = circuit.evaluate(&Assignment(vec![a, b]));
                            let test = |x: u32, y: u32| {
                                if signed {
                                    holds(relation, x as i32, y as i32)
                                } else {
                                    holds(relation, x, y)
                                }
                            };
                            assert_eq!(
                                values.get(right),
                                test(x, c),
                                "{x:x} {relation} {c:x} {signed}"
                            );
                            assert_eq!(
                                values.get(left),
                                test(c, x),
                                "{c:x} {relation} {x:x} {signed}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn plain_reals_compare_as_singles_and_others_freely() {
        for relation in RELATIONS {
            let (mut words, mut circuit) = (Words::default(), Circuit::default());
            let free: Vec<Word> = (0..4).map(|v| words.free(VarId(v))).collect();
            let special = circuit.atom(scanbound_model::Atom::Bit(VarId(4)));
            let lit =
                compare_real(&mut words, &mut circuit, relation, &free[..2], &free[2..], special);
            for a in VALUES {
                for b in VALUES {
                    for choice in [0, 1] {
                        let values = circuit.evaluate(&Assignment(vec![0, a, 1, b, choice]));
                        let (x, y) = (f32::from_bits(double(0, a)), f32::from_bits(double(1, b)));
                        let plain = |f: f32| f.is_normal() || f.to_bits() == 0;
                        let want =
                            if plain(x) && plain(y) { holds(relation, x, y) } else { choice == 1 };
                        assert_eq!(values.get(lit), want, "{x} {relation} {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn sums_and_differences_wrap_over_words() {
        for subtract in [false, true] {
            for constant in [
                None,
                Some((1, 0)),
                Some((0xFFFF, 0)),
                Some((0, 1)),
                Some((0xFFFF, 0xFFFF)),
                Some((5, 0x7FFF)),
            ] {
                let (mut words, mut circuit) = (Words::default(), Circuit::default());
                let free: Vec<Word> = (0..4).map(|v| words.free(VarId(v))).collect();
                let right = match constant {
                    Some((low, high)) => vec![words.constant(low), words.constant(high)],
                    None => free[2..].to_vec(),
                };
                let sum = add(&mut words, &free[..2], &right, subtract);
                let bits: Vec<_> = sum.iter().map(|&w| words.bits(&mut circuit, w)).collect();
                for a in VALUES {
                    for b in VALUES {
                        let values = circuit.evaluate(&Assignment(vec![a, b, b, a]));
                        let (x, y) = (
                            double(a, b),
                            constant.map_or(double(b, a), |(low, high)| double(low, high)),
                        );
                        let want = if subtract { x.wrapping_sub(y) } else { x.wrapping_add(y) };
                        let got = (0..32).fold(0u32, |n, i| {
                            n | u32::from(values.get(bits[i / 16][i % 16])) << i
                        });
                        assert_eq!(got, want, "{x:x} {y:x} {subtract}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_parts_of_a_number_are_the_number_and_all_of_them_the_most() {
        for most in [0, 1, 2, 3, 5, 7, 8, 20, 512, 1000, 0xFFFF] {
            let (mut words, mut circuit) = (Words::default(), Circuit::default());
            let word = words.free(VarId(0));
            let limit = words.constant(most as u16);
            let over =
                compare(&mut words, &mut circuit, Relation::Greater, false, &[word], &[limit]);
            let bits = words.bits(&mut circuit, word);
            let parts = in_parts(&mut circuit, &bits, over, most);
            assert_eq!(parts.iter().map(|(_, count)| count).sum::<u64>(), most);
            for number in (0..40).chain(most.saturating_sub(3)..=0xFFFF.min(most + 3)) {
                let values = circuit.evaluate(&Assignment(vec![number as u16]));
                let true_parts = parts.iter().filter(|(holds, _)| values.get(*holds));
                let sum: u64 = true_parts.map(|(_, count)| count).sum();
                assert_eq!(sum, number.min(most), "{number} of {most}");
            }
        }
    }
}
