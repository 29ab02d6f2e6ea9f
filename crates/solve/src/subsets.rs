//! The paper's search: ask which guards can hold together, and take away what conflicts.

use super::bounds::Bounds;
use super::clauses::Clauses;
use super::hitting::least_hitting_set;
use super::problem::Problem;
use super::sat::Sat;
pub use super::sat::with_solver;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

/// Up to so many items the search takes away one item at a time, as the paper does; with more, it takes away
/// what unsatisfiable cores show to conflict.
const PLAIN: usize = 8;

/// A group of at most so many items, over so many nodes, is small. With 24 items a search takes some twenty
/// milliseconds, with 60 a tenth of a second; the cores take one or two.
const SMALL: usize = 24;
const NODES: usize = 2_000;

/// What a search may spend before it gives way to another. It counts questions and the solver's own effort, not
/// time, so that every run gives way at the same place.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Questions put to the solver.
    pub questions: u64,
    /// The solver's own measure of effort for each.
    pub effort: u32,
    /// Looks at the clock while a least set to take away is sought.
    pub looks: u32,
}

/// What is spent on a small group.
pub const BUDGET: Budget = Budget { questions: 300, effort: 200_000, looks: 4 };

/// How a search came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The bounds have met, or the limits ended it.
    Done,
    /// It has used up its budget.
    OutOfBudget,
}

/// Whether the search by subsets is tried first.
pub fn is_small(problem: &Problem) -> bool {
    (1..=SMALL).contains(&problem.items.len()) && problem.circuit.nodes().len() <= NODES
}

/// The solver's own measure of effort for one question between two looks at the clock. A question that needs more
/// is asked again with twice as much.
const EFFORT: u32 = 2_000_000;

/// Searches, within `with_solver`, until the bounds meet, the limits end it, or the budget is used up if there is one.
pub fn search(problem: &Problem, bounds: &mut Bounds<'_>, budget: Option<Budget>) -> End {
    if bounds.exact() || bounds.limits().reached() {
        return End::Done;
    }
    let clauses = Clauses::new(problem);
    let mut judge = Judge::new(problem, &clauses, bounds, budget);
    let ended = if problem.items.len() <= PLAIN { plain(&mut judge) } else { by_cores(&mut judge) };
    // A search that is stopped leaves the bounds as far as it got.
    ended.err().map_or(End::Done, |Stopped(end)| end)
}

/// The limits or the budget ended the search.
struct Stopped(End);

/// The paper's order: all items, then all sets with one item less, and so on; of an unsatisfiable set only if
/// its total is above the best satisfiable set so far.
fn plain(judge: &mut Judge<'_, '_>) -> Result<(), Stopped> {
    let all: Vec<usize> = (0..judge.problem.items.len()).collect();
    let mut level = BTreeSet::from([all]);
    while !level.is_empty() {
        let mut conflicting = Vec::new();
        for set in level {
            if !judge.ask(&set)? {
                conflicting.push(set);
            }
        }
        level = BTreeSet::new();
        let mut upper = judge.bounds.lower();
        for set in conflicting {
            if judge.total(&set) > judge.bounds.lower() {
                upper = upper.max(judge.total(&set));
                for &item in &set {
                    level.insert(set.iter().copied().filter(|&other| other != item).collect());
                }
            }
        }
        judge.bounds.proved(upper);
        judge.bounds.round();
    }
    Ok(())
}

/// Takes away the cheapest items that break every conflict found so far, until what is left can hold together.
fn by_cores(judge: &mut Judge<'_, '_>) -> Result<(), Stopped> {
    let weights: Vec<u64> = judge.problem.items.iter().map(|item| item.weight).collect();
    let mut cores: Vec<Vec<usize>> = Vec::new();
    while !judge.bounds.exact() {
        let (looks, limits) = (Cell::new(0), judge.bounds.limits());
        let spent = || judge.budget.is_some_and(|budget| looks.get() > budget.looks);
        let stop = || {
            looks.set(looks.get() + 1);
            spent() || (judge.budget.is_none() && limits.reached())
        };
        let Some(taken) = least_hitting_set(&weights, &cores, &stop) else {
            return Err(Stopped(if spent() { End::OutOfBudget } else { End::Done }));
        };
        let mut left: Vec<usize> =
            (0..weights.len()).filter(|item| taken.binary_search(item).is_err()).collect();
        let upper = judge.total(&left);
        judge.bounds.proved(upper);
        judge.bounds.round();
        // Conflicts that have nothing in common, as many as there are: each lowers the bound by itself.
        while !judge.ask(&left)? {
            let core = judge.core(&left)?;
            if core.is_empty() {
                return Ok(()); // The constraints contradict each other.
            }
            left.retain(|item| !core.contains(item));
            cores.push(core);
        }
    }
    Ok(())
}

