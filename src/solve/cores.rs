//! Core-guided search: the OLL algorithm of MaxSAT solvers, partition by partition of the program.
//!
//! Every guard is a *soft literal* with a weight: the time that is lost if it is false. Soft literals that cannot all
//! be true are a *core*. At least one of them is false in every scan, so the bound falls by the core's weight, the
//! least of its literals' weights. That weight is subtracted from each of them, and the core is *relaxed*: that no
//! second one of them is false becomes a new soft literal of that weight, an output of a totalizer. When all soft
//! literals that are left can be true together, the bound is met. Heavier ones come first (stratification).
//!
//! Guards that exclude each other by their form are taken together first (`exclusive`). What is special to ladder
//! programs: nearly all conflicts are local. So the search begins with small partitions of
//! the program, as they follow each other in the order of execution, each with a small solver of its own, and goes on
//! with larger ones. A partition's clauses are a subset of the whole's, so its cores are cores of the whole. No two
//! partitions share a soft literal, so all threads work on them side by side. In between, `propagation` looks for cores
//! over the whole program: modes and run flags tie it together.

mod exclusive;
mod objective;
mod partition;
mod propagation;

use super::Limits;
use super::bounds::Bounds;
use super::clauses::Clauses;
use super::formula::Formula;
use super::problem::Problem;
use super::trace::Step;
use crate::base::time::Picos;
use crate::scan::model::VarId;
use exclusive::Merged;
use objective::Objective;
use partition::Partition;
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How many variables the smallest partitions have.
const SMALLEST: usize = 300;

/// By how much the partitions grow from round to round.
const GROWTH: usize = 12;

/// How many mode bits are tried with both values when the partitions' scans are combined.
const MODES: usize = 16;

/// How many rounds go by before the search looks for cores by propagation over the whole program.
const PROPAGATE_AFTER: usize = 2;

/// How many conflicts an easy question takes at most.
const EASY: u64 = 300;

/// Searches until the bounds meet or the limits end it.
pub fn search(problem: &Problem, bounds: &mut Bounds<'_>) {
    search_from(SMALLEST, EASY, problem, bounds);
}

/// The same with smallest partitions of so many variables, and easy questions of so many conflicts.
fn search_from(smallest: usize, easy: u64, problem: &Problem, bounds: &mut Bounds<'_>) {
    if bounds.limits().reached() {
        return;
    }
    let Merged { problem: merged, origins, taken } = exclusive::merge(problem);
    for (items, off) in taken {
        bounds.step(|| Step::Core { items, counts: 0, weight: Picos(off) });
        bounds.falsified(off);
    }
    let mut clauses = Clauses::with_late(&merged, problem.circuit.nodes().len());
    let modes = clauses.busiest_bits(MODES);
    let mut objective = Objective::new(Formula::new(&mut clauses), clauses.variables);
    for (item, &guard) in merged.items.iter().zip(&clauses.items) {
        objective.add_soft(guard, item.weight);
    }
    bounds.falsified(objective.take_falsified());
    let mut search = Search {
        problem,
        clauses: &clauses,
        origins: &origins,
        limits: bounds.limits(),
        easy,
        values: Vec::new(),
        modes,
        bounds: Mutex::new(bounds),
    };
    let whole = clauses.variables + 1;
    let mut size = smallest;
    for round in 0.. {
        if round == PROPAGATE_AFTER && !search.done() {
            search.bounds().step(|| Step::Propagation);
            search.propagation_cores(&mut objective);
            search.bounds().round();
        }
        if search.done() {
            return;
        }
        // A round just below the whole would cost as much.
        size = if size < whole / 2 { size } else { whole };
        let possible = search.round(&mut objective, size, whole);
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

/// What all partitions have in common.
struct Search<'a, 'b> {
    problem: &'a Problem,
    clauses: &'a Clauses,
    /// By item of the clauses: which it is of the problem's, if it is one.
    origins: &'a [Option<usize>],
    limits: &'b Limits<'b>,
    /// How many conflicts an easy question takes at most.
    easy: u64,
    bounds: Mutex<&'a mut Bounds<'b>>,
    /// By variable of the circuit, from 1: its value in the last scan found for its partition. Empty in the first round.
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

    /// Searches all partitions of `size` variables of the `whole`, side by side. No partition sees another, nor that
    /// the bounds have met, so the result does not depend on which is first. Returns whether the constraints can hold.
    fn round(&mut self, objective: &mut Objective, size: usize, whole: usize) -> bool {
        let count = whole.div_ceil(size);
        let objectives = objective.split(size, count).into_iter().enumerate();
        let mut partitions: Vec<Partition> = objectives
            .map(|(index, objective)| {
                Partition::new(index * size..((index + 1) * size).min(whole), objective)
            })
            .collect();
        self.bounds().step(|| Step::Partitions { count, size });
        partitions.par_iter_mut().for_each(|partition| partition.solve(self, count == 1));
        for partition in &mut partitions {
            self.bounds().steps(std::mem::take(&mut partition.trace));
        }
        let possible = partitions.iter().all(|partition| !partition.contradiction);
        self.values.resize(whole, false);
        for partition in &mut partitions {
            if !partition.values.is_empty() {
                self.values[partition.positions.clone()].copy_from_slice(&partition.values);
            }
        }
        objective.join(partitions.into_iter().map(|partition| partition.objective));
        possible
    }

    /// What the trace says of a core of this weight.
    fn core(&self, core: &[i32], weight: u64) -> Step {
        let items = self.clauses.items.iter().zip(self.origins);
        let items: Vec<usize> = items
            .filter(|(guard, _)| core.contains(guard))
            .filter_map(|(_, origin)| *origin)
            .collect();
        Step::Core { counts: core.len().saturating_sub(items.len()), items, weight: Picos(weight) }
    }

    /// Combines the partitions' best values to one scan, seldom the best of the whole. The mode bits, on which the
    /// partitions disagree, are tried with both values.
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

    /// Takes note of a model of the whole. A soft literal that weighs more than the gap between the bounds is true in
    /// every better one, so it is hardened: it becomes a clause.
    fn found(&self, objective: &mut Objective, holds: impl Fn(i32) -> bool) {
        let mut bounds = self.bounds();
        bounds.falsified(objective.take_falsified());
        bounds.found(self.clauses.assignment(self.problem, holds));
        let heavy = objective.soft_literals(bounds.gap() + 1).map(|(literal, _)| literal);
        heavy.collect::<Vec<i32>>().into_iter().for_each(|literal| objective.harden(literal));
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
            for (smallest, easy) in [(1, EASY), (3, 0), (10, 2)] {
                let limits = Limits::default();
                let mut bounds = Bounds::new(&problem, &limits);
                search_from(smallest, easy, &problem, &mut bounds);
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
                search_from(20, EASY, &problem, &mut bounds);
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
