//! A satisfiability solver that answers one question after another about a growing set of clauses.

use super::Limits;
use batsat::callbacks::Callbacks;
use batsat::{Lit, Solver, SolverInterface, SolverOpts, Var, lbool};
use std::cell::Cell;

/// How many decisions there are between two looks at the clock.
const LOOK: u64 = 1 << 12;

/// Ends a question that takes too many decisions, or too long.
struct Effort<'a> {
    limits: &'a Limits<'a>,
    decisions: Cell<u64>,
    most: u64,
    /// The question has been ended. The solver asks more than once before it stops, and goes on at any no.
    ended: Cell<bool>,
}

impl Callbacks for Effort<'_> {
    /// The solver asks before each of its decisions.
    fn stop(&self) -> bool {
        let decisions = self.decisions.get() + 1;
        self.decisions.set(decisions);
        let looks = decisions.is_multiple_of(LOOK);
        if let (true, Some(left)) = (looks, self.limits.decisions) {
            left.spend(LOOK);
        }
        if decisions > self.most || (looks && self.limits.reached()) {
            self.ended.set(true);
        }
        self.ended.get()
    }
}

/// Literals are as in DIMACS files: a variable (from 1) or its negative. The solver knows only the variables
/// that occur, under numbers of its own.
pub struct Oracle<'a> {
    solver: Solver<Effort<'a>>,
    inner: Vec<Option<Var>>,
    outer: Vec<i32>,
}

impl<'a> Oracle<'a> {
    pub fn new(limits: &'a Limits<'a>) -> Oracle<'a> {
        let effort = Effort { limits, decisions: Cell::new(0), most: 0, ended: Cell::new(false) };
        let solver = Solver::new(SolverOpts::default(), effort);
        Oracle { solver, inner: Vec::new(), outer: Vec::new() }
    }

    /// What holds from now on.
    pub fn add(&mut self, clause: &[i32]) {
        let mut clause = self.translate(clause);
        self.solver.add_clause_reuse(&mut clause);
    }

    /// A variable whose value follows from others', or does not matter: the solver need not choose it. To
    /// be told before the variable occurs.
    pub fn define(&mut self, variable: i32) {
        self.variable(variable, false);
    }

    /// Whether all assumptions can hold together; `None` if that takes more than so many decisions (each
    /// assumption may be one) or the limits are reached.
    pub fn ask(&mut self, assumptions: &[i32], decisions: u64) -> Option<bool> {
        let assumptions = self.translate(assumptions);
        let effort = self.solver.cb_mut();
        if let Some(left) = effort.limits.decisions {
            // What the question before took since it was looked at last.
            left.spend(effort.decisions.get() % LOOK);
        }
        effort.decisions.set(0);
        effort.ended.set(false);
        effort.most = decisions;
        match self.solver.solve_limited(&assumptions) {
            answer if answer == lbool::TRUE => Some(true),
            answer if answer == lbool::FALSE => Some(false),
            _ => None,
        }
    }

    /// After the answer no: assumptions that cannot hold together.
    pub fn core(&self) -> Vec<i32> {
        let refuted = self.solver.unsat_core().iter();
        refuted
            .map(|lit| {
                let variable = self.outer[lit.var().idx() as usize];
                if lit.sign() { -variable } else { variable }
            })
            .collect()
    }

    /// After the answer yes: whether the literal holds in the model found. A variable that occurs nowhere
    /// is false.
    pub fn holds(&self, literal: i32) -> bool {
        let variable = self.inner.get(literal.unsigned_abs() as usize).copied().flatten();
        let value = variable.map_or(lbool::FALSE, |variable| self.solver.value_var(variable));
        (value == lbool::TRUE) == (literal > 0)
    }

    fn translate(&mut self, literals: &[i32]) -> Vec<Lit> {
        literals
            .iter()
            .map(|&literal| Lit::new(self.variable(literal, true), literal > 0))
            .collect()
    }

    fn variable(&mut self, literal: i32, chosen: bool) -> Var {
        let place = literal.unsigned_abs() as usize;
        if self.inner.len() <= place {
            self.inner.resize(place + 1, None);
        }
        *self.inner[place].get_or_insert_with(|| {
            self.outer.push(literal.abs());
            self.solver.new_var(lbool::UNDEF, chosen)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_end_a_hard_question() {
        let limits = Limits { cancelled: &|| true, ..Limits::default() };
        let mut oracle = Oracle::new(&limits);
        // Eleven pigeons in ten holes: the solver needs far more decisions than it makes between two looks.
        let (pigeons, holes) = (11, 10);
        let sits = |pigeon: i32, hole: i32| 1 + pigeon * holes + hole;
        for pigeon in 0..pigeons {
            oracle.add(&(0..holes).map(|hole| sits(pigeon, hole)).collect::<Vec<_>>());
        }
        for hole in 0..holes {
            for pigeon in 0..pigeons {
                for other in 0..pigeon {
                    oracle.add(&[-sits(pigeon, hole), -sits(other, hole)]);
                }
            }
        }
        assert_eq!(oracle.ask(&[], u64::MAX), None);
    }
}
