//! How a real PLC determines the values that effects and sources leave nondeterministic: types of choices, operations
//! on operands, and what executing them has shown.
//!
//! The analysis lets every choice have any value, which never makes the bound too low. A lower bound, however, must
//! be a scan that a PLC can really execute. For it the interpreter makes *real runs*, in which the type of a choice
//! gives its value:
//!
//! - [`ChoiceKind::External`]: an external value; it may be anything. Inputs that are read directly, data from modules
//!   and networks, how far timers have run, the moment of an interrupt.
//! - [`ChoiceKind::Exact`]: an operation computes the value, or what is written, from operands.
//! - no entry in `Program::kinds`: the value is unknown. A real run stops where its path or cost depends on such a
//!   value.
//!
//! # Exact choices
//!
//! If the choice is *read* (`BitSource::Free`, `WordSource::Free`), its value is the first word of the operation's
//! first result; `outputs` is empty. If the choice is *havocked* (`Write::Havoc`), the operation writes its results to
//! the `outputs`, one result to each, and nothing else. It does so at the instruction's first effect with this choice;
//! the other effects with the same choice belong to the same write. All inputs are read before anything is written, in
//! the state after the preceding effects. All targets must lie in the regions of these effects. Otherwise this is an
//! internal error, because the upper bound relies on the effects.
//!
//! If the manuals do not define the result (an invalid BCD digit, a division by zero, a count beyond the limit, an
//! address outside the area), the operation gives `None`: the value stays nondeterministic and is unknown.

use super::{
    BitSource, BitTarget, Cell, ChoiceId, ChoiceKey, Frame, Logic, Number, Region, Relation,
    Source, WordSource, WordTarget, source,
};
use scanbound_base::time::Picos;
use std::collections::BTreeMap;

/// How the value of a choice is determined in a real run. See the module documentation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ChoiceKind {
    /// A value from outside the program: any value is possible.
    External,
    /// The result of an operation on operands. A real run executes the operation; the analysis may let the result have
    /// any value.
    Exact(Box<Meaning>),
    /// A value that something outside the program may change at any moment, but need not change within a scan. In a
    /// real run it is the value of this source. (The analysis lets it have any value at each read.)
    StableExternal(Source),
    /// A bit that is on if the controller does something in another way than the standard has it, the same in every
    /// scan. The number is an index into `Program::readings`. The analysis lets the bit have any value at each read. A
    /// real run is made in both ways, and the least time counts.
    Reading(u32),
    /// A bit that is on where a controller may execute instructions that others do not. The analysis lets it have any
    /// value; a real run uses 0.
    ExtraTime,
    /// A bit of the CPU's parameters. The analysis lets it have any value; on the CPU of a real run it is off.
    Parameter,
    /// The present value of a timer or counter: the set value if its contact is on; else the external value if that is
    /// below the set value; else 0.
    PresentValue {
        /// The contact (completion flag) of the timer or counter.
        contact: Cell,
        /// The constant set value: a time in the timer's unit, or a count.
        setting: u16,
    },
    /// The largest number of time units that pass in one scan, as a word: a timer with a larger set value cannot time
    /// out in the scan that starts it. For an upper bound, the analysis uses any value until a bound of the scan is
    /// known, then the largest number. A real run uses 0, or the largest number if `goes_on` is set.
    ScanTicks {
        /// The time of one unit of the word.
        unit: Picos,
        /// Whether the word is in BCD.
        is_decimal: bool,
        /// Whether a real run uses the largest number, because the timer may go on after a reset.
        goes_on: bool,
    },
    /// The address of a cell, low word first, only for a havocked region of two words. Manuals do not say which number
    /// it is, and the analysis lets it be any. Lower bounds use `number`: a real run does not depend on it, because the
    /// words are unknown except as an [`IntegerFormat::Address`].
    AddressOf {
        /// The number that stands for the address.
        number: u32,
        /// The first cell of the [`AddressRange`] that contains the addressed cell.
        first: Cell,
    },
    /// A bit that is on if the PLC does not have all cells of a list of this many words at an address: an operation
    /// error. The analysis lets it have any value. In a real run it is off or unknown.
    Unreachable(Box<(Address, Count)>),
    /// The number of iterations of a loop, only for the count of a `ForBegin`: the word's value, signed. For values
    /// below 1, manuals do not say whether the loop makes one iteration or none; bit 0 of the choice decides, and a
    /// lower bound uses the cheaper case. The analysis follows choices of this type too.
    Iterations(WordSource),
    /// The number of iterations of a loop, only for the count of a `ForBegin`: the word's value, unsigned. The analysis
    /// follows choices of this type too.
    UnsignedIterations(WordSource),
}

