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
    /// The program files, as the user named them, in the order of execution.
    pub files: Vec<String>,
    /// Indices into `files` of the files that contain only subroutines, which run only if they are called.
    pub standby: Vec<usize>,
    /// The program and comment files, the timing table and the facts file from which the audit was made, each with a
    /// checksum.
    pub sources: Vec<Source>,
    /// The name of the dialect in which the programs are written.
    pub dialect: String,
    /// The CPU that the user names, otherwise the one that the source names. `None` if neither names one.
    pub cpu: Option<String>,
    /// The number of instructions in the source of all files.
    pub instructions: usize,
    /// The number of rungs in all files.
    pub blocks: u32,
    /// The number of program words in a scan, for a PLC that executes one word per clock period. `None` for other PLCs.
    pub clocked: Option<u64>,
    /// The timing table, and which of its times are uncertain.
    pub table: TableUse,
    /// The bounds of the scan time, without the wait for a constant scan time.
    pub bound: Bound,
    /// The constant scan: the minimum scan time that the CPU, the program or the user sets, if any.
    pub cycle: Cycle,
    /// Whether an instruction of the program may let interrupts wait beyond the end of a scan, so that one more may run
    /// in the next scan.
    pub holds_interrupts: bool,
    /// The watchdog time, and the longest time between two restarts of the watchdog.
    pub watchdog: Watchdog,
    /// The times that every scan takes in addition to its instructions, such as END processing: one entry for each
    /// term.
    pub overhead: Vec<OverheadUse>,
    /// The charges whose time is the same in every scan. They belong to no group.
    pub always: Vec<ChargeUse>,
    /// The groups of charges that share free variables, numbered from 1. The times of two groups do not depend on each
    /// other.
    pub groups: Vec<GroupUse>,
    /// The values with which the scan starts that takes `Bound::lower`, and its nondeterministic values.
    pub witness: Vec<FreeValue>,
    /// The time of the model's scan that has the values of `witness`. Each [`FreeValue::worth`] is a part of it. It can
    /// be longer than the scan found, because the simulation of that one may have stopped early.
    pub weighed: Picos,
    /// The scans of a run from power-up to one that takes `Bound::lower`. Empty if no such run was found.
    pub witness_run: Vec<RunScan>,
    /// The areas of which the scan of `Bound::lower` needs more devices than each CPU has that can run the program: the
    /// letters of each, and how many it needs.
    pub needed_devices: Vec<(String, u32)>,
    /// Why no simulated scan was found that takes as long as the model's longest scan (`Bound::model`), as a text for
    /// reports. `None` if one was found.
    pub stands_between: Option<String>,
    /// The instructions with a time that the scan of `Bound::lower` executes, in order. Only for flowcharts and charts,
    /// which are shown as a path; otherwise empty.
    pub path: Vec<PathStep>,
    /// Loops that a scan can reach and for which no end is known. If there are any, no time is a bound: all figures are
    /// then for scans that end after such a loop ran once.
    pub unbounded: Vec<LoopUse>,
    /// The user's statements that the audit used, in the order of reports.
    pub facts: Vec<Fact>,
    /// Inputs or outputs for which the number of refreshed points is not stated. The points that the program uses were
    /// charged.
    pub points: Vec<UnstatedPoints>,
    /// Inputs or outputs whose base units are not stated. The slowest base was charged.
    pub bases: Vec<UnstatedBase>,
    /// Network devices that the program uses and whose refresh time is not stated. The bound does not include that
    /// time.
    pub networks: Vec<NetworkUse>,
    /// Reasons besides `points` why the bound may be too low: mostly facts that the bound needs and that are not
    /// stated.
    pub doubts: Vec<Doubt>,
    /// Values of words and relays at the start of a scan that the audit derived and used. They hold only if the program
    /// alone writes these words and relays.
    pub assumptions: Vec<Assumption>,
    /// Values on which the bound depends and of which little is known: numbers of iterations or units, and targets of
    /// writes. Each comes with a fact that the user could state.
    pub unknowns: Vec<Unknown>,
    /// The bounds of further audits in which the counts in `unknowns` are limited, or in which assumptions are dropped.
    /// `None` if that was not requested.
    pub what_if: Option<WhatIf>,
    /// The bound if steps and stored actions of charts were not mutually exclusive. `None` if there are no charts, or
    /// if that was not computed.
    pub coactivity: Option<Coactivity>,
    /// The task whose scan is bounded, if the project has several.
    pub bounded_task: Option<String>,
    /// The tasks of the project, the one whose scan is bounded first. Empty if there is only one, or if that was not
    /// requested.
    pub tasks: Vec<TaskUse>,
    /// How an S-net's sets of mutually exclusive elements change the bound. `None` if that was not requested.
    pub net: Option<NetBound>,
    /// The rungs for drawing. `None` if they were not requested.
    pub ladder: Option<Ladder>,
    /// Places where the model allows more behaviour than the PLC has, sorted by place.
    pub approximations: Vec<ApproximationUse>,
    /// What some controllers do in another way than the standard has it, as far as this program depends on it and the
    /// facts do not state it.
    pub readings: Vec<String>,
    /// How many statements of the source are followed exactly. `None` if the front lists no statements.
    pub exactness: Option<Exactness>,
    /// Warnings: findings that did not stop the audit.
    pub warnings: Vec<Diagnostic>,
    /// The worst-case time from the change of an input to that of an output. `None` if it was not requested.
    pub response: Option<response::Response>,
    /// Which writers between scans the bound takes into account.
    pub trust: scanbound_passes::values::Trust,
    /// Whether the search ended early because it was already decided whether any scan exceeds the requested limit.
    pub ended_early: bool,
    /// The stages that the time limit or the user ended early, and what they left open. Empty if every stage was
    /// finished.
    pub cuts: Vec<EarlyStop>,
    /// The command line arguments that name the project, quoted for a shell. Empty if none is needed.
    pub named: String,
    /// How long the audit took.
    pub elapsed: Duration,
}

