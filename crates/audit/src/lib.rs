//! The result of an audit, with everything that a report shows already worked out.

pub mod advise;
mod assemble;
mod assumption;
pub mod breakdown;
#[cfg(test)]
mod charge_tests;
mod coactivity;
mod condition;
mod confirmed;
mod contradiction;
mod counts;
pub mod cpus;
mod deciding;
pub mod difference;
pub mod doctor;
mod doubt;
mod due;
mod exactness;
mod executed;
pub mod explain;
mod fact;
mod failure;
#[cfg(any(test, feature = "testing"))]
pub mod fixture;
mod hints;
mod indices;
pub mod intervals;
mod invariants;
mod iterations;
pub mod ladder;
mod lag;
mod made_from;
mod meeting;
pub mod method;
mod model_search;
mod modelling;
mod names;
pub mod net;
pub mod offer;
mod own;
mod pipeline;
mod power_up;
mod priced;
mod proved;
mod questions;
mod reachable;
mod real;
mod reason;
mod refinement;
mod remembered;
mod request;
pub mod response;
mod rung;
mod search;
mod solved_bound;
mod stated;
mod stretch;
mod table_use;
mod tasks;
mod timers;
mod unbounded;
mod understood;
mod unknown;
mod unknown_writes;
pub mod verdict;
mod violations;
mod watchdog;
mod weight;
mod what_if;

pub use coactivity::{Coactivity, coactivity};
pub use doubt::Doubt;
pub use exactness::{Construct, Exactness, InexactUse, LanguageUse};
pub use fact::{Fact, Status};
pub use failure::Failure;
pub use names::comments_in;
pub use net::{NetBound, net_bound};
pub use pipeline::{
    Concluded, Followed, Prepared, Ready, audit, conclude, concluded, follow, read, ready,
};
pub use questions::{File, Form, certificates, question};
pub use reason::Reason;
pub use request::{Progress, Request};
pub use solved_bound::SolvedBound;
pub use tasks::{TaskUse, tasks};

pub use assumption::Assumption;
pub use made_from::{Source, SourceKind};
use scanbound_base::budget::EarlyStop;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
pub use scanbound_ir::{Approximated, SummaryReason};
pub use scanbound_solve::{Engine, Opinion, SUBSET_SOLVER};
pub use scanbound_timing::price::{MorePoints, UnstatedBase, UnstatedPoints};
use scanbound_timing::price::{more_points, unsure};
pub use scanbound_timing::table::Evidence;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;
pub use unknown::{Counts, Unknown, UnknownKind};
pub use watchdog::{Cycle, SettingUse, Stretch, Watchdog};
pub use what_if::{Minor, Own, Step, WhatIf, what_if, what_if_offered};

