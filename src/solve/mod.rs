//! The maximum of one group: the most that its charges can cost in one scan.

mod bounds;
mod clauses;
mod cores;
mod explain;
pub mod export;
mod formula;
mod hitting;
mod maxima;
mod oracle;
mod problem;
mod propagator;
mod subsets;
mod totalizer;

pub use explain::exclusions;
pub use maxima::maxima;
pub use problem::{Item, Problem};

use crate::model::{Assignment, Group, ScanModel};
use crate::time::Picos;
use bounds::Bounds;
use std::time::Instant;

/// Which search to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The one that suits the group.
    #[default]
    Auto,
    /// The paper's: take away what conflicts, one at a time, bounded by T_MAX.
    Subsets,
    /// Core-guided search.
    Cores,
}

/// What was found out about a group's maximum.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Maximum {
    /// No scan costs more.
    pub upper: Picos,
    /// The assignment below costs this.
    pub lower: Picos,
    /// Values of all variables of the model; 0 outside the group. It keeps the group's constraints, unless
    /// the search ended before any assignment that keeps them was found (or there is none): then all are 0
    /// and so is `lower`.
    pub best: Assignment,
    /// Questions put to a solver.
    pub calls: u64,
}

/// What a search may use and whom it tells.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// When to stop with what is proved.
    pub deadline: Option<Instant>,
    /// Asked now and then; true stops the search as the deadline does.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Told of every better bound: upper and lower.
    pub progress: &'a (dyn Fn(Picos, Picos) + Sync),
    /// Told of every question of `Method::Subsets`: whether these charges (indices into
    /// `ScanModel::charges`, ascending) can all cost their most in one scan, and the answer.
    pub asked: &'a (dyn Fn(&[usize], bool) + Sync),
}

impl Default for Limits<'_> {
    /// No limit, and nobody is told.
    fn default() -> Self {
        Limits { deadline: None, cancelled: &|| false, progress: &|_, _| {}, asked: &|_, _| {} }
    }
}

impl Limits<'_> {
    /// Whether to stop with what is proved.
    fn reached(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline) || (self.cancelled)()
    }
}

/// The group's maximum. The bounds are valid however early the search ends.
#[must_use]
pub fn maximum(model: &ScanModel, group: &Group, method: Method, limits: &Limits<'_>) -> Maximum {
    let problem = Problem::new(model, group);
    let mut bounds = Bounds::new(&problem, limits);
    match method {
        Method::Subsets => subsets::search(&problem, &mut bounds),
        Method::Auto | Method::Cores => cores::search(&problem, &mut bounds),
    }
    bounds.finish()
}

#[cfg(test)]
mod testing;

#[cfg(test)]
mod tests {
    use super::testing::{Builder, equals_brute, plant, sound};
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn all_groups_keep_their_order() {
        let mut b = Builder::default();
        let groups: Vec<Group> = (0..40)
            .map(|n| {
                let (x, y) = (b.bit(), b.bit());
                let both = b.model.circuit.and(x, y);
                let first = b.model.charges.len();
                b.charge(crate::model::Lit::TRUE, both, 100 + n, 0);
                b.charge(crate::model::Lit::TRUE, !x, 7, 0);
                let charges = (first..first + 2).collect();
                Group { charges, ..Group::default() }
            })
            .collect();
        let deadline = Some(std::time::Instant::now() + std::time::Duration::from_secs(3600));
        let limits = Limits { deadline, ..Limits::default() };
        let found = maxima(&b.model, &groups, Method::Auto, &limits, &|_, _, _| {});
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
            // And again, to the last bit.
            assert_eq!(maximum(&model, &group, Method::Cores, &Limits::default()), found);
        }
    }

    /// Blocks 1, 4 and 6 of the paper's example: X0 and X1; not X0 or not X2; not X1.
    fn example(times: [u64; 3]) -> (Maximum, Vec<(Vec<usize>, bool)>) {
        let mut b = Builder::default();
        let x: Vec<_> = (0..3).map(|_| b.bit()).collect();
        let circuit = &mut b.model.circuit;
        let guards = [circuit.and(x[0], x[1]), circuit.or(!x[0], !x[2]), !x[1]];
        for (guard, time) in guards.into_iter().zip(times) {
            b.charge(crate::model::Lit::TRUE, guard, time, 0);
        }
        let asked = Mutex::new(Vec::new());
        let note = |charges: &[usize], answer: bool| {
            asked.lock().unwrap().push((charges.to_vec(), answer));
        };
        let limits = Limits { asked: &note, ..Limits::default() };
        let found = maximum(&b.model, &b.group(), Method::Subsets, &limits);
        (found, asked.into_inner().unwrap())
    }

    #[test]
    fn the_papers_example_is_asked_in_the_papers_order() {
        let questions =
            [(vec![0, 1, 2], false), (vec![0, 1], true), (vec![0, 2], false), (vec![1, 2], true)];
        // Blocks 1 and 6 together are not above the best pair, so they are not taken apart.
        for (times, most) in [([30, 20, 10], 50), ([10, 20, 30], 50), ([10, 20, 10], 30)] {
            let (found, asked) = example(times);
            assert_eq!((found.upper, found.lower), (Picos(most), Picos(most)));
            assert_eq!(asked, questions);
        }
        // They are above it here, so each is asked alone.
        let (found, asked) = example([30, 5, 20]);
        assert_eq!(found.upper, Picos(35));
        let alone = [(vec![0], true), (vec![2], true)];
        assert_eq!(asked, [&questions[..], &alone].concat());
    }
}
