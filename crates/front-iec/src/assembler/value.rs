//! Values of expressions during lowering.

use super::types::Kind;
use scanbound_ir::{Cell, Logic, Number, NumberFormat, Relation, WordSource, WordTarget};

/// The value of an expression.
#[derive(Debug, Clone)]
pub(crate) enum Value {
    Bit(Logic),
    Number(Kind, Number),
    /// An integer result that may overflow its type: its kind, its low bits at the size of the type, and the condition
    /// under which it overflows. There, compilers keep more of its bits, or none.
    Open(Kind, Number, Logic),
    /// An integer constant without a type yet.
    Constant(i64),
    /// The word of a reference, and the indices of the variables to which it can point.
    Address(Number, Vec<usize>),
    /// A text, or a value that is not modelled.
    Any,
}

/// `words` consecutive words from a cell on, to be read.
pub(crate) fn sources(first: Cell, words: u32) -> Vec<WordSource> {
    (0..words).map(|at| WordSource::Cell(first.plus(at))).collect()
}

/// `words` consecutive words from a cell on, to be written.
pub(crate) fn targets(first: Cell, words: u32) -> Vec<WordTarget> {
    (0..words).map(|at| WordTarget::Cell(first.plus(at))).collect()
}

/// A comparison of two signed numbers.
pub(crate) fn signed(relation: Relation, left: Number, right: Number) -> Logic {
    Logic::compare(relation, NumberFormat::Signed, left, right)
}

/// A comparison of two unsigned numbers.
pub(crate) fn unsigned(relation: Relation, left: Number, right: Number) -> Logic {
    Logic::compare(relation, NumberFormat::Unsigned, left, right)
}

/// Exclusive or of two bits.
pub(crate) fn differ(one: &Logic, two: &Logic) -> Logic {
    let only = |a: &Logic, b: &Logic| Logic::All(vec![a.clone(), b.clone().not()]);
    Logic::Any(vec![only(one, two), only(two, one)])
}

/// An integer constant as `words` words, the lowest first, in two's complement.
pub(crate) fn constant(value: i64, words: u32) -> Number {
    let value = value.cast_unsigned();
    let word = |at: u32| if at < 4 { (value >> (16 * at)) as u16 } else { 0 };
    Number::Words((0..words).map(|at| WordSource::Const(word(at))).collect())
}

/// A constant as words of a kind. It wraps at the size of the kind.
pub(crate) fn within(kind: Kind, value: i64) -> Number {
    let value = match kind {
        Kind::Whole { bits: 8, signed: true } => i64::from((value & 0xFF) as u8 as i8),
        Kind::Whole { bits: 8, signed: false } => value & 0xFF,
        _ => value,
    };
    constant(value, kind.words())
}

/// Wraps a result at the size of its kind. Only 8-bit kinds need it, since they are kept in 16-bit words.
pub(crate) fn wrapped(kind: Kind, number: Number) -> Number {
    let Kind::Whole { bits: 8, signed } = kind else { return number };
    let low = Number::And(Box::new(number), Box::new(constant(0xFF, 1)));
    if !signed {
        return low;
    }
    let flipped = Number::Xor(Box::new(low), Box::new(constant(0x80, 1)));
    Number::Sub(Box::new(flipped), Box::new(constant(0x80, 1)))
}

/// The bits of a decimal literal as an IEEE 754 single. None if it is not a number.
pub(crate) fn real(text: &str) -> Option<Number> {
    let value: f32 = text.parse().ok()?;
    Some(constant(i64::from(value.to_bits()), 2))
}

/// Whether an IEEE 754 single represents a decimal literal with the same value as a double does.
pub(crate) fn is_real(text: &str) -> bool {
    matches!((text.parse::<f32>(), text.parse::<f64>()), (Ok(short), Ok(long)) if f64::from(short) == long)
}
