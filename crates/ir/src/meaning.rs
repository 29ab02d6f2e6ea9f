//! What a PLC does where an effect or a source says "any value": the kinds of choices, operations on operands, and what
//! was learned by carrying them out.
//!
//! The analysis follows every choice as any value at all, which is never too little. A lower bound has to be a scan
//! that a PLC can make, so the interpreter also makes *real runs*, in which a choice's value comes from its kind:
//!
//! - [`ChoiceKind::World`]: the outside may give any value: inputs that are read directly, what modules and networks
//!   deliver, how far timers have run, the moment of an interrupt.
//! - [`ChoiceKind::Exact`]: the value, or what is written, is worked out by an operation on operands.
//! - none (`Program::kinds` does not name the choice): it is not known here. A scan whose path or cost depends on such a
//!   value is followed no further.
//!
//! # Exact choices
//!
//! A choice that is *read* (`BitSource::Free`, `WordSource::Free`) takes the first word of the operation's first result;
//! its `outputs` are empty. A choice that is *havocked to* (`Write::Havoc`) writes the operation's results to the
//! `outputs`, one operand a result, and nothing else, in the place of the instruction's first effect with this choice;
//! its other effects with the same choice are part of the same writing. All inputs are read before anything is written,
//! in the state that the effects before have left. Everything written must lie in the regions of these effects, else
//! that is an internal error: the effects are what the upper bound rests on.
//!
//! Where an operation has no result that a manual settles (a digit that is none in BCD, a division by zero, a count
//! beyond what is allowed, a place beyond the area) it is `None`: the effects' any value stands, and is not known.

use super::{
    BitSource, BitTarget, Cell, ChoiceId, ChoiceKey, Frame, Logic, Number, Region, Source,
    WordSource, WordTarget, reads,
};
use scanbound_base::time::Picos;
use std::collections::BTreeMap;

/// Where a choice's value comes from in a real run. See the page's head.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ChoiceKind {
    /// The outside may give any value.
    World,
    /// An operation gives it.
    Exact(Box<Meaning>),
    /// A bit that the outside gives and does not change within a scan: what this cell holds when the scan starts. (The
    /// analysis follows it as any value at each place where it is read.)
    Steady(Cell),
    /// A timer's or counter's present value: the setting if its contact is on, else the value that the outside gives if
    /// that is below the setting, else 0.
    Present {
        /// The contact.
        contact: Cell,
        /// The setting.
        setting: u16,
    },
    /// How many units of time one scan can take, as a word: a timer whose setting is larger cannot be over in the scan that
    /// starts it. The analysis takes any value until the bound of a scan is known; a real run takes 0.
    ScanTicks {
        /// The unit.
        unit: Picos,
        /// Whether the word is decimal digits.
        is_decimal: bool,
    },
    /// How many iterations a loop makes, only for the count of a `ForBegin`: the word's value, signed. Where that is
    /// below 1, manuals do not say whether it makes one or none: the choice's bit 0 decides. A lower bound takes the
    /// cheaper of the two. The analysis follows this kind, too.
    Iterations(WordSource),
    /// How many iterations a loop makes, only for the count of a `ForBegin`: the word's value, unsigned. The analysis
    /// follows this kind, too.
    Unsigned(WordSource),
}

/// An operation with its operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Meaning {
    /// What is worked out.
    pub operation: Operation,
    /// From what, each a list of words.
    pub inputs: Vec<Operand>,
    /// Where the results go, one a result; empty for a choice that is read.
    pub outputs: Vec<Target>,
}

/// Where an operation reads a list of words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Operand {
    /// These words.
    Words(Vec<WordSource>),
    /// These bits, each a word of 0 or 1.
    Bits(Vec<BitSource>),
    /// A number's words.
    Number(Number),
    /// A truth value as 0 or 1; the condition is that of the instruction.
    Truth(Logic),
    /// A number of words from an address on.
    Run(Address, Shape, Count),
}

/// Where an operation's result goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// These words, as many as the result has.
    Words(Vec<WordTarget>),
    /// These bits, as many as the result has words: bit 0 of each.
    Bits(Vec<BitTarget>),
    /// From an address on, as many as the result has.
    Run(Address, Shape),
    /// Nowhere that matters.
    Nowhere,
}

