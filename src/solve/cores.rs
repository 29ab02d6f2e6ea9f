//! Core-guided search: pay for what cannot hold together until the rest can, part by part of the program.
//!
//! Every guard is a wish with a weight. Wishes that cannot all hold are a *core*: one of them fails, so the
//! bound falls by the least of their weights, and is taken off each; that no further one of them fails becomes a
//! new wish of that weight (a counter's output). When all wishes that are left can hold together, the bound is
//! met. This is the OLL scheme of MaxSAT solvers, heavier wishes first.
//!
//! What is special to ladder programs: nearly all conflicts are local. So the search first looks at small parts
//! of the program by themselves, as they follow each other in the order of execution, each with a small solver
//! of its own, and leaves to larger and larger parts only what is left. A part's clauses are some of the whole's,
//! so its cores are the whole's cores; no two parts share a wish, so all threads work on them side by side. In
//! between, `mine` takes what ties the whole together: modes and run flags.

mod ledger;
mod mine;
mod part;

use super::Limits;
use super::bounds::Bounds;
use super::clauses::Clauses;
use super::formula::Formula;
use super::problem::Problem;
use super::trace::Step;
use crate::base::time::Picos;
use crate::scan::model::VarId;
use ledger::Ledger;
use part::Part;
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The smallest parts have so many variables.
const SMALLEST: usize = 100;

/// Each round's parts are so many times larger than the last round's.
const GROWTH: usize = 3;

/// So many bits are tried either way when the parts' values are taken together.
const MODES: usize = 16;

/// So many rounds go by before the search looks at the whole for what propagation shows.
const MINE_AFTER: usize = 2;

/// Searches until the bounds meet or the limits end it.
pub fn search(problem: &Problem, bounds: &mut Bounds<'_>) {
    search_from(SMALLEST, problem, bounds);
}

/// The same with smallest parts of so many variables.
fn search_from(smallest: usize, problem: &Problem, bounds: &mut Bounds<'_>) {
    if bounds.limits().reached() {
        return;
    }
    let clauses = Clauses::new(problem);
    let mut ledger = Ledger::new(Formula::new(&clauses), clauses.variables);
    for (item, &guard) in problem.items.iter().zip(&clauses.items) {
        ledger.wish(guard, item.weight);
    }
    bounds.lost(ledger.take_lost());
    let mut search = Search {
        problem,
        clauses: &clauses,
        limits: bounds.limits(),
        values: vec![false; clauses.variables + 1],
        modes: clauses.busiest_bits(MODES),
        bounds: Mutex::new(bounds),
    };
    let whole = clauses.variables + 1;
    let mut size = smallest;
    for round in 0.. {
        if search.done() {
            return;
        }
        if round == MINE_AFTER {
            search.bounds().step(|| Step::Mined);
            search.mine(&mut ledger);
            search.bounds().round();
        }
        // A round just below the whole would cost as much.
        size = if size < whole / 2 { size } else { whole };
        let possible = search.round(&mut ledger, size, whole);
        if possible && size < whole {
            search.combine();
        }
        search.bounds().round();
        if !possible || size == whole {
            return;
        }
        size *= GROWTH;
    }
}

/// What all parts share.
struct Search<'a, 'b> {
    problem: &'a Problem,
    clauses: &'a Clauses,
    limits: &'b Limits<'b>,
    bounds: Mutex<&'a mut Bounds<'b>>,
    /// By variable of the circuit, from 1: its value in the last scan found for its part.
    values: Vec<bool>,
    /// The bits that most clauses ask for.
    modes: Vec<VarId>,
}

impl<'a, 'b> Search<'a, 'b> {
    fn bounds(&self) -> MutexGuard<'_, &'a mut Bounds<'b>> {
        self.bounds.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn done(&self) -> bool {
        self.bounds().exact() || self.limits.reached()
    }

