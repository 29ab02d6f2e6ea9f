//! Explains why a charge does not have its largest cost: a minimal set of charges that exclude it by having theirs.

use super::Limits;
use super::clauses::Clauses;
use super::formula::Formula;
use super::oracle::{Branching, Effort, Oracle};
use super::problem::Problem;
use scanbound_model::{Assignment, Group, ScanModel};
use std::cmp::Reverse;

/// The number of decisions of the solver for one query, besides one for each assumption. If this is not enough, there
/// is no explanation.
const EFFORT: u64 = 10_000;

/// Finds out why charges of a group do not have their largest times in a scan: which other charges exclude that by
/// having theirs.
pub struct Exclusions<'a> {
    problem: Problem,
    subset_search: SubsetSearch<'a>,
}

impl<'a> Exclusions<'a> {
    /// Prepares everything that does not depend on a particular scan, which is most of the work.
    #[must_use]
    pub fn of(model: &ScanModel, group: &Group, limits: &Limits<'a>) -> Exclusions<'a> {
        let problem = Problem::with_negations(model, group);
        let subset_search = SubsetSearch::new(Clauses::new(&problem), limits);
        Exclusions { problem, subset_search }
    }

    /// For each wanted charge (an index into `ScanModel::charges` of the same model) that does not have its largest
    /// cost under the assignment: a minimal set of charges that have their largest cost, which exclude that the wanted
    /// charge has its largest cost too. The set is empty if the wanted charge can never have it. `None` if the wanted
    /// charge has its largest cost, if nothing excludes that, or if no reason is found within the effort and the
    /// limits.
    pub fn in_scan(
        &mut self,
        model: &ScanModel,
        assignment: &Assignment,
        wanted: &[usize],
    ) -> Vec<Option<Vec<usize>>> {
        let Exclusions { problem, subset_search } = self;
        let values = problem.circuit.evaluate(&problem.restricted(assignment));
        let items = 0..problem.items.len();
        let mut running: Vec<usize> =
            items.clone().filter(|&item| values.get(problem.items[item].guard)).collect();
        running.sort_by_key(|&item| Reverse(problem.items[item].weight));
        wanted
            .iter()
            .map(|charge| {
                let missing = items
                    .clone()
                    .filter(|&item| !values.get(problem.items[item].guard))
                    .filter(|&item| problem.items[item].charges.contains(charge))
                    .max_by_key(|&item| problem.items[item].weight)?;
                let reason = subset_search.reason(missing, &running)?;
                let largest = |item: usize| {
                    let charges = problem.items[item].charges.iter().rev().copied();
                    charges.max_by_key(|&charge| model.charges[charge].largest_cost())
                };
                Some(reason.into_iter().filter_map(largest).collect())
            })
            .collect()
    }
}

struct SubsetSearch<'a> {
    oracle: Oracle<'a>,
    guards: Vec<i32>,
}

impl<'a> SubsetSearch<'a> {
    fn new(mut clauses: Clauses, limits: &Limits<'a>) -> SubsetSearch<'a> {
        let mut oracle = Oracle::new(limits, Branching::Inputs);
        Formula::new(&mut clauses).pass_to(0, &mut oracle);
        SubsetSearch { oracle, guards: clauses.items }
    }

    /// A minimal subset of `running` (true items, heaviest first) that together exclude the item `missing`. Empty if
    /// the item alone is impossible. `None` if they do not exclude it, or a query takes too long.
    fn reason(&mut self, missing: usize, running: &[usize]) -> Option<Vec<usize>> {
        if !self.conflict(missing, running)? {
            return None;
        }
        let named = self.oracle.core();
        let mut reason: Vec<usize> =
            running.iter().copied().filter(|&item| named.contains(&self.guards[item])).collect();
        // The lightest are removed first, because a reason with heavy items says more.
        for item in reason.clone().into_iter().rev() {
            let rest: Vec<usize> = reason.iter().copied().filter(|&o| o != item).collect();
            if self.conflict(missing, &rest)? {
                reason = rest;
            }
        }
        Some(reason)
    }

    fn conflict(&mut self, missing: usize, others: &[usize]) -> Option<bool> {
        let assumptions: Vec<i32> =
            [missing].iter().chain(others).map(|&item| self.guards[item]).collect();
        let decisions = EFFORT + assumptions.len() as u64;
        self.oracle.ask(&assumptions, Effort::decisions(decisions)).map(|together| !together)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Builder;
    use super::*;
    use scanbound_model::Lit;

    #[test]
    fn a_reason_names_only_what_excludes() {
        let mut b = Builder::default();
        let x: Vec<Lit> = (0..4).map(|_| b.bit()).collect();
        let both = b.model.circuit.and(!x[0], !x[1]);
        for (guard, time) in [(x[0], 30), (x[2], 40), (both, 20), (x[1], 10), (!x[0], 5), (x[3], 1)]
        {
            b.charge(Lit::TRUE, guard, time, 0);
        }
        b.model.constraints.push(!x[3]);
        let best = Assignment(vec![1, 1, 1, 0]);
        let limits = Limits::default();
        let mut exclusions = Exclusions::of(&b.model, &b.group(), &limits);
        let found = exclusions.in_scan(&b.model, &best, &[0, 2, 4, 5]);
        // Charge 2 is excluded by 0 and by 3, of which the heavier is named; 4 by 0 alone; 5 by the constraint.
        assert_eq!(found, [None, Some(vec![0]), Some(vec![0]), Some(vec![])]);
    }

    #[test]
    fn what_could_run_too_has_no_reason() {
        let mut b = Builder::default();
        let (x, y) = (b.bit(), b.bit());
        b.charge(Lit::TRUE, x, 3, 0);
        b.charge(Lit::TRUE, y, 3, 0);
        let best = Assignment(vec![1, 0]);
        let limits = Limits::default();
        let mut exclusions = Exclusions::of(&b.model, &b.group(), &limits);
        assert_eq!(exclusions.in_scan(&b.model, &best, &[1]), [None]);
    }
}
