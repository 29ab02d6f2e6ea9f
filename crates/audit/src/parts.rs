//! The parts of an audit's result.

use super::method;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::Approximated;
use scanbound_timing::table::Evidence;
use std::fmt;
use std::sync::Arc;

/// The bound and its parts: `upper` = `always` + `overhead` + the groups' `upper`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bound {
    /// The upper bound: no scan takes longer.
    pub upper: Picos,
    /// The admissible lower bound: a scan that nothing known here excludes takes this long, executed as on a PLC.
    pub lower: Picos,
    /// The longest scan that the model allows, as far as it was found. It may need values that are not known to be
    /// possible.
    pub model: Picos,
    /// The structural bound: every charge at the larger of its two times, plus the overhead.
    pub naive: Picos,
    /// The charges that have the same time in every scan.
    pub always: Picos,
    /// The time that each scan takes in addition to the instructions.
    pub overhead: Picos,
    /// The sum of the groups' upper bounds.
    pub groups: Picos,
}

impl Bound {
    /// Whether upper and lower bound are equal.
    #[must_use]
    pub fn exact(&self) -> bool {
        self.upper == self.lower
    }

    /// The time that mutual exclusion saves compared with the structural bound.
    #[must_use]
    pub fn saved(&self) -> Picos {
        self.naive.checked_sub(self.upper).unwrap_or(Picos::ZERO)
    }
}

/// A share in thousandths, rounded to the nearest. Shown in percent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Share(pub u64);

impl Share {
    /// The share of `part` in `whole`. 0 if `whole` is 0.
    #[must_use]
    pub fn of(part: Picos, whole: Picos) -> Share {
        let (part, whole) = (u128::from(part.0), u128::from(whole.0));
        let thousandths = (part * 2000 + whole).checked_div(whole * 2).unwrap_or(0);
        Share(u64::try_from(thousandths).unwrap_or(u64::MAX))
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{}.{} %", self.0 / 10, self.0 % 10))
    }
}

/// The timing table, and which of its times are uncertain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableUse {
    /// The name of the table, or its file.
    pub name: String,
    /// The title of the table, one line. May be empty.
    pub title: String,
    /// Whether all times of the table are assumed: none is published, measured or stated.
    pub is_all_assumed: bool,
    /// What the table's times do not include.
    pub notes: Vec<String>,
    /// The CPU's default watchdog time.
    pub watchdog: Option<Picos>,
    /// The factor on the whole scan.
    pub factor: Option<FactorUse>,
    /// The assumed times that the program uses. Those on which most of the bound rests come first.
    pub assumed: Vec<AssumedUse>,
    /// The assumed part of the time of the longest scan found, including overhead.
    pub assumed_time: Picos,
    /// The assumed part of the longest scan found, as a share of that scan.
    pub assumed_share: Share,
}

/// A factor on the whole scan, and the bound without it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FactorUse {
    /// The factor as it is written in the table.
    pub text: String,
    /// The evidence for the factor.
    pub evidence: Evidence,
    /// The source of the factor, or the reason for it.
    pub source: String,
    /// The bound without the factor, rounded up.
    pub without: Picos,
    /// The factor in millionths.
    pub millionths: u64,
    /// The time that it adds to the parts of the bound. With the other parts without the factor
    /// ([`Audit::bare`](super::Audit::bare)), the sum is the bound.
    pub part: Picos,
}

/// An assumed time, and how much of the bound rests on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AssumedUse {
    /// The instruction or the overhead term.
    pub name: String,
    /// The row of the table that has the time.
    pub row: String,
    /// Whether the row is for a whole class of instructions.
    pub by_class: bool,
    /// The number of instructions whose time the row gives. 0 for overhead and for the factor.
    pub count: usize,
    /// The part of the longest scan found that rests on this time. For the factor: what it adds to times that are not
    /// assumed themselves.
    pub time: Picos,
    /// The part of the bound that rests on the time, as far as the search determined it.
    pub part: Picos,
}

/// A time that each scan takes in addition to its instructions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OverheadUse {
    /// The name of the overhead term in the table.
    pub name: String,
    /// The time of the term.
    pub time: Picos,
    /// The evidence for the time.
    pub evidence: Evidence,
    /// What the time is for, and how it was calculated.
    pub why: String,
}

/// A network device that the program uses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkUse {
    /// The name of the network device.
    pub what: String,
    /// The place of the first instruction that uses the device.
    pub first: Location,
}

/// A loop that a scan can reach and for which no end is known.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct LoopUse {
    /// The place at which the loop begins.
    pub from: Location,
    /// The place of the instruction that jumps back.
    pub to: Location,
    /// The text of the loop's first instruction.
    pub begins: String,
    /// The text of the loop's last instruction.
    pub ends: String,
    /// True: a scan can stay in the loop for ever. False: nothing is known that ends the loop.
    pub certain: bool,
}

/// One instruction on the path of the longest scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathStep {
    /// The place of the instruction.
    pub at: Location,
    /// The source text of the instruction.
    pub instruction: Arc<str>,
    /// The call context: the calls on the path to the instruction, outermost first.
    pub via: Vec<String>,
    /// Whether the instruction fired: a test was true, or a jump was taken.
    pub held: bool,
    /// The time of the instruction.
    pub cost: Picos,
}

