//! Finds the charges of a model that no scan reaches.

use super::clauses::Clauses;
use super::oracle::{Branching, Effort, Oracle};
use super::problem::Problem;
use super::{Group, Limits};
use scanbound_model::{Lit, ScanModel};
use std::collections::BTreeSet;

/// The largest number of solver decisions of one query.
const DECISIONS: u64 = 500_000;

/// The charges of a group (indices into [`ScanModel::charges`]) that are proved to take no time in any scan. If neither
/// of a charge's two times is 0, this means that no scan reaches it. The others may be reachable or not: a query may
/// take too long, or the limits may end the search.
#[must_use]
pub fn unreachable_charges(
    model: &ScanModel,
    group: &Group,
    limits: &Limits<'_>,
) -> BTreeSet<usize> {
    let problem = Problem::with_negations(model, group);
    let clauses = Clauses::new(&problem);
    let mut oracle = Oracle::new(limits, Branching::Inputs);
    clauses.clauses.iter().for_each(|clause| oracle.add(clause));
    let always = |&charge: &usize| model.charges[charge].reached == Lit::TRUE;
    let mut open: BTreeSet<usize> = group.charges.iter().copied().filter(always).collect();
    for (item, &happens) in problem.items.iter().zip(&clauses.items) {
        if limits.reached() || oracle.ask(&[happens], Effort::decisions(DECISIONS)) != Some(false) {
            open.extend(&item.charges);
        }
    }
    group.charges.iter().copied().filter(|charge| !open.contains(charge)).collect()
}
