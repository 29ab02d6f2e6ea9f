//! What instructions read and write: cells, choices, numbers, truth values, regions.

use std::collections::BTreeSet;

/// A memory area, an index into `Program::areas`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AreaId(pub u16);

/// A memory cell: a bit or a 16-bit word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// The area that contains the cell.
    pub area: AreaId,
    /// The index in the area.
    pub index: u32,
}

impl Cell {
    /// The cell `n` cells later in the same area.
    #[must_use]
    pub fn plus(self, n: u32) -> Cell {
        Cell { area: self.area, index: self.index + n }
    }
}

/// The identifier of a nondeterministic value: a place in the program whose value is unknown. See the crate
/// documentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChoiceId(pub u32);

/// A source of one bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BitSource {
    /// A constant.
    Const(bool),
    /// The value of a bit cell.
    Cell(Cell),
    /// Bit 0 (least significant) to 15 of a word cell.
    WordBit(Cell, u8),
    /// A nondeterministic value: bit 0 of the choice.
    Free(ChoiceId),
}

/// A source of sixteen bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WordSource {
    /// A constant.
    Const(u16),
    /// A word cell.
    Cell(Cell),
    /// `count` (1 to 16) bit cells from `first` on, `first` being the least significant bit; the upper bits are 0.
    Bits {
        /// The least significant bit.
        first: Cell,
        /// The number of bits.
        count: u8,
    },
    /// A nondeterministic value.
    Free(ChoiceId),
}

/// The destination of one bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BitTarget {
    /// The value of a bit cell.
    Cell(Cell),
    /// A bit of a word cell; the other bits keep their values.
    WordBit(Cell, u8),
}

impl BitTarget {
    /// The cell that contains the bit.
    #[must_use]
    pub fn cell(self) -> Cell {
        match self {
            BitTarget::Cell(cell) | BitTarget::WordBit(cell, _) => cell,
        }
    }

    /// The source that reads this bit.
    #[must_use]
    pub fn source(self) -> BitSource {
        match self {
            BitTarget::Cell(cell) => BitSource::Cell(cell),
            BitTarget::WordBit(cell, bit) => BitSource::WordBit(cell, bit),
        }
    }
}

/// The destination of sixteen bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WordTarget {
    /// A word cell.
    Cell(Cell),
    /// The low `count` (1 to 16) bits go to the bit cells from `first` on; the upper bits are lost.
    Bits {
        /// The destination of the least significant bit.
        first: Cell,
        /// The number of bits.
        count: u8,
    },
    /// The value is not stored.
    Discard,
}

/// An expression for a number of one or more words, low word first. Both operands of an operation have the same number
/// of words. Results wrap around.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Number {
    /// A number that consists of these words.
    Words(Vec<WordSource>),
    /// Sum.
    Add(Box<Number>, Box<Number>),
    /// Difference, left minus right.
    Sub(Box<Number>, Box<Number>),
    /// Bitwise and.
    And(Box<Number>, Box<Number>),
    /// Bitwise or.
    Or(Box<Number>, Box<Number>),
    /// Bitwise exclusive or.
    Xor(Box<Number>, Box<Number>),
}

impl Number {
    /// Its words, those of left operands first.
    pub fn words(&self) -> impl Iterator<Item = WordSource> {
        let mut open = vec![self];
        let next = move || loop {
            match open.pop()? {
                Number::Words(words) => return Some(words),
                Number::Add(a, b)
                | Number::Sub(a, b)
                | Number::And(a, b)
                | Number::Or(a, b)
                | Number::Xor(a, b) => open.extend([&**b, &**a]),
            }
        };
        std::iter::from_fn(next).flatten().copied()
    }
}

/// How two numbers compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Relation {
    /// `=`
    Equal,
    /// `<>`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
}

/// How the words of a comparison are interpreted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NumberFormat {
    /// One signed number (two's complement).
    Signed,
    /// One unsigned number.
    Unsigned,
    /// IEEE 754 single precision (two words). If either side is neither a normal number nor +0 (that is: -0, denormal,
    /// infinite, or not a number), the result of the comparison is bit 0 of the choice.
    Real(ChoiceId),
}

