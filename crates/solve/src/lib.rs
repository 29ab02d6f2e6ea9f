//! Finds the maximum of a group of charges: the largest total time that they take in one scan.

mod bounds;
mod clause_list;
mod clauses;
mod cone;
mod cores;
mod explain;
pub mod export;
mod formula;
mod found;
mod hitting;
pub mod inductive;
mod limits;
mod maxima;
mod opinion;
mod oracle;
pub mod predecessors;
mod problem;
mod propagator;
mod sat;
#[cfg(feature = "z3")]
mod second;
mod subsets;
mod totalizer;
pub mod trace;
mod unreachable;

pub use explain::Exclusions;
pub use found::{Engine, Maximum};
pub use limits::{Decisions, Limits};
pub use maxima::{maxima, methods};
#[cfg(not(feature = "z3"))]
pub use opinion::second_opinion;
pub use opinion::{HAS_Z3, Opinion, SUBSET_SOLVER};
pub use problem::{Item, Problem};
#[cfg(feature = "z3")]
pub use second::second_opinion;
pub use unreachable::unreachable_charges;

use bounds::Bounds;
use scanbound_model::{Group, ScanModel};
use trace::Step;

/// The method by which the maximum of a group is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The search by subsets for a small group, up to an effort limit; otherwise the core-guided search.
    #[default]
    Auto,
    /// The method of the paper that `docs/method.md` describes: asks whether sets of guards can be true together, from
    /// all of them to ever smaller subsets, and leaves out subsets that cannot exceed the longest scan found (T_MAX).
    /// With more than 8 guards, conflicts that the solver names decide which guards to leave out.
    Subsets,
    /// Core-guided search (OLL, as in MaxSAT solvers): finds sets of guards that cannot all be true, and lowers the
    /// bound by each.
    Cores,
}

/// Searches the maximum of one group. Its bounds are valid however early the limits end the search.
#[must_use]
pub fn maximum(model: &ScanModel, group: &Group, method: Method, limits: &Limits<'_>) -> Maximum {
    let problem = Problem::new(model, group);
    match method {
        Method::Auto if !subsets::is_small(&problem) => search(&problem, method, limits),
        Method::Cores => search(&problem, method, limits),
        Method::Auto | Method::Subsets => subsets::with_solver(|| search(&problem, method, limits)),
    }
}

/// Searches a problem with a method. Unless the method is [`Method::Cores`], it must be called within
/// [`subsets::with_solver`].
fn search(problem: &Problem, method: Method, limits: &Limits<'_>) -> Maximum {
    let mut bounds = Bounds::new(problem, limits);
    let subsets = match method {
        Method::Subsets => Some(None),
        Method::Auto => subsets::is_small(problem).then_some(Some(subsets::BUDGET)),
        Method::Cores => None,
    };
    if let Some(budget) = subsets {
        bounds.set_engine(Engine::Subsets);
        if subsets::search(problem, &mut bounds, budget) == subsets::SearchEnd::OutOfBudget {
            bounds.step(|| Step::TakenOver);
        } else {
            return bounds.finish();
        }
    }
    bounds.set_engine(Engine::Cores);
    cores::search(problem, &mut bounds);
    bounds.finish()
}

#[cfg(test)]
mod cross_checks;
#[cfg(test)]
mod testing;

#[cfg(test)]
mod tests {
    use super::testing::{Builder, brute, equals_brute, plant, random, sound};
    use super::*;
    use scanbound_base::time::Picos;

    #[test]
    fn all_groups_keep_their_order() {
        let mut b = Builder::default();
        let groups: Vec<Group> = (0..40)
            .map(|n| {
                let (x, y) = (b.bit(), b.bit());
                let both = b.model.circuit.and(x, y);
                let first = b.model.charges.len();
                b.charge(scanbound_model::Lit::TRUE, both, 100 + n, 0);
                b.charge(scanbound_model::Lit::TRUE, !x, 7, 0);
                let charges = (first..first + 2).collect();
                Group { charges, ..Group::default() }
            })
            .collect();
        let deadline = Some(std::time::Instant::now() + std::time::Duration::from_secs(3600));
        let limits = Limits { deadline, ..Limits::default() };
        let by = methods(&groups, Method::Auto);
        let found = maxima(&b.model, &groups, &by, &limits, &|_, _, _| {});
        for (n, found) in (0..).zip(found) {
            assert_eq!((found.lower, found.upper), (Picos(100 + n), Picos(100 + n)));
        }
    }

    #[test]
    fn subsets_equal_trying_everything() {
        for seed in 0..120 {
            equals_brute(Method::Subsets, seed, 3 + seed % 20);
        }
    }

    #[test]
    fn what_suits_the_group_equals_trying_everything() {
        for seed in 200..280 {
            equals_brute(Method::Auto, seed, 3 + seed % 40);
        }
    }

    #[test]
    fn cores_equal_trying_everything() {
        for seed in 0..150 {
            equals_brute(Method::Cores, seed, 3 + seed % 40);
        }
    }

