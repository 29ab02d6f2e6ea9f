//! A partition of the program, with a SAT solver of its own.

use super::objective::Objective;
use super::search::PartitionSearch;
use crate::formula::Formula;
use crate::limits::{Decisions, Limits};
use crate::oracle::{Branching, Effort, Oracle};
use crate::trace::Trace;
use std::cmp::Reverse;
use std::ops::Range;

/// The largest number of solver decisions, besides those for assumptions, for the question whether a core without one
/// of its literals is still a core.
const CORE_EFFORT: u64 = 30;

/// The largest number of solver decisions for each question whether one more literal of a core (a second, a third, and
/// so on) must be false.
const COUNT_EFFORT: u64 = 10;

/// In the search of a case, the reduction of a core stops after this many literals turned out to be needed.
const PATIENCE: usize = 30;

/// A partition while it is solved separately.
pub struct Partition {
    /// The positions of the partition in the order of execution; each variable of the circuit is its own position.
    pub positions: Range<usize>,
    /// The soft literals and clauses of the partition.
    pub objective: Objective,
    /// The values of the partition's variables when all its soft literals could be true together; empty if the search
    /// ended before.
    pub values: Vec<bool>,
    /// Whether the clauses of the partition are proved contradictory: no scan satisfies the constraints.
    pub contradiction: bool,
    /// The cores that were found, if a trace is requested.
    pub trace: Trace,
}

impl Partition {
    /// A partition that has not been solved yet.
    pub fn new(positions: Range<usize>, objective: Objective) -> Partition {
        let (values, trace) = (Vec::new(), Trace::default());
        Partition { positions, objective, values, contradiction: false, trace }
    }

    /// Extracts cores until all remaining soft literals can be true together, the clauses are contradictory, or the
    /// limits are reached. If this is the `whole` program, every model of the solver is a scan and is recorded.
    ///
    /// Every round goes stratum by stratum: asked for all soft literals of a project of 64 stations at once, the solver
    /// took minutes.
    pub fn solve(&mut self, search: &PartitionSearch<'_, '_>, whole: bool) {
        if search.limits.reached() {
            // Passing the clauses to a solver takes long too.
            return;
        }
        let own = search.decisions.map(Decisions::new);
        let limits =
            Limits { decisions: own.as_ref().or(search.limits.decisions), ..*search.limits };
        let patience = search.decisions.map_or(usize::MAX, |_| PATIENCE);
        let mut asker = Asker::new(search, &limits);
        let mut least = self.objective.soft_literals(1).next().map_or(1, |(_, weight)| weight);
        // The cores of this stratum, with their weights. They are relaxed only when all remaining soft literals of the
        // stratum can be true together.
        let mut cores: Vec<(Vec<i32>, u64)> = Vec::new();
        // The number of strata in the next query: doubled after each positive answer, one after a core. Most of the
        // many strata of late rounds have no core.
        let mut strata = 1;
        loop {
            search.bounds().count();
            let stratum = self.objective.soft_literals(least);
            let wanted: Vec<i32> = stratum.map(|(literal, _)| literal).collect();
            match asker.ask(&self.objective.formula, &wanted, u64::MAX) {
                None => return,
                Some(false) => {
                    let core = asker.oracle.core();
                    self.contradiction = core.is_empty();
                    if self.contradiction {
                        return;
                    }
                    let core = self.minimised(core, patience, &mut asker, &limits);
                    strata = 1;
                    let weight = self.objective.subtract_core(&core);
                    if search.limits.trace {
                        self.trace.push(search.core(&core, weight));
                    }
                    cores.push((core, weight));
                }
                Some(true) => {
                    if whole {
                        search.record_assignment(&mut self.objective, |literal| {
                            asker.oracle.holds(literal)
                        });
                    }
                    if cores.is_empty() {
                        let Some(next) = self.stratum_below(least, &asker.oracle, strata) else {
                            break;
                        };
                        least = next;
                        strata *= 2;
                    }
                    for (core, weight) in cores.drain(..) {
                        self.objective.relax(&core, weight, |formula, literal| {
                            !limits.reached()
                                && asker.ask(formula, &[literal], COUNT_EFFORT) == Some(false)
                        });
                    }
                }
            }
            search.bounds().falsified(self.objective.take_falsified());
            if limits.reached() || (whole && search.bounds().exact()) {
                return;
            }
        }
        // Each variable of the circuit is its own position.
        let variables = self.positions.clone().filter_map(|position| i32::try_from(position).ok());
        self.values = variables.map(|variable| asker.oracle.holds(variable)).collect();
    }

