//! Timers and counters as an emulated CPU runs them, by its own clock. The analysis goes by effects and choices instead.

use super::{Cell, ChoiceId, WordSource};
use crate::base::time::Picos;
use std::collections::BTreeMap;
use std::ops::Range;

/// How a timer or counter goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manner {
    /// A timer that starts at its setting and is over at 0; while its condition is off it stands at its setting.
    TimesDown(Picos),
    /// A timer that starts at 0 and is over at its setting. While its condition is off it stands at 0, or stays (`true`).
    TimesUp(Picos, bool),
    /// The same that stays, with an input of its own that resets it.
    AddsUp(Picos),
    /// A counter that starts at its setting and is over at 0: inputs count and reset.
    CountsDown,
    /// A counter that goes round between 0 and its setting, and is on where it last went round: inputs up, down and reset.
    CountsBothWays,
}

/// A timer's or counter's instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Timed {
    /// How it goes.
    pub manner: Manner,
    /// The bit that tells that it is over.
    pub flag: Cell,
    /// The word of its present value.
    pub present: Cell,
    /// Its setting.
    pub setting: WordSource,
    /// Whether setting and present value are decimal digits.
    pub is_decimal: bool,
    /// The slots in which its inputs were saved; a timer without them goes by the instruction's condition.
    pub inputs: Vec<u32>,
    /// Its further parts, instructions that an emulated CPU leaves out.
    pub parts: Range<usize>,
}

/// All that an emulated CPU needs to know of timers and counters.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Timekeeping {
    /// By the instruction, an index into `Program::instructions`.
    pub coils: BTreeMap<usize, Timed>,
    /// Choices that stand for timers which run out between instructions. An emulated CPU's do not: they say 0, or read the
    /// cell of the present value.
    pub between: BTreeMap<ChoiceId, Option<Cell>>,
}
