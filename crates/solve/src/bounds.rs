//! The bounds of a problem that are proved so far, and when to stop.

use super::found::{Engine, Maximum};
use super::limits::Limits;
use super::problem::Problem;
use super::trace::{Step, Trace};
use scanbound_base::time::Picos;
use scanbound_model::{Assignment, GroupAssignment};
use std::time::Duration;

/// The upper and the lower bound of a running search, in picoseconds. They only become tighter.
pub struct Bounds<'a> {
    problem: &'a Problem,
    limits: &'a Limits<'a>,
    upper: u64,
    best: Option<(u64, Assignment)>,
    calls: u64,
    /// The cost of all items together minus the weights of the cores found, in picoseconds. The upper bound may be
    /// lower, if another search has proved more.
    remaining: u64,
    engine: Engine,
    /// The trace, if requested.
    trace: Option<Trace>,
}

impl<'a> Bounds<'a> {
    /// The bounds before any search. Upper: all items together. Lower: all variables 0, if the constraints allow it.
    pub fn new(problem: &'a Problem, limits: &'a Limits<'a>) -> Bounds<'a> {
        let naive = problem.naive();
        let mut bounds = Bounds {
            problem,
            limits,
            upper: naive,
            best: None,
            calls: 0,
            remaining: naive,
            engine: Engine::Cores,
            trace: limits.trace.then(Trace::default),
        };
        bounds.record_assignment(problem.zeros());
        bounds
    }

    /// The bounds for one case of a search case by case, whose scans cost at most `upper`. The best scan found so far
    /// is included even if it belongs to another case, because only longer ones are of interest.
    pub fn of_case(&self, limits: &'a Limits<'a>, upper: u64) -> Bounds<'a> {
        Bounds {
            limits,
            upper: upper.max(self.lower()),
            best: self.best.clone(),
            calls: 0,
            remaining: upper,
            trace: None,
            ..*self
        }
    }

    /// Takes over the best scan of a case that was searched, and adds its number of queries.
    pub fn after_case(&mut self, case: Bounds<'_>) {
        self.calls += case.calls;
        if let Some((_, best)) = case.best {
            self.record_assignment(best);
        }
    }

    /// The upper bound in picoseconds.
    pub fn upper(&self) -> u64 {
        self.upper
    }

    /// The cost of the best assignment in picoseconds; 0 if none is known.
    pub fn lower(&self) -> u64 {
        self.best.as_ref().map_or(0, |best| best.0)
    }

    /// Whether the maximum is known: an assignment was found that costs the upper bound.
    pub fn exact(&self) -> bool {
        self.best.as_ref().is_some_and(|best| best.0 == self.upper)
    }

    /// Records an assignment if it satisfies the constraints and costs more than the best one so far.
    pub fn record_assignment(&mut self, assignment: Assignment) {
        if let Some(cost) = self.problem.cost(&assignment)
            && self.best.as_ref().is_none_or(|best| best.0 < cost)
        {
            debug_assert!(cost <= self.upper, "an assignment costs more than the upper bound");
            self.best = Some((cost, assignment));
            self.report_progress();
        }
    }

    /// Records that no assignment costs more than this (picoseconds). Changes nothing if the upper bound is already as
    /// low.
    pub fn record_upper(&mut self, upper: u64) {
        if upper < self.upper {
            debug_assert!(
                upper >= self.lower(),
                "an upper bound is less than the cost of an assignment"
            );
            self.upper = upper;
            self.report_progress();
        }
    }

    /// Records that in every scan guards with this much more weight are false. In terms of MaxSAT, the lower bound of
    /// the cost rises; here the upper bound of the time falls.
    pub fn falsified(&mut self, weight: u64) {
        self.remaining -= weight;
        // Within a case, the upper bound must not fall below the best scan, which may belong to another case.
        self.record_upper(self.remaining.max(self.lower()));
    }

    /// The cost of all items together minus the weights of the cores found, in picoseconds.
    pub fn remaining(&self) -> u64 {
        self.remaining
    }

    /// The difference between `remaining` and the cost of the best scan. A soft literal that weighs more than this is
    /// true in every better scan.
    pub fn gap(&self) -> u64 {
        self.remaining.saturating_sub(self.lower())
    }

    /// Records which search is running.
    pub fn set_engine(&mut self, engine: Engine) {
        self.engine = engine;
    }

    /// Adds a step to the trace; `step` is called only if a trace is requested.
    pub fn step(&mut self, step: impl FnOnce() -> Step) {
        if let Some(trace) = &mut self.trace {
            trace.push(step());
        }
    }

    /// Adds the steps of another search to the trace, if one is requested.
    pub fn steps(&mut self, steps: Trace) {
        if let Some(trace) = &mut self.trace {
            trace.append(steps);
        }
    }

    /// Adds the current bounds to the trace, at the end of a round.
    pub fn round(&mut self) {
        let (upper, lower) = (Picos(self.upper), Picos(self.lower()));
        self.step(|| Step::Bounds { upper, lower });
    }

    /// Raises the number of queries to a solver by one.
    pub fn count(&mut self) {
        self.calls += 1;
    }

    /// Adds to the trace that the search by subsets asked whether these items can be true together, with their cost
    /// `total` (picoseconds), the answer, and the time that the query took.
    pub fn record_query(&mut self, items: &[usize], total: u64, together: bool, time: Duration) {
        let (total, most) = (Picos(total), Picos(self.lower()));
        self.step(|| Step::Asked { items: items.to_vec(), total, together, time, most });
    }

    /// The limits of the search.
    pub fn limits(&self) -> &'a Limits<'a> {
        self.limits
    }

    /// The result of the search with the bounds proved so far. Without an assignment, the lower bound is 0 and the best
    /// assignment all zeros.
    pub fn finish(self) -> Maximum {
        let feasible = self.best.is_some();
        let (lower, best) = self.best.unwrap_or_else(|| (0, self.problem.zeros()));
        let best = GroupAssignment(self.problem.variables.iter().copied().zip(best.0).collect());
        Maximum {
            upper: Picos(self.upper),
            lower: Picos(lower),
            best,
            feasible,
            calls: self.calls,
            engine: self.engine,
            trace: self.trace.unwrap_or_default(),
        }
    }

    fn report_progress(&self) {
        (self.limits.progress)(Picos(self.upper), Picos(self.lower()));
    }
}
