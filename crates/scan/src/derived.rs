//! Results of operations whose operands are not known: products, quotients, bits that are moved. They are words like others;
//! how they hang on their operands' bits is worked out where a guard asks for theirs.

use super::term::Word;
use scanbound_model::{Circuit, Lit};

/// What is worked out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Function {
    /// The product of two numbers.
    Product {
        /// Two's complement.
        signed: bool,
    },
    /// The quotient, towards zero; anything where the divisor is 0.
    Quotient {
        /// Two's complement.
        signed: bool,
    },
    /// The remainder, with the dividend's sign.
    Remainder {
        /// Two's complement.
        signed: bool,
    },
    /// The first number's bits moved by the second: anything for more places than bits.
    Moved(Way),
    /// Four decimal digits a word as a number.
    FromDecimal,
    /// The opposite; anything beyond 9999 a word.
    ToDecimal,
}

/// Where bits are moved to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Way {
    /// Towards the highest bit; zeros come in.
    Left,
    /// Towards the lowest bit; zeros come in.
    Right,
    /// Towards the lowest bit; the highest bit comes in again and again.
    SignedRight,
    /// Towards the highest bit; what is moved out there comes in at the other end.
    RoundLeft,
    /// The opposite.
    RoundRight,
}

/// A function and the words of its operands, of one or two words each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Derived {
    pub function: Function,
    /// How many words each operand has.
    pub words: u8,
    pub first: [Word; 2],
    /// The same as the first where there is no second.
    pub second: [Word; 2],
    /// How many words are asked for of the result.
    pub wanted: u8,
}

impl Derived {
    /// All words that it is worked out from.
    pub fn operands(&self) -> impl Iterator<Item = Word> {
        let words = usize::from(self.words);
        self.first.into_iter().take(words).chain(self.second.into_iter().take(words))
    }

    /// The result's bits, the least first, from those of the operands.
    pub fn bits(&self, circuit: &mut Circuit, first: &[Lit], second: &[Lit]) -> Vec<Lit> {
        let wanted = 16 * usize::from(self.wanted);
        let mut bits = match self.function {
            Function::Product { signed } => {
                let [a, b] = [first, second].map(|number| extended(number, signed, wanted));
                product(circuit, &a, &b)
            }
            Function::Quotient { signed } => divided(circuit, first, second, signed).0,
            Function::Remainder { signed } => divided(circuit, first, second, signed).1,
            Function::Moved(way) => moved(circuit, first, second, way),
            Function::FromDecimal => from_decimal(circuit, first),
            Function::ToDecimal => to_decimal(circuit, first),
        };
        bits.resize(wanted, Lit::FALSE);
        bits
    }
}

/// A number in so many bits.
fn extended(number: &[Lit], signed: bool, count: usize) -> Vec<Lit> {
    let sign = number.last().copied().filter(|_| signed).unwrap_or(Lit::FALSE);
    let mut bits = number.to_vec();
    bits.resize(count, sign);
    bits
}

/// A sum with a carry, as many bits as the first number; and the carry out.
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

/// A number's negative where a condition holds.
fn negated_if(circuit: &mut Circuit, condition: Lit, number: &[Lit]) -> Vec<Lit> {
    let flipped: Vec<Lit> = number.iter().map(|&bit| circuit.xor(bit, condition)).collect();
    let zeros = vec![Lit::FALSE; number.len()];
    sum(circuit, &flipped, &zeros, condition).0
}

/// The low bits of a product, as many as both numbers have.
fn product(circuit: &mut Circuit, a: &[Lit], b: &[Lit]) -> Vec<Lit> {
    let zeros = |number: &[Lit]| number.iter().filter(|bit| **bit == Lit::FALSE).count();
    // Each bit of the one that is not known to be 0 takes an addition.
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

/// Quotient and remainder.
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

/// As on paper: the divisor is taken off where it fits, bit by bit.
fn divided_unsigned(circuit: &mut Circuit, a: &[Lit], b: &[Lit]) -> (Vec<Lit>, Vec<Lit>) {
    let count = a.len();
    let mut quotient = vec![Lit::FALSE; count];
    let mut left = vec![Lit::FALSE; count];
    // One bit more, so that nothing is lost where the rest is moved up.
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

/// Bits moved by a number of places, up to as many as there are: by one place if the number's lowest bit is on, then by two
/// if the next one is, and so on.
fn moved(circuit: &mut Circuit, bits: &[Lit], places: &[Lit], way: Way) -> Vec<Lit> {
    let count = bits.len();
    let fill = if way == Way::SignedRight { bits[count - 1] } else { Lit::FALSE };
    let mut now = bits.to_vec();
    let stages = count.ilog2() as usize + 1;
    for (stage, &by) in places.iter().enumerate().take(stages) {
        let step = 1usize << stage;
        let from = |at: usize| match way {
            Way::RoundLeft => Some((at + count - step % count) % count),
            Way::RoundRight => Some((at + step) % count),
            Way::Left => at.checked_sub(step),
            Way::Right | Way::SignedRight => Some(at + step).filter(|&at| at < count),
        };
        let there = (0..count).map(|at| from(at).map_or(fill, |at| now[at]));
        now = there.zip(&now).map(|(there, &here)| circuit.ite(by, there, here)).collect();
    }
    now
}

/// Decimal digits of four bits as a number.
fn from_decimal(circuit: &mut Circuit, digits: &[Lit]) -> Vec<Lit> {
    let count = digits.len();
    let mut total = vec![Lit::FALSE; count];
    for digit in digits.chunks(4).rev() {
        // Ten times what there is: eight times and twice.
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

/// A number as decimal digits of four bits: each is doubled with the number's next bit.
fn to_decimal(circuit: &mut Circuit, number: &[Lit]) -> Vec<Lit> {
    let count = number.len();
    let mut digits = vec![Lit::FALSE; count];
    let three = [Lit::TRUE, Lit::TRUE, Lit::FALSE, Lit::FALSE];
    for &bit in number.iter().rev() {
        for digit in digits.chunks_mut(4) {
            // Five and more: doubled, it carries into the next digit.
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
