//! The data that all partitions of a search share.

use super::objective::Objective;
use crate::bounds::Bounds;
use crate::clauses::Clauses;
use crate::limits::Limits;
use crate::problem::Problem;
use crate::trace::Step;
use scanbound_base::time::Picos;
use scanbound_model::VarId;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The data that all partitions share.
pub(super) struct PartitionSearch<'a, 'b> {
    pub(super) problem: &'a Problem,
    pub(super) clauses: &'a Clauses,
    /// For each item of the clauses, the index of the original item. `None` if several items were combined.
    pub(super) origins: &'a [Option<usize>],
    pub(super) limits: &'b Limits<'b>,
    /// The solver decisions that each partition may use; `None` if only `limits` limits them.
    pub(super) decisions: Option<u64>,
    /// The largest number of conflicts of a query before a solver that branches on all variables takes over.
    pub(super) easy: u64,
    pub(super) bounds: Mutex<&'a mut Bounds<'b>>,
    /// For each variable of the circuit, from 1: its value in the last scan found for its partition. Empty in the first
    /// round.
    pub(super) values: Vec<bool>,
    /// By variable: 1 or -1 if it is fixed to true or false in the current case. Empty if there are no cases.
    pub(super) fixed: &'a [i8],
    /// The bit variables that occur in most clauses. They are tried with both values when the partitions' best scans
    /// are combined to one scan.
    pub(super) modes: &'a [VarId],
}

impl<'a, 'b> PartitionSearch<'a, 'b> {
    pub(super) fn bounds(&self) -> MutexGuard<'_, &'a mut Bounds<'b>> {
        self.bounds.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn done(&self) -> bool {
        self.bounds().exact() || self.limits.reached()
    }

    /// The trace entry of a core of this weight (picoseconds).
    pub(super) fn core(&self, core: &[i32], weight: u64) -> Step {
        let items = self.clauses.items.iter().zip(self.origins);
        let items: Vec<usize> = items
            .filter(|(guard, _)| core.contains(guard))
            .filter_map(|(_, origin)| *origin)
            .collect();
        Step::Core { counts: core.len().saturating_sub(items.len()), items, weight: Picos(weight) }
    }

    /// Records a solver's model of the whole program as a scan. A soft literal that then weighs more than the gap
    /// between the bounds is true in every better scan, so it is hardened: it becomes a clause.
    pub(super) fn record_assignment(&self, objective: &mut Objective, holds: impl Fn(i32) -> bool) {
        let mut bounds = self.bounds();
        bounds.falsified(objective.take_falsified());
        let holds = |literal: i32| match self.fixed.get(literal.unsigned_abs() as usize) {
            None | Some(0) => holds(literal),
            Some(fixed) => (*fixed > 0) == (literal > 0),
        };
        bounds.record_assignment(self.clauses.assignment(self.problem, holds));
        let heavy = objective.soft_literals(bounds.gap() + 1).map(|(literal, _)| literal);
        heavy.collect::<Vec<i32>>().into_iter().for_each(|literal| objective.harden(literal));
    }
}
