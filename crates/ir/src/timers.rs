//! How timers and counters behave in real time. The analysis uses effects and choices instead; runs of successive scans
//! and the emulated CPU use this description.

use super::{AreaId, Cell, ChoiceId, Logic, WordSource};
use scanbound_base::time::Picos;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The type of a timer or counter. The duration in a type of timer is the unit of the timer's set value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimerKind {
    /// A timer that counts down from its set value and times out at 0. While its condition is off, its present value is
    /// the set value.
    DownTimer(Picos),
    /// A timer that counts up from 0 and times out at its set value. While its condition is off, its present value is 0
    /// (`false`) or keeps its value (`true`).
    UpTimer(Picos, bool),
    /// A retentive timer that counts up, with a separate reset input.
    RetentiveTimer(Picos),
    /// A counter that counts down from its set value and stops at 0. Inputs: count, reset.
    DownCounter,
    /// A ring counter between 0 and its set value. Its flag comes on when it overflows. Inputs: up, down, reset.
    RingCounter,
}

impl TimerKind {
    /// Whether the present value changes with time, and not with a count input.
    #[must_use]
    pub fn is_timer(&self) -> bool {
        match self {
            TimerKind::DownTimer(_) | TimerKind::UpTimer(..) | TimerKind::RetentiveTimer(_) => true,
            TimerKind::DownCounter | TimerKind::RingCounter => false,
        }
    }
}

/// What the instruction of one timer or counter does in real time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimerOrCounter {
    /// The type of the timer or counter.
    pub kind: TimerKind,
    /// The completion flag: the bit that is on when the timer has timed out or the count is reached.
    pub flag: Cell,
    /// The word that holds the present value.
    pub present: Cell,
    /// The set value (preset): a count, or a time in the unit that `kind` gives.
    pub setting: WordSource,
    /// Whether set value and present value are in BCD.
    pub is_decimal: bool,
    /// The slots in which the values of the inputs were saved. A timer without inputs uses the instruction's condition.
    pub inputs: Vec<u32>,
    /// For each counting input of a counter, the bit in which the instruction remembers it. `None` if this is not
    /// followed, as in an interlock: then a run does not know whether the input rises.
    pub seen: Vec<Option<Cell>>,
    /// The bit that says whether the timer runs, if an instruction that resets a running timer makes it unknown.
    /// Manuals leave open whether the timer then goes on from 0 or starts anew when it is executed next.
    pub running: Option<Cell>,
    /// The other parts of the instruction, which an emulated CPU skips because it executes this description.
    pub parts: Range<usize>,
}

/// The choice "has this running timer timed out?", and what decides it in a real run: a timer cannot time out in the
/// scan that starts it, nor before its time has passed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Expiry {
    /// The cell that says whether the timer is running.
    pub memory: Cell,
    /// The value of the cell `memory` while the timer is not running.
    pub idle: u16,
    /// The value of the choice while the timer runs and has not timed out.
    pub while_running: bool,
    /// The set value, low word first.
    pub setting: Vec<WordSource>,
    /// Whether the set value is in BCD.
    pub is_decimal: bool,
    /// The time of one unit of the set value: a timer of 100 ms has the unit 100 ms.
    pub unit: Picos,
    /// By how many units the timer may time out early or late, because its clock ticks only once in so many units.
    pub tick: u64,
    /// The cell with the previous present value, for timers whose behaviour is undefined for set values below 1 or
    /// values at the set value. `None` for other timers.
    pub previous: Option<Cell>,
    /// The completion flag, if it stays on as long as the timer runs.
    pub flag: Option<Cell>,
    /// Whether an instruction may reset the timer while it runs. Manuals leave open whether it then goes on from 0 or
    /// starts anew when it is executed next.
    pub is_reset: bool,
    /// Whether PLCs differ in how often they look at the clock in a scan. Then it is unknown whether a timer is over in
    /// the scan in which it starts, once its set value has passed in that scan.
    pub is_asked_again: bool,
}

