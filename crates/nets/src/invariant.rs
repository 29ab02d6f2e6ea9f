//! Place invariants: weights of places such that no firing changes the weighted sum of tokens. Found by Farkas'
//! algorithm.
//!
//! If the weighted sum is 1 in the initial marking, no two places of the invariant are ever marked together, and none
//! has two tokens. This holds however many markings the net has.

use super::{Net, Transition};

/// One weight for each place.
pub type Weights = Vec<i64>;

/// Place invariants with non-negative weights: all minimal ones if the number of rows stays within the limit, else some
/// of them.
#[must_use]
pub fn invariants(net: &Net, limit: usize) -> Vec<Weights> {
    let width = net.transitions.len();
    // Each row holds the remaining columns of the incidence matrix, and the weights whose combination gave them.
    let mut rows: Vec<(Vec<i64>, Weights)> = (0..net.places)
        .map(|place| {
            let mut change = vec![0; width];
            for (at, transition) in net.transitions.iter().enumerate() {
                change[at] -= count(&transition.inputs, place);
                change[at] += count(&transition.outputs, place);
            }
            let mut weights = vec![0; net.places];
            weights[place] = 1;
            (change, weights)
        })
        .collect();
    let mut open: Vec<usize> = (0..width).collect();
    while let Some(column) = cheapest(&rows, &mut open) {
        let (mut kept, moved): (Vec<_>, Vec<_>) =
            rows.into_iter().partition(|(change, _)| change[column] == 0);
        let (gains, losses): (Vec<_>, Vec<_>) =
            moved.into_iter().partition(|(change, _)| change[column] > 0);
        'all: for gain in &gains {
            for loss in &losses {
                if kept.len() >= limit {
                    break 'all;
                }
                if let Some(row) = combined(gain, loss, column) {
                    add_minimal(&mut kept, row);
                }
            }
        }
        rows = kept;
    }
    rows.into_iter().map(|(_, weights)| weights).collect()
}

/// Transition invariants with non-negative weights: how often each transition fires so that every place has as many
/// tokens as before. All minimal ones if the number of rows stays within the limit, else some of them.
#[must_use]
pub fn transition_invariants(net: &Net, limit: usize) -> Vec<Weights> {
    let mut transposed = Net { places: net.transitions.len(), ..Net::default() };
    transposed.transitions.resize(net.places, Transition::default());
    for (at, transition) in net.transitions.iter().enumerate() {
        transition.inputs.iter().for_each(|&place| transposed.transitions[place].inputs.push(at));
        transition.outputs.iter().for_each(|&place| transposed.transitions[place].outputs.push(at));
    }
    invariants(&transposed, limit)
}

fn count(places: &[usize], place: usize) -> i64 {
    places.iter().filter(|&&one| one == place).map(|_| 1).sum()
}

/// Removes from `open` the column whose elimination creates the fewest rows, and returns it.
fn cheapest(rows: &[(Vec<i64>, Weights)], open: &mut Vec<usize>) -> Option<usize> {
    let price = |column: usize| -> usize {
        let gains = rows.iter().filter(|(change, _)| change[column] > 0).count();
        let losses = rows.iter().filter(|(change, _)| change[column] < 0).count();
        gains * losses
    };
    let (at, _) = open.iter().enumerate().min_by_key(|&(_, &column)| price(column))?;
    Some(open.swap_remove(at))
}

/// The positive combination of two rows in which this column is 0; `None` on overflow.
fn combined(
    (gain, for_gain): &(Vec<i64>, Weights),
    (loss, for_loss): &(Vec<i64>, Weights),
    column: usize,
) -> Option<(Vec<i64>, Weights)> {
    let (first, second) = (loss[column].checked_neg()?, gain[column]);
    let add = |one: &[i64], other: &[i64]| -> Option<Vec<i64>> {
        one.iter()
            .zip(other)
            .map(|(&a, &b)| a.checked_mul(first)?.checked_add(b.checked_mul(second)?))
            .collect()
    };
    let (mut change, mut weights) = (add(gain, loss)?, add(for_gain, for_loss)?);
    let divisor = change.iter().chain(&weights).fold(0, |a, &b| common(a, b.abs()));
    if divisor > 1 {
        change.iter_mut().chain(&mut weights).for_each(|number| *number /= divisor);
    }
    Some((change, weights))
}

fn common(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { common(b, a % b) }
}

/// Adds a row unless its places include all places of an existing row; removes existing rows whose places include all
/// of its places.
fn add_minimal(rows: &mut Vec<(Vec<i64>, Weights)>, row: (Vec<i64>, Weights)) {
    let within =
        |one: &Weights, other: &Weights| one.iter().zip(other).all(|(&a, &b)| a == 0 || b != 0);
    if rows.iter().any(|(_, weights)| within(weights, &row.1)) {
        return;
    }
    rows.retain(|(_, weights)| !within(&row.1, weights));
    rows.push(row);
}

/// The place invariants whose weighted sum is 1 in the initial marking, as sets of places: at most one place of a set
/// is marked, with one token.
#[must_use]
pub fn exclusive(net: &Net, limit: usize) -> Vec<Vec<usize>> {
    let sum = |weights: &Weights| net.initial.iter().map(|&place| weights[place]).sum::<i64>();
    let found = invariants(net, limit).into_iter().filter(|weights| sum(weights) == 1);
    found.map(|weights| (0..net.places).filter(|&place| weights[place] > 0).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reach::reach;
    use crate::testing::net;

    #[test]
    fn invariants_keep_places_apart_as_the_markings_do() {
        let net = net(5, &[0], &[(&[0], &[1, 2]), (&[1], &[3]), (&[2, 3], &[4]), (&[4], &[0])]);
        let mut found = exclusive(&net, 100);
        found.sort();
        assert_eq!(found, [vec![0, 1, 3, 4], vec![0, 2, 4]]);
        let reached = reach(&net, 100);
        for group in found {
            for (at, &one) in group.iter().enumerate() {
                assert!(
                    group[at + 1..].iter().all(|&other| !reached.together[one].contains(other))
                );
            }
        }
    }

    #[test]
    fn transition_invariants_lead_back_to_the_marking_they_began_in() {
        let net = net(3, &[0], &[(&[0], &[1, 1]), (&[1], &[2]), (&[2, 2], &[0]), (&[1], &[])]);
        assert_eq!(transition_invariants(&net, 100), [vec![1, 2, 1, 0]]);
    }

    #[test]
    fn a_net_that_gains_tokens_has_none() {
        assert!(
            exclusive(&net(2, &[0], &[(&[0], &[0, 1])]), 100).iter().all(|group| group == &[0])
        );
    }
}