/// An operation with its operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Meaning {
    /// The operation that is executed.
    pub operation: Operation,
    /// The operands of the operation, each a list of words.
    pub inputs: Vec<OperationInput>,
    /// The targets, one for each result of the operation; empty if the choice itself is read.
    pub outputs: Vec<Target>,
}

/// An operand of an operation: a list of words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OperationInput {
    /// The values of these words.
    Words(Vec<WordSource>),
    /// The values of these bits, each as a word of 0 or 1.
    Bits(Vec<BitSource>),
    /// The words of an expression.
    Number(Number),
    /// A Boolean expression as 0 or 1. `Logic::Condition` in it is the condition of the instruction.
    Truth(Logic),
    /// This many words, read from this address on.
    Run(Address, Shape, Count),
}

/// Where a result of an operation is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// The result is written to these words, of which there are as many as the result has.
    Words(Vec<WordTarget>),
    /// Bit 0 of each word of the result is written to these bits.
    Bits(Vec<BitTarget>),
    /// The result is written to consecutive addresses from this one on, one for each word.
    Run(Address, Shape),
    /// The result is not stored.
    Nowhere,
}

/// How the words of a list are stored at an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// One cell for each: a word, or a bit as 0 or 1.
    Cells,
    /// Consecutive bits of words, each as 0 or 1, from this bit (0 to 15) of the addressed word on.
    WordBits(u8),
    /// Sixteen bit cells for each word, least significant bit first. The last word has only this many bits (1 to 16);
    /// its other bits are read as 0 and lost when written.
    Packed(u8),
}

/// A computed address: `base` plus the sum of `terms`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    /// The constant summand of the address.
    pub base: i64,
    /// The summands of the address that depend on words.
    pub terms: Vec<Term>,
    /// Which cells have which addresses. The result of an access that is not completely inside these ranges is unknown.
    pub ranges: Vec<AddressRange>,
}

/// An integer read from words, times a factor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Term {
    /// One or two words, low word first.
    pub words: Vec<WordSource>,
    /// Whether the words are signed or unsigned, and binary or BCD.
    pub format: IntegerFormat,
    /// The factor by which the integer is multiplied.
    pub factor: i64,
}

/// How words are interpreted as an integer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntegerFormat {
    /// A signed number in two's complement.
    Signed,
    /// An unsigned binary number.
    Unsigned,
    /// BCD, four digits a word; unknown if a digit is above 9.
    Bcd,
    /// An unsigned number that certainly is an address: [`ChoiceKind::AddressOf`], moved, or with a known number
    /// added to it or subtracted from it. It leads only to cells of the same [`AddressRange`]. Unknown otherwise.
    Address,
}

/// Consecutive cells with consecutive addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AddressRange {
    /// The address of the first cell.
    pub from: i64,
    /// The number of successive cells with successive addresses that each PLC has.
    pub count: u32,
    /// The number of these cells on the PLC of a real run, at least `count`: how many there are is a parameter. An
    /// access beyond them is an operation error. The upper bound does not depend on this number.
    pub chosen: u32,
    /// The cell at the address `from`.
    pub first: Cell,
}

