//! The result of auditing one project.

use super::assumption::Assumption;
use super::cycle::{Cycle, Watchdog};
use super::doubt::Doubt;
use super::drawn::Ladder;
use super::exactness::Exactness;
use super::fact::Fact;
use super::parts::{
    ApproximationUse, Bound, ChargeUse, FreeValue, GroupUse, LoopUse, NetworkUse, OverheadUse,
    PathStep, RunScan, TableUse, possible,
};
use super::requested::{Coactivity, NetBound, TaskUse, WhatIf};
use super::response;
use super::sources::Source;
use super::unknown::Unknown;
use scanbound_base::budget::EarlyStop;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_timing::price::{UnstatedBase, UnstatedPoints, more_points, uncertain_refresh};
use std::time::Duration;

/// The result of auditing one project.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Audit {
    /// The files, as the user named them, in the order of execution.
    pub files: Vec<String>,
    /// Indices into `files` of the files that contain only subroutines, which run only if they are called.
    pub standby: Vec<usize>,
    /// The program files, the table and the facts file from which the audit was made.
    pub sources: Vec<Source>,
    /// The dialect's name.
    pub dialect: String,
    /// The CPU that the source or the user names.
    pub cpu: Option<String>,
    /// The number of instructions in the source.
    pub instructions: usize,
    /// The number of rungs.
    pub blocks: u32,
    /// The number of program words in a scan, for a PLC that executes one word per clock period. `None` for other PLCs.
    pub clocked: Option<u64>,
    /// The timing table, and which of its times are uncertain.
    pub table: TableUse,
    /// The bounds of the scan time.
    pub bound: Bound,
    /// The minimum scan time that the CPU or the program sets, if any.
    pub cycle: Cycle,
    /// Whether the program may let interrupts wait beyond the end of a scan.
    pub holds_interrupts: bool,
    /// The watchdog of the program, and what restarts it.
    pub watchdog: Watchdog,
    /// The time of each scan in addition to its instructions.
    pub overhead: Vec<OverheadUse>,
    /// Charges that have the same time in every scan.
    pub always: Vec<ChargeUse>,
    /// The groups of charges, numbered from 1.
    pub groups: Vec<GroupUse>,
    /// The free values of the scan that takes `Bound::lower`.
    pub witness: Vec<FreeValue>,
    /// The time of the model's scan that starts with the witness. Each [`FreeValue::worth`] is a part of it. It can be
    /// longer than the scan found, because that one may have stopped early.
    pub weighed: Picos,
    /// The scans of a run from power-up to one that takes `Bound::lower`, if such a run was found.
    pub witness_run: Vec<RunScan>,
    /// Why the simulation of the scan that takes `Bound::lower` stopped early, or may take longer than this time.
    /// `None` if neither.
    pub stands_between: Option<String>,
    /// The path of that scan through the program, if not every instruction runs exactly once. Otherwise empty.
    pub path: Vec<PathStep>,
    /// Loops in which a scan can stay for ever. If there are any, no time is a bound: all figures are then for scans
    /// that end after such a loop ran once.
    pub unbounded: Vec<LoopUse>,
    /// The user's statements on which the bound rests.
    pub facts: Vec<Fact>,
    /// Inputs or outputs for which the number of refreshed points is not stated.
    pub points: Vec<UnstatedPoints>,
    /// Inputs or outputs whose base units are not stated. The slowest base was charged.
    pub bases: Vec<UnstatedBase>,
    /// Network devices that the program uses and whose refresh time is not stated. The bound does not include that
    /// time.
    pub networks: Vec<NetworkUse>,
    /// Further reasons why the bound may be too low: facts that the bound needs and that are not stated.
    pub doubts: Vec<Doubt>,
    /// Derived values of words at the start of a scan that lower counts. They hold only if the program alone writes
    /// these words.
    pub assumptions: Vec<Assumption>,
    /// Unknown numbers of iterations or units on which the bound depends, the one with the most time first.
    pub unknowns: Vec<Unknown>,
    /// How much the bound changes with these unknowns stated, and without each assumption, if that was requested.
    pub what_if: Option<WhatIf>,
    /// How much the mutual exclusion of steps and stored actions lowers the bound, if there are charts.
    pub coactivity: Option<Coactivity>,
    /// The tasks of the project, if there are several and that was requested. The first one is the task whose scan is
    /// bounded.
    pub tasks: Vec<TaskUse>,
    /// How a net's sets of mutually exclusive elements change the bound, if that was requested.
    pub net: Option<NetBound>,
    /// The rungs for drawing, if they were requested.
    pub ladder: Option<Ladder>,
    /// Places where the program is over-approximated.
    pub approximations: Vec<ApproximationUse>,
    /// How much of the source is followed exactly, if its dialect lists statements.
    pub exactness: Option<Exactness>,
    /// Findings that did not stop the audit.
    pub warnings: Vec<Diagnostic>,
    /// The worst-case response time, if it was requested.
    pub response: Option<response::Response>,
    /// Which writers between scans were assumed.
    pub trust: scanbound_passes::values::Trust,
    /// Whether the search ended early because it was already decided whether any scan exceeds the limit.
    pub ended_early: bool,
    /// The stages that the time limit or the user ended early, and what they left open.
    pub cuts: Vec<EarlyStop>,
    /// The command line arguments that name the project, quoted for a shell. Empty if none is needed.
    pub named: String,
    /// How long the audit took.
    pub elapsed: Duration,
}