/// One execution of one instruction: its possible times, and its time in the longest scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChargeUse {
    /// The instruction's place.
    pub at: Location,
    /// The number of the instruction's rung.
    pub block: u32,
    /// The source text of the instruction.
    pub instruction: Arc<str>,
    /// The call context: calls, loop iterations and interrupts on the path to the instruction, outermost first.
    pub via: Vec<String>,
    /// The on-time.
    pub on: Picos,
    /// The off-time: the time if control reaches the instruction but it does not fire.
    pub off: Picos,
    /// Whether the instruction fires in the longest scan found.
    pub runs: bool,
    /// Whether control reaches the instruction in the longest scan found.
    pub reached: bool,
    /// The time of the instruction in the longest scan found.
    pub cost: Picos,
    /// The part of the bound that the instruction takes: its time in the longest scan that the model allows. If the
    /// bound is structural: the larger of its two times.
    pub share: Picos,
    /// The called routine that contains the instruction. `None` outside of routines.
    pub routine: Option<Arc<str>>,
    /// The row of the table that gives the times.
    pub row: Arc<str>,
    /// The evidence for the times.
    pub evidence: Evidence,
}

/// Charges that depend on common variables, and their maximum.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupUse {
    /// The number of the group, counted from 1.
    pub id: usize,
    /// The numbers of the group's rungs, ascending.
    pub blocks: Vec<u32>,
    /// The names of the devices on which the charges of the group depend.
    pub devices: Vec<String>,
    /// The devices on which several of the charges depend, the most used first.
    pub ties: Vec<Tie>,
    /// The upper bound on the time of all charges of the group together.
    pub upper: Picos,
    /// The time of the group in the longest scan found.
    pub lower: Picos,
    /// The sum, over all charges of the group, of the larger of on-time and off-time.
    pub naive: Picos,
    /// The number of queries to a solver.
    pub solver_calls: u64,
    /// The charges of the group, in the order of execution.
    pub charges: Vec<ChargeUse>,
    /// The rungs of the group, the longest time first.
    pub rungs: Vec<RungUse>,
    /// By which search the maximum of the group was found.
    pub search: method::SearchUse,
}

impl GroupUse {
    /// Whether the maximum of the group is known exactly.
    #[must_use]
    pub fn exact(&self) -> bool {
        self.upper == self.lower
    }
}

/// A device that several charges depend on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tie {
    /// The name of the device.
    pub device: String,
    /// The comment of the device. Empty if there is none.
    pub comment: String,
    /// The number of places that use the device's value.
    pub uses: usize,
}

/// The part of a group that one rung has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RungUse {
    /// The number of the rung.
    pub block: u32,
    /// The place of the rung's instruction with the longest time.
    pub at: Location,
    /// The text of the rung's instruction with the longest time.
    pub instruction: Arc<str>,
    /// The comments of the devices in the text of that instruction.
    pub comments: Vec<String>,
    /// The number of the rung's other charges in the group.
    pub others: usize,
    /// How much of its time the rung takes in the longest scan that the model allows.
    pub fate: Fate,
    /// Whether that instruction is charged with its off-time because it does not fire in that scan.
    pub is_charged_off: bool,
    /// The time of the rung in the longest scan that the model allows: its part of the bound.
    pub cost: Picos,
    /// The sum, over the rung's charges, of the larger of on-time and off-time.
    pub naive: Picos,
    /// Why the rung cannot take longer together with the rungs that run. `None` if unknown.
    pub exclusion: Option<Exclusion>,
}

/// How much of its time a rung takes in the longest scan that the model allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fate {
    /// The rung takes its longest possible time.
    Runs,
    /// The rung takes some time, but less than its longest possible time.
    Partly,
    /// The rung takes no time, or only off-times.
    Excluded,
}

/// A minimal set of rungs that run in the longest scan and prevent a rung from taking longer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exclusion {
    /// The rungs of the set. Empty if the rung can never take longer.
    pub blocks: Vec<u32>,
    /// The devices on which the times of both rungs depend.
    pub devices: Vec<String>,
}

/// One scan of a run from power-up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunScan {
    /// The number of the scan, 1 at power-up. Scans between two listed ones repeat the first of these two: the run
    /// waits for a timer.
    pub number: u64,
    /// The inputs that are on, or not 0, in the scan.
    pub inputs: Vec<(String, Value)>,
    /// A lower bound on the time of the scan.
    pub took: Picos,
}

/// A free value in the worst scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FreeValue {
    /// The name of the value in reports.
    pub name: String,
    /// The comment of the device. Empty if there is none.
    pub comment: String,
    /// The value in the longest scan found.
    pub value: Value,
    /// True: the value is read at the start of the scan. False: something happens during the scan.
    pub at_start: bool,
    /// Whether the value is needed to show that the scan takes this time.
    pub matters: bool,
    /// The time by which the model's scan ([`Audit::weighed`](super::Audit::weighed)) would be shorter if only this
    /// value were different.
    pub worth: Picos,
}

/// A value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Value {
    /// A bit.
    Bit(bool),
    /// A word: sixteen bits, as the signed number that a monitor shows.
    Word(i16),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Bit(true) => f.pad("on"),
            Value::Bit(false) => f.pad("off"),
            Value::Word(number) => f.pad(&number.to_string()),
        }
    }
}

/// A place that is over-approximated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ApproximationUse {
    /// The instruction's place.
    pub at: Location,
    /// The instruction's text.
    pub instruction: Arc<str>,
    /// Why the instruction was over-approximated.
    pub what: Approximated,
}

/// The time of the longest scan that is known to be possible. For a PLC with a clock, the clock's tolerance is not
/// included.
pub(super) fn possible(bound: &Bound, factor: Option<&FactorUse>, is_clocked: bool) -> Picos {
    match factor {
        Some(factor) if is_clocked => bound.lower.min(factor.without),
        _ => bound.lower,
    }
}
