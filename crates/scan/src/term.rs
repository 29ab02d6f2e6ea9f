//! What symbolic words are made of, and what can be asked of them.

use rustc_hash::FxHashMap;
use scanbound_model::{Lit, VarId};

/// A symbolic word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Word(pub(super) u32);

/// How a word comes about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Const(u16),
    Free(VarId),
    Either(Lit, Word, Word),
    Plus(Word, u16),
    /// Sixteen bits, by their number.
    Bits(u32),
    Bitwise(Gate, Word, Word),
    /// The sum of two words and a carry.
    Sum(Word, Word, Carry),
    /// The sum of a word, a constant and a carry.
    Carried(Word, u16, Carry),
    /// A word of what an operation gives, by the operation's number.
    Derived(u32, u8),
}

/// What is done with two bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Gate {
    And,
    Or,
    Xor,
}

/// The carry out of a sum, for the next word of the number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Carry(pub(super) u32);

/// Of which sum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum CarryOf {
    None,
    Always,
    Sum(Word, Word, Carry),
    Carried(Word, u16, Carry),
}

impl Carry {
    /// No carry.
    pub const NONE: Carry = Carry(0);
    /// A carry, whatever was added.
    pub const ALWAYS: Carry = Carry(1);
}

/// A question.
#[derive(Debug, Clone, Copy)]
pub(super) enum Question {
    Range(Range),
    Bits(Word),
    Carry(Carry),
}

/// Whether a word, unsigned, lies between two values, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Range(pub Word, pub u16, pub u16);

/// What was asked of the words so far.
#[derive(Debug, Default)]
pub(super) struct Answers {
    pub ranges: FxHashMap<Range, Lit>,
    /// Of which question a literal is the answer, of several the first.
    pub asked: FxHashMap<Lit, Range>,
    pub bits: FxHashMap<Word, [Lit; 16]>,
    pub carries: FxHashMap<Carry, Lit>,
    /// The stack of questions to be answered. Kept between questions, so that it is not allocated each time.
    pub open: Vec<Question>,
}
