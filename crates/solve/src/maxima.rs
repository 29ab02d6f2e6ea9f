//! The maxima of all groups, side by side under one deadline.

use super::subsets::with_solver;
use super::{Decisions, Limits, Maximum, Method, Problem};
use scanbound_base::time::Picos;
use scanbound_model::Group;
use scanbound_model::ScanModel;
use std::cmp::Reverse;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Of the time left, the part that one round of groups may take; what they leave over is the next ones'.
const SHARE: f64 = 0.9;

/// The most small groups that are searched by subsets where the method is not stated. Some projects have thousands of a
/// single charge, and Z3 takes a millisecond to begin with one.
const FEW: usize = 24;

/// A group of more charges is not small: it is not looked at how many different guards they have.
const CHARGES: usize = 100;

/// How each of a scan's groups is searched: of those that look small the first few as `Method::Auto` says, the
/// others by cores, unless the method is stated.
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

/// The maximum of every group, in the groups' order, on the threads of the rayon pool this is called in.
///
/// The groups share the one deadline: each may take of the time that is left what its charges are of all the
/// charges that are left, so that a hard group leaves time for the others. `each` is told of every better
/// bound: the group's index, its upper and its lower bound.
#[must_use]
pub fn maxima(
    model: &ScanModel,
    groups: &[Group],
    methods: &[Method],
    limits: &Limits<'_>,
    each: &(dyn Fn(usize, Picos, Picos) + Sync),
) -> Vec<Maximum> {
    // The largest first: it takes longest, and the others fit beside it.
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by_key(|&group| Reverse(groups[group].charges.len()));
    // Small groups follow each other: to take Z3's memory for each takes longer than to search it.
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
        let decisions = limits.decisions.map(Decisions::again);
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
                    // One after the other, always the same: so they may share one solver context.
                    Some(Method::Auto | Method::Subsets) => with_solver(all),
                }
            });
        }
    });
    let found = results.into_iter().map(|place| place.into_inner().ok().flatten());
    found.map(|maximum| maximum.expect("the scope ends when every group is done")).collect()
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
        let [jump, dear] = [builder.bit(), builder.bit()];
        // What is jumped over costs the same on and off, so that the two groups share nothing.
        builder.charge(jump, dear, 3, 3);
        builder.charge(Lit::TRUE, dear, 70, 0);
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
