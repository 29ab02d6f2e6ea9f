//! The maxima of all groups, side by side under one deadline.

use super::{Limits, Maximum, Method, maximum};
use crate::model::Group;
use crate::model::ScanModel;
use crate::time::Picos;
use std::cmp::Reverse;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Of the time left, the part that one round of groups may take; what they leave over is the next ones'.
const SHARE: f64 = 0.9;

/// The maximum of every group, in the groups' order, on the threads of the rayon pool this is called in.
///
/// The groups share the one deadline: each may take of the time that is left what its charges are of all the
/// charges that are left, so that a hard group leaves time for the others. `each` is told of every better
/// bound: the group's index, its upper and its lower bound.
#[must_use]
pub fn maxima(
    model: &ScanModel,
    groups: &[Group],
    method: Method,
    limits: &Limits<'_>,
    each: &(dyn Fn(usize, Picos, Picos) + Sync),
) -> Vec<Maximum> {
    // The largest first: it takes longest, and the others fit beside it.
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by_key(|&group| Reverse(groups[group].charges.len()));
    let left = Mutex::new(order.iter().map(|&group| weight(&groups[group])).sum::<usize>());
    let results: Vec<Mutex<Option<Maximum>>> = groups.iter().map(|_| Mutex::new(None)).collect();
    rayon::scope_fifo(|scope| {
        for &group in &order {
            let (left, results) = (&left, &results);
            scope.spawn_fifo(move |_| {
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
                let limits = Limits { deadline, progress: &progress, ..*limits };
                let found = maximum(model, &groups[group], method, &limits);
                if let Ok(mut place) = results[group].lock() {
                    *place = Some(found);
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
