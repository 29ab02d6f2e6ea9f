//! How symbolic words are composed, and the queries on them whose answers are literals.

use rustc_hash::FxHashMap;
use scanbound_model::{Lit, VarId};

/// A symbolic 16-bit word: its index among the nodes of [`Words`](super::word::Words). Equal expressions have the same
/// index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Word(pub(super) u32);

/// How a word is computed: an expression over literals, free words and other words, modulo 65,536.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Const(u16),
    Free(VarId),
    Either(Lit, Word, Word),
    Plus(Word, u16),
    /// Sixteen literals, one for each bit; the number is an index into the list of such words.
    Bits(u32),
    Bitwise(Gate, Word, Word),
    /// The sum of two words and a carry, modulo 65,536.
    Sum(Word, Word, Carry),
    /// The sum of a word, a constant and a carry, modulo 65,536.
    Carried(Word, u16, Carry),
    /// Word `u8` of the result of an operation, which has the number `u32` in the list of operations.
    Derived(u32, u8),
}

/// A bitwise operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Gate {
    And,
    Or,
    Xor,
}

/// The carry out of a sum of two words, which the sum of the next higher words adds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Carry(pub(super) u32);

/// The sum from which a carry comes: two words, or a word and a constant, each with the carry that the sum adds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum CarryDefinition {
    None,
    Always,
    Sum(Word, Word, Carry),
    Carried(Word, u16, Carry),
}

impl Carry {
    /// No carry: it is always 0.
    pub const NONE: Carry = Carry(0);
    /// A carry that is always 1.
    pub const ALWAYS: Carry = Carry(1);
}

/// A question about a word or a carry: whether the word is in a range, its bits, or whether the carry is 1. The answer
/// is one literal, or sixteen for bits.
#[derive(Debug, Clone, Copy)]
pub(super) enum Query {
    Range(Range),
    Bits(Word),
    Carry(Carry),
}

/// The query whether a word, unsigned, lies between two values (inclusive).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Range(pub Word, pub u16, pub u16);

/// The queries that were answered, and their answers.
#[derive(Debug, Default)]
pub(super) struct Answers {
    pub ranges: FxHashMap<Range, Lit>,
    /// For each literal that answers a range query, that query; the first if there are several.
    pub asked: FxHashMap<Lit, Range>,
    pub bits: FxHashMap<Word, [Lit; 16]>,
    pub carries: FxHashMap<Carry, Lit>,
    /// The stack of pending queries. Kept between queries to avoid allocations.
    pub open: Vec<Query>,
}
