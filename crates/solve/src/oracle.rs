//! A SAT solver that answers queries about a growing set of clauses.

use super::limits::Limits;
use batsat::callbacks::Callbacks;
use batsat::clause::Kind;
use batsat::{Lit, Solver, SolverInterface, SolverOpts, Var, lbool};
use std::cell::Cell;

/// The number of decisions after which the solver checks the clock again.
const LOOK: u64 = 1 << 12;

/// The variables on which the solver branches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branching {
    /// Only variables that are not defined by others. Most queries about a scan are easy, and satisfiable ones are
    /// answered fastest this way.
    Inputs,
    /// All variables. Hard refutations need lemmas about defined variables: a query about 40,000 instructions that took
    /// 20 s otherwise takes 0.1 s.
    All,
}

/// The largest effort of one query; a query that needs more gets no answer.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// The largest number of decisions (guesses of a variable's value); each assumption may cost one.
    pub decisions: u64,
    /// The largest number of conflicts (decisions that turned out to be wrong together).
    pub conflicts: u64,
}

impl Effort {
    /// No limit.
    pub const ANY: Effort = Effort::decisions(u64::MAX);

    /// A limit on decisions only.
    pub const fn decisions(decisions: u64) -> Effort {
        Effort { decisions, conflicts: u64::MAX }
    }
}

/// Stops a query that exceeds its effort or the limits.
struct StopCheck<'a> {
    limits: Limits<'a>,
    decisions: Cell<u64>,
    conflicts: u64,
    most: Effort,
    /// Whether the query was stopped. Stored, because the solver asks several times and would continue if one answer
    /// were false.
    ended: Cell<bool>,
}

impl Callbacks for StopCheck<'_> {
    fn on_new_clause(&mut self, _: &[Lit], _: Kind) {
        self.conflicts += 1;
    }

    /// Called by the solver before each decision.
    fn stop(&self) -> bool {
        let decisions = self.decisions.get() + 1;
        self.decisions.set(decisions);
        let looks = decisions.is_multiple_of(LOOK);
        if let (true, Some(left)) = (looks, self.limits.decisions) {
            left.spend(LOOK);
        }
        let enough = decisions > self.most.decisions || self.conflicts > self.most.conflicts;
        if enough || (looks && self.limits.reached()) {
            self.ended.set(true);
        }
        self.ended.get()
    }
}

/// A solver with a set of clauses. Literals are integers as in DIMACS files: a variable (from 1) or its negative. The
/// solver uses its own numbers, and only for variables that occur.
pub struct Oracle<'a> {
    solver: Solver<StopCheck<'a>>,
    branching: Branching,
    /// For each variable, the value to try first; may be shorter than the list of variables.
    hints: &'a [bool],
    inner: Numbers,
    outer: Vec<i32>,
}

/// The number of variables in one page of the table.
const PAGE: usize = 512;

/// Maps variables to the solver's numbers. A small part of a large program has few variables with widely spread
/// numbers, so the table is divided into pages, most of which are never allocated.
#[derive(Default)]
struct Numbers(Vec<Option<Box<[Option<Var>; PAGE]>>>);

impl Numbers {
    fn get(&self, variable: usize) -> Option<Var> {
        self.0.get(variable / PAGE)?.as_ref()?[variable % PAGE]
    }

    fn entry(&mut self, variable: usize) -> &mut Option<Var> {
        let page = variable / PAGE;
        if self.0.len() <= page {
            self.0.resize_with(page + 1, || None);
        }
        let page = self.0[page].get_or_insert_with(|| Box::new([None; PAGE]));
        &mut page[variable % PAGE]
    }
}

impl<'a> Oracle<'a> {
    pub fn new(limits: &Limits<'a>, branching: Branching) -> Oracle<'a> {
        let watch = StopCheck {
            limits: *limits,
            decisions: Cell::new(0),
            conflicts: 0,
            most: Effort::ANY,
            ended: Cell::new(false),
        };
        let solver = Solver::new(SolverOpts::default(), watch);
        Oracle { solver, branching, hints: &[], inner: Numbers::default(), outer: Vec::new() }
    }

    /// Makes the solver try these values first. They change no answer, only the time to find it.
    pub fn with_hints(self, hints: &'a [bool]) -> Oracle<'a> {
        Oracle { hints, ..self }
    }

    /// Adds a clause.
    pub fn add(&mut self, clause: &[i32]) {
        let mut clause = self.translate(clause);
        self.solver.add_clause_reuse(&mut clause);
    }

    /// Declares that the value of a variable follows from others or does not matter, so that it is not an input. Must
    /// be called before the variable occurs in a clause.
    pub fn define(&mut self, variable: i32) {
        self.variable(variable, self.branching == Branching::All);
    }

    /// Whether all assumptions can be true together; `None` if this takes more effort, or the limits are reached.
    pub fn ask(&mut self, assumptions: &[i32], most: Effort) -> Option<bool> {
        let assumptions = self.translate(assumptions);
        let watch = self.solver.cb_mut();
        if let Some(left) = watch.limits.decisions {
            // The decisions of the previous query that were not counted yet.
            left.spend(watch.decisions.get() % LOOK);
        }
        watch.decisions.set(0);
        watch.conflicts = 0;
        watch.ended.set(false);
        watch.most = most;
        match self.solver.solve_limited(&assumptions) {
            answer if answer == lbool::TRUE => Some(true),
            answer if answer == lbool::FALSE => Some(false),
            _ => None,
        }
    }

    /// After a query without answer: whether it exceeded its limit on conflicts.
    pub fn had_conflicts(&self) -> bool {
        let watch = self.solver.cb();
        watch.conflicts > watch.most.conflicts
    }

    /// After a negative answer: a subset of the assumptions that cannot be true together; empty if the clauses alone
    /// are contradictory.
    pub fn core(&self) -> Vec<i32> {
        let refuted = self.solver.unsat_core().iter();
        refuted
            .map(|lit| {
                let variable = self.outer[lit.var().idx() as usize];
                if lit.sign() { -variable } else { variable }
            })
            .collect()
    }

    /// After a positive answer: whether the literal is true in the model. A variable that occurs nowhere is false.
    pub fn holds(&self, literal: i32) -> bool {
        let variable = self.inner.get(literal.unsigned_abs() as usize);
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
        *self.inner.entry(place).get_or_insert_with(|| {
            self.outer.push(literal.abs());
            let hint = self.hints.get(place).map_or(lbool::UNDEF, |&hint| lbool::new(hint));
            self.solver.new_var(hint, chosen)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_end_a_hard_question() {
        let limits = Limits { cancelled: &|| true, ..Limits::default() };
        let mut oracle = Oracle::new(&limits, Branching::Inputs);
        // Eleven pigeons in ten holes: the solver needs far more decisions than between two looks at the clock.
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
        assert_eq!(oracle.ask(&[], Effort::ANY), None);
    }
}