/// What is known about one project's longest scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Audit {
    /// The files, as the user gave them, in the order in which they run.
    pub files: Vec<String>,
    /// The places among these of those that hold subroutines alone: they run only where they are called.
    pub standby: Vec<usize>,
    /// What the audit was made from.
    pub sources: Vec<Source>,
    /// The dialect's name.
    pub dialect: String,
    /// The CPU that the source or the user names.
    pub cpu: Option<String>,
    /// How many instructions the source has.
    pub instructions: usize,
    /// How many rungs it has.
    pub blocks: u32,
    /// How many words a scan has, on a machine where each takes one period of a clock.
    pub clocked: Option<u64>,
    /// The timing table and what it leaves to trust.
    pub table: TableUse,
    /// The answer.
    pub bound: Bound,
    /// The least time of each scan, beside what it executes.
    pub cycle: Cycle,
    /// The watchdog, and what restarts it.
    pub watchdog: Watchdog,
    /// What each scan costs besides its instructions.
    pub overhead: Vec<OverheadUse>,
    /// Charges that no assignment changes.
    pub always: Vec<ChargeUse>,
    /// The groups, numbered from 1.
    pub groups: Vec<GroupUse>,
    /// The scan that costs `Bound::lower`, by what is free in it.
    pub witness: Vec<FreeValue>,
    /// How long the scan of the model takes that starts with the witness: what each value is worth there
    /// ([`FreeValue::worth`]) is a part of it. The model may go on where the scan that was found is not followed.
    pub weighed: Picos,
    /// The scans of a run from power-up to one that costs `Bound::lower`, if such a run was found.
    pub witness_run: Vec<RunScan>,
    /// Why the scan that costs `Bound::lower` is followed no further, or may cost more than it is known to.
    pub stands_between: Option<String>,
    /// Its path through the program, where not everything runs once; else empty.
    pub path: Vec<PathStep>,
    /// Loops that a scan can go round for ever. If there are any, no scan time is a bound: the figures are those
    /// of scans that end where such a loop was gone round.
    pub unbounded: Vec<LoopUse>,
    /// What the user stated and the bound rests on.
    pub facts: Vec<Fact>,
    /// The sides of which it is not stated how many points are refreshed.
    pub points: Vec<UnstatedPoints>,
    /// The sides of which it is not stated on which base units they are: the dearest was taken.
    pub bases: Vec<UnstatedBase>,
    /// What networks refresh that the program uses, where nobody says how long that takes: it is not in the bound.
    pub networks: Vec<NetworkUse>,
    /// Why else the bound may be too low: what it needs and nobody stated.
    pub doubts: Vec<Doubt>,
    /// What words were found to hold whenever a scan starts, and that lowers counts: what only the trust in the program rests
    /// on.
    pub assumptions: Vec<Assumption>,
    /// Counts of which nothing is known and that the bound rests on, the dearest first.
    pub unknowns: Vec<Unknown>,
    /// What these and the assumptions are worth, if it was asked for.
    pub what_if: Option<WhatIf>,
    /// What it is worth that steps and stored actions of charts exclude each other, where there are charts.
    pub coactivity: Option<Coactivity>,
    /// The tasks of the project, each by itself, where it has several and that was asked for; the one whose scan is bounded is
    /// the first.
    pub tasks: Vec<TaskUse>,
    /// What a net does to the bound of its code, if that was asked for.
    pub net: Option<NetBound>,
    /// The rungs as they are drawn, if they were asked for.
    pub ladder: Option<ladder::Ladder>,
    /// What is over-approximated.
    pub approximations: Vec<ApproximationUse>,
    /// How much of the source is followed exactly, where its dialect tells statements apart.
    pub exactness: Option<Exactness>,
    /// Findings that did not stop the audit.
    pub warnings: Vec<Diagnostic>,
    /// The worst response time, if it was asked for.
    pub response: Option<response::Response>,
    /// Whose writes between scans were reckoned with.
    pub trust: scanbound_passes::values::Trust,
    /// Whether the search ended before the longest scan was known, since it was decided whether any takes longer
    /// than the request's limit.
    pub ended_early: bool,
    /// The stages that the time limit or the user cut short, and what they left open.
    pub cuts: Vec<EarlyStop>,
    /// The arguments that name the project, as a shell takes them; empty where none is needed.
    pub named: String,
    /// How long the audit took.
    pub elapsed: Duration,
}

impl Audit {
    /// The longest scan that is known to be possible, by the table: the lower bound, without what is added for a clock's
    /// tolerance, since no scan is known to need that.
    #[must_use]
    pub fn possible(&self) -> Picos {
        possible(&self.bound, self.table.factor.as_ref(), self.clocked.is_some())
    }

    /// Whether a scan was found that goes round a loop for ever.
    #[must_use]
    pub fn is_endless(&self) -> bool {
        self.unbounded.iter().any(|one| one.certain)
    }

    /// Whether a run from power-up to the scan that costs `Bound::lower` was found.
    #[must_use]
    pub fn is_reached(&self) -> bool {
        !self.witness_run.is_empty()
    }