/// The number of words of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Count {
    /// A constant number of words.
    Exactly(u32),
    /// The value of the term. The number is unknown if the value is not from `least` to `most`.
    Of {
        /// The term whose value is the number of words.
        term: Term,
        /// The smallest number of words for which the operation is modelled.
        least: u32,
        /// The largest number of words for which the operation is modelled.
        most: u32,
    },
    /// The words up to and including the first one that contains a zero byte. The number is unknown if none of the
    /// first words, this many, contains one.
    Text(u32),
}

/// A function from lists of words to lists of words. Numbers of several words have their low word first. Its result is
/// unknown (`None`) in the cases named.
///
/// Operations know no dialect. Where dialects differ, an operation has a parameter, or there are two operations. Only
/// `replay/operation.rs` and `replay/lists.rs` implement them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Operation {
    /// Copies each input to the output with the same index.
    Copy,
    /// Applies a function to the first input, taken as one number. One result.
    Each(Unary),
    /// Rotates the bits of the first input, taken as one number, by the first word of the second input. The carry is
    /// bit 0 of the third input. Results: the number; the carry, which is the last bit rotated out (for 0 places the
    /// old carry). Unknown if the places exceed the number of bits, or if `through` is true and the third input is
    /// missing.
    Rotate {
        /// Rotates towards the most significant bit (`true`), or towards the least significant one.
        left: bool,
        /// Whether the bits rotate through the carry: it is then one more bit of the rotated number.
        through: bool,
    },
    /// Shifts the bits of the first input by the number of places in the first word of the second input. Zeros come in,
    /// or copies of the most significant bit for a signed shift to the right. Results: the number; the last bit shifted
    /// out (for 0 places the third input, unchanged). Unknown if the places exceed the number of bits.
    Shift {
        /// Shifts towards the most significant bit (`true`), or towards the least significant one.
        left: bool,
        /// Whether copies of the most significant bit come in. Otherwise zeros come in.
        signed: bool,
    },
    /// Counts the bits of the first input that are set. The result has this many words.
    CountBits(u8),
    /// Decoder: sets the bit whose number is in the low bits of the first input, and clears all others. The second
    /// input says how many low bits are used; the result is a list of 2 to this power bits. Unknown if that number is
    /// not 1 to 8.
    Decode,
    /// Encoder: the number of the highest set bit in the first input, a list of bits. Unknown if no bit is set.
    Encode,
    /// Multiplies two numbers with the same number of words. The result has twice as many words.
    Multiply {
        /// Whether the numbers are in two's complement. Otherwise they are unsigned.
        signed: bool,
    },
    /// Quotient (rounded towards zero) and remainder of two numbers with the same number of words, as two results.
    /// Unknown if the divisor is 0 or the quotient does not fit.
    Divide {
        /// Whether the numbers are in two's complement. Otherwise they are unsigned.
        signed: bool,
    },
    /// Sum or difference of two binary numbers with the same number of words, with the third input as carry or borrow
    /// (0 if missing). Results: the number; the carry or borrow.
    Sum {
        /// Whether the second number is subtracted from the first. Otherwise they are added.
        subtract: bool,
    },
    /// Only the carry or borrow of [`Operation::Sum`].
    Carry {
        /// Whether the second number is subtracted from the first. Otherwise they are added.
        subtract: bool,
    },
    /// [`Operation::Sum`] for BCD numbers. A negative difference is given as its complement to a power of ten. Unknown
    /// if a digit is above 9.
    DecimalSum {
        /// Whether the second number is subtracted from the first. Otherwise they are added.
        subtract: bool,
    },
    /// Multiplies two BCD numbers with the same number of words. The result has twice as many words. Unknown if a digit
    /// is above 9.
    DecimalMultiply,
    /// Quotient and remainder of two BCD numbers in one result, the remainder after the quotient. Unknown if the
    /// divisor is 0 or a digit is above 9.
    DecimalDivide,
    /// [`Operation::Divide`] with both numbers in one result, the remainder after the quotient.
    DivideJoined {
        /// Whether the numbers are in two's complement. Otherwise they are unsigned.
        signed: bool,
    },
    /// The results of an operation, followed by two flags about the low words of the first result: whether all are 0,
    /// and the most significant bit.
    WithFlags {
        /// The operation whose result the flags describe.
        operation: Box<Operation>,
        /// The number of low words of the result that the flags describe.
        words: u8,
    },
    /// Applies a function to each word of the first input separately.
    EachWord(Unary),
    /// Limits the third input to the range from the first input to the second, signed. Unknown if the first is larger
    /// than the second.
    Limit,
    /// Dead band: by how much the third input is outside the range from the first input to the second, signed. Unknown
    /// if the first is larger than the second, or if the result does not fit.
    Band,
    /// Zone control: adds the first input to the third if the third is negative, and the second input if it is
    /// positive, signed. Unknown if the first input is larger than the second, or if the sum does not fit.
    Zone,
    /// The first input as a signed number in this many words. Unknown if the number does not fit.
    Resize(u8),
    /// The words of the first input, repeated as often as the first word of the second input says. Unknown if that is
    /// not 1 to 32767.
    Repeat,
    /// The sum of the signed numbers in the first input, each of this many words. The result has twice as many words.
    Total(u8),
    /// The mean of the signed numbers in the first input, each of this many words, in as many words. Unknown if it is
    /// not an integer, or if there are no numbers.
    Mean(u8),
    /// The maximum or minimum of the signed numbers in the first input. One result: the value, the position (from 1) of
    /// its first occurrence, the number of occurrences. Unknown if there are no numbers.
    Extreme {
        /// The number of words of each number in the list.
        words: u8,
        /// Whether the maximum of the list is found. Otherwise the minimum.
        greatest: bool,
    },
    /// Searches the second input, a list, for the number in the first input. One result of two words: the position
    /// (from 1) of the first occurrence, or 0; the number of occurrences.
    Find {
        /// Whether the PLC may search by bisection. If so, position and number are always unknown, because they depend
        /// on the steps of the search if the value occurs several times.
        halving: bool,
    },
    /// Compares each number in the first input with the number at the same position in the second one. Results: for
    /// each pair a bit, which is on if the relation holds; a bit that is on if it holds for all pairs.
    CompareEach {
        /// The relation of the first number to the second.
        relation: Relation,
        /// Whether the numbers are in two's complement. Otherwise they are unsigned.
        signed: bool,
        /// The number of words of each number.
        words: u8,
    },
    /// Splits the words of the first input into groups of this many bits (4 or 8), lowest group first, and gives each
    /// as a word. The first word of the second input is the number of groups. Unknown if the input has fewer groups.
    Split(u8),
    /// Joins the lowest bits, this many (4 or 8), of each word of the first input to words, the first word's lowest;
    /// the remaining bits are 0.
    Combine(u8),
    /// The bit of the first input whose number is the first word of the second input, modulo the number of bits, as a
    /// word of 0 or 1.
    PickBit,
    /// The first input, with the bit whose number is the first word of the second input set (`true`) or cleared.
    PutBit(bool),
    /// The signed number in one word as a text of six characters in three words: a space or minus sign, then five
    /// digits with spaces in place of leading zeros. A fourth word is 0.
    ToDecimalText,
    /// Converts a signed number to IEEE 754 single precision. Unknown if it must be rounded.
    ToReal,
    /// Converts an IEEE 754 single to a signed number of this many words. Unknown if it is not an integer or does not
    /// fit.
    FromReal(u8),
    /// Computes with two IEEE 754 singles. Unknown if an operand or the result is neither normal nor +0, or if the
    /// result must be rounded.
    Real(Arithmetic),
    /// Converts hours, minutes and seconds to seconds in two words. Unknown if there is no such time of day.
    ToSeconds,
    /// Converts seconds to hours, minutes and seconds. Unknown if they are not within one day (0 to 86,399).
    FromSeconds,
    /// The date and time that three numbers choose: the day from 1 January 1980 on, the minute of the day and the
    /// second, each modulo the number of possible ones, so that every choice is a date up to 31 December 2079. One
    /// result: year, month, day, hour, minute, second, day of the week (0 is Sunday).
    Date,
    /// The present value of a running timer. Inputs: whether it has timed out, its previous value, its set value, an
    /// external number. The result is the external number, limited to the range from the previous value to just below
    /// the set value. Unknown if the timer has timed out, for set values below 1, and for previous values that are
    /// negative or not below the set value.
    Elapsed,
    /// The present value of a counter whose count input is on. Inputs: whether the count input was on before, whether
    /// the count was reached, its previous value, its set value. The result is the previous value, and one more if the
    /// input was off before and the count was not reached. Unknown for set values below 1, for previous values that are
    /// negative or above the set value, and if the previous value and the second input do not agree on whether the
    /// count was reached.
    Counted,
}

