//! What is proved about a problem so far, and when to stop.

use super::found::{Engine, Maximum};
use super::limits::Limits;
use super::problem::Problem;
use super::trace::{Step, Trace};
use scanbound_base::time::Picos;
use scanbound_model::{Assignment, Portion};
use std::time::Duration;

/// The two bounds of a running search. Both only ever get better.
pub struct Bounds<'a> {
    problem: &'a Problem,
    limits: &'a Limits<'a>,
    upper: u64,
    best: Option<(u64, Assignment)>,
    calls: u64,
    /// All items together less the weight of the cores found. The upper bound may be lower, since another search may
    /// have proved more.
    remaining: u64,
    engine: Engine,
    /// Kept if the limits ask for it.
    trace: Option<Trace>,
}

impl<'a> Bounds<'a> {
    /// Before any search: all items together above; below, all variables 0 if that is allowed.
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
        bounds.found(problem.zeros());
        bounds
    }

    /// The bounds of the scans of one case, which cost no more than `upper`. The best scan that is known counts, whichever
    /// case it is of: what costs no more is of no interest.
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

    /// Takes note of the best scan and the questions of a case.
    pub fn after_case(&mut self, case: Bounds<'_>) {
        self.calls += case.calls;
        if let Some((_, best)) = case.best {
            self.found(best);
        }
    }

    /// No scan costs more than this, in picoseconds.
    pub fn upper(&self) -> u64 {
        self.upper
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

    /// Takes note that every scan falsifies so much more weight. In a MaxSAT solver's words, the lower bound of the cost
    /// rises; here the upper bound of the time falls.
    pub fn falsified(&mut self, weight: u64) {
        self.remaining -= weight;
        // Of a case, no scan may be as dear as the best of another.
        self.proved(self.remaining.max(self.lower()));
    }

    /// All items together less the weight of the cores found.
    pub fn remaining(&self) -> u64 {
        self.remaining
    }

    /// How far the best scan is below what remains: a soft literal that weighs more is true in every better scan.
    pub fn gap(&self) -> u64 {
        self.remaining.saturating_sub(self.lower())
    }

    /// Takes note of who is searching.
    pub fn by(&mut self, engine: Engine) {
        self.engine = engine;
    }

    /// Takes note of a step, which is put together only if anyone wants to know.
    pub fn step(&mut self, step: impl FnOnce() -> Step) {
        if let Some(trace) = &mut self.trace {
            trace.push(step());
        }
    }

    /// Takes note of steps that were made elsewhere.
    pub fn steps(&mut self, steps: Trace) {
        if let Some(trace) = &mut self.trace {
            trace.append(steps);
        }
    }

    /// Takes note of what is known at the end of a round.
    pub fn round(&mut self) {
        let (upper, lower) = (Picos(self.upper), Picos(self.lower()));
        self.step(|| Step::Bounds { upper, lower });
    }

    /// Counts one more question to a solver.
    pub fn count(&mut self) {
        self.calls += 1;
    }

    /// Tells of a question and its answer.
    pub fn asked(&mut self, items: &[usize], total: u64, together: bool, time: Duration) {
        let (total, most) = (Picos(total), Picos(self.lower()));
        self.step(|| Step::Asked { items: items.to_vec(), total, together, time, most });
    }

    /// What ends the search.
    pub fn limits(&self) -> &'a Limits<'a> {
        self.limits
    }

    /// The result.
    pub fn finish(self) -> Maximum {
        let kept = self.best.is_some();
        let (lower, best) = self.best.unwrap_or_else(|| (0, self.problem.zeros()));
        let best = Portion(self.problem.variables.iter().copied().zip(best.0).collect());
        Maximum {
            upper: Picos(self.upper),
            lower: Picos(lower),
            best,
            kept,
            calls: self.calls,
            engine: self.engine,
            trace: self.trace.unwrap_or_default(),
        }
    }

    fn tell(&self) {
        (self.limits.progress)(Picos(self.upper), Picos(self.lower()));
    }
}
