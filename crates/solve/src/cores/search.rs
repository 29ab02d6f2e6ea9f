//! What all partitions of a search have in common.

use super::objective::Objective;
use crate::bounds::Bounds;
use crate::clauses::Clauses;
use crate::limits::Limits;
use crate::problem::Problem;
use crate::trace::Step;
use scanbound_base::time::Picos;
use scanbound_model::VarId;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What all partitions have in common.
pub(super) struct Search<'a, 'b> {
    pub(super) problem: &'a Problem,
    pub(super) clauses: &'a Clauses,
    /// By item of the clauses: which it is of the problem's, if it is one.
    pub(super) origins: &'a [Option<usize>],
    pub(super) limits: &'b Limits<'b>,
    /// The decisions that each partition may take, if the search may be given up.
    pub(super) decisions: Option<u64>,
    /// How many conflicts an easy question takes at most.
    pub(super) easy: u64,
    pub(super) bounds: Mutex<&'a mut Bounds<'b>>,
    /// By variable of the circuit, from 1: its value in the last scan found for its partition. Empty in the first round.
    pub(super) values: Vec<bool>,
    /// By variable: 1 where it is true in the case that is searched, -1 where it is false. Empty where that is all there is.
    pub(super) fixed: &'a [i8],
    /// The bits that most clauses ask for.
    pub(super) modes: &'a [VarId],
}

impl<'a, 'b> Search<'a, 'b> {
    pub(super) fn bounds(&self) -> MutexGuard<'_, &'a mut Bounds<'b>> {
        self.bounds.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn done(&self) -> bool {
        self.bounds().exact() || self.limits.reached()
    }

    /// What the trace says of a core of this weight.
    pub(super) fn core(&self, core: &[i32], weight: u64) -> Step {
        let items = self.clauses.items.iter().zip(self.origins);
        let items: Vec<usize> = items
            .filter(|(guard, _)| core.contains(guard))
            .filter_map(|(_, origin)| *origin)
            .collect();
        Step::Core { counts: core.len().saturating_sub(items.len()), items, weight: Picos(weight) }
    }

    /// Takes note of a model of the whole. A soft literal that weighs more than the gap between the bounds is true in
    /// every better one, so it is hardened: it becomes a clause.
    pub(super) fn found(&self, objective: &mut Objective, holds: impl Fn(i32) -> bool) {
        let mut bounds = self.bounds();
        bounds.falsified(objective.take_falsified());
        let holds = |literal: i32| match self.fixed.get(literal.unsigned_abs() as usize) {
            None | Some(0) => holds(literal),
            Some(fixed) => (*fixed > 0) == (literal > 0),
        };
        bounds.found(self.clauses.assignment(self.problem, holds));
        let heavy = objective.soft_literals(bounds.gap() + 1).map(|(literal, _)| literal);
        heavy.collect::<Vec<i32>>().into_iter().for_each(|literal| objective.harden(literal));
    }
}
