//! Core-guided search: the OLL algorithm of MaxSAT solvers, applied to one partition of the program after another.
//!
//! Every guard is a *soft literal*; its weight is the time that is lost if it is false. Soft literals that cannot all
//! be true are a *core*. At least one of them is false in every scan, so the bound falls by the weight of the core,
//! which is the smallest of its literals' weights. This weight is subtracted from each literal, and the core is
//! *relaxed*: a new soft literal of this weight says that no second literal of the core is false; it is an output of a
//! totalizer. When all remaining soft literals can be true together, the bound is exact. Heavier literals come first
//! (stratification).
//!
//! Guards that exclude each other by their structure are combined first (`exclusive`). Ladder programs have a special
//! property: nearly all conflicts are local. Therefore the search begins with small partitions of the program, in the
//! order of execution, each with a small solver of its own, and continues with larger ones. The clauses of a partition
//! are a subset of all clauses, so its cores are cores of the whole program. No two partitions share a soft literal, so
//! all threads work on them in parallel. In between, `propagation` finds cores over the whole program, because mode
//! bits and run flags connect all parts of it.
//!
//! Charts are searched case by case (`cases`), because the set of active steps decides most of a scan.

mod cases;
mod exclusive;
mod ground;
mod objective;
mod partition;
mod propagation;
mod rounds;
mod search;
mod slices;

use super::bounds::Bounds;
use super::clauses::Clauses;
use super::formula::Formula;
use super::problem::Problem;
use super::trace::Step;
use exclusive::Merged;
use ground::{Ground, Sizes};
use scanbound_base::time::Picos;

/// The number of variables of the smallest partitions.
const SMALLEST: usize = 300;

/// The number of mode bits that are tried with both values when the partitions' best scans are combined to one scan.
const MODES: usize = 16;

/// The largest number of conflicts of a query before a solver that branches on all variables takes over.
const EASY: u64 = 300;

const SIZES: Sizes = Sizes {
    smallest: SMALLEST,
    easy: EASY,
    least: cases::FEWEST_CLAUSES,
    decisions: cases::DECISIONS,
};

/// Searches a problem until the bounds meet or the limits are reached, and records the results in `bounds`.
pub fn search(problem: &Problem, bounds: &mut Bounds<'_>) {
    search_from(SIZES, problem, bounds);
}

/// As [`search`], with these sizes and limits in place of the usual ones.
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
    let modes = clauses.most_used_bits(MODES);
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
