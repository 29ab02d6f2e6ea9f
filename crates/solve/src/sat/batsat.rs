//! BatSat as the satisfiability solver of the search by subsets, in builds without Z3.

use crate::Limits;
use crate::clauses::Clauses;
use crate::oracle::{Branching, Effort, Oracle};

/// How many decisions make up one conflict of a question's effort. Few questions about small groups take any.
const DECISIONS: u64 = 16;

/// Nothing needs to be prepared: each solver stands by itself.
pub fn with_solver<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// A set of clauses that answers questions. Literals are those of [`Clauses`].
pub struct Sat(Oracle<'static>);

impl Sat {
    /// Clauses that hold in every answer.
    pub fn new(clauses: &Clauses) -> Sat {
        let mut oracle = Oracle::new(&Limits::default(), Branching::All);
        clauses.clauses.iter().for_each(|clause| oracle.add(clause));
        Sat(oracle)
    }

    /// Whether all assumptions can hold together; `None` if that takes more decisions than this effort.
    pub fn check(&mut self, assumptions: &[i32], effort: u32) -> Option<bool> {
        let decisions = u64::from(effort);
        self.0.ask(assumptions, Effort { decisions, conflicts: decisions / DECISIONS })
    }

    /// After the answer yes: the values of all variables.
    pub fn model(&self) -> impl Fn(i32) -> bool {
        |literal| self.0.holds(literal.abs())
    }

    /// After the answer no: assumptions that cannot hold together.
    pub fn core(&self, assumptions: &[i32]) -> Vec<i32> {
        let core = self.0.core();
        // The solver names literals as they were assumed, or their opposites: both name the same variable.
        assumptions.iter().copied().filter(|l| core.iter().any(|c| c.abs() == l.abs())).collect()
    }
}