    /// The weight at which the next query's stratum ends, after a positive answer: at most `strata` strata below
    /// `least`. Strata whose soft literals are all true in the solver's model are not counted. `None` if no soft
    /// literal is lighter than `least`.
    fn stratum_below(&self, least: u64, oracle: &Oracle<'_>, strata: usize) -> Option<u64> {
        let mut next = self.objective.next_stratum(least)?;
        let mut left = strata - 1;
        loop {
            let kept = self.objective.soft_literals(next).all(|(literal, _)| oracle.holds(literal));
            if !kept && left == 0 {
                return Some(next);
            }
            let Some(below) = self.objective.next_stratum(next) else { return Some(next) };
            left -= usize::from(!kept);
            next = below;
        }
    }

    /// A smaller core, found with a small effort: leaves out literals without which it is still a core, until
    /// `patience` literals turned out to be needed. Cores of two are left unchanged, because soft literals that cannot
    /// be true alone are rare. For a core of thousands of literals, a query takes so long that the limits may stop it.
    fn minimised(
        &self,
        mut core: Vec<i32>,
        mut patience: usize,
        asker: &mut Asker<'_>,
        limits: &Limits<'_>,
    ) -> Vec<i32> {
        if core.len() <= 2 {
            return core;
        }
        // Remove the lightest literals first: without them the weight of the core is larger.
        core.sort_by_key(|&l| (Reverse(self.objective.weight(l)), l.unsigned_abs(), l));
        let mut at = core.len();
        while at > 0 && core.len() > 1 && patience > 0 && !limits.reached() {
            at -= 1;
            let mut rest = core.clone();
            rest.remove(at);
            let decisions = rest.len() as u64 + CORE_EFFORT;
            if asker.ask(&self.objective.formula, &rest, decisions) == Some(false) {
                let smaller = asker.oracle.core();
                core.retain(|literal| smaller.contains(literal));
                at = at.min(core.len());
            } else {
                patience -= 1;
            }
        }
        core
    }
}

/// A solver that gets the new clauses of a growing formula before each query.
struct Asker<'a> {
    limits: &'a Limits<'a>,
    /// For each variable, the value to try first, from the partitions of the round before.
    hints: &'a [bool],
    oracle: Oracle<'a>,
    /// The number of the formula's clauses that the solver already has.
    passed_clauses: usize,
    /// The conflicts that a query may take before a solver that branches on all variables takes over.
    easy: u64,
}

impl<'a> Asker<'a> {
    fn new(search: &'a PartitionSearch<'_, '_>, limits: &'a Limits<'a>) -> Asker<'a> {
        let hints = search.values.as_slice();
        let oracle = Oracle::new(limits, Branching::Inputs).with_hints(hints);
        Asker { limits, hints, oracle, passed_clauses: 0, easy: search.easy }
    }

    /// Whether the clauses of `formula` and the assumptions can be true together; `None` if this takes more than
    /// `decisions` solver decisions, or the limits are reached.
    fn ask(&mut self, formula: &Formula, assumptions: &[i32], decisions: u64) -> Option<bool> {
        let effort = Effort { decisions, conflicts: self.easy };
        let answer = self.ask_with(formula, assumptions, effort);
        if answer.is_some() || !self.oracle.had_conflicts() {
            return answer;
        }
        self.oracle = Oracle::new(self.limits, Branching::All).with_hints(self.hints);
        (self.passed_clauses, self.easy) = (0, u64::MAX);
        self.ask_with(formula, assumptions, Effort::decisions(decisions))
    }

    fn ask_with(&mut self, formula: &Formula, assumptions: &[i32], most: Effort) -> Option<bool> {
        formula.pass_to(self.passed_clauses, &mut self.oracle);
        self.passed_clauses = formula.len();
        self.oracle.ask(assumptions, most)
    }
}