/// The unit of times in IEC 61131-3 programs: half a millisecond.
pub const TIME_UNIT: Picos = Picos(500_000_000);

impl Expiry {
    /// Whether [`Timekeeping::are_kept`] concerns the timer: its flag stays on while it runs on, or its previous
    /// present value is known (`flag` or `previous` is set).
    #[must_use]
    pub fn can_be_kept(&self) -> bool {
        self.flag.is_some() || self.previous.is_some()
    }

    /// A timer that times out after running for its set value, and whose `memory` is 0 while it is not running.
    #[must_use]
    pub fn of_on_delay(memory: Cell, setting: WordSource, unit: Picos) -> Expiry {
        let setting = vec![setting];
        Expiry {
            memory,
            idle: 0,
            while_running: false,
            setting,
            is_decimal: false,
            unit,
            tick: 1,
            previous: None,
            flag: None,
            is_reset: false,
            is_asked_again: false,
        }
    }
}

/// What is known about the timers and counters of a program.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Timekeeping {
    /// Timers and counters by their instruction, an index into `Program::instructions`.
    pub instructions: BTreeMap<usize, TimerOrCounter>,
    /// Choices for timers that time out between two instructions. In a run that simulates time, no timer times out
    /// there: the choice has the value that the cell given here holds at that moment, or 0 if none is given.
    pub between_instructions: BTreeMap<ChoiceId, Option<Cell>>,
    /// Choices that say whether a timer has timed out.
    pub expiries: BTreeMap<ChoiceId, Expiry>,
    /// Choices that depend on earlier scans, such as on elapsed time, in a way that runs of several scans do not
    /// follow. In such runs their value is unknown.
    pub untracked: BTreeSet<ChoiceId>,
    /// Choices for a bit that is on once a time is over: the bit that is on while the time runs, and the time in units
    /// of [`TIME_UNIT`].
    pub ends: BTreeMap<ChoiceId, (Cell, u32)>,
    /// Choices for a time of two words that goes on from scan to scan, in units of [`TIME_UNIT`]: the first cell that
    /// the choice havocs, and the first cell of the time so far.
    pub continued: BTreeMap<ChoiceId, [Cell; 2]>,
    /// The areas whose values do not persist from scan to scan.
    pub scratch: BTreeSet<AreaId>,
    /// For choices of [`super::ChoiceKind::ScanTicks`]: the largest number of units that one scan can take. The upper
    /// bound counts this many; a real run counts none, or this many for a timer that may go on after a reset.
    pub most_ticks: BTreeMap<ChoiceId, u16>,
    /// Whether a real run of a single scan must not let a timer run out whose flag stays on ([`Expiry::can_be_kept`]),
    /// because it is unknown how long the timer ran before. If it does, the result is unknown.
    pub are_kept: bool,
    /// Choices that are 0 as manuals are usually understood, and not 0 only in an unusual reading.
    pub unusual: BTreeSet<ChoiceId>,
    /// Choices between two ways in which a manual can be understood. A lower bound must hold in both.
    pub readings: BTreeSet<ChoiceId>,
    /// By the memory of a timer that one instruction starts: the least time from that instruction to the end of a scan
    /// and its overhead. A timer that ran when the scan began has been running for longer.
    pub least_gaps: BTreeMap<Cell, Picos>,
    /// By the cell of a present value: a condition on this value and its flag that is true after each execution of the
    /// instruction. Other instructions may write either, but no lower bound rests on such a scan. `None` if several
    /// instructions have different conditions.
    pub consistency: BTreeMap<Cell, Option<Logic>>,
    /// Choices that say how far a timer has run, each with the choice that says whether the timer has timed out.
    pub elapsed: BTreeMap<ChoiceId, ChoiceId>,
}

impl Timekeeping {
    /// Records a condition on a present value and its flag that is true after the instruction.
    pub fn note_consistency(&mut self, present: Cell, holds: Logic) {
        let known = self.consistency.entry(present).or_insert_with(|| Some(holds.clone()));
        if known.as_ref().is_some_and(|known| *known != holds) {
            *known = None;
        }
    }
}