    /// No scan takes longer, even if all points are fitted that the CPU can have, where it is not stated how many
    /// are and the table says how many can be.
    #[must_use]
    pub fn upper_with_all_points(&self) -> Picos {
        self.bound.upper + more_points(&self.points)
    }

    /// The lower bound if no point is fitted where it is not stated how many are, and those that are on the
    /// cheapest base where it is not stated on which.
    #[must_use]
    pub fn lower_without_points(&self) -> Picos {
        let unsure = unsure(&self.points, &self.bases);
        self.possible().checked_sub(unsure).unwrap_or_default()
    }

    /// The lower bound with the points that are charged, on the cheapest base where it is not stated on which they are.
    #[must_use]
    pub fn lower_on_least_bases(&self) -> Picos {
        let saves = self.bases.iter().map(|base| base.saves).sum();
        self.possible().checked_sub(saves).unwrap_or_default()
    }

    /// The shortest limit that a check proves; `None` where it proves none, however long, since the bound may be too low.
    #[must_use]
    pub fn proved(&self) -> Option<Picos> {
        let is_proved = self.unbounded.is_empty() && self.uncounted_doubts().is_empty();
        is_proved.then(|| self.upper_with_all_points())
    }

    /// A time of the report without the table's factor, which all of them hold.
    #[must_use]
    pub fn bare(&self, time: Picos) -> Picos {
        let factor = self.table.factor.as_ref();
        factor.map_or(time, |factor| scanbound_timing::table::taken_off(factor.millionths, time))
    }

    /// The groups that are worth a look, of at least a two-hundredth of the bound and at most so many; and the others.
    #[must_use]
    pub fn main_groups(&self, most: usize) -> (&[GroupUse], &[GroupUse]) {
        let main = |group: &&GroupUse| Audit::is_main(group.upper, self.bound.upper);
        let shown = self.groups.iter().take(most).take_while(main).count();
        self.groups.split_at(shown)
    }

    fn is_main(group: Picos, upper: Picos) -> bool {
        u128::from(group.0) * 200 >= u128::from(upper.0)
    }
}

impl Audit {
    /// What each scan takes at least by the table: what no condition avoids, without the table's factor.
    #[must_use]
    pub fn least(&self) -> Picos {
        let always = self.bound.always + self.bound.overhead;
        let always = always.checked_sub(unsure(&self.points, &self.bases)).unwrap_or_default();
        let Some(factor) = &self.table.factor else { return always };
        // The same share as of the whole bound, rounded down.
        let part = u128::from(always.0) * u128::from(factor.without.0);
        let least = part.checked_div(u128::from(self.bound.upper.0)).unwrap_or(0);
        Picos(u64::try_from(least).unwrap_or(always.0))
    }
}

/// The longest scan that is known to be possible: on a machine with a clock, without the clock's tolerance.
fn possible(bound: &Bound, factor: Option<&FactorUse>, is_clocked: bool) -> Picos {
    match factor {
        Some(factor) if is_clocked => bound.lower.min(factor.without),
        _ => bound.lower,
    }
}

/// The bound and its parts: `upper` = `always` + `overhead` + the groups' `upper`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bound {
    /// No scan takes longer.
    pub upper: Picos,
    /// A scan that nothing known here excludes takes this long, run as the PLC runs it.
    pub lower: Picos,
    /// The dearest scan that the model allows, as far as it was found: it may need values that are not known here.
    pub model: Picos,
    /// Every charge at the dearer of its two times, and the overhead.
    pub naive: Picos,
    /// The charges that no assignment changes.
    pub always: Picos,
    /// What each scan costs besides its instructions.
    pub overhead: Picos,
    /// The groups' upper bounds together.
    pub groups: Picos,
}

impl Bound {
    /// Whether the longest scan is known to the picosecond.
    #[must_use]
    pub fn exact(&self) -> bool {
        self.upper == self.lower
    }

