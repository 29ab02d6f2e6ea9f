//! Results of operations on symbolic operands: products, quotients, shifts, BCD conversions. The results are symbolic
//! words; their bits are computed from the operands' bits only if a guard needs them.

use super::term::Word;
use scanbound_model::{Circuit, Lit};

/// An operation on symbolic numbers of one or two words; the bits of its result are computed from the bits of the
/// numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Function {
    /// The product of two numbers.
    Product {
        /// Whether the factors are in two's complement. Otherwise they are unsigned.
        signed: bool,
    },
    /// The quotient, rounded towards zero; any value if the divisor is 0.
    Quotient {
        /// Whether both numbers are in two's complement. Otherwise they are unsigned.
        signed: bool,
    },
    /// The remainder (if signed, with the dividend's sign); any value if the divisor is 0.
    Remainder {
        /// Whether both numbers are in two's complement. Otherwise they are unsigned.
        signed: bool,
    },
    /// The first number shifted or rotated by as many places as the second says; any value if these are more than the
    /// number of bits.
    Moved(ShiftKind),
    /// BCD (four digits a word) to binary.
    FromDecimal,
    /// Binary to BCD, four digits a word; any value for numbers above 9999 (one word) or 99999999 (two words).
    ToDecimal,
}

/// How bits are shifted or rotated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ShiftKind {
    /// Shift left; zeros come in.
    Left,
    /// Logical shift right; zeros come in.
    Right,
    /// Arithmetic shift right; copies of the sign bit come in.
    SignedRight,
    /// Rotate left; the bits that leave come in at the right.
    RoundLeft,
    /// Rotate right; the bits that leave come in at the left.
    RoundRight,
}

/// An operation and its operands, each of one or two words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Derived {
    pub function: Function,
    /// The number of words of each operand.
    pub words: u8,
    pub first: [Word; 2],
    /// The second operand. Equal to the first one if the operation has only one.
    pub second: [Word; 2],
    /// The number of words of the result that are used, from the lowest on.
    pub wanted: u8,
}

impl Derived {
    /// All words on which the result depends.
    pub fn operands(&self) -> impl Iterator<Item = Word> {
        let words = usize::from(self.words);
        self.first.into_iter().take(words).chain(self.second.into_iter().take(words))
    }

    /// The bits of the result, least significant first, computed from the bits of the operands.
    pub fn bits(&self, circuit: &mut Circuit, first: &[Lit], second: &[Lit]) -> Vec<Lit> {
        let wanted = 16 * usize::from(self.wanted);
        let mut bits = match self.function {
            Function::Product { signed } => {
                let [a, b] = [first, second].map(|number| extended(number, signed, wanted));
                product(circuit, &a, &b)
            }
            Function::Quotient { signed } => divided(circuit, first, second, signed).0,
            Function::Remainder { signed } => divided(circuit, first, second, signed).1,
            Function::Moved(way) => shifted(circuit, first, second, way),
            Function::FromDecimal => from_decimal(circuit, first),
            Function::ToDecimal => to_decimal(circuit, first),
        };
        bits.resize(wanted, Lit::FALSE);
        bits
    }
}

/// The bits of a number, extended with its sign or with zeros to `count` bits.
fn extended(number: &[Lit], signed: bool, count: usize) -> Vec<Lit> {
    let sign = number.last().copied().filter(|_| signed).unwrap_or(Lit::FALSE);
    let mut bits = number.to_vec();
    bits.resize(count, sign);
    bits
}

/// The sum of two numbers of equally many bits and a carry, with as many bits, and the carry out.
fn sum(circuit: &mut Circuit, a: &[Lit], b: &[Lit], carry: Lit) -> (Vec<Lit>, Lit) {
    let mut carry = carry;
    let bits = a.iter().zip(b).map(|(&a, &b)| {
        let half = circuit.xor(a, b);
        let bit = circuit.xor(half, carry);
        let (both, passed) = (circuit.and(a, b), circuit.and(half, carry));
        carry = circuit.or(both, passed);
        bit
    });
    let bits = bits.collect();
    (bits, carry)
}

/// The negative of a number if the condition is true, else the number.
fn negated_if(circuit: &mut Circuit, condition: Lit, number: &[Lit]) -> Vec<Lit> {
    let flipped: Vec<Lit> = number.iter().map(|&bit| circuit.xor(bit, condition)).collect();
    let zeros = vec![Lit::FALSE; number.len()];
    sum(circuit, &flipped, &zeros, condition).0
}

/// The low bits of a product, as many as each operand has (both have equally many).
fn product(circuit: &mut Circuit, a: &[Lit], b: &[Lit]) -> Vec<Lit> {
    let zeros = |number: &[Lit]| number.iter().filter(|bit| **bit == Lit::FALSE).count();
    // Each bit of `by` that may be 1 needs an addition, so `by` is the number with more bits known to be 0.
    let (by, of) = if zeros(a) > zeros(b) { (a, b) } else { (b, a) };
    let mut total = vec![Lit::FALSE; of.len()];
    for (place, &bit) in by.iter().enumerate().filter(|(_, bit)| **bit != Lit::FALSE) {
        let part: Vec<Lit> =
            of[..of.len() - place].iter().map(|&one| circuit.and(one, bit)).collect();
        let high = sum(circuit, &total[place..], &part, Lit::FALSE).0;
        total[place..].copy_from_slice(&high);
    }
    total
}

