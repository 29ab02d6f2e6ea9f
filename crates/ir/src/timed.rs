//! How timers and counters go by the clock. The analysis goes by effects and choices; runs that scans make one after another
//! go by this, and so does an emulated CPU.

use super::{AreaId, Cell, ChoiceId, WordSource};
use scanbound_base::time::Picos;
use std::collections::{BTreeMap, BTreeSet};
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

impl Manner {
    /// Whether time makes it go, and not an input that counts.
    #[must_use]
    pub fn is_timer(&self) -> bool {
        match self {
            Manner::TimesDown(_) | Manner::TimesUp(..) | Manner::AddsUp(_) => true,
            Manner::CountsDown | Manner::CountsBothWays => false,
        }
    }
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

/// A choice that tells whether a running timer is over, and what decides it in a real run: a timer cannot be over in the
/// scan that starts it, nor before its time has passed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Expiry {
    /// The cell that tells whether the timer runs.
    pub memory: Cell,
    /// What that holds while the timer is at rest.
    pub rest: u16,
    /// The choice's value while the time has not passed.
    pub running: bool,
    /// The time that is set, the least word first.
    pub setting: Vec<WordSource>,
    /// Whether that is decimal digits.
    pub is_decimal: bool,
    /// What one unit of the setting takes.
    pub unit: Picos,
    /// Where what it stood at before stands, for timers that settings below 1 and values at the setting leave open.
    pub stood: Option<Cell>,
}

impl Expiry {
    /// Of a timer that is over when it has run for its setting, and whose memory is 0 while it is at rest.
    #[must_use]
    pub fn of_on_delay(memory: Cell, setting: WordSource, unit: Picos) -> Expiry {
        let setting = vec![setting];
        Expiry { memory, rest: 0, running: false, setting, is_decimal: false, unit, stood: None }
    }
}

/// All that is known of the time that timers take.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Timekeeping {
    /// By the instruction, an index into `Program::instructions`.
    pub coils: BTreeMap<usize, Timed>,
    /// Choices that stand for timers which run out between instructions. An emulated CPU's do not: they say 0, or read the
    /// cell of the present value.
    pub between: BTreeMap<ChoiceId, Option<Cell>>,
    /// Choices that tell whether a timer is over.
    pub expiries: BTreeMap<ChoiceId, Expiry>,
    /// Choices that tell how much time has passed in a way that runs from power-up do not count: what they are is not known
    /// there.
    pub uncounted: BTreeSet<ChoiceId>,
    /// Areas of words that hold nothing from one scan to the next.
    pub scratch: BTreeSet<AreaId>,
    /// Choices that tell how far a timer has run, and the choice that tells whether it is over.
    pub elapsed: BTreeMap<ChoiceId, ChoiceId>,
}
