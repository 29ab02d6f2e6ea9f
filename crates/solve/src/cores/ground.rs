//! The problem that all cases share, and the rounds of the search on it.

use super::objective::Objective;
use super::search::PartitionSearch;
use crate::bounds::Bounds;
use crate::clauses::Clauses;
use crate::formula::Formula;
use crate::problem::Problem;
use crate::trace::Step;
use scanbound_model::VarId;
use std::sync::Mutex;

/// The parameters with which a search begins.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    /// The number of variables of the smallest partitions.
    pub(super) smallest: usize,
    /// The largest number of conflicts of a query before a solver that branches on all variables takes over.
    pub(super) easy: u64,
    /// The smallest number of clauses of a problem that is searched case by case.
    pub(super) least: usize,
    /// The solver decisions that the search of a case may use in each partition before the case is split.
    pub(super) decisions: u64,
}

/// The problem and its clauses, which are the same in all cases.
pub(super) struct Ground<'a> {
    pub(super) problem: &'a Problem,
    pub(super) clauses: &'a Clauses,
    /// For each item of the clauses, the index of the original item. `None` if several items were combined.
    pub(super) origins: &'a [Option<usize>],
    pub(super) sizes: Sizes,
    /// The bit variables that occur in most clauses. They are tried with both values when the partitions' best scans
    /// are combined to one scan.
    pub(super) modes: Vec<VarId>,
}

impl Ground<'_> {
    /// The objective of soft literals with these weights (picoseconds). What literals and their negations have in
    /// common is at once subtracted from the upper bound.
    pub(super) fn objective(
        &self,
        formula: Formula,
        softs: &[(i32, u64)],
        bounds: &mut Bounds<'_>,
    ) -> Objective {
        let mut objective = Objective::new(formula, self.clauses.variables);
        for &(literal, weight) in softs {
            objective.add_soft(literal, weight);
        }
        bounds.falsified(objective.take_falsified());
        objective
    }

    /// Searches, with some values fixed (see `PartitionSearch::fixed`), until the bounds meet, the limits are reached,
    /// or the whole program was one partition. Each partition may use this many solver decisions. Returns `false` if it
    /// is proved that no scan satisfies the constraints.
    pub(super) fn search(
        &self,
        mut objective: Objective,
        fixed: &[i8],
        decisions: Option<u64>,
        bounds: &mut Bounds<'_>,
    ) -> bool {
        let mut search = PartitionSearch {
            problem: self.problem,
            clauses: self.clauses,
            origins: self.origins,
            limits: bounds.limits(),
            easy: self.sizes.easy,
            decisions,
            values: Vec::new(),
            fixed,
            modes: &self.modes,
            bounds: Mutex::new(bounds),
        };
        let whole = self.clauses.variables + 1;
        // In a case, few clauses of each partition remain.
        let mut size = if fixed.is_empty() { self.sizes.smallest } else { whole };
        for round in 0.. {
            if round == PROPAGATE_AFTER && !search.done() {
                search.bounds().step(|| Step::Propagation);
                search.propagation_cores(&mut objective);
                search.bounds().round();
            }
            if search.done() {
                return true;
            }
            // A round slightly below the whole size would cost as much as the whole.
            size = if size < whole / 2 { size } else { whole };
            let possible = search.round(&mut objective, size, whole);
            if possible && size < whole {
                search.combine();
            }
            search.bounds().round();
            if !possible || size == whole {
                return possible;
            }
            size *= GROWTH;
        }
        true
    }
}

/// The number of rounds before the search looks for cores by propagation over the whole program.
pub(super) const PROPAGATE_AFTER: usize = 2;

/// The factor by which partitions become larger from round to round.
pub(super) const GROWTH: usize = 12;
