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
    /// The index of the cell in the area, from 0.
    pub index: u32,
}

impl Cell {
    /// The cell `n` cells later in the same area.
    #[must_use]
    pub fn plus(self, n: u32) -> Cell {
        Cell { area: self.area, index: self.index + n }
    }
}

/// The identifier of a nondeterministic value (a *choice*) in the program. In each call context it has one value; see
/// the crate documentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChoiceId(pub u32);

/// Where an instruction reads one bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BitSource {
    /// A constant bit, which is not read from memory.
    Const(bool),
    /// The value of a bit cell.
    Cell(Cell),
    /// Bit 0 (least significant) to 15 of a word cell.
    WordBit(Cell, u8),
    /// A nondeterministic value: bit 0 of the choice.
    Free(ChoiceId),
}

/// Where an instruction reads sixteen bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WordSource {
    /// A constant word, which is not read from memory.
    Const(u16),
    /// The value of a word cell.
    Cell(Cell),
    /// `count` (1 to 16) bit cells from `first` on, `first` being the least significant bit; the upper bits are 0.
    Bits {
        /// The least significant bit.
        first: Cell,
        /// The number of bits.
        count: u8,
    },
    /// A nondeterministic value: all sixteen bits of the choice.
    Free(ChoiceId),
}

/// Where an instruction writes one bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BitTarget {
    /// The bit is written to a bit cell.
    Cell(Cell),
    /// The bit is written to this bit (0 to 15) of a word cell; the other bits keep their values.
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

/// Where an instruction writes sixteen bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WordTarget {
    /// The word is written to a word cell.
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
    /// The number in these words, low word first.
    Words(Vec<WordSource>),
    /// The sum of two numbers.
    Add(Box<Number>, Box<Number>),
    /// The difference of two numbers, left minus right.
    Sub(Box<Number>, Box<Number>),
    /// The bitwise AND of two numbers.
    And(Box<Number>, Box<Number>),
    /// The bitwise OR of two numbers.
    Or(Box<Number>, Box<Number>),
    /// The bitwise exclusive OR of two numbers.
    Xor(Box<Number>, Box<Number>),
}

impl Number {
    /// All words that occur in the expression, from left to right.
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

/// A comparison operator, between a left and a right number.
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

impl Relation {
    /// Whether the relation holds.
    #[must_use]
    pub fn holds<T: PartialOrd>(self, a: T, b: T) -> bool {
        match self {
            Relation::Equal => a == b,
            Relation::NotEqual => a != b,
            Relation::Less => a < b,
            Relation::LessOrEqual => a <= b,
            Relation::Greater => a > b,
            Relation::GreaterOrEqual => a >= b,
        }
    }

    /// The relation that holds where this one does not.
    #[must_use]
    pub fn negated(self) -> Relation {
        match self {
            Relation::Equal => Relation::NotEqual,
            Relation::NotEqual => Relation::Equal,
            Relation::Less => Relation::GreaterOrEqual,
            Relation::LessOrEqual => Relation::Greater,
            Relation::Greater => Relation::LessOrEqual,
            Relation::GreaterOrEqual => Relation::Less,
        }
    }

    /// The relation of `b` to `a` that says the same as this one says of `a` to `b`.
    #[must_use]
    pub fn mirrored(self) -> Relation {
        match self {
            Relation::Equal | Relation::NotEqual => self,
            Relation::Less => Relation::Greater,
            Relation::LessOrEqual => Relation::GreaterOrEqual,
            Relation::Greater => Relation::Less,
            Relation::GreaterOrEqual => Relation::LessOrEqual,
        }
    }
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
    /// The operator between the left and the right side.
    pub relation: Relation,
    /// How the words of both sides are interpreted.
    pub format: NumberFormat,
    /// The left side of the comparison.
    pub left: Number,
    /// The right side of the comparison.
    pub right: Number,
}

/// A Boolean expression over cells, choices and the execution condition of an instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Logic {
    /// The execution condition of the instruction: the top of the stack of results (true if the stack is empty). For a
    /// step that [depends on master control](crate::Step::depends_on_master_control), it is combined by AND with the
    /// conditions of all open master control regions.
    Condition,
    /// A constant truth value.
    Const(bool),
    /// True if the bit is on.
    Bit(BitSource),
    /// True if the operand is false.
    Not(Box<Logic>),
    /// True if all operands are true (true if there are none).
    All(Vec<Logic>),
    /// True if at least one operand is true (false if there are none).
    Any(Vec<Logic>),
    /// True if the comparison holds.
    Compare(Box<Compare>),
}

impl Logic {
    /// The negation of the expression.
    #[must_use]
    #[allow(clippy::should_implement_trait)]
    pub fn not(self) -> Logic {
        Logic::Not(Box::new(self))
    }

    /// The expression that is true while this bit cell is on.
    #[must_use]
    pub fn cell(cell: Cell) -> Logic {
        Logic::Bit(BitSource::Cell(cell))
    }

    /// The expression that is true if `left` has this relation to `right`.
    #[must_use]
    pub fn compare(relation: Relation, format: NumberFormat, left: Number, right: Number) -> Logic {
        Logic::Compare(Box::new(Compare { relation, format, left, right }))
    }
}

/// A set of cells: what a write with an unknown target or value may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Region {
    /// `count` cells from `first` on.
    Range {
        /// The first cell of the range.
        first: Cell,
        /// The number of cells of the range.
        count: u32,
    },
    /// Every cell of an area.
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

    /// The cells that this region shares with each of `stretches`, which must lie in the same area; empty intersections
    /// are omitted. If this region is not a `Range`, returns all of `stretches`.
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
    /// The choice that is read, or that gives the values of the havocked cells.
    pub choice: ChoiceId,
    /// The cell whose value it is, if `Write::Havoc` or `Step::Summary` havocked a region. `None` if an expression
    /// reads the choice.
    pub cell: Option<Cell>,
}