/// An arithmetic operation on two real numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arithmetic {
    /// The sum of the two numbers.
    Add,
    /// The first number minus the second.
    Sub,
    /// The product of the two numbers.
    Multiply,
    /// The first number divided by the second.
    Divide,
}

/// A function of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unary {
    /// Binary to BCD, four digits a word. Unknown for negative numbers and numbers above 9999 or 99999999.
    ToBcd,
    /// BCD to binary. Unknown if a digit is above 9.
    FromBcd,
    /// Swaps the two bytes of each word.
    SwapBytes,
    /// Reverses the order of all bits of the number.
    Reverse,
    /// The negative in two's complement, with wraparound.
    Negate,
    /// Binary to Gray code. Unknown for negative numbers.
    ToGray,
    /// Gray code to binary. Unknown for negative numbers.
    FromGray,
}

impl ChoiceKind {
    /// Calls `see` with every word that the operation of [`ChoiceKind::Exact`] reads as a word, or from which it
    /// computes an address or a length, and with the word of a number of iterations. Bits, the cells at computed
    /// addresses, and words of the format [`IntegerFormat::Address`] are omitted. Other kinds have no words.
    pub fn each_word(&self, see: &mut dyn FnMut(WordSource)) {
        let meaning = match self {
            ChoiceKind::External
            | ChoiceKind::StableExternal(_)
            | ChoiceKind::Reading(_)
            | ChoiceKind::ExtraTime
            | ChoiceKind::Parameter
            | ChoiceKind::PresentValue { .. }
            | ChoiceKind::AddressOf { .. }
            | ChoiceKind::Unreachable(_)
            | ChoiceKind::ScanTicks { .. } => return,
            ChoiceKind::Iterations(word) | ChoiceKind::UnsignedIterations(word) => {
                return see(*word);
            }
            ChoiceKind::Exact(meaning) => meaning,
        };
        let mut words = |words: &[WordSource]| words.iter().for_each(|&word| see(word));
        for input in &meaning.inputs {
            match input {
                OperationInput::Words(sources) => words(sources),
                OperationInput::Bits(_) => {}
                OperationInput::Number(number) => source::number(number, &mut |source| {
                    if let Source::Word(word) = source {
                        words(&[word]);
                    }
                }),
                OperationInput::Truth(logic) => source::logic(logic, &mut |source| {
                    if let Source::Word(word) = source {
                        words(&[word]);
                    }
                }),
                OperationInput::Run(address, _, count) => {
                    address.indices().for_each(|term| words(&term.words));
                    if let Count::Of { term, .. } = count {
                        words(&term.words);
                    }
                }
            }
        }
        for output in &meaning.outputs {
            if let Target::Run(address, _) = output {
                address.indices().for_each(|term| words(&term.words));
            }
        }
    }
}