/// The quotient of `a` divided by `b`, rounded towards zero, and the remainder, with the sign of `a`.
fn divided(circuit: &mut Circuit, a: &[Lit], b: &[Lit], signed: bool) -> (Vec<Lit>, Vec<Lit>) {
    if !signed {
        return divided_unsigned(circuit, a, b);
    }
    let (minus_a, minus_b) = (a[a.len() - 1], b[b.len() - 1]);
    let of = negated_if(circuit, minus_a, a);
    let by = negated_if(circuit, minus_b, b);
    let (quotient, remainder) = divided_unsigned(circuit, &of, &by);
    let differ = circuit.xor(minus_a, minus_b);
    (negated_if(circuit, differ, &quotient), negated_if(circuit, minus_a, &remainder))
}

/// Quotient and remainder by long division in binary: subtracts the divisor, bit by bit, where it fits.
fn divided_unsigned(circuit: &mut Circuit, a: &[Lit], b: &[Lit]) -> (Vec<Lit>, Vec<Lit>) {
    let count = a.len();
    let mut quotient = vec![Lit::FALSE; count];
    let mut left = vec![Lit::FALSE; count];
    // One additional bit, so that shifting the remainder loses nothing.
    let mut inverse: Vec<Lit> = b.iter().map(|&bit| !bit).collect();
    inverse.push(Lit::TRUE);
    for place in (0..count).rev() {
        left.insert(0, a[place]);
        let (less, fits) = sum(circuit, &left, &inverse, Lit::TRUE);
        quotient[place] = fits;
        left =
            less.iter().zip(&left).map(|(&less, &as_is)| circuit.ite(fits, less, as_is)).collect();
        left.truncate(count);
    }
    (quotient, left)
}

/// A barrel shifter: shifts by 1 if bit 0 of `places` is on, then by 2 if bit 1 is on, and so on.
fn shifted(circuit: &mut Circuit, bits: &[Lit], places: &[Lit], way: ShiftKind) -> Vec<Lit> {
    let count = bits.len();
    let fill = if way == ShiftKind::SignedRight { bits[count - 1] } else { Lit::FALSE };
    let mut now = bits.to_vec();
    let stages = count.ilog2() as usize + 1;
    for (stage, &by) in places.iter().enumerate().take(stages) {
        let step = 1usize << stage;
        let from = |at: usize| match way {
            ShiftKind::RoundLeft => Some((at + count - step % count) % count),
            ShiftKind::RoundRight => Some((at + step) % count),
            ShiftKind::Left => at.checked_sub(step),
            ShiftKind::Right | ShiftKind::SignedRight => Some(at + step).filter(|&at| at < count),
        };
        let there = (0..count).map(|at| from(at).map_or(fill, |at| now[at]));
        now = there.zip(&now).map(|(there, &here)| circuit.ite(by, there, here)).collect();
    }
    now
}

/// Converts BCD digits of four bits to binary.
fn from_decimal(circuit: &mut Circuit, digits: &[Lit]) -> Vec<Lit> {
    let count = digits.len();
    let mut total = vec![Lit::FALSE; count];
    for digit in digits.chunks(4).rev() {
        // Multiplies by ten: eight times plus twice.
        let up = |places: usize| -> Vec<Lit> {
            std::iter::repeat_n(Lit::FALSE, places)
                .chain(total.iter().copied())
                .take(count)
                .collect()
        };
        let (eight, two) = (up(3), up(1));
        let ten = sum(circuit, &eight, &two, Lit::FALSE).0;
        let more = extended(digit, false, count);
        total = sum(circuit, &ten, &more, Lit::FALSE).0;
    }
    total
}

/// Converts a binary number to BCD digits by repeated doubling ("double dabble").
fn to_decimal(circuit: &mut Circuit, number: &[Lit]) -> Vec<Lit> {
    let count = number.len();
    let mut digits = vec![Lit::FALSE; count];
    let three = [Lit::TRUE, Lit::TRUE, Lit::FALSE, Lit::FALSE];
    for &bit in number.iter().rev() {
        for digit in digits.chunks_mut(4) {
            // A digit of 5 or more carries into the next digit when doubled.
            let low = circuit.or(digit[0], digit[1]);
            let middle = circuit.and(digit[2], low);
            let five = circuit.or(digit[3], middle);
            let add: Vec<Lit> = three.iter().map(|&bit| circuit.and(bit, five)).collect();
            let more = sum(circuit, digit, &add, Lit::FALSE).0;
            digit.copy_from_slice(&more);
        }
        digits.insert(0, bit);
        digits.truncate(count);
    }
    digits
}
