//! What is proved about a problem so far, and when to stop.

use super::{Limits, Maximum, Problem};
use crate::model::Assignment;
use crate::time::Picos;

/// The two bounds of a running search. Both only ever get better.
pub struct Bounds<'a> {
    problem: &'a Problem,
    limits: &'a Limits<'a>,
    upper: u64,
    best: Option<(u64, Assignment)>,
    calls: u64,
}

impl<'a> Bounds<'a> {
    /// Before any search: all items together above; below, all variables 0 if that is allowed.
    pub fn new(problem: &'a Problem, limits: &'a Limits<'a>) -> Bounds<'a> {
        let mut bounds = Bounds { problem, limits, upper: problem.naive(), best: None, calls: 0 };
        bounds.found(problem.zeros());
        bounds
    }

    /// The best assignment's cost, in picoseconds; 0 as long as none is known.
    pub fn lower(&self) -> u64 {
        self.best.as_ref().map_or(0, |best| best.0)
    }

    /// Whether an assignment is known that costs as much as any can.
    pub fn exact(&self) -> bool {
        self.best.as_ref().is_some_and(|best| best.0 == self.upper)
    }

    /// Takes note of an assignment.
    pub fn found(&mut self, assignment: Assignment) {
        if let Some(cost) = self.problem.cost(&assignment)
            && self.best.as_ref().is_none_or(|best| best.0 < cost)
        {
            debug_assert!(cost <= self.upper, "an assignment above the upper bound");
            self.best = Some((cost, assignment));
            self.tell();
        }
    }

    /// Takes note that no assignment costs more than this.
    pub fn proved(&mut self, upper: u64) {
        if upper < self.upper {
            debug_assert!(upper >= self.lower(), "an upper bound below an assignment");
            self.upper = upper;
            self.tell();
        }
    }

    /// Takes note that the upper bound falls by so many picoseconds.
    pub fn lost(&mut self, weight: u64) {
        self.proved(self.upper - weight);
    }

    /// How far the bounds are apart, in picoseconds.
    pub fn gap(&self) -> u64 {
        self.upper - self.lower()
    }

    /// Counts one more question to a solver.
    pub fn count(&mut self) {
        self.calls += 1;
    }

    /// Tells of a question and its answer.
    pub fn asked(&self, items: &[usize], answer: bool) {
        let charges =
            items.iter().flat_map(|&item| self.problem.items[item].charges.iter().copied());
        let mut charges: Vec<usize> = charges.collect();
        charges.sort_unstable();
        charges.dedup();
        (self.limits.asked)(&charges, answer);
    }

    /// What ends the search.
    pub fn limits(&self) -> &'a Limits<'a> {
        self.limits
    }

    /// The result.
    pub fn finish(self) -> Maximum {
        let (lower, best) = self.best.unwrap_or_else(|| (0, self.problem.zeros()));
        Maximum { upper: Picos(self.upper), lower: Picos(lower), best, calls: self.calls }
    }

    fn tell(&self) {
        (self.limits.progress)(Picos(self.upper), Picos(self.lower()));
    }
}
