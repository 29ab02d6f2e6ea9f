//! Searches the maximum of each group, until all are known, the limit is decided or the time is over.

use super::{Progress, Request};
use scanbound_base::time::Picos;
use scanbound_model::{Assignment, Charge, Group, GroupAssignment, ScanModel};
use scanbound_solve::trace::Trace;
use scanbound_solve::{Engine, Limits, Maximum, Method, maxima, methods};
use scanbound_timing::price::Prices;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The groups whose maxima are searched, and the limits of the search.
pub struct GroupSearch<'a> {
    /// The request, which gives the method, the limit to decide, the cancellation and the progress reports.
    pub request: &'a Request<'a>,
    /// The prices, which say how much time the points add that the CPU can have in addition to those charged.
    pub prices: &'a Prices,
    /// The model that the groups belong to.
    pub model: &'a ScanModel,
    /// The groups, the longest time first.
    pub groups: &'a [Group],
    /// The part of the scan time that is the same in every scan: the overhead, and the charges that belong to no group.
    pub constant: Picos,
    /// When the whole search ends. `None`: there is no time limit.
    pub deadline: Option<Instant>,
    /// If the upper bound of the scan is at least this time, it may be too low, so that the limit is not proved.
    /// `None`: the bound is never too low for this reason.
    pub doubtful_from: Option<Picos>,
}

/// The best bounds of each group so far, and their sums.
struct GroupBounds {
    /// Each group's upper and lower bound.
    bounds: Vec<(Picos, Picos)>,
    /// The sum of the groups' upper bounds.
    upper: Picos,
    /// The sum of the groups' lower bounds.
    lower: Picos,
    /// The number of groups whose bounds are equal.
    solved: usize,
}

impl GroupBounds {
    fn new(bounds: Vec<(Picos, Picos)>) -> GroupBounds {
        let upper = bounds.iter().map(|bounds| bounds.0).sum();
        let lower = bounds.iter().map(|bounds| bounds.1).sum();
        let solved = bounds.iter().filter(|(upper, lower)| upper == lower).count();
        GroupBounds { bounds, upper, lower, solved }
    }

    /// Records a group's new bounds. Returns whether its lower bound rose: a longer scan is known now.
    fn record(&mut self, group: usize, upper: Picos, lower: Picos) -> bool {
        // The sums are updated incrementally, as there may be many groups.
        let old = std::mem::replace(&mut self.bounds[group], (upper, lower));
        let without = |sum: Picos, old| sum.checked_sub(old).unwrap_or_default();
        self.upper = without(self.upper, old.0) + upper;
        self.lower = without(self.lower, old.1) + lower;
        self.solved = self.solved + usize::from(upper == lower) - usize::from(old.0 == old.1);
        lower > old.1
    }
}

fn is_open(maximum: &Maximum) -> bool {
    maximum.lower < maximum.upper
}

/// Replaces the bounds in `known` by those of a later search where these are better.
fn improve(known: &mut Maximum, again: Maximum) {
    let calls = known.calls + again.calls;
    let upper = known.upper.min(again.upper);
    if again.lower >= known.lower {
        *known = again;
    }
    (known.calls, known.upper) = (calls, upper);
}

