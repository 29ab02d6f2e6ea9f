//! Values of expressions, as what the analysis follows.

use super::types::Kind;
use scanbound_ir::{Cell, Logic, Number, NumberFormat, Relation, WordSource, WordTarget};

/// A value.
#[derive(Debug, Clone)]
pub(crate) enum Value {
    Bit(Logic),
    Number(Kind, Number),
    /// A whole number at the size of its type, as it comes of a sum, and where it does not fit that: compilers keep
    /// more of its bits there, or none.
    Open(Kind, Number, Logic),
    /// A whole constant that has no type of its own yet.
    Constant(i64),
    /// The word of a reference, and the indices of the variables that it can mean.
    Address(Number, Vec<usize>),
    /// Text, or what is not followed at all.
    Any,
}

/// Words that lie from a cell on.
pub(crate) fn sources(first: Cell, words: u32) -> Vec<WordSource> {
    (0..words).map(|at| WordSource::Cell(first.plus(at))).collect()
}

/// The words from a cell on, to be written.
pub(crate) fn targets(first: Cell, words: u32) -> Vec<WordTarget> {
    (0..words).map(|at| WordTarget::Cell(first.plus(at))).collect()
}

/// How one number compares to another, both with a sign.
pub(crate) fn signed(relation: Relation, left: Number, right: Number) -> Logic {
    Logic::compare(relation, NumberFormat::Signed, left, right)
}

/// How one number compares to another, both without a sign.
pub(crate) fn unsigned(relation: Relation, left: Number, right: Number) -> Logic {
    Logic::compare(relation, NumberFormat::Unsigned, left, right)
}

/// Whether one of two bits is true alone.
pub(crate) fn differ(one: &Logic, two: &Logic) -> Logic {
    let only = |a: &Logic, b: &Logic| Logic::All(vec![a.clone(), b.clone().not()]);
    Logic::Any(vec![only(one, two), only(two, one)])
}

/// The words of a whole number.
pub(crate) fn constant(value: i64, words: u32) -> Number {
    let value = value.cast_unsigned();
    let word = |at: u32| if at < 4 { (value >> (16 * at)) as u16 } else { 0 };
    Number::Words((0..words).map(|at| WordSource::Const(word(at))).collect())
}

/// The words of a constant that becomes one of a type.
pub(crate) fn within(kind: Kind, value: i64) -> Number {
    let value = match kind {
        Kind::Whole { bits: 8, signed: true } => i64::from((value & 0xFF) as u8 as i8),
        Kind::Whole { bits: 8, signed: false } => value & 0xFF,
        _ => value,
    };
    constant(value, kind.words())
}

/// What a number's type keeps of words that may hold more: those of 8 bits wrap within their word.
pub(crate) fn wrapped(kind: Kind, number: Number) -> Number {
    let Kind::Whole { bits: 8, signed } = kind else { return number };
    let low = Number::And(Box::new(number), Box::new(constant(0xFF, 1)));
    if !signed {
        return low;
    }
    let flipped = Number::Xor(Box::new(low), Box::new(constant(0x80, 1)));
    Number::Sub(Box::new(flipped), Box::new(constant(0x80, 1)))
}

/// The bits of a number with one digit behind the point, or none, as an IEEE 754 single.
pub(crate) fn real(text: &str) -> Option<Number> {
    let value: f32 = text.parse().ok()?;
    Some(constant(i64::from(value.to_bits()), 2))
}

/// Whether a single holds a number exactly.
pub(crate) fn is_real(text: &str) -> bool {
    matches!((text.parse::<f32>(), text.parse::<f64>()), (Ok(short), Ok(long)) if f64::from(short) == long)
}
