//! The search of the paper that `docs/method.md` describes: asks which guards can be true together, and removes those
//! that conflict.

use super::bounds::Bounds;
use super::clauses::Clauses;
use super::hitting::least_hitting_set;
use super::problem::Problem;
use super::sat::Sat;
pub use super::sat::with_solver;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

/// With at most this many items, the search removes one item at a time, as the paper does; with more, it uses
/// unsatisfiable cores.
const PLAIN: usize = 8;

/// The largest number of items of a small group. With 24 items a search takes about twenty milliseconds, with 60 a
/// tenth of a second; the core-guided search takes one or two.
const SMALL: usize = 24;
/// The largest number of circuit nodes of a small group.
const NODES: usize = 2_000;

/// The effort after which the search by subsets is given up for the core-guided one. It is counted in queries and the
/// solver's own measure, not in time, so that every run ends at the same point.
#[derive(Debug, Clone, Copy)]
pub struct EffortLimit {
    /// The largest number of queries.
    pub questions: u64,
    /// The largest effort of each query, in the solver's own measure.
    pub effort: u32,
    /// The largest number of times that the computation of a minimum hitting set asks whether to stop, which it does
    /// once in 1,024 steps.
    pub looks: u32,
}

/// The effort limit for a small group.
pub const BUDGET: EffortLimit = EffortLimit { questions: 300, effort: 200_000, looks: 4 };

/// How the search by subsets ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchEnd {
    /// The bounds have met, no scan satisfies the constraints, or the user's limits were reached.
    Done,
    /// The effort limit was reached.
    OutOfBudget,
}

/// Whether the problem is small enough to try the search by subsets first.
pub fn is_small(problem: &Problem) -> bool {
    (1..=SMALL).contains(&problem.items.len()) && problem.circuit.nodes().len() <= NODES
}

/// The effort of one query, in the solver's own measure, between two looks at the clock. A query that needs more is
/// repeated with twice as much.
const EFFORT: u32 = 2_000_000;

/// Searches by subsets until the bounds meet, the limits are reached, or `budget`, if any, is used up. To be called
/// within [`with_solver`].
pub fn search(
    problem: &Problem,
    bounds: &mut Bounds<'_>,
    budget: Option<EffortLimit>,
) -> SearchEnd {
    if bounds.exact() || bounds.limits().reached() {
        return SearchEnd::Done;
    }
    let clauses = Clauses::new(problem);
    let mut subset_search = SubsetSearch::new(problem, &clauses, bounds, budget);
    let ended = if problem.items.len() <= PLAIN {
        plain(&mut subset_search)
    } else {
        by_cores(&mut subset_search)
    };
    // A search that is stopped leaves the bounds that it has proved so far.
    ended.err().map_or(SearchEnd::Done, |SearchStopped(end)| end)
}

/// The error that the limits or the effort limit ended the search.
struct SearchStopped(SearchEnd);

/// Searches in the order of the paper: asks all items, then all subsets with one item less, and so on. The subsets of
/// an unsatisfiable set are tried only if its total exceeds the best satisfiable set so far.
fn plain(subset_search: &mut SubsetSearch<'_, '_>) -> Result<(), SearchStopped> {
    let all: Vec<usize> = (0..subset_search.problem.items.len()).collect();
    let mut level = BTreeSet::from([all]);
    while !level.is_empty() {
        let mut conflicting = Vec::new();
        for set in level {
            if !subset_search.ask(&set)? {
                conflicting.push(set);
            }
        }
        level = BTreeSet::new();
        let mut upper = subset_search.bounds.lower();
        for set in conflicting {
            if subset_search.total(&set) > subset_search.bounds.lower() {
                upper = upper.max(subset_search.total(&set));
                for &item in &set {
                    level.insert(set.iter().copied().filter(|&other| other != item).collect());
                }
            }
        }
        subset_search.bounds.record_upper(upper);
        subset_search.bounds.round();
    }
    Ok(())
}

