//! The parts of the result of an audit: the bound, what it consists of, and the scan that shows the lower bound.

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
    /// The admissible lower bound: a scan that nothing known here excludes takes this long, executed as on a PLC. If no
    /// such scan is known, it is at most the overhead.
    pub lower: Picos,
    /// The time of the longest scan of the model that was found, at least `lower`. That scan may need values that are
    /// not known to be possible.
    pub model: Picos,
    /// The structural bound: every charge at the larger of its two times, plus the overhead.
    pub naive: Picos,
    /// The sum of the charges that have the same time in every scan.
    pub always: Picos,
    /// The time that each scan takes in addition to its instructions, such as END processing and refresh.
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

    /// The time by which the upper bound is below the structural bound. Zero if it is not.
    #[must_use]
    pub fn saved(&self) -> Picos {
        self.naive.checked_sub(self.upper).unwrap_or(Picos::ZERO)
    }
}

/// A share in thousandths, rounded to the nearest. Shown in percent with one decimal.
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
    /// The CPU's default watchdog time. `None` if the table does not give it.
    pub watchdog: Option<Picos>,
    /// The factor by which the table multiplies the whole scan. `None` if it has none.
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
    /// The time that the factor adds to the bound: with the overhead, the constant charges and the groups, each divided
    /// by the factor ([`Audit::bare`](super::Audit::bare)), the sum is the bound.
    pub part: Picos,
}

/// An assumed time, and how much of the bound rests on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AssumedUse {
    /// What has the time: an instruction as the table's rows name it, an overhead term, or the factor. If `by_class`:
    /// the name under which the table could have a row for the instruction itself.
    pub name: String,
    /// The names of the table's rows that give the time, joined by ` + `.
    pub row: String,
    /// Whether the row is a class row (`@move`), which is used because the table has no row for the instruction itself.
    pub by_class: bool,
    /// The number of instructions whose time the row gives. 0 for overhead and for the factor.
    pub count: usize,
    /// The part of the longest scan found that rests on this time. For the factor: what it adds to times that are not
    /// assumed themselves.
    pub time: Picos,
    /// The part of the bound that rests on the time, as far as the search showed which charges make up the bound.
    pub part: Picos,
}

/// A time that each scan takes in addition to its instructions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OverheadUse {
    /// The name of the overhead term in reports, such as `END processing`.
    pub name: String,
    /// The time of the term.
    pub time: Picos,
    /// The evidence for the time.
    pub evidence: Evidence,
    /// What the time is for, and how it was calculated.
    pub why: String,
}

/// What the program uses of a network whose refresh time is not known: devices that the network refreshes, or a
/// station.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkUse {
    /// The name of the network's devices, such as `B`; or the station.
    pub what: String,
    /// The place of the first instruction that uses these devices or this station.
    pub first: Location,
}

/// A loop without a bound. In [`Audit::unbounded`](super::Audit::unbounded): one that a scan can reach.
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

/// One executed instruction on the path of the longest scan found. Instructions that never take time are left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathStep {
    /// The place of the instruction.
    pub at: Location,
    /// The source text of the instruction.
    pub instruction: Arc<str>,
    /// The call context: the calls on the path to the instruction, outermost first.
    pub via: Vec<String>,
    /// Whether the instruction fired: for a contact, whether the test was true; for a jump, whether it was taken.
    pub held: bool,
    /// The time of this execution of the instruction.
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
    /// The on-time, with the largest possible number of units.
    pub on: Picos,
    /// The off-time: the time if control reaches the instruction but it does not fire.
    pub off: Picos,
    /// Whether the instruction fires in the longest scan found.
    pub runs: bool,
    /// Whether control reaches the instruction in the longest scan found.
    pub reached: bool,
    /// The time of the instruction in the longest scan found.
    pub cost: Picos,
    /// The part of the bound that is known to be due to this execution: its time in the longest scan of the model that
    /// was found. If the group's bound excludes nothing: the larger of the two times. Zero if no scan of the group was
    /// found.
    pub share: Picos,
    /// The label of the innermost called routine, or of the interrupt, in which the instruction runs. `None` outside of
    /// routines.
    pub routine: Option<Arc<str>>,
    /// The names of the table's rows that give the times, joined by ` + `. Empty if the instruction takes no time.
    pub row: Arc<str>,
    /// The evidence for the times.
    pub evidence: Evidence,
}