/// What stands at an address, for each word of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A cell: a word, or a bit as 0 or 1.
    Cells,
    /// A bit of words as 0 or 1, from this bit (0 to 15) of the address's word on.
    WordBits(u8),
    /// Bit cells, sixteen a word, the first the least; of the last word so many (1 to 16), its other bits are 0 when
    /// read and lost when written.
    Packed(u8),
}

/// A cell whose number is worked out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    /// What is added up.
    pub base: i64,
    /// To this.
    pub terms: Vec<Term>,
    /// Which cells have which addresses. What lies outside, the cells of a run behind the first included, is not known.
    pub stretches: Vec<Stretch>,
}

/// A number read from words, times a factor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Term {
    /// One or two words, the least first.
    pub words: Vec<WordSource>,
    /// How they are read.
    pub reading: Digits,
    /// The factor.
    pub times: i64,
}

/// How words are read as a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Digits {
    /// Two's complement.
    Signed,
    /// Binary.
    Unsigned,
    /// Four digits a word; where one is above 9, the number is not known.
    Bcd,
}

/// Consecutive cells with consecutive addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// The first one's address.
    pub from: i64,
    /// How many.
    pub count: u32,
    /// The first.
    pub first: Cell,
}

/// How many words a list has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Count {
    /// A known number.
    Exactly(u32),
    /// As many as the term says; not known outside these limits.
    Of {
        /// The number.
        term: Term,
        /// The least that is settled.
        least: u32,
        /// The most.
        most: u32,
    },
    /// Up to and with the first word that has a byte of 0 (the low byte comes first), at most so many.
    Text(u32),
}