/// The solver with the problem's clauses, and the answers it gave.
struct Judge<'a, 'b> {
    problem: &'a Problem,
    clauses: &'a Clauses,
    bounds: &'a mut Bounds<'b>,
    budget: Option<Budget>,
    asked: u64,
    solver: Sat,
    answers: BTreeMap<Vec<usize>, bool>,
    /// What the solver was last asked, if the answer was no.
    refuted: Option<Vec<usize>>,
}

impl<'a, 'b> Judge<'a, 'b> {
    fn new(
        problem: &'a Problem,
        clauses: &'a Clauses,
        bounds: &'a mut Bounds<'b>,
        budget: Option<Budget>,
    ) -> Judge<'a, 'b> {
        Judge {
            problem,
            clauses,
            bounds,
            budget,
            asked: 0,
            solver: Sat::new(clauses),
            answers: BTreeMap::new(),
            refuted: None,
        }
    }

    /// What these items and the constant cost together.
    fn total(&self, items: &[usize]) -> u64 {
        self.problem.total(items.iter().map(|&item| self.problem.items[item].weight))
    }

    /// Whether these items can hold together. Takes note of the scan in which they do.
    fn ask(&mut self, items: &[usize]) -> Result<bool, Stopped> {
        if let Some(&answer) = self.answers.get(items) {
            return Ok(answer);
        }
        let begin = Instant::now();
        let answer = self.check(items)?;
        let time = begin.elapsed();
        if answer {
            self.bounds.found(self.clauses.assignment(self.problem, self.solver.model()));
        }
        self.bounds.asked(items, self.total(items), answer, time);
        self.answers.insert(items.to_vec(), answer);
        Ok(answer)
    }

    /// Of items that cannot hold together, some that cannot either, none of them to spare.
    fn core(&mut self, items: &[usize]) -> Result<Vec<usize>, Stopped> {
        let mut core = items.to_vec();
        if self.refuted.as_deref() == Some(items) || !self.check(items)? {
            self.keep_named(&mut core);
        }
        // The dearest are tried first: a core of cheap items costs least to break.
        let mut order = core.clone();
        order.sort_by_key(|&item| std::cmp::Reverse(self.problem.items[item].weight));
        for item in order {
            let rest: Vec<usize> = core.iter().copied().filter(|&other| other != item).collect();
            if rest.len() < core.len() && !self.ask(&rest)? {
                core = rest;
                if self.refuted.as_ref() == Some(&core) {
                    self.keep_named(&mut core);
                }
            }
        }
        Ok(core)
    }

    /// Of the items just refuted, those that the solver names as excluding each other.
    fn keep_named(&self, items: &mut Vec<usize>) {
        let guard = |item: usize| self.clauses.items[item];
        let asked: Vec<i32> = items.iter().map(|&item| guard(item)).collect();
        let named = self.solver.core(&asked);
        items.retain(|&item| named.contains(&guard(item)));
    }

    fn check(&mut self, items: &[usize]) -> Result<bool, Stopped> {
        let assumptions: Vec<i32> = items.iter().map(|&item| self.clauses.items[item]).collect();
        let mut effort = self.budget.map_or(EFFORT, |budget| budget.effort);
        loop {
            if self.ended() {
                return Err(Stopped(End::Done));
            }
            if self.budget.is_some_and(|budget| self.asked >= budget.questions) {
                return Err(Stopped(End::OutOfBudget));
            }
            self.asked += 1;
            self.bounds.count();
            match self.solver.check(&assumptions, effort) {
                Some(true) => {
                    self.refuted = None;
                    return Ok(true);
                }
                Some(false) => {
                    self.refuted = Some(items.to_vec());
                    return Ok(false);
                }
                None if self.budget.is_some() => {
                    return Err(Stopped(End::OutOfBudget));
                }
                None => effort = effort.saturating_mul(2),
            }
        }
    }

    /// Whether the limits end the search. One that has a budget takes no longer than is noticed: only its time may run
    /// out, so that a limit that is decided meanwhile does not leave a small group half done.
    fn ended(&self) -> bool {
        let limits = self.bounds.limits();
        match self.budget {
            None => limits.reached(),
            Some(_) => limits.deadline.is_some_and(|deadline| Instant::now() >= deadline),
        }
    }
}