    /// Goes through all parts of `size` variables of the `whole`, side by side. Parts neither see each other nor when the bounds meet, so
    /// what comes out does not depend on who is first. Whether the constraints can hold.
    fn round(&mut self, ledger: &mut Ledger, size: usize, whole: usize) -> bool {
        let count = whole.div_ceil(size);
        let ledgers = ledger.split(size, count).into_iter().enumerate();
        let mut parts: Vec<Part> = ledgers
            .map(|(part, ledger)| Part::new(part * size..((part + 1) * size).min(whole), ledger))
            .collect();
        self.bounds().step(|| Step::Parts { count, size });
        parts.par_iter_mut().for_each(|part| part.solve(self, count == 1));
        for part in &mut parts {
            self.bounds().steps(std::mem::take(&mut part.trace));
        }
        let possible = parts.iter().all(|part| !part.contradiction);
        for part in &mut parts {
            if !part.values.is_empty() {
                self.values[part.homes.clone()].copy_from_slice(&part.values);
            }
        }
        ledger.join(parts.into_iter().map(|part| part.ledger));
        possible
    }

    /// The step at which a core was paid.
    fn core(&self, core: &[i32], paid: u64) -> Step {
        let wished = |guard: &i32| core.contains(guard);
        let items = self.clauses.items.iter().enumerate();
        let items: Vec<usize> =
            items.filter(|(_, guard)| wished(guard)).map(|(item, _)| item).collect();
        Step::Core { counts: core.len().saturating_sub(items.len()), items, paid: Picos(paid) }
    }

    /// Takes the parts' best values together: seldom the best of the whole, but a scan. Modes that the parts
    /// disagree on are tried either way.
    fn combine(&self) {
        let values = &self.values;
        let holds = |literal: i32| values[literal.unsigned_abs() as usize] == (literal > 0);
        let mut best = self.clauses.assignment(self.problem, holds);
        let mut most = self.problem.cost(&best);
        for &mode in &self.modes {
            let value = &mut best.0[mode.0 as usize];
            *value ^= 1;
            let cost = self.problem.cost(&best);
            if cost > most {
                most = cost;
            } else {
                best.0[mode.0 as usize] ^= 1;
            }
        }
        self.bounds().found(best);
    }

    /// Takes note of a model of the whole. A wish that is worth more than the bounds are apart holds in every
    /// better one, so it is granted.
    fn found(&self, ledger: &mut Ledger, holds: impl Fn(i32) -> bool) {
        let mut bounds = self.bounds();
        bounds.lost(ledger.take_lost());
        bounds.found(self.clauses.assignment(self.problem, holds));
        let granted: Vec<i32> = ledger.wishes(bounds.gap() + 1).map(|(wish, _)| wish).collect();
        granted.into_iter().for_each(|wish| ledger.grant(wish));
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Builder, brute, plant, random};
    use super::super::{Limits, Maximum};
    use super::*;
    use crate::solve::testing::sound;

    #[test]
    fn small_parts_change_nothing() {
        for seed in 1000..1060 {
            let model = random(seed, 10 + seed % 30);
            let group = Builder { model: model.clone() }.group();
            let problem = Problem::new(&model, &group);
            let truth = brute(&model, &group).unwrap();
            for smallest in [1, 3, 10] {
                let limits = Limits::default();
                let mut bounds = Bounds::new(&problem, &limits);
                search_from(smallest, &problem, &mut bounds);
                let found: Maximum = bounds.finish();
                sound(&model, &group, &found);
                assert_eq!((found.lower, found.upper), (truth, truth), "seed {seed}");
            }
        }
    }

    #[test]
    fn threads_change_nothing() {
        let (model, _) = plant(5, 12);
        let group = Builder { model: model.clone() }.group();
        let problem = Problem::new(&model, &group);
        let by = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let limits = Limits::default();
                let mut bounds = Bounds::new(&problem, &limits);
                search_from(20, &problem, &mut bounds);
                bounds.finish()
            })
        };
        let alone = by(1);
        assert_eq!(alone.lower, alone.upper);
        for _ in 0..3 {
            assert_eq!(by(3), alone);
        }
    }
}
