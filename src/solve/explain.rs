//! Why a charge does not cost its most: a smallest set of charges that do and keep it from it.

use super::clauses::Clauses;
use super::problem::Problem;
use crate::model::{Assignment, Group, ScanModel};
use std::cmp::Reverse;
use z3::ast::Bool;
use z3::{Config, Params, SatResult, Solver, with_z3_config};

/// Z3's own measure of effort for one question; what takes more is left unexplained.
const EFFORT: u32 = 500_000;

/// For each wanted charge (an index into `ScanModel::charges`) that does not cost its most under the
/// assignment: charges that do and together keep it from it, none of them to spare; empty if it never can.
/// `None` if the charge costs its most, or nothing keeps it from that, or no reason is found in short time.
#[must_use]
pub fn exclusions(
    model: &ScanModel,
    group: &Group,
    assignment: &Assignment,
    wanted: &[usize],
) -> Vec<Option<Vec<usize>>> {
    let problem = Problem::with_negations(model, group);
    let values = problem.circuit.evaluate(assignment);
    let mut running: Vec<usize> =
        (0..problem.items.len()).filter(|&item| values.get(problem.items[item].guard)).collect();
    running.sort_by_key(|&item| Reverse(problem.items[item].weight));
    // A context of its own, so that the reasons do not depend on what else was asked.
    with_z3_config(&Config::new(), || {
        let judge = Judge::new(&Clauses::new(&problem));
        wanted
            .iter()
            .map(|charge| {
                let missing = (0..problem.items.len())
                    .filter(|item| !running.contains(item))
                    .filter(|&item| problem.items[item].charges.contains(charge))
                    .max_by_key(|&item| problem.items[item].weight)?;
                let reason = judge.reason(missing, &running)?;
                let dearest = |item: usize| {
                    let charges = problem.items[item].charges.iter().rev().copied();
                    charges.max_by_key(|&charge| model.charges[charge].dearer())
                };
                Some(reason.into_iter().filter_map(dearest).collect())
            })
            .collect()
    })
}

struct Judge {
    solver: Solver,
    guards: Vec<Bool>,
}

impl Judge {
    fn new(clauses: &Clauses) -> Judge {
        let solver = Solver::new_for_logic("QF_FD").unwrap_or_default();
        let mut params = Params::new();
        params.set_u32("rlimit", EFFORT);
        solver.set_params(&params);
        let variables: Vec<Bool> = (1..=clauses.variables)
            .map(|v| Bool::new_const(u32::try_from(v).unwrap_or(u32::MAX)))
            .collect();
        let literal = |literal: i32| {
            let variable = &variables[literal.unsigned_abs() as usize - 1];
            if literal < 0 { variable.not() } else { variable.clone() }
        };
        for clause in &clauses.clauses {
            let literals: Vec<Bool> = clause.iter().map(|&l| literal(l)).collect();
            solver.assert(Bool::or(&literals));
        }
        Judge { solver, guards: clauses.items.iter().map(|&l| literal(l)).collect() }
    }

    /// Of the running items, the dearest first, some that the missing one cannot hold together with, none to spare.
    fn reason(&self, missing: usize, running: &[usize]) -> Option<Vec<usize>> {
        if !self.conflict(missing, running)? {
            return None;
        }
        let named = self.solver.get_unsat_core();
        let mut reason: Vec<usize> =
            running.iter().copied().filter(|&item| named.contains(&self.guards[item])).collect();
        // The cheapest are tried first: a reason of dear items says more.
        for &item in running.iter().rev() {
            if reason.contains(&item) {
                let rest: Vec<usize> = reason.iter().copied().filter(|&o| o != item).collect();
                if self.conflict(missing, &rest)? {
                    reason = rest;
                }
            }
        }
        Some(reason)
    }

    fn conflict(&self, missing: usize, others: &[usize]) -> Option<bool> {
        let assumptions: Vec<Bool> =
            others.iter().chain([&missing]).map(|&item| self.guards[item].clone()).collect();
        match self.solver.check_assumptions(&assumptions) {
            SatResult::Sat => Some(false),
            SatResult::Unsat => Some(true),
            SatResult::Unknown => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Builder;
    use super::*;
    use crate::model::Lit;

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
        let found = exclusions(&b.model, &b.group(), &best, &[0, 2, 4, 5]);
        // Charge 2 is excluded by 0 and by 3, of which the dearer is named; 4 by 0 alone; 5 by the constraint.
        assert_eq!(found, [None, Some(vec![0]), Some(vec![0]), Some(vec![])]);
    }

    #[test]
    fn what_could_run_too_has_no_reason() {
        let mut b = Builder::default();
        let (x, y) = (b.bit(), b.bit());
        b.charge(Lit::TRUE, x, 3, 0);
        b.charge(Lit::TRUE, y, 3, 0);
        let best = Assignment(vec![1, 0]);
        assert_eq!(exclusions(&b.model, &b.group(), &best, &[1]), [None]);
    }
}
