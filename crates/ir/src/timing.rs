//! What an instruction's time hangs on: its name, how many units it handles, and what its operands name.

use super::{Frame, Region, WordSource};

/// How many units (words, digits, characters ...) an instruction handles, for times per unit.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Units {
    /// The instruction has no count.
    None,
    /// A known number.
    Exactly(u64),
    /// Not known: at most so many.
    AtMost(u64),
    /// As many as words say when the instruction is reached.
    Counted(Counted),
}

/// A number of units that stands in words. It is read in the state before the instruction; from iteration
/// [`Counted::ITERATIONS`] of a loop on, counted from 0, the most units are taken instead: a loop would ask for its count's
/// bits in every iteration.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Counted {
    /// The count, an unsigned number, its least word first.
    pub words: Vec<WordSource>,
    /// How many units are handled for each that is counted.
    pub each: u64,
    /// A larger count handles no more than this one.
    pub most: u64,
    /// The PLC is known to carry the instruction out with every count up to this one. With a larger count it may refuse
    /// (what it handles would lie beyond its memory), so a scan that needs one is no lower bound.
    pub executes_up_to: u64,
}

impl Counted {
    /// The number of iterations of a loop in which the words are asked.
    pub const ITERATIONS: u32 = 16;

    /// Whether the words are asked in a call context.
    #[must_use]
    pub fn is_asked(frames: &[Frame]) -> bool {
        frames.iter().all(|frame| frame.iteration < Counted::ITERATIONS)
    }

    /// The most units that it can say.
    #[must_use]
    pub fn most_units(&self) -> u64 {
        self.most.saturating_mul(self.each)
    }
}

/// By what an instruction's time is looked up in a timing table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimingKey {
    /// Row names to try, the most specific first (`OUT:T`, `OUT`).
    pub names: Vec<String>,
    /// The `@class` row to fall back on, without the `@`.
    pub class: &'static str,
    /// The count for times per unit.
    pub units: Units,
    /// Both times are the dearer of the row's two: a contact, whose condition tables define differently.
    pub dearer: bool,
    /// Costs nothing where the table does not know it (labels).
    pub optional: bool,
    /// What its operands name, for times by area.
    pub touched: Touched,
}

impl TimingKey {
    /// The words that say how many units it handles.
    #[must_use]
    pub fn counted(&self) -> Option<&Counted> {
        match &self.units {
            Units::Counted(counted) => Some(counted),
            Units::None | Units::Exactly(_) | Units::AtMost(_) => None,
        }
    }
}

/// Cells and bits of words that an instruction's operands name, whether or not its meaning shows them: what is taken
/// as any value costs no less. Empty where a dialect leaves it to the meaning.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Touched {
    /// The cells, each mention a region.
    pub regions: Vec<Region>,
    /// How many bits of words.
    pub word_bits: u64,
}
