//! BatSat as the SAT solver of the search by subsets, in builds without Z3.

use crate::Limits;
use crate::clauses::Clauses;
use crate::oracle::{Branching, Effort, Oracle};

/// The number of decisions that count as one conflict of a query's effort. Few queries about small groups need any.
const DECISIONS: u64 = 16;

/// Calls `work`. Nothing has to be prepared, because BatSat solvers are independent.
pub fn with_solver<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// A SAT solver with a set of clauses. Literals are those of [`Clauses`].
pub struct Sat(Oracle<'static>);

impl Sat {
    /// A solver with these clauses.
    pub fn new(clauses: &Clauses) -> Sat {
        let mut oracle = Oracle::new(&Limits::default(), Branching::All);
        clauses.clauses.iter().for_each(|clause| oracle.add(clause));
        Sat(oracle)
    }

    /// Whether all assumptions can be true together; `None` if this takes more than `effort` decisions, or a sixteenth
    /// as many conflicts.
    pub fn check(&mut self, assumptions: &[i32], effort: u32) -> Option<bool> {
        let decisions = u64::from(effort);
        self.0.ask(assumptions, Effort { decisions, conflicts: decisions / DECISIONS })
    }

    /// After a positive answer: the values of all variables.
    pub fn model(&self) -> impl Fn(i32) -> bool {
        |literal| self.0.holds(literal.abs())
    }

    /// After a negative answer: a subset of the assumptions that cannot be true together.
    pub fn core(&self, assumptions: &[i32]) -> Vec<i32> {
        let core = self.0.core();
        // The solver returns literals as they were assumed, or negated; both have the same variable.
        assumptions.iter().copied().filter(|l| core.iter().any(|c| c.abs() == l.abs())).collect()
    }
}