/// A comparison of two numbers with the same number of words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Compare {
    /// The comparison operator of the contact.
    pub relation: Relation,
    /// How the words are interpreted.
    pub format: NumberFormat,
    /// The left side of the comparison.
    pub left: Number,
    /// The right side of the comparison.
    pub right: Number,
}

/// A Boolean expression over the state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Logic {
    /// The condition of this instruction.
    Condition,
    /// A constant.
    Const(bool),
    /// The value of a bit.
    Bit(BitSource),
    /// Negation.
    Not(Box<Logic>),
    /// True if all operands are true (true if there are none).
    All(Vec<Logic>),
    /// True if at least one operand is true (false if there are none).
    Any(Vec<Logic>),
    /// A comparison.
    Compare(Box<Compare>),
}

impl Logic {
    /// The negation of the expression.
    #[must_use]
    #[allow(clippy::should_implement_trait)]
    pub fn not(self) -> Logic {
        Logic::Not(Box::new(self))
    }

    /// The value of a bit cell.
    #[must_use]
    pub fn cell(cell: Cell) -> Logic {
        Logic::Bit(BitSource::Cell(cell))
    }

    /// How one number compares to another.
    #[must_use]
    pub fn compare(relation: Relation, format: NumberFormat, left: Number, right: Number) -> Logic {
        Logic::Compare(Box::new(Compare { relation, format, left, right }))
    }
}

/// A set of cells, for writes whose target or value is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Region {
    /// `count` cells from `first` on.
    Range {
        /// The first cell.
        first: Cell,
        /// The number of cells.
        count: u32,
    },
    /// A whole area.
    Area(AreaId),
    /// Every cell of every area.
    Everything,
}

impl Region {
    /// Whether the region contains the cell.
    #[must_use]
    pub fn contains(self, cell: Cell) -> bool {
        match self {
            Region::Range { first, count } => {
                cell.area == first.area
                    && cell.index >= first.index
                    && cell.index - first.index < count
            }
            Region::Area(area) => cell.area == area,
            Region::Everything => true,
        }
    }

    /// The intersections of this region with each of `stretches`, which lie in the same area.
    #[must_use]
    pub fn intersections(self, stretches: &[Region]) -> Vec<Region> {
        let Region::Range { first: own, count: most } = self else { return stretches.to_vec() };
        let part = |stretch: &Region| {
            let Region::Range { first, count } = *stretch else { return Some(self) };
            let end = |first: Cell, count: u32| u64::from(first.index) + u64::from(count);
            let end = end(own, most).min(end(first, count));
            let first = first.max(own);
            let count = u32::try_from(end.checked_sub(first.index.into())?).ok()?;
            (count > 0).then_some(Region::Range { first, count })
        };
        stretches.iter().filter_map(part).collect()
    }
}

/// One iteration of a loop, one call, or one run of an interrupt routine, on the path to an instruction. A list of
/// frames is a call context.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Frame {
    /// The index of the `Call` or `ForBegin`, or of the first instruction of the interrupt routine.
    pub at: usize,
    /// The iteration of the loop or the run of the interrupt routine, from 0; 0 for a call.
    pub iteration: u32,
}

impl Frame {
    /// Whether code with these frames runs in an interrupt routine. `entries` are the first instructions of these
    /// routines.
    #[must_use]
    pub fn in_interrupt(frames: &[Frame], entries: &BTreeSet<usize>) -> bool {
        frames.first().is_some_and(|frame| entries.contains(&frame.at))
    }
}

/// Identifies one nondeterministic value: the choice, the call context, and the cell of a havocked region.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChoiceKey {
    /// The call context, outermost frame first; empty in the main routine outside loops.
    pub frames: Vec<Frame>,
    /// The choice that is read.
    pub choice: ChoiceId,
    /// The cell, for regions havocked by `Write::Havoc` or `Step::Summary`.
    pub cell: Option<Cell>,
}