    #[test]
    fn stations_under_shared_modes_are_exact() {
        for seed in 0..6 {
            let (model, most) = plant(seed, 3 + 11 * seed as usize);
            let group = Builder { model: model.clone() }.group();
            let constant: Picos = (0..model.charges.len())
                .filter(|charge| !group.charges.contains(charge))
                .map(|charge| model.charges[charge].on)
                .sum();
            let found = maximum(&model, &group, Method::Cores, &Limits::default());
            assert_eq!((found.lower, found.upper), (found.upper, found.lower));
            assert_eq!(found.upper + constant, most, "seed {seed}");
            sound(&model, &group, &found);
            // A second run gives the identical result.
            assert_eq!(maximum(&model, &group, Method::Cores, &Limits::default()), found);
        }
    }

    #[test]
    fn cores_take_over_where_the_budget_for_subsets_ends() {
        let mut taken_over = 0;
        for seed in 0..60 {
            let model = random(7000 + seed, 3 + seed % 30);
            let group = Builder { model: model.clone() }.group();
            let truth = brute(&model, &group).unwrap();
            let problem = Problem::new(&model, &group);
            for questions in [0, 1, 2, 3, 5, 8, 13] {
                let limits = Limits::default();
                let mut bounds = Bounds::new(&problem, &limits);
                let budget = subsets::EffortLimit { questions, ..subsets::BUDGET };
                let end =
                    subsets::with_solver(|| subsets::search(&problem, &mut bounds, Some(budget)));
                taken_over += usize::from(end == subsets::SearchEnd::OutOfBudget);
                cores::search(&problem, &mut bounds);
                let found = bounds.finish();
                sound(&model, &group, &found);
                assert_eq!((found.lower, found.upper), (truth, truth), "seed {seed}");
            }
        }
        assert!(taken_over > 100, "{taken_over}");
    }

    #[test]
    fn small_groups_are_searched_by_subsets_as_far_as_there_are_few() {
        let mut b = Builder::default();
        let groups: Vec<Group> = (0..40)
            .map(|_| {
                let x = b.bit();
                b.charge(scanbound_model::Lit::TRUE, x, 7, 0);
                Group { charges: vec![b.model.charges.len() - 1], ..Group::default() }
            })
            .collect();
        let by = methods(&groups, Method::Auto);
        let found = maxima(&b.model, &groups, &by, &Limits::default(), &|_, _, _| {});
        let subsets = found.iter().filter(|found| found.engine == Engine::Subsets).count();
        assert!((10..40).contains(&subsets), "{subsets}");
        assert!(found[..subsets].iter().all(|found| found.engine == Engine::Subsets));
        assert!(methods(&groups, Method::Cores).iter().all(|&by| by == Method::Cores));
        // A large group goes to the core-guided search.
        let (model, _) = plant(3, 20);
        let group = Builder { model: model.clone() }.group();
        let found = maximum(&model, &group, Method::Auto, &Limits::default());
        assert_eq!(found.engine, Engine::Cores);
    }

    #[test]
    fn a_trace_does_not_depend_on_threads() {
        let (model, _) = plant(5, 12);
        let group = Builder { model: model.clone() }.group();
        let by = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let limits = Limits { trace: true, ..Limits::default() };
            pool.install(|| maximum(&model, &group, Method::Auto, &limits))
        };
        let alone = by(1);
        let cores = |step: &&Step| matches!(step, Step::Core { .. });
        assert!(alone.trace.steps.iter().filter(cores).count() > 10);
        assert!(matches!(
            alone.trace.steps.last(),
            Some(Step::Bounds { upper, lower }) if upper == lower
        ));
        for _ in 0..3 {
            assert_eq!(by(3), alone);
        }
    }

    /// Blocks 1, 4 and 6 of the paper's example: X0 and X1; not X0 or not X2; not X1.
    fn example(times: [u64; 3]) -> (Maximum, Vec<(Vec<usize>, bool)>) {
        let mut b = Builder::default();
        let x: Vec<_> = (0..3).map(|_| b.bit()).collect();
        let circuit = &mut b.model.circuit;
        let guards = [circuit.and(x[0], x[1]), circuit.or(!x[0], !x[2]), !x[1]];
        for (guard, time) in guards.into_iter().zip(times) {
            b.charge(scanbound_model::Lit::TRUE, guard, time, 0);
        }
        let limits = Limits { trace: true, ..Limits::default() };
        let found = maximum(&b.model, &b.group(), Method::Auto, &limits);
        let asked = found.trace.steps.iter().filter_map(|step| match step {
            Step::Asked { items, together, .. } => Some((items.clone(), *together)),
            _ => None,
        });
        let asked = asked.collect();
        (found, asked)
    }

    #[test]
    fn the_papers_example_is_asked_in_the_papers_order() {
        let questions =
            [(vec![0, 1, 2], false), (vec![0, 1], true), (vec![0, 2], false), (vec![1, 2], true)];
        // Blocks 1 and 6 together do not exceed the best pair, so their subsets are not tried.
        for (times, most) in [([30, 20, 10], 50), ([10, 20, 30], 50), ([10, 20, 10], 30)] {
            let (found, asked) = example(times);
            assert_eq!((found.upper, found.lower), (Picos(most), Picos(most)));
            assert_eq!(asked, questions);
        }
        // Here they exceed it, so each is tried alone.
        let (found, asked) = example([30, 5, 20]);
        assert_eq!(found.upper, Picos(35));
        let alone = [(vec![0], true), (vec![2], true)];
        assert_eq!(asked, [&questions[..], &alone].concat());
    }
}
