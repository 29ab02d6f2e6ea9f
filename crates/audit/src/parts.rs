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
    /// No scan takes longer.
    pub upper: Picos,
    /// A scan that nothing known here excludes takes this long, executed as on a PLC.
    pub lower: Picos,
    /// The longest scan that the model allows, as far as it was found. It may need values that are not known to be
    /// possible.
    pub model: Picos,
    /// The structural bound: every charge at the larger of its two times, plus the overhead.
    pub naive: Picos,
    /// The charges that have the same time in every scan.
    pub always: Picos,
    /// The time of each scan in addition to its instructions.
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

    /// How much mutual exclusion saves compared with the structural bound.
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
    /// Its name or file.
    pub name: String,
    /// Its title, one line. May be empty.
    pub title: String,
    /// Whether all of its times are assumed: none is published, measured or stated.
    pub is_all_assumed: bool,
    /// What its times do not include.
    pub notes: Vec<String>,
    /// The CPU's default watchdog time.
    pub watchdog: Option<Picos>,
    /// The factor on the whole scan.
    pub factor: Option<FactorUse>,
    /// The assumed times that the program uses. Those come first on which most of the bound rests.
    pub assumed: Vec<AssumedUse>,
    /// How much of the worst scan found rests on assumed times, including overhead.
    pub assumed_time: Picos,
    /// The same as a share of that scan.
    pub assumed_share: Share,
}

/// A factor on the whole scan, and the bound without it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FactorUse {
    /// As written in the table.
    pub text: String,
    /// How well founded.
    pub evidence: Evidence,
    /// Its source or reason.
    pub source: String,
    /// The bound without it, rounded up.
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
    /// The table's row.
    pub row: String,
    /// Whether the row is for a whole class of instructions.
    pub by_class: bool,
    /// The number of instructions that it prices. 0 for overhead and for the factor.
    pub count: usize,
    /// Its part of the worst scan found. For the factor: what it adds to times that are not assumed themselves.
    pub time: Picos,
    /// Its part of the bound, as far as the search determined it.
    pub part: Picos,
}

/// A time that each scan takes in addition to its instructions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OverheadUse {
    /// The name of the table's term.
    pub name: String,
    /// Its time.
    pub time: Picos,
    /// How well the time is founded.
    pub evidence: Evidence,
    /// What it is for, and how it was calculated.
    pub why: String,
}

/// A network device that the program uses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkUse {
    /// Its name.
    pub what: String,
    /// The first instruction that uses it.
    pub first: Location,
}

/// A loop that a scan can reach and that nothing bounds.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct LoopUse {
    /// Where it begins.
    pub from: Location,
    /// The instruction that jumps back.
    pub to: Location,
    /// Its first instruction.
    pub begins: String,
    /// Its last instruction.
    pub ends: String,
    /// True: a scan can stay in it for ever. False: nothing known ends it.
    pub certain: bool,
}

/// One instruction on the path of the worst scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathStep {
    /// Its place.
    pub at: Location,
    /// Its source text.
    pub instruction: Arc<str>,
    /// The call context: the calls on the path to it, outermost first.
    pub via: Vec<String>,
    /// Whether it fired: the test was true, or the jump was taken.
    pub held: bool,
    /// Its time.
    pub cost: Picos,
}

/// One execution of one instruction: its possible times, and its time in the worst scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChargeUse {
    /// The instruction's place.
    pub at: Location,
    /// The number of its rung.
    pub block: u32,
    /// Its source text.
    pub instruction: Arc<str>,
    /// The call context: calls, loop iterations and interrupts on the path to it, outermost first.
    pub via: Vec<String>,
    /// The on-time.
    pub on: Picos,
    /// The off-time: it is reached and does not run.
    pub off: Picos,
    /// Whether it runs in the worst scan found.
    pub runs: bool,
    /// Whether it is reached in that scan.
    pub reached: bool,
    /// Its time in that scan.
    pub cost: Picos,
    /// Its part of the bound: its time in the longest scan that the model allows. If the bound is structural: the
    /// larger of its two times.
    pub share: Picos,
    /// The called routine that contains it, if any.
    pub routine: Option<Arc<str>>,
    /// The table's row.
    pub row: Arc<str>,
    /// How well the time is founded.
    pub evidence: Evidence,
}