impl Meaning {
    /// Calls `see` with all cells that the operation may read, including those at computed addresses.
    pub fn each_read(&self, see: &mut dyn FnMut(Region)) {
        let mut source = |source: Source| source.region().into_iter().for_each(&mut *see);
        for input in &self.inputs {
            match input {
                OperationInput::Words(words) => {
                    words.iter().for_each(|&one| source(Source::Word(one)))
                }
                OperationInput::Bits(bits) => bits.iter().for_each(|&one| source(Source::Bit(one))),
                OperationInput::Number(number) => source::number(number, &mut source),
                OperationInput::Truth(logic) => source::logic(logic, &mut source),
                OperationInput::Run(..) => {}
            }
        }
        let addresses = self.inputs.iter().filter_map(|input| match input {
            OperationInput::Run(address, ..) => Some(address),
            _ => None,
        });
        for address in addresses {
            let stretch =
                |one: &AddressRange| Region::Range { first: one.first, count: one.chosen };
            address.ranges.iter().map(stretch).for_each(&mut *see);
        }
        let words = ChoiceKind::Exact(Box::new(self.clone()));
        words.each_word(&mut |word| Source::Word(word).region().into_iter().for_each(&mut *see));
    }

    /// The meaning of a choice that is read and has the value of this operand's first word.
    #[must_use]
    pub fn of(input: OperationInput) -> Meaning {
        Meaning { operation: Operation::Copy, inputs: vec![input], outputs: Vec::new() }
    }
}

