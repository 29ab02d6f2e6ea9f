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
//!
//! Charts are searched case by case (`cases`): which of their steps are active decides most of a scan.

mod cases;
mod exclusive;
mod objective;
mod partition;
mod propagation;
mod slices;

use super::Limits;
use super::bounds::Bounds;
use super::clauses::Clauses;
use super::formula::Formula;
use super::problem::Problem;
use super::trace::Step;
use exclusive::Merged;
use objective::Objective;
use partition::Partition;
use rayon::prelude::*;
use scanbound_base::time::Picos;
use scanbound_model::VarId;
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

/// Where a search begins.
#[derive(Clone, Copy)]
struct Sizes {
    /// How many variables the smallest partitions have.
    smallest: usize,
    /// How many conflicts an easy question takes at most.
    easy: u64,
    /// How many clauses a question has at least that is searched case by case.
    least: usize,
    /// The decisions that a case's search may take at each partition before the case is split.
    decisions: u64,
}

const SIZES: Sizes = Sizes {
    smallest: SMALLEST,
    easy: EASY,
    least: cases::FEWEST_CLAUSES,
    decisions: cases::DECISIONS,
};

/// Searches until the bounds meet or the limits end it.
pub fn search(problem: &Problem, bounds: &mut Bounds<'_>) {
    search_from(SIZES, problem, bounds);
}

/// The same from other sizes on.
fn search_from(sizes: Sizes, problem: &Problem, bounds: &mut Bounds<'_>) {
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
    let formula = Formula::new(&mut clauses);
    let guards = clauses.items.iter().copied();
    let softs: Vec<(i32, u64)> = guards.zip(merged.items.iter().map(|item| item.weight)).collect();
    let ground = Ground { problem, clauses: &clauses, origins: &origins, sizes, modes };
    let may_suit = cases::may_suit(&ground, &formula, bounds.limits());
    let mut objective = ground.objective(formula, &softs, bounds);
    if may_suit {
        match cases::search(&ground, objective, bounds) {
            None => return,
            Some(whole) => objective = whole,
        }
    }
    ground.search(objective, &[], None, bounds);
}

/// What is asked, the same in all cases.
struct Ground<'a> {
    problem: &'a Problem,
    clauses: &'a Clauses,
    /// By item of the clauses: which it is of the problem's, if it is one.
    origins: &'a [Option<usize>],
    sizes: Sizes,
    /// The bits that most clauses ask for.
    modes: Vec<VarId>,
}

impl Ground<'_> {
    /// The objective of soft literals with these weights.
    fn objective(
        &self,
        formula: Formula,
        softs: &[(i32, u64)],
        bounds: &mut Bounds<'_>,
    ) -> Objective {
        let mut objective = Objective::new(formula, self.clauses.variables);
        for &(literal, weight) in softs {
            objective.add_soft(literal, weight);
        }
        bounds.falsified(objective.take_falsified());
        objective
    }

    /// Searches until the bounds meet or the limits end it, where some values are fixed. Each partition may take
    /// so many decisions. Whether any scan keeps the constraints, as far as that was found out.
    fn search(
        &self,
        mut objective: Objective,
        fixed: &[i8],
        decisions: Option<u64>,
        bounds: &mut Bounds<'_>,
    ) -> bool {
        let mut search = Search {
            problem: self.problem,
            clauses: self.clauses,
            origins: self.origins,
            limits: bounds.limits(),
            easy: self.sizes.easy,
            decisions,
            values: Vec::new(),
            fixed,
            modes: &self.modes,
            bounds: Mutex::new(bounds),
        };
        let whole = self.clauses.variables + 1;
        // In a case, little is left of each partition.
        let mut size = if fixed.is_empty() { self.sizes.smallest } else { whole };
        for round in 0.. {
            if round == PROPAGATE_AFTER && !search.done() {
                search.bounds().step(|| Step::Propagation);
                search.propagation_cores(&mut objective);
                search.bounds().round();
            }
            if search.done() {
                return true;
            }
            // A round just below the whole would cost as much.
            size = if size < whole / 2 { size } else { whole };
            let possible = search.round(&mut objective, size, whole);
            if possible && size < whole {
                search.combine();
            }
            search.bounds().round();
            if !possible || size == whole {
                return possible;
            }
            size *= GROWTH;
        }
        true
    }
}

/// What all partitions have in common.
struct Search<'a, 'b> {
    problem: &'a Problem,
    clauses: &'a Clauses,
    /// By item of the clauses: which it is of the problem's, if it is one.
    origins: &'a [Option<usize>],
    limits: &'b Limits<'b>,
    /// The decisions that each partition may take, if the search may be given up.
    decisions: Option<u64>,
    /// How many conflicts an easy question takes at most.
    easy: u64,
    bounds: Mutex<&'a mut Bounds<'b>>,
    /// By variable of the circuit, from 1: its value in the last scan found for its partition. Empty in the first round.
    values: Vec<bool>,
    /// By variable: 1 where it is true in the case that is searched, -1 where it is false. Empty where that is all there is.
    fixed: &'a [i8],
    /// The bits that most clauses ask for.
    modes: &'a [VarId],
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
        for (value, &fixed) in self.values.iter_mut().zip(self.fixed) {
            *value = if fixed == 0 { *value } else { fixed > 0 };
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
        for &mode in self.modes {
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
        let holds = |literal: i32| match self.fixed.get(literal.unsigned_abs() as usize) {
            None | Some(0) => holds(literal),
            Some(fixed) => (*fixed > 0) == (literal > 0),
        };
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
    use crate::testing::sound;

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
                search_from(Sizes { smallest, easy, ..SIZES }, &problem, &mut bounds);
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
                search_from(Sizes { smallest: 20, ..SIZES }, &problem, &mut bounds);
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