/// Charges that depend on common variables, and their maximum.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupUse {
    /// Its number, counted from 1.
    pub id: usize,
    /// The numbers of its rungs, ascending.
    pub blocks: Vec<u32>,
    /// The names of the devices on which its charges depend.
    pub devices: Vec<String>,
    /// The same devices, the most used first.
    pub ties: Vec<Tie>,
    /// The largest time of all its charges together.
    pub upper: Picos,
    /// Their time in the worst scan found.
    pub lower: Picos,
    /// The sum of the larger of each charge's two times.
    pub naive: Picos,
    /// The number of queries to a solver.
    pub solver_calls: u64,
    /// Its charges, in the order of execution.
    pub charges: Vec<ChargeUse>,
    /// Its rungs, the longest time first.
    pub rungs: Vec<RungUse>,
    /// How its maximum was found.
    pub search: method::SearchUse,
}

impl GroupUse {
    /// Whether its maximum is known exactly.
    #[must_use]
    pub fn exact(&self) -> bool {
        self.upper == self.lower
    }
}

/// A device that several charges depend on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tie {
    /// Its name.
    pub device: String,
    /// Its comment, empty if there is none.
    pub comment: String,
    /// The number of places that use its value.
    pub uses: usize,
}

/// A rung's part of its group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RungUse {
    /// Its number.
    pub block: u32,
    /// The place of its instruction with the longest time.
    pub at: Location,
    /// The text of that instruction.
    pub instruction: Arc<str>,
    /// The comments of the devices in that text.
    pub comments: Vec<String>,
    /// The number of its other charges in the group.
    pub others: usize,
    /// What happens to it in the longest scan that the model allows.
    pub fate: Fate,
    /// Whether that instruction does not run there but is charged with its off-time.
    pub is_charged_off: bool,
    /// Its time there: its part of the bound.
    pub cost: Picos,
    /// The sum of the larger of its charges' two times.
    pub naive: Picos,
    /// Why it cannot take longer together with the rungs that run, if that is known.
    pub exclusion: Option<Exclusion>,
}

/// What happens to a rung in the longest scan that the model allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fate {
    /// It takes its longest possible time.
    Runs,
    /// It takes some time, but less than possible.
    Partly,
    /// It does not run: it takes no time, or only off-times.
    Excluded,
}

/// A minimal set of rungs that run in the worst scan and prevent a rung from taking longer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exclusion {
    /// The rungs. Empty if the rung can never take longer.
    pub blocks: Vec<u32>,
    /// The devices on which both depend.
    pub devices: Vec<String>,
}

/// One scan of a run from power-up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunScan {
    /// Its number, 1 at power-up. Scans between two that are listed repeat the first of them: the run waits for a
    /// timer.
    pub number: u64,
    /// The inputs that are on, or not 0, in it.
    pub inputs: Vec<(String, Value)>,
    /// A lower bound on its time.
    pub took: Picos,
}

/// A free value in the worst scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FreeValue {
    /// Its name for users.
    pub name: String,
    /// Its comment, empty if there is none.
    pub comment: String,
    /// Its value.
    pub value: Value,
    /// True: the value at the start of the scan. False: something that happens during the scan.
    pub at_start: bool,
    /// Whether it is needed to show that the scan takes this time.
    pub matters: bool,
    /// How much shorter the model's scan ([`Audit::weighed`](super::Audit::weighed)) would be if only this value were
    /// different.
    pub worth: Picos,
}

/// A value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Value {
    /// A bit.
    Bit(bool),
    /// Sixteen bits, as the signed number that a monitor shows.
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
    /// How it was over-approximated.
    pub what: Approximated,
}

/// The time of the longest scan that is known to be possible: for a machine with a clock, without the clock's
/// tolerance.
pub(super) fn possible(bound: &Bound, factor: Option<&FactorUse>, is_clocked: bool) -> Picos {
    match factor {
        Some(factor) if is_clocked => bound.lower.min(factor.without),
        _ => bound.lower,
    }
}