/// A function of lists of words to lists of words. Numbers of several words have the least word first.
///
/// No operation knows a dialect; what differs between dialects is a parameter or another operation. How each is carried
/// out stands in `replay/operation.rs` and `replay/lists.rs` alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Operation {
    /// Each input as it is, to the output of its place.
    Copy,
    /// The first input's words changed by a function that needs nothing else; one result.
    Each(Unary),
    /// Bits of the first input, all its words as one number, rotated by the second input's first word; with a third,
    /// through that bit, the carry. Results: the number, then the carry: the last bit rotated out (unchanged for 0
    /// places). Not known for more places than bits.
    Rotate {
        /// Towards the highest bit.
        left: bool,
        /// Whether the carry is one of the bits that go round.
        through: bool,
    },
    /// Bits of the first input moved by so many places as the second input's first word says; zeros come in, or the
    /// highest bit where `signed` and to the right. Results: the number, then the last bit moved out (unchanged, the
    /// third input, for 0 places). Not known for more places than bits.
    Shift {
        /// Towards the highest bit.
        left: bool,
        /// The highest bit comes in.
        signed: bool,
    },
    /// How many bits of the first input are set, in the first result's words: as many as the parameter says.
    CountBits(u8),
    /// The bit whose number the first input's low bits (so many as the second input says, 1 to 8) give is 1, all
    /// others of two to that power 0: a list of bits.
    Decode,
    /// The number of the highest bit that is set among the first input's bits, a list of bits; not known if none is.
    Encode,
    /// Product of two numbers of equally many words, signed; twice as many words.
    Multiply {
        /// Two's complement.
        signed: bool,
    },
    /// Quotient and remainder of two numbers of equally many words, towards zero: two results. Not known for a divisor
    /// of 0 and where the quotient does not fit.
    Divide {
        /// Two's complement.
        signed: bool,
    },
    /// Sum or difference of two numbers of equally many words, the third input, a carry or borrow, with it (none: 0).
    /// Results: the number, then the carry or borrow out of it, both binary.
    Sum {
        /// The second is taken from the first.
        subtract: bool,
    },
    /// The carry or borrow of [`Operation::Sum`] alone.
    Carry {
        /// The second is taken from the first.
        subtract: bool,
    },
    /// The same of numbers in binary coded decimal; a difference below 0 is that to the next power of ten.
    DecimalSum {
        /// The second is taken from the first.
        subtract: bool,
    },
    /// Product of two numbers of equally many words in binary coded decimal; twice as many words.
    DecimalMultiply,
    /// Quotient and remainder of two numbers in binary coded decimal, in one result: the remainder behind. Not known
    /// for a divisor of 0.
    DecimalDivide,
    /// The words of both results of [`Operation::Divide`] in one: the remainder behind.
    DivideJoined {
        /// Two's complement.
        signed: bool,
    },
    /// The results of an operation, and behind them two bits of so many words of the first one from its least on: whether
    /// all are 0, and the highest bit.
    Judged {
        /// The operation.
        operation: Box<Operation>,
        /// How many words.
        words: u8,
    },
    /// The first input's words, each changed by a function as a number of its own.
    EachWord(Unary),
    /// The third input's number, kept between those of the first and the second, signed. Not known where the first is
    /// larger than the second; so with the next.
    Limit,
    /// By how much the third input's number lies outside those of the first and the second, signed; not known where
    /// that does not fit.
    Band,
    /// The third input's number and, signed, the first's if it is below 0, the second's if above; not known where the
    /// sum does not fit.
    Zone,
    /// The first input's number in so many words, signed; not known where it does not fit.
    Resize(u8),
    /// The first input's words, so many times as the second input's first word says, 1 to 32767.
    Repeat,
    /// The sum of the first input's numbers of so many words each, signed, in twice as many.
    Total(u8),
    /// Their mean, in so many words; not known where it is no whole number.
    Mean(u8),
    /// Which of the first input's numbers of so many words, signed, is the greatest or the least: its value, the place
    /// of the first such from 1 on, how many there are. One result.
    Extreme {
        /// Words of each.
        words: u8,
        /// The greatest.
        greatest: bool,
    },
    /// Where the first input's number stands in the second's list of as long ones: the first place from 1 on, 0 if
    /// nowhere, and how often.
    Find {
        /// The list may be taken for a sorted one: then it is not known which place is found, and how many.
        halving: bool,
    },
    /// Groups of so many bits (4 or 8) of the first input's words, the lowest first, each as a word: as many as the
    /// second input's first word says.
    Split(u8),
    /// The lowest so many bits (4 or 8) of the first input's words, one group behind the other, zeros above.
    Join(u8),
    /// The first input's bit whose number is the second's first word, modulo the bits that there are.
    PickBit,
    /// The first input with that bit set or cleared.
    PutBit(bool),
    /// A signed number as an IEEE 754 single; not known where it is rounded.
    ToReal,
    /// An IEEE 754 single as a signed number of so many words; not known where it is not whole or does not fit.
    FromReal(u8),
    /// Two IEEE 754 singles; not known where one is not normal or +0, nor is the result, or it is rounded.
    Real(Arithmetic),
    /// Hours, minutes and seconds of a day as seconds, two words; not known where there is no such time.
    ToSeconds,
    /// The opposite.
    FromSeconds,
    /// What a running timer stands at, of which the inputs are: whether it is through, its value before, its setting,
    /// and the outside's number: that number, kept between what it was and what is below the setting. Not known where it
    /// is through, for settings below 1, and beyond the setting.
    Elapsed,
    /// What a counter stands at whose input is on, of which the inputs are: whether its input was on, whether it was
    /// through, its value before, its setting. One more if the input came on. Not known for settings below 1, and
    /// beyond the setting.
    Counted,
}

/// What is done with two real numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arithmetic {
    /// Sum.
    Add,
    /// First minus second.
    Sub,
    /// Product.
    Multiply,
    /// First by second.
    Divide,
}

/// A function of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unary {
    /// Binary to binary coded decimal, four digits a word; not known beyond 9999 or 99999999, and below 0.
    ToBcd,
    /// Binary coded decimal to binary; not known where a digit is above 9.
    FromBcd,
    /// The bytes of each word change places.
    SwapBytes,
    /// All bits in the opposite order.
    Reverse,
    /// The number's two's complement negative.
    Negate,
    /// Binary to Gray code; not known below 0.
    ToGray,
    /// Gray code to binary; not known below 0.
    FromGray,
}