    /// What mutual exclusion takes off the naive sum.
    #[must_use]
    pub fn saved(&self) -> Picos {
        self.naive.checked_sub(self.upper).unwrap_or(Picos::ZERO)
    }
}

/// A part of a whole, in thousandths, rounded to the nearest; shown in percent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Share(pub u64);

impl Share {
    /// The part's share; none of nothing.
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

/// The timing table and what it leaves to trust.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableUse {
    /// Its name or file.
    pub name: String,
    /// What it is for, one line; may be empty.
    pub title: String,
    /// Whether no time in it is published, measured or stated: all are assumed.
    pub is_all_assumed: bool,
    /// What its times do not hold.
    pub notes: Vec<String>,
    /// The CPU's watchdog time by default.
    pub watchdog: Option<Picos>,
    /// The factor on the whole scan.
    pub factor: Option<FactorUse>,
    /// The assumed times that the program uses, those first on which most of the bound rests.
    pub assumed: Vec<AssumedUse>,
    /// How much of the worst scan found rests on assumed times, overhead included.
    pub assumed_time: Picos,
    /// The same as a share of that scan.
    pub assumed_share: Share,
}

/// A factor on the whole scan, and what the bound would be without it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FactorUse {
    /// As the table has it.
    pub text: String,
    /// How well founded.
    pub evidence: Evidence,
    /// Why there is one.
    pub source: String,
    /// The bound without it, rounded up.
    pub without: Picos,
    /// In millionths.
    pub millionths: u64,
    /// What it adds to the parts of the bound: with their times without it, [`Audit::bare`], this makes the bound.
    pub part: Picos,
}

/// An assumed time and what it weighs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AssumedUse {
    /// The instruction or the table's term.
    pub name: String,
    /// The table's row.
    pub row: String,
    /// Whether the row is that of a whole class of instructions.
    pub by_class: bool,
    /// How many instructions of the program it prices; 0 for a term of the scan, and for the factor on it.
    pub count: usize,
    /// Its part in the worst scan found; of the factor, what it adds to times that are not assumed themselves.
    pub time: Picos,
    /// Its part in the bound likewise, as far as the search settled it.
    pub part: Picos,
}

/// A cost of each scan besides its instructions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OverheadUse {
    /// The table's term.
    pub name: String,
    /// Its time.
    pub time: Picos,
    /// How well the time is founded.
    pub evidence: Evidence,
    /// What it is for and how it was worked out.
    pub why: String,
}

/// Something that the program uses and that a network refreshes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkUse {
    /// What, in words.
    pub what: String,
    /// The first instruction that uses it.
    pub first: Location,
}

/// A loop that a scan can come to and that nothing bounds.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct LoopUse {
    /// Where it begins.
    pub from: Location,
    /// Where control goes back.
    pub to: Location,
    /// Its first instruction.
    pub begins: String,
    /// Its last one.
    pub ends: String,
    /// Whether a scan can go round it for ever; else only nothing is known that ends it.
    pub certain: bool,
}

/// One instruction on the path of the worst scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathStep {
    /// Where it stands.
    pub at: Location,
    /// Its source text.
    pub instruction: Arc<str>,
    /// The call context: the calls on the path to it, outermost first.
    pub via: Vec<String>,
    /// Whether it fired: a test that held, a jump that was taken.
    pub held: bool,
    /// What it cost.
    pub cost: Picos,
}

/// One execution of one instruction, what it may cost, and what it costs in the worst scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChargeUse {
    /// Where the instruction stands.
    pub at: Location,
    /// Its rung.
    pub block: u32,
    /// Its source text.
    pub instruction: Arc<str>,
    /// The call context: calls, loop iterations and interrupts on the path to it, outermost first.
    pub via: Vec<String>,
    /// Time when it runs.
    pub on: Picos,
    /// Time when it is reached and does not run.
    pub off: Picos,
    /// Whether it runs in the worst scan found.
    pub runs: bool,
    /// Whether control reaches it there.
    pub reached: bool,
    /// What it costs there.
    pub cost: Picos,
    /// Its part in the bound: what it costs in the dearest scan that the model allows; where the bound is
    /// the sum of all at their dearer times, that.
    pub share: Picos,
    /// The routine that it was called in, if any.
    pub routine: Option<Arc<str>>,
    /// The table's row.
    pub row: Arc<str>,
    /// How well the time is founded.
    pub evidence: Evidence,
}