impl Audit {
    /// The time of the longest scan that is known to be possible by the table. It is the lower bound without the
    /// tolerance of a clock, since no scan is known to need that.
    #[must_use]
    pub fn possible(&self) -> Picos {
        possible(&self.bound, self.table.factor.as_ref(), self.clocked.is_some())
    }

    /// Whether a scan was found that never leaves a loop.
    #[must_use]
    pub fn is_endless(&self) -> bool {
        self.unbounded.iter().any(|one| one.certain)
    }

    /// Whether a run from power-up to the scan that takes `Bound::lower` was found.
    #[must_use]
    pub fn is_reached(&self) -> bool {
        !self.witness_run.is_empty()
    }

    /// The upper bound with all points that the CPU can have, where their number is not stated and the table gives it.
    #[must_use]
    pub fn upper_with_all_points(&self) -> Picos {
        self.bound.upper + more_points(&self.points)
    }

    /// The lower bound without points whose number is not stated. If the base unit is not stated, the fastest one is
    /// assumed.
    #[must_use]
    pub fn lower_without_points(&self) -> Picos {
        let uncertain = uncertain_refresh(&self.points, &self.bases);
        self.possible().checked_sub(uncertain).unwrap_or_default()
    }

    /// The lower bound with the points that are charged. If the base unit is not stated, the fastest one is assumed.
    #[must_use]
    pub fn lower_on_least_bases(&self) -> Picos {
        let saves = self.bases.iter().map(|base| base.saves).sum();
        self.possible().checked_sub(saves).unwrap_or_default()
    }

    /// The shortest limit that a check proves. `None` if a check proves no limit because the bound may be too low.
    #[must_use]
    pub fn proved(&self) -> Option<Picos> {
        let is_proved = self.unbounded.is_empty() && self.uncounted_doubts().is_empty();
        is_proved.then(|| self.upper_with_all_points())
    }

    /// Divides a time of the report by the table's factor.
    #[must_use]
    pub fn bare(&self, time: Picos) -> Picos {
        let factor = self.table.factor.as_ref();
        factor.map_or(time, |factor| scanbound_timing::table::taken_off(factor.millionths, time))
    }

    /// The groups that matter: those with at least a two-hundredth of the bound, at most `most`. The others follow as
    /// the second part.
    #[must_use]
    pub fn main_groups(&self, most: usize) -> (&[GroupUse], &[GroupUse]) {
        let main = |group: &&GroupUse| Audit::is_main(group.upper, self.bound.upper);
        let shown = self.groups.iter().take(most).take_while(main).count();
        self.groups.split_at(shown)
    }

    pub(super) fn is_main(group: Picos, upper: Picos) -> bool {
        u128::from(group.0) * 200 >= u128::from(upper.0)
    }
}

impl Audit {
    /// A lower bound on the time of every scan: the charges that no condition avoids, without the table's factor.
    #[must_use]
    pub fn least(&self) -> Picos {
        let always = self.bound.always + self.bound.overhead;
        let always =
            always.checked_sub(uncertain_refresh(&self.points, &self.bases)).unwrap_or_default();
        let Some(factor) = &self.table.factor else { return always };
        // The same share as of the whole bound, rounded down.
        let part = u128::from(always.0) * u128::from(factor.without.0);
        let least = part.checked_div(u128::from(self.bound.upper.0)).unwrap_or(0);
        Picos(u64::try_from(least).unwrap_or(always.0))
    }
}

impl Audit {
    /// An upper bound on the scan time, including the wait for the constant scan time.
    #[must_use]
    pub fn cycle_upper(&self) -> Picos {
        self.bound.upper.max(self.cycle.longest().unwrap_or_default())
    }

    /// An upper bound on the scan time, including the wait for the constant scan time. If the number of points is not
    /// stated: with all points that the CPU can have.
    #[must_use]
    pub fn cycle_with_all_points(&self) -> Picos {
        self.upper_with_all_points().max(self.cycle.longest().unwrap_or_default())
    }

    /// A lower bound on the scan time, including the wait for the constant scan time.
    #[must_use]
    pub fn cycle_lower(&self) -> Picos {
        self.possible().max(self.cycle.lower.unwrap_or_default())
    }

    /// A lower bound on the scan time, including the wait for the constant scan time, without the refresh time of
    /// points whose number is not stated.
    #[must_use]
    pub fn cycle_without_points(&self) -> Picos {
        self.lower_without_points().max(self.cycle.lower.unwrap_or_default())
    }
}

impl Audit {
    /// All reasons why the bound may be too low, including unstated points.
    #[must_use]
    pub fn all_doubts(&self) -> Vec<Doubt> {
        let is_more = |points: &&UnstatedPoints| {
            points.most.as_ref().is_none_or(|most| most.more > Picos::ZERO)
        };
        let points = self.points.iter().filter(is_more).cloned().map(Doubt::Points);
        points.chain(self.doubts.iter().cloned()).collect()
    }

    /// The reasons that [`Audit::upper_with_all_points`] does not cover. Unstated points are not among them if the
    /// table says how many the CPU can have.
    #[must_use]
    pub fn uncounted_doubts(&self) -> Vec<Doubt> {
        let is_unknown = self.points.iter().any(|points| points.most.is_none());
        if is_unknown { self.all_doubts() } else { self.doubts.clone() }
    }
}