impl GroupSearch<'_> {
    /// The maximum of every group, in the order of the groups, and whether the search ended early because it was
    /// decided whether a scan exceeds the request's limit.
    ///
    /// With a limit, the groups are searched in rounds: the largest alone, then two, then four, and so on. What is
    /// known between two rounds does not depend on the order of the threads. The same is true when the search of one
    /// group has found a longer scan, since its threads have then synchronised. Only at these points is it checked
    /// whether the limit is decided, so that every run ends with the same bounds.
    pub fn run(&self) -> (Vec<Maximum>, bool) {
        let largest = |group: &Group| {
            let times =
                group.charges.iter().map(|&charge| self.model.charges[charge].largest_cost());
            (times.sum::<Picos>(), Picos::ZERO)
        };
        let known = Mutex::new(GroupBounds::new(self.groups.iter().map(largest).collect()));
        let stop = AtomicBool::new(false);
        let cancelled = || stop.load(Ordering::Relaxed) || (self.request.cancelled)();
        let methods = methods(self.groups, self.request.method);
        let mut found = Vec::with_capacity(self.groups.len());
        for round in self.rounds() {
            if known.lock().is_ok_and(|known| self.decided(&known)) {
                stop.store(true, Ordering::Relaxed);
            }
            let alone = round.len() == 1;
            let each = |group: usize, upper: Picos, lower: Picos| {
                let Ok(mut known) = known.lock() else { return };
                let better = known.record(round.start + group, upper, lower);
                if better && alone && self.decided(&known) {
                    stop.store(true, Ordering::Relaxed);
                }
                self.report_progress(round.start + group, &known);
            };
            let deadline = self.deadline.map(|end| self.deadline_of_round(&round, end));
            let trace = self.request.trace;
            let limits = Limits { deadline, cancelled: &cancelled, trace, ..Limits::default() };
            let (groups, methods) = (&self.groups[round.clone()], &methods[round.clone()]);
            found.extend(maxima(self.model, groups, methods, &limits, &each));
        }
        self.search_again(&mut found, &methods, &known, &cancelled);
        let open = found.iter().any(is_open);
        (found, open && stop.into_inner())
    }

    /// Searches the undecided groups again in the time that the other groups did not use. Without a deadline, nothing
    /// is searched again.
    fn search_again(
        &self,
        found: &mut [Maximum],
        methods: &[Method],
        known: &Mutex<GroupBounds>,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) {
        let Some(end) = self.deadline else { return };
        loop {
            let open: Vec<usize> =
                (0..found.len()).filter(|&group| is_open(&found[group])).collect();
            let start = Instant::now();
            if open.is_empty() || cancelled() || start >= end {
                return;
            }
            let groups: Vec<Group> = open.iter().map(|&group| self.groups[group].clone()).collect();
            let methods: Vec<Method> = open.iter().map(|&group| methods[group]).collect();
            let each = |group: usize, upper: Picos, lower: Picos| {
                let Ok(mut known) = known.lock() else { return };
                let (most, least) = known.bounds[open[group]];
                known.record(open[group], upper.min(most), lower.max(least));
                self.report_progress(open[group], &known);
            };
            let (deadline, trace) = (Some(end), self.request.trace);
            let limits = Limits { deadline, cancelled, trace, ..Limits::default() };
            let again = maxima(self.model, &groups, &methods, &limits, &each);
            for (&group, again) in open.iter().zip(again) {
                improve(&mut found[group], again);
            }
            // A search that ended before its time limit without a decision would do so again.
            if start.elapsed() < (end - start) / 2
                && found.iter().filter(|one| is_open(one)).count() == open.len()
            {
                return;
            }
        }
    }

    /// For the structural bound, in place of a search: the upper bound of each group is the sum of the larger times of
    /// its charges, its lower bound the time with all variables 0. The second result is always false.
    pub fn sums(&self) -> (Vec<Maximum>, bool) {
        let zeros = Assignment(vec![0; self.model.variables.len()]);
        let values = self.model.circuit.evaluate(&zeros);
        let sum = |group: &Group| {
            let charges = || group.charges.iter().map(|&charge| &self.model.charges[charge]);
            let mut constraints = group.constraints.iter();
            Maximum {
                upper: charges().map(Charge::largest_cost).sum(),
                lower: charges().map(|charge| charge.cost(&values)).sum(),
                best: GroupAssignment::default(),
                feasible: constraints.all(|&holds| values.get(self.model.constraints[holds])),
                calls: 0,
                engine: Engine::Cores,
                trace: Trace::default(),
            }
        };
        (self.groups.iter().map(sum).collect(), false)
    }

    /// The ranges of groups that are searched in parallel, one range for each round. Without a limit to decide, there
    /// is one round.
    fn rounds(&self) -> Vec<Range<usize>> {
        let count = self.groups.len();
        let mut size = if self.request.limit.is_some() { 1 } else { count };
        let mut rounds: Vec<Range<usize>> = Vec::new();
        let mut start = 0;
        while start < count {
            let end = start.saturating_add(size).min(count);
            rounds.push(start..end);
            start = end;
            size *= 2;
        }
        rounds
    }

    /// Whether it is decided if some scan exceeds the limit, for any number of points that the CPU can have. False if
    /// there is no limit.
    fn decided(&self, known: &GroupBounds) -> bool {
        let Some(limit) = self.request.limit else { return false };
        let (upper, lower) = (self.constant + known.upper, self.constant + known.lower);
        let doubtful = self.doubtful_from.is_some_and(|least| upper >= least);
        let within_limit = upper + self.prices.more_points() <= limit && !doubtful;
        within_limit
            || lower.checked_sub(self.prices.uncertain_refresh()).is_some_and(|lower| lower > limit)
    }

    fn report_progress(&self, group: usize, known: &GroupBounds) {
        (self.request.progress)(Progress::Bounds {
            group: group + 1,
            upper: self.constant + known.upper,
            lower: self.constant + known.lower,
            solved: known.solved,
            groups: self.groups.len(),
        });
    }

    /// The moment at which a round must end, so that later rounds get time in proportion to their charges. `end` is the
    /// end of the whole search.
    fn deadline_of_round(&self, round: &Range<usize>, end: Instant) -> Instant {
        let charges = |groups: &[Group]| -> usize {
            groups.iter().map(|group| group.charges.len() + 1).sum()
        };
        let (own, later) =
            (charges(&self.groups[round.clone()]), charges(&self.groups[round.end..]));
        let rest = end.saturating_duration_since(Instant::now()).as_nanos();
        let own = rest * own as u128 / (own + later) as u128;
        let own = Duration::from_nanos(u64::try_from(own).unwrap_or(u64::MAX));
        if later == 0 { end } else { Instant::now() + own }
    }
}