/// Charges that depend on common variables, and their maximum.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupUse {
    /// Its number, from 1.
    pub id: usize,
    /// Its rungs, ascending.
    pub blocks: Vec<u32>,
    /// The devices that tie it, by name.
    pub devices: Vec<String>,
    /// The same, the most used first.
    pub ties: Vec<Tie>,
    /// Its charges can't cost more together.
    pub upper: Picos,
    /// What they cost in the worst scan found.
    pub lower: Picos,
    /// Every charge at the dearer of its times.
    pub naive: Picos,
    /// Questions put to a solver.
    pub solver_calls: u64,
    /// Its charges, in the order of execution.
    pub charges: Vec<ChargeUse>,
    /// Its rungs, the dearest first.
    pub rungs: Vec<RungUse>,
    /// How its maximum was found.
    pub search: method::SearchUse,
}

impl GroupUse {
    /// Whether its maximum is known to the picosecond.
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
    /// How many places ask for its value.
    pub uses: usize,
}

/// A rung's part in its group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RungUse {
    /// Its number.
    pub block: u32,
    /// Its dearest instruction's place.
    pub at: Location,
    /// Its dearest instruction's text.
    pub instruction: Arc<str>,
    /// The comments of the devices in that text, those that have one.
    pub comments: Vec<String>,
    /// How many other charges of the group it has.
    pub others: usize,
    /// What becomes of it in the dearest scan that the model allows.
    pub fate: Fate,
    /// Whether its dearest instruction does not run there and is charged all the same, with its time when off.
    pub is_charged_off: bool,
    /// What it costs there: its part in the bound.
    pub cost: Picos,
    /// What it would cost, every charge at the dearer of its times.
    pub naive: Picos,
    /// Why it can't cost more together with what runs, where that is known.
    pub exclusion: Option<Exclusion>,
}

/// What becomes of a rung in the dearest scan that the model allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fate {
    /// It costs the most that it can.
    Runs,
    /// It costs something, and could cost more.
    Partly,
    /// None of it runs: it costs nothing, or what it costs when it is off.
    Excluded,
}

/// A smallest set of rungs that run in the worst scan and keep a rung from costing more.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exclusion {
    /// The rungs; empty if the rung can never cost more.
    pub blocks: Vec<u32>,
    /// The devices through which they do.
    pub devices: Vec<String>,
}

/// One scan of a run from power-up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunScan {
    /// Its number from 1 at power-up. The scans between two that are shown are like the first of them: the run waits for a
    /// timer.
    pub number: u64,
    /// The inputs that are on, or not 0, in it.
    pub inputs: Vec<(String, Value)>,
    /// How long it takes at least.
    pub took: Picos,
}

/// A free value in the worst scan found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FreeValue {
    /// What is free, by the name that people know.
    pub name: String,
    /// Its comment, empty if there is none.
    pub comment: String,
    /// Its value.
    pub value: Value,
    /// Whether it is the value at the start of the scan, rather than something that happens within.
    pub at_start: bool,
    /// Whether the scan would not be known to cost as much without it.
    pub matters: bool,
    /// How much less the scan of the model ([`Audit::weighed`]) would cost if this alone were another.
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

/// Something that is over-approximated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ApproximationUse {
    /// Where.
    pub at: Location,
    /// The instruction's text.
    pub instruction: Arc<str>,
    /// What was done.
    pub what: Approximated,
}