impl Audit {
    /// The time of the longest scan that is known to be possible by the table. This is `Bound::lower`; for a PLC with a
    /// clock (`clocked`) without the clock's tolerance, since no scan is known to need that.
    #[must_use]
    pub fn possible(&self) -> Picos {
        possible(&self.bound, self.table.factor.as_ref(), self.clocked.is_some())
    }

    /// Whether a scan was found that stays in a loop for ever. Loops for which merely no end is known do not count.
    #[must_use]
    pub fn is_endless(&self) -> bool {
        self.unbounded.iter().any(|one| one.certain)
    }

    /// Whether a run from power-up to the scan that takes `Bound::lower` was found (`witness_run`).
    #[must_use]
    pub fn is_reached(&self) -> bool {
        !self.witness_run.is_empty()
    }

    /// The upper bound if all points that the CPU can have are refreshed. This applies only to inputs or outputs whose
    /// number is not stated and for which the table gives the largest number.
    #[must_use]
    pub fn upper_with_all_points(&self) -> Picos {
        self.bound.upper + more_points(&self.points)
    }

    /// [`possible`](Audit::possible) without the refresh time of points whose number is not stated. Where only the base
    /// unit is not stated, the fastest one is assumed.
    #[must_use]
    pub fn lower_without_points(&self) -> Picos {
        let uncertain = uncertain_refresh(&self.points, &self.bases);
        self.possible().checked_sub(uncertain).unwrap_or_default()
    }

    /// [`possible`](Audit::possible) with the points that were charged, stated or not. Where the base unit is not
    /// stated, the fastest one is assumed.
    #[must_use]
    pub fn lower_on_least_bases(&self) -> Picos {
        let saves = self.bases.iter().map(|base| base.saves).sum();
        self.possible().checked_sub(saves).unwrap_or_default()
    }

    /// The shortest limit on the execution time that a check without a margin proves: the upper bound with all points
    /// that the CPU can have. `None` if the bound may be too low for another reason, or a loop may never end.
    #[must_use]
    pub fn proved(&self) -> Option<Picos> {
        let is_proved = self.unbounded.is_empty() && self.uncounted_doubts().is_empty();
        is_proved.then(|| self.upper_with_all_points())
    }

    /// A time divided by the table's factor on the whole scan, rounded up. Unchanged if the table has no factor.
    #[must_use]
    pub fn bare(&self, time: Picos) -> Picos {
        let factor = self.table.factor.as_ref();
        factor.map_or(time, |factor| scanbound_timing::table::taken_off(factor.millionths, time))
    }

    /// Splits the groups into those that matter and the others. The first part has at most `most` groups, and ends
    /// before the first group whose upper bound is less than 0.5 % of the whole bound.
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
    /// The time that every scan takes by the model: overhead and the charges whose time is the same in every scan,
    /// without refresh that may not occur and without the table's factor. A number of units that is unknown counts as
    /// charged.
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
    /// The upper bound on the scan time, including the wait for the constant scan time and the interrupts at its end.
    /// Unstated points count as charged.
    #[must_use]
    pub fn cycle_upper(&self) -> Picos {
        self.bound.upper.max(self.cycle.longest().unwrap_or_default())
    }

    /// As [`cycle_upper`](Audit::cycle_upper), but with all points that the CPU can have where their number is not
    /// stated.
    #[must_use]
    pub fn cycle_with_all_points(&self) -> Picos {
        self.upper_with_all_points().max(self.cycle.longest().unwrap_or_default())
    }

    /// A lower bound on the longest scan time, including the wait for the constant scan time.
    #[must_use]
    pub fn cycle_lower(&self) -> Picos {
        self.possible().max(self.cycle.lower.unwrap_or_default())
    }

    /// As [`cycle_lower`](Audit::cycle_lower), but without the refresh time of points whose number is not stated, and
    /// with the fastest base unit where none is stated.
    #[must_use]
    pub fn cycle_without_points(&self) -> Picos {
        self.lower_without_points().max(self.cycle.lower.unwrap_or_default())
    }
}

impl Audit {
    /// All reasons why the bound may be too low: `doubts`, after unstated points. Points are left out if the table
    /// shows that more of them would add no time.
    #[must_use]
    pub fn all_doubts(&self) -> Vec<Doubt> {
        let is_more = |points: &&UnstatedPoints| {
            points.most.as_ref().is_none_or(|most| most.more > Picos::ZERO)
        };
        let points = self.points.iter().filter(is_more).cloned().map(Doubt::Points);
        points.chain(self.doubts.iter().cloned()).collect()
    }

    /// The reasons why even [`Audit::upper_with_all_points`] may be too low. These are `doubts` alone, if the table
    /// gives the largest number of all unstated points; otherwise [`Audit::all_doubts`].
    #[must_use]
    pub fn uncounted_doubts(&self) -> Vec<Doubt> {
        let is_unknown = self.points.iter().any(|points| points.most.is_none());
        if is_unknown { self.all_doubts() } else { self.doubts.clone() }
    }
}
