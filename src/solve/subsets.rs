//! The paper's search: ask which guards can hold together, and take away what conflicts.

use super::bounds::Bounds;
use super::clauses::Clauses;
use super::hitting::least_hitting_set;
use super::problem::Problem;
use std::collections::{BTreeMap, BTreeSet};
use z3::ast::Bool;
use z3::{Config, Params, SatResult, Solver, with_z3_config};

/// Up to so many items the search takes away one item at a time, as the paper does; with more, it takes away
/// what unsatisfiable cores show to conflict.
const PLAIN: usize = 8;

/// Z3's own measure of effort for one question between two looks at the clock. A question that needs more
/// is asked again with twice as much.
const EFFORT: u32 = 2_000_000;

/// Searches until the bounds meet or the limits end it.
pub fn search(problem: &Problem, bounds: &mut Bounds<'_>) {
    let clauses = Clauses::new(problem);
    // A context of its own: with a shared one, equally good scans fall differently from run to run.
    with_z3_config(&Config::new(), || {
        let mut judge = Judge::new(problem, &clauses, bounds);
        let ended =
            if problem.items.len() <= PLAIN { plain(&mut judge) } else { by_cores(&mut judge) };
        // A search that is stopped leaves the bounds as far as it got.
        ended.unwrap_or(());
    });
}

/// The limits ended the search.
struct Stopped;

/// The paper's order: all items, then all sets with one item less, and so on; of an unsatisfiable set only if
/// its total is above the best satisfiable set so far.
fn plain(judge: &mut Judge<'_, '_>) -> Result<(), Stopped> {
    let all: Vec<usize> = (0..judge.problem.items.len()).collect();
    let mut level = BTreeSet::from([all]);
    while !level.is_empty() {
        let mut conflicting = Vec::new();
        for set in level {
            if !judge.ask(&set)? {
                conflicting.push(set);
            }
        }
        level = BTreeSet::new();
        let mut upper = judge.bounds.lower();
        for set in conflicting {
            if judge.total(&set) > judge.bounds.lower() {
                upper = upper.max(judge.total(&set));
                for &item in &set {
                    level.insert(set.iter().copied().filter(|&other| other != item).collect());
                }
            }
        }
        judge.bounds.proved(upper);
    }
    Ok(())
}

/// Takes away the cheapest items that break every conflict found so far, until what is left can hold together.
fn by_cores(judge: &mut Judge<'_, '_>) -> Result<(), Stopped> {
    let weights: Vec<u64> = judge.problem.items.iter().map(|item| item.weight).collect();
    let mut cores: Vec<Vec<usize>> = Vec::new();
    while !judge.bounds.exact() {
        let stop = || judge.bounds.limits().reached();
        let taken = least_hitting_set(&weights, &cores, &stop).ok_or(Stopped)?;
        let mut left: Vec<usize> =
            (0..weights.len()).filter(|item| taken.binary_search(item).is_err()).collect();
        let upper = judge.total(&left);
        judge.bounds.proved(upper);
        // Conflicts that have nothing in common, as many as there are: each lowers the bound by itself.
        while !judge.ask(&left)? {
            let core = judge.core(&left)?;
            if core.is_empty() {
                return Ok(()); // The constraints contradict each other.
            }
            left.retain(|item| !core.contains(item));
            cores.push(core);
        }
    }
    Ok(())
}

/// Z3 with the problem's clauses, and the answers it gave.
struct Judge<'a, 'b> {
    problem: &'a Problem,
    clauses: &'a Clauses,
    bounds: &'a mut Bounds<'b>,
    solver: Solver,
    variables: Vec<Bool>,
    guards: Vec<Bool>,
    answers: BTreeMap<Vec<usize>, bool>,
}

impl<'a, 'b> Judge<'a, 'b> {
    fn new(
        problem: &'a Problem,
        clauses: &'a Clauses,
        bounds: &'a mut Bounds<'b>,
    ) -> Judge<'a, 'b> {
        let solver = Solver::new_for_logic("QF_FD").unwrap_or_default();
        let variables: Vec<Bool> = (1..=clauses.variables)
            .map(|v| Bool::new_const(u32::try_from(v).unwrap_or(0)))
            .collect();
        let literal = |literal: i32| {
            let variable = &variables[literal.unsigned_abs() as usize - 1];
            if literal < 0 { variable.not() } else { variable.clone() }
        };
        for clause in &clauses.clauses {
            let literals: Vec<Bool> = clause.iter().map(|&l| literal(l)).collect();
            solver.assert(Bool::or(&literals));
        }
        let guards = clauses.items.iter().map(|&l| literal(l)).collect();
        Judge { problem, clauses, bounds, solver, variables, guards, answers: BTreeMap::new() }
    }

    /// What these items and the constant cost together.
    fn total(&self, items: &[usize]) -> u64 {
        items.iter().map(|&item| self.problem.items[item].weight).sum::<u64>()
            + self.problem.constant
    }

    /// Whether these items can hold together. Takes note of the scan in which they do.
    fn ask(&mut self, items: &[usize]) -> Result<bool, Stopped> {
        if let Some(&answer) = self.answers.get(items) {
            return Ok(answer);
        }
        let answer = self.check(items)?;
        self.bounds.asked(items, answer);
        if answer {
            let model = self.solver.get_model();
            let holds = |variable: i32| {
                let variable = &self.variables[variable.unsigned_abs() as usize - 1];
                let value = model.as_ref().and_then(|model| model.eval(variable, true));
                value.and_then(|value| value.as_bool()).unwrap_or(false)
            };
            self.bounds.found(self.clauses.assignment(self.problem, holds));
        }
        self.answers.insert(items.to_vec(), answer);
        Ok(answer)
    }

    /// Of items that cannot hold together, some that cannot either, none of them to spare.
    fn core(&mut self, items: &[usize]) -> Result<Vec<usize>, Stopped> {
        let mut core = items.to_vec();
        if !self.check(items)? {
            let named = self.solver.get_unsat_core();
            core.retain(|&item| named.contains(&self.guards[item]));
        }
        // The dearest are tried first: a core of cheap items costs least to break.
        let mut order = core.clone();
        order.sort_by_key(|&item| std::cmp::Reverse(self.problem.items[item].weight));
        for item in order {
            let rest: Vec<usize> = core.iter().copied().filter(|&other| other != item).collect();
            if !self.ask(&rest)? {
                core = rest;
            }
        }
        Ok(core)
    }

    fn check(&mut self, items: &[usize]) -> Result<bool, Stopped> {
        let assumptions: Vec<Bool> = items.iter().map(|&item| self.guards[item].clone()).collect();
        let mut effort = EFFORT;
        loop {
            if self.bounds.limits().reached() {
                return Err(Stopped);
            }
            let mut params = Params::new();
            params.set_u32("rlimit", effort);
            self.solver.set_params(&params);
            self.bounds.count();
            match self.solver.check_assumptions(&assumptions) {
                SatResult::Sat => return Ok(true),
                SatResult::Unsat => return Ok(false),
                SatResult::Unknown => effort = effort.saturating_mul(2),
            }
        }
    }
}
