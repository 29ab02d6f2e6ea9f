//! A satisfiability solver that answers one question after another about a growing set of clauses.

use super::limits::Limits;
use batsat::callbacks::Callbacks;
use batsat::clause::Kind;
use batsat::{Lit, Solver, SolverInterface, SolverOpts, Var, lbool};
use std::cell::Cell;

/// How many decisions there are between two looks at the clock.
const LOOK: u64 = 1 << 12;

/// Which variables the solver chooses values for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branching {
    /// Those whose values do not follow from others'. Most questions about a scan are easy, and yes is told soonest so.
    Inputs,
    /// All. What is hard to refute needs lemmas about what lies between: a question about 40,000 instructions that
    /// took 20 s otherwise takes 0.1 s.
    All,
}

/// What a question may take at most.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Decisions; each assumption may be one.
    pub decisions: u64,
    /// Conflicts.
    pub conflicts: u64,
}

impl Effort {
    /// As much as it takes.
    pub const ANY: Effort = Effort::decisions(u64::MAX);

    /// So many decisions, however many conflicts.
    pub const fn decisions(decisions: u64) -> Effort {
        Effort { decisions, conflicts: u64::MAX }
    }
}

/// Ends a question that takes too much effort, or too long.
struct Watch<'a> {
    limits: Limits<'a>,
    decisions: Cell<u64>,
    conflicts: u64,
    most: Effort,
    /// The question has been ended. The solver asks more than once before it stops, and goes on at any no.
    ended: Cell<bool>,
}

impl Callbacks for Watch<'_> {
    fn on_new_clause(&mut self, _: &[Lit], _: Kind) {
        self.conflicts += 1;
    }

    /// The solver asks before each of its decisions.
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

/// Literals are as in DIMACS files: a variable (from 1) or its negative. The solver knows only the variables
/// that occur, under numbers of its own.
pub struct Oracle<'a> {
    solver: Solver<Watch<'a>>,
    branching: Branching,
    /// By variable: the value that is tried first, where there is one.
    hints: &'a [bool],
    inner: Numbers,
    outer: Vec<i32>,
}

/// How many variables one page of numbers has.
const PAGE: usize = 512;

/// The solver's own numbers of the variables that occur. A small part of a large program names few of its variables, from
/// anywhere in it: so they stand in pages, most of which are never made.
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
        let watch = Watch {
            limits: *limits,
            decisions: Cell::new(0),
            conflicts: 0,
            most: Effort::ANY,
            ended: Cell::new(false),
        };
        let solver = Solver::new(SolverOpts::default(), watch);
        Oracle { solver, branching, hints: &[], inner: Numbers::default(), outer: Vec::new() }
    }

    /// The same, with the values to try first, by variable. It changes no answer, only how soon it is found.
    pub fn with_hints(self, hints: &'a [bool]) -> Oracle<'a> {
        Oracle { hints, ..self }
    }

    /// What holds from now on.
    pub fn add(&mut self, clause: &[i32]) {
        let mut clause = self.translate(clause);
        self.solver.add_clause_reuse(&mut clause);
    }

    /// A variable whose value follows from others', or does not matter: no input. To be told before the variable
    /// occurs.
    pub fn define(&mut self, variable: i32) {
        self.variable(variable, self.branching == Branching::All);
    }

    /// Whether all assumptions can hold together; `None` if that takes more effort than this or the limits are
    /// reached.
    pub fn ask(&mut self, assumptions: &[i32], most: Effort) -> Option<bool> {
        let assumptions = self.translate(assumptions);
        let watch = self.solver.cb_mut();
        if let Some(left) = watch.limits.decisions {
            // What the question before took since it was looked at last.
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

    /// After no answer: whether it would have taken more conflicts than it might.
    pub fn had_conflicts(&self) -> bool {
        let watch = self.solver.cb();
        watch.conflicts > watch.most.conflicts
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
        assert_eq!(oracle.ask(&[], Effort::ANY), None);
    }
}
