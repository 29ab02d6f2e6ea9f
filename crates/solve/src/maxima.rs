//! Computes the maxima of all groups in parallel, under one deadline.

use super::subsets::with_solver;
use super::{Decisions, Limits, Maximum, Method, Problem};
use scanbound_base::time::Picos;
use scanbound_model::Group;
use scanbound_model::ScanModel;
use std::cmp::Reverse;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The largest fraction of the remaining time that a group may use while others have not begun.
const SHARE: f64 = 0.9;

/// The largest number of small groups that are searched by subsets if the user does not choose a method. Some projects
/// have thousands of groups with a single charge, and Z3 takes a millisecond to start with one.
const FEW: usize = 24;

/// A group with more charges than this is not small, even if many of its charges have the same guard.
const CHARGES: usize = 100;

/// The search method of each group: `method`, if it is not [`Method::Auto`]; else `Auto` for the first 24 groups of at
/// most 100 charges, and [`Method::Cores`] for the others.
#[must_use]
pub fn methods(groups: &[Group], method: Method) -> Vec<Method> {
    let mut left = FEW;
    let each = groups.iter().map(|group| {
        if method == Method::Auto && (left == 0 || group.charges.len() > CHARGES) {
            return Method::Cores;
        }
        left = left.saturating_sub(1);
        method
    });
    each.collect()
}

/// Searches the maximum of every group, each by its method in `methods`, on the threads of the current rayon pool. The
/// results are in the order of the groups.
///
/// The groups share one deadline: the remaining time is divided in proportion to the groups' charges, so that a hard
/// group leaves time for the others. `each` is called with every better bound: the group's index, its upper bound, its
/// lower bound.
#[must_use]
pub fn maxima(
    model: &ScanModel,
    groups: &[Group],
    methods: &[Method],
    limits: &Limits<'_>,
    each: &(dyn Fn(usize, Picos, Picos) + Sync),
) -> Vec<Maximum> {
    // The largest group first: it takes longest, and the others run in parallel to it.
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by_key(|&group| Reverse(groups[group].charges.len()));
    // Small groups run one after the other: allocating Z3's memory for each takes longer than searching it.
    let (small, others): (Vec<usize>, Vec<usize>) =
        order.into_iter().partition(|&group| methods[group] == Method::Auto);
    let mut tasks: Vec<Vec<usize>> = others.into_iter().map(|group| vec![group]).collect();
    tasks.insert(tasks.len().min(1), small);
    let left = Mutex::new(groups.iter().map(weight).sum::<usize>());
    let results: Vec<Mutex<Option<Maximum>>> = groups.iter().map(|_| Mutex::new(None)).collect();
    let search = |group: usize| {
        let deadline = limits.deadline.map(|end| {
            let mut left = left.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let own = weight(&groups[group]);
            let share = own as f64 / *left as f64 * rayon::current_num_threads() as f64;
            *left -= own;
            let rest = end.saturating_duration_since(Instant::now());
            let last = *left == 0;
            Instant::now() + if last { rest } else { part(rest, share) }
        });
        let progress = |upper: Picos, lower: Picos| {
            (limits.progress)(upper, lower);
            each(group, upper, lower);
        };
        let decisions = limits.decisions.map(Decisions::remaining);
        let limits =
            Limits { deadline, progress: &progress, decisions: decisions.as_ref(), ..*limits };
        let problem = Problem::new(model, &groups[group]);
        let found = super::search(&problem, methods[group], &limits);
        if let Ok(mut place) = results[group].lock() {
            *place = Some(found);
        }
    };
    rayon::scope_fifo(|scope| {
        for task in &tasks {
            let search = &search;
            scope.spawn_fifo(move |_| {
                let all = || task.iter().for_each(|&group| search(group));
                match task.first().map(|&group| methods[group]) {
                    None | Some(Method::Cores) => all(),
                    // One after the other in a fixed order, so they can share one solver context.
                    Some(Method::Auto | Method::Subsets) => with_solver(all),
                }
            });
        }
    });
    let found = results.into_iter().map(|place| place.into_inner().ok().flatten());
    found
        .map(|maximum| {
            maximum.expect("each group's search stored its result before the scope ended")
        })
        .collect()
}

fn weight(group: &Group) -> usize {
    group.charges.len() + 1
}

fn part(rest: Duration, share: f64) -> Duration {
    rest.mul_f64(share.min(SHARE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Builder;
    use scanbound_model::Lit;
    use scanbound_model::groups::groups;

    #[test]
    fn a_groups_best_scan_says_nothing_of_what_decides_nothing_in_it() {
        let mut builder = Builder::default();
        let [jump, costly] = [builder.bit(), builder.bit()];
        // The skipped instruction costs the same in both cases, so the two groups share nothing.
        builder.charge(jump, costly, 3, 3);
        builder.charge(Lit::TRUE, costly, 70, 0);
        let model = builder.model;
        let groups = groups(&model);
        assert_eq!(groups.len(), 2);
        for method in [Method::Subsets, Method::Cores] {
            let found = maxima(&model, &groups, &[method; 2], &Limits::default(), &|_, _, _| {});
            for (group, maximum) in groups.iter().zip(&found) {
                let told = maximum.best.0.iter().map(|&(variable, _)| variable);
                assert_eq!(told.collect::<Vec<_>>(), group.variables);
            }
        }
    }
}