impl Address {
    /// The terms that are not addresses themselves.
    pub fn indices(&self) -> impl Iterator<Item = &Term> {
        self.terms.iter().filter(|term| term.format != IntegerFormat::Address)
    }

    /// An address in `count` consecutive cells. The cell `first` has number 0; the address is the number `base` plus
    /// the sum of the terms.
    #[must_use]
    pub fn within(first: Cell, count: u32, base: i64, terms: Vec<Term>) -> Address {
        Address { base, terms, ranges: vec![AddressRange { from: 0, count, chosen: count, first }] }
    }
}

impl Term {
    /// A term whose value is this word as a signed number, with the factor 1.
    #[must_use]
    pub fn signed(word: WordSource) -> Term {
        Term { words: vec![word], format: IntegerFormat::Signed, factor: 1 }
    }

    /// A term whose value is this word as an unsigned number, with the factor 1.
    #[must_use]
    pub fn unsigned(word: WordSource) -> Term {
        Term { words: vec![word], format: IntegerFormat::Unsigned, factor: 1 }
    }
}

/// A value that an operation read while its result was computed.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Read {
    /// A cell, the mask of the bits that were read, and the value of these bits.
    Cell(Cell, u16, u16),
    /// A choice that was read, and its value.
    Choice(ChoiceKey, u16),
    /// The execution condition of the instruction, and its value.
    Condition(bool),
}

/// The observed result of a choice of the kind [`ChoiceKind::Exact`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// The value of a choice that is read.
    Value(u16),
    /// What was written: for each cell a mask of bits and the value of these bits. Nothing else was written.
    Writes(Vec<(Cell, u16, u16)>),
}

/// One observation of a choice in a call context: if all reads have these values, this is the result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Observation {
    /// The values that the operation read.
    pub reads: Vec<Read>,
    /// The result of the operation for these values.
    pub outcome: Outcome,
    /// Whether the operation accessed a cell that not each PLC has ([`AddressRange::count`]). The upper bound must not
    /// rest on such an observation.
    pub needs_devices: bool,
}

/// What real runs showed about choices of the kind [`ChoiceKind::Exact`], by call context and choice.
pub type Knowledge = BTreeMap<(Vec<Frame>, ChoiceId), Vec<Observation>>;

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