impl ChoiceKind {
    /// Shows every word that is read for the choice.
    pub fn each_word(&self, see: &mut dyn FnMut(WordSource)) {
        let meaning = match self {
            ChoiceKind::World
            | ChoiceKind::Steady(_)
            | ChoiceKind::Present { .. }
            | ChoiceKind::ScanTicks { .. } => return,
            ChoiceKind::Iterations(word) | ChoiceKind::Unsigned(word) => return see(*word),
            ChoiceKind::Exact(meaning) => meaning,
        };
        let mut words = |words: &[WordSource]| words.iter().for_each(|&word| see(word));
        for input in &meaning.inputs {
            match input {
                Operand::Words(sources) => words(sources),
                Operand::Bits(_) => {}
                Operand::Number(number) => reads::number(number, &mut |source| {
                    if let Source::Word(word) = source {
                        words(&[word]);
                    }
                }),
                Operand::Truth(logic) => reads::logic(logic, &mut |source| {
                    if let Source::Word(word) = source {
                        words(&[word]);
                    }
                }),
                Operand::Run(address, _, count) => {
                    address.terms.iter().for_each(|term| words(&term.words));
                    if let Count::Of { term, .. } = count {
                        words(&term.words);
                    }
                }
            }
        }
        for output in &meaning.outputs {
            if let Target::Run(address, _) = output {
                address.terms.iter().for_each(|term| words(&term.words));
            }
        }
    }
}

impl Meaning {
    /// Shows all cells that it may read, those at addresses included.
    pub fn each_read(&self, see: &mut dyn FnMut(Region)) {
        let mut source = |source: Source| source.region().into_iter().for_each(&mut *see);
        for input in &self.inputs {
            match input {
                Operand::Words(words) => words.iter().for_each(|&one| source(Source::Word(one))),
                Operand::Bits(bits) => bits.iter().for_each(|&one| source(Source::Bit(one))),
                Operand::Number(number) => reads::number(number, &mut source),
                Operand::Truth(logic) => reads::logic(logic, &mut source),
                Operand::Run(..) => {}
            }
        }
        let addresses = self.inputs.iter().filter_map(|input| match input {
            Operand::Run(address, ..) => Some(address),
            _ => None,
        });
        for address in addresses {
            let stretch = |one: &Stretch| Region::Range { first: one.first, count: one.count };
            address.stretches.iter().map(stretch).for_each(&mut *see);
        }
        let words = ChoiceKind::Exact(Box::new(self.clone()));
        words.each_word(&mut |word| Source::Word(word).region().into_iter().for_each(&mut *see));
    }

    /// What a choice that is read is the value of: this operand's first word.
    #[must_use]
    pub fn of(input: Operand) -> Meaning {
        Meaning { operation: Operation::Copy, inputs: vec![input], outputs: Vec::new() }
    }
}

impl Address {
    /// The cells of one area that begin with this one as number 0, at a number that is the sum of these terms.
    #[must_use]
    pub fn within(first: Cell, count: u32, base: i64, terms: Vec<Term>) -> Address {
        Address { base, terms, stretches: vec![Stretch { from: 0, count, first }] }
    }
}

impl Term {
    /// A word as a signed number.
    #[must_use]
    pub fn signed(word: WordSource) -> Term {
        Term { words: vec![word], reading: Digits::Signed, times: 1 }
    }

    /// A word as it is.
    #[must_use]
    pub fn unsigned(word: WordSource) -> Term {
        Term { words: vec![word], reading: Digits::Unsigned, times: 1 }
    }
}

/// Something that an exact choice was worked out from at one moment.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Read {
    /// These bits of a cell had this value.
    Cell(Cell, u16, u16),
    /// A choice had this value.
    Choice(ChoiceKey, u16),
    /// The instruction's condition was this.
    Condition(bool),
}

/// What came of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Learned {
    /// The choice that was read has this value.
    Value(u16),
    /// These bits of these cells take this value, and nothing else is written.
    Writes(Vec<(Cell, u16, u16)>),
}

/// One thing that was learned about a choice at a moment: if all this is read, that comes of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// What is read.
    pub reads: Vec<Read>,
    /// What comes of it.
    pub learned: Learned,
}

/// What was learned about choices, by the moment: the call context and the choice.
pub type Knowledge = BTreeMap<(Vec<Frame>, ChoiceId), Vec<Fact>>;

impl std::fmt::Display for super::Relation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            super::Relation::Equal => "=",
            super::Relation::NotEqual => "<>",
            super::Relation::Less => "<",
            super::Relation::LessOrEqual => "<=",
            super::Relation::Greater => ">",
            super::Relation::GreaterOrEqual => ">=",
        })
    }
}