/// A group: charges that share free variables, directly or through others, with the bounds on their time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupUse {
    /// The number of the group, counted from 1.
    pub id: usize,
    /// The numbers of the group's rungs, ascending.
    pub blocks: Vec<u32>,
    /// The names of the devices on which the charges of the group depend.
    pub devices: Vec<String>,
    /// The devices on which the charges of the group depend, each with the number of its uses, the most used first.
    pub ties: Vec<Tie>,
    /// The upper bound on the time of all charges of the group together.
    pub upper: Picos,
    /// The time of the group's charges in the longest scan found.
    pub lower: Picos,
    /// The sum, over all charges of the group, of the larger of on-time and off-time.
    pub naive: Picos,
    /// The number of queries to a solver that the search of this group made.
    pub solver_calls: u64,
    /// The charges of the group, in the order of execution.
    pub charges: Vec<ChargeUse>,
    /// The rungs of the group, the one with the longest possible time first.
    pub rungs: Vec<RungUse>,
    /// How the maximum of the group was searched.
    pub search: method::SearchUse,
}

impl GroupUse {
    /// Whether the longest scan found takes as long in this group as its upper bound.
    #[must_use]
    pub fn exact(&self) -> bool {
        self.upper == self.lower
    }
}

/// A device on which charges of a group depend.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tie {
    /// The name of the device.
    pub device: String,
    /// The comment of the device. Empty if there is none.
    pub comment: String,
    /// How often the model uses the device's value directly: the number of gates of the guards' circuit, and of
    /// charges, that read it.
    pub uses: usize,
}

/// The charges of one rung in a group, taken together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RungUse {
    /// The number of the rung.
    pub block: u32,
    /// The place of the rung's instruction with the longest time.
    pub at: Location,
    /// The text of the rung's instruction with the longest time.
    pub instruction: Arc<str>,
    /// The comments of the devices that the rung's instruction with the longest time names.
    pub comments: Vec<String>,
    /// The number of the rung's other charges in the group.
    pub others: usize,
    /// How many of the rung's charges take the larger of their two times in the longest scan of the model that was
    /// found.
    pub fate: Fate,
    /// Whether the instruction at `at` is charged with its off-time, because it does not fire in the longest scan of
    /// the model that was found.
    pub is_charged_off: bool,
    /// The time of the rung in the longest scan of the model that was found: its part of the bound.
    pub cost: Picos,
    /// The sum, over the rung's charges, of the larger of on-time and off-time.
    pub naive: Picos,
    /// Why the rung cannot take longer together with the rungs that run. `None` if it takes its longest time, or the
    /// reason was not found or not searched for.
    pub exclusion: Option<Exclusion>,
}

/// How many charges of a rung take the larger of their two times in the longest scan of the model that was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fate {
    /// Every charge of the rung takes the larger of its two times: the rung takes its longest possible time.
    Runs,
    /// Some charges of the rung take the larger of their two times, but not all: the rung takes less than its longest
    /// possible time.
    Partly,
    /// No charge of the rung takes the larger of its two times: the rung takes no time, or only the smaller times.
    Excluded,
}

/// A minimal set of rungs that run in the longest scan of the model that was found and prevent another rung from taking
/// longer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exclusion {
    /// The rungs of the set. Empty if the rung can never take longer.
    pub blocks: Vec<u32>,
    /// The devices on which both the rung that is prevented and a rung of `blocks` depend. If `blocks` is empty: the
    /// devices on which the charge that is furthest below its larger time depends.
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
    /// A lower bound on the time of the scan, including the overhead.
    pub took: Picos,
}

/// A free value of the longest scan found: a value at its start, or one that the program does not determine during it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FreeValue {
    /// The name of the value in reports.
    pub name: String,
    /// The comment of the device. Empty if there is none.
    pub comment: String,
    /// The value in the longest scan found.
    pub value: Value,
    /// True: it is the value of a device when the scan starts. False: it arises during the scan, such as whether a
    /// timer times out.
    pub at_start: bool,
    /// Whether the value is needed to show that the scan takes this time.
    pub matters: bool,
    /// The time by which the model's scan ([`Audit::weighed`](super::Audit::weighed)) would be shorter if only this
    /// value were different. For a word, a few other values are tried. Zero if the value does not matter.
    pub worth: Picos,
}

/// The value of a bit or of a word, as reports show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Value {
    /// The value of a bit: `true` is on.
    Bit(bool),
    /// The value of a word: sixteen bits, as the signed number that a monitor shows.
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

/// An instruction that is over-approximated: modelled with more behaviour than it has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ApproximationUse {
    /// The instruction's place.
    pub at: Location,
    /// The instruction's text.
    pub instruction: Arc<str>,
    /// Why the instruction was over-approximated.
    pub what: Approximated,
}

/// The lower bound: the time of the longest scan that is known to be possible. For a PLC with a clock (`is_clocked`),
/// it does not include the clock's tolerance, which the factor expresses.
pub(super) fn possible(bound: &Bound, factor: Option<&FactorUse>, is_clocked: bool) -> Picos {
    match factor {
        Some(factor) if is_clocked => bound.lower.min(factor.without),
        _ => bound.lower,
    }
}