/// Leaves out the cheapest items of which every conflict found so far contains one, and looks for conflicts among the
/// others, until these can be true together.
fn by_cores(subset_search: &mut SubsetSearch<'_, '_>) -> Result<(), SearchStopped> {
    let weights: Vec<u64> = subset_search.problem.items.iter().map(|item| item.weight).collect();
    let mut cores: Vec<Vec<usize>> = Vec::new();
    while !subset_search.bounds.exact() {
        let (looks, limits) = (Cell::new(0), subset_search.bounds.limits());
        let spent = || subset_search.budget.is_some_and(|budget| looks.get() > budget.looks);
        let stop = || {
            looks.set(looks.get() + 1);
            spent() || (subset_search.budget.is_none() && limits.reached())
        };
        let Some(taken) = least_hitting_set(&weights, &cores, &stop) else {
            return Err(SearchStopped(if spent() {
                SearchEnd::OutOfBudget
            } else {
                SearchEnd::Done
            }));
        };
        let mut left: Vec<usize> =
            (0..weights.len()).filter(|item| taken.binary_search(item).is_err()).collect();
        let upper = subset_search.total(&left);
        subset_search.bounds.record_upper(upper);
        subset_search.bounds.round();
        // Find conflicts without common items, as many as there are: each lowers the bound separately.
        while !subset_search.ask(&left)? {
            let core = subset_search.core(&left)?;
            if core.is_empty() {
                return Ok(()); // The constraints contradict each other.
            }
            left.retain(|item| !core.contains(item));
            cores.push(core);
        }
    }
    Ok(())
}

/// The state of a search by subsets: the solver with the problem's clauses, and its answers so far.
struct SubsetSearch<'a, 'b> {
    problem: &'a Problem,
    clauses: &'a Clauses,
    bounds: &'a mut Bounds<'b>,
    budget: Option<EffortLimit>,
    asked: u64,
    solver: Sat,
    answers: BTreeMap<Vec<usize>, bool>,
    /// The items of the last query, if the answer was negative.
    refuted: Option<Vec<usize>>,
}

impl<'a, 'b> SubsetSearch<'a, 'b> {
    fn new(
        problem: &'a Problem,
        clauses: &'a Clauses,
        bounds: &'a mut Bounds<'b>,
        budget: Option<EffortLimit>,
    ) -> SubsetSearch<'a, 'b> {
        SubsetSearch {
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

    /// The cost if these items are true, in picoseconds.
    fn total(&self, items: &[usize]) -> u64 {
        self.problem.total(items.iter().map(|&item| self.problem.items[item].weight))
    }

    /// Whether these items can be true together, from an earlier answer or the solver. If so, the scan is recorded.
    fn ask(&mut self, items: &[usize]) -> Result<bool, SearchStopped> {
        if let Some(&answer) = self.answers.get(items) {
            return Ok(answer);
        }
        let begin = Instant::now();
        let answer = self.check(items)?;
        let time = begin.elapsed();
        if answer {
            self.bounds
                .record_assignment(self.clauses.assignment(self.problem, self.solver.model()));
        }
        self.bounds.record_query(items, self.total(items), answer, time);
        self.answers.insert(items.to_vec(), answer);
        Ok(answer)
    }

    /// A minimal subset of these items, which cannot all be true, that cannot be true together. Empty if the
    /// constraints are contradictory.
    fn core(&mut self, items: &[usize]) -> Result<Vec<usize>, SearchStopped> {
        let mut core = items.to_vec();
        if self.refuted.as_deref() == Some(items) || !self.check(items)? {
            self.keep_named(&mut core);
        }
        // Remove the heaviest items first: a core of light items costs least to break.
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

    /// Keeps only the items that are in the core of the solver's last answer, which must be negative.
    fn keep_named(&self, items: &mut Vec<usize>) {
        let guard = |item: usize| self.clauses.items[item];
        let asked: Vec<i32> = items.iter().map(|&item| guard(item)).collect();
        let named = self.solver.core(&asked);
        items.retain(|&item| named.contains(&guard(item)));
    }

    fn check(&mut self, items: &[usize]) -> Result<bool, SearchStopped> {
        let assumptions: Vec<i32> = items.iter().map(|&item| self.clauses.items[item]).collect();
        let mut effort = self.budget.map_or(EFFORT, |budget| budget.effort);
        loop {
            if self.ended() {
                return Err(SearchStopped(SearchEnd::Done));
            }
            if self.budget.is_some_and(|budget| self.asked >= budget.questions) {
                return Err(SearchStopped(SearchEnd::OutOfBudget));
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
                    return Err(SearchStopped(SearchEnd::OutOfBudget));
                }
                None => effort = effort.saturating_mul(2),
            }
        }
    }

    /// Whether the limits end the search. A search with an effort limit is so short that it checks only the deadline;
    /// other limits must not stop a small group half done.
    fn ended(&self) -> bool {
        let limits = self.bounds.limits();
        match self.budget {
            None => limits.reached(),
            Some(_) => limits.deadline.is_some_and(|deadline| Instant::now() >= deadline),
        }
    }
}
