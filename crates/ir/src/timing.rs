//! What the time of an instruction depends on: its name, its number of units, and the devices of its operands.

use super::{Frame, Region, WordSource};

/// The number of units (words, digits, characters ...) that this instruction processes, by which a time per unit in the
/// timing table is multiplied.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Units {
    /// The instruction's time does not depend on a number of units.
    None,
    /// A constant number of units.
    Exactly(u64),
    /// An unknown number of units, which is at most this.
    AtMost(u64),
    /// The number of units is read from words when the instruction is reached.
    Counted(Counted),
}

/// A number of units that is read from words, in the state before the instruction. From iteration
/// [`Counted::ITERATIONS`] of a loop on (counted from 0) the largest number is used instead, because the model would
/// otherwise need the bits of the count in every iteration.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Counted {
    /// The words that hold the number, which is unsigned, low word first.
    pub words: Vec<WordSource>,
    /// The number of units that the instruction has for each 1 of that number.
    pub each: u64,
    /// The largest number that counts: if the words hold a larger one, the instruction processes as if they held this.
    pub most: u64,
    /// The largest count with which the PLC certainly executes the instruction. With a larger one, the instruction may
    /// access cells outside the memory, which is an error. No scan with such a count is used as a lower bound.
    pub executes_up_to: u64,
}

impl Counted {
    /// Within loops, the number of units is read only in the first iterations of each loop, of which there are this
    /// many.
    pub const ITERATIONS: u32 = 16;

    /// Whether the number of units is read in this call context: no iteration in it has a number of
    /// [`Counted::ITERATIONS`] or more. Otherwise the largest number is charged.
    #[must_use]
    pub fn is_read(frames: &[Frame]) -> bool {
        frames.iter().all(|frame| frame.iteration < Counted::ITERATIONS)
    }

    /// The largest number of units of the instruction.
    #[must_use]
    pub fn most_units(&self) -> u64 {
        self.most.saturating_mul(self.each)
    }
}

/// How the time of an instruction is found in a timing table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimingKey {
    /// Names of table rows to try, most specific first (`OUT:T`, `OUT`).
    pub names: Vec<String>,
    /// The `@class` row to use if no name matches, without the `@`.
    pub class: &'static str,
    /// The number of units, for times per unit.
    pub units: Units,
    /// Whether on-time and off-time are both the larger of the row's two times. This is so for contacts, for which
    /// tables define the condition differently.
    pub use_larger_time: bool,
    /// Whether the instruction takes no time if the table has no row for it, as labels do.
    pub optional: bool,
    /// The devices of its operands, for times that depend on the memory area.
    pub accessed: AccessedDevices,
}

impl TimingKey {
    /// The words from which the number of units is read. `None` if `units` is not [`Units::Counted`]: there are no
    /// units, a constant number, or an unknown number up to a limit.
    #[must_use]
    pub fn counted(&self) -> Option<&Counted> {
        match &self.units {
            Units::Counted(counted) => Some(counted),
            Units::None | Units::Exactly(_) | Units::AtMost(_) => None,
        }
    }
}

/// The cells and bits of words that an instruction's operands name, even if its effects do not show them: an
/// over-approximated instruction accesses the same devices. Empty if the dialect leaves it to the effects.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AccessedDevices {
    /// The cells that the operands name: one region for each operand.
    pub regions: Vec<Region>,
    /// The number of operands that are bits of words.
    pub word_bits: u64,
}
