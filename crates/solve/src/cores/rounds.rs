//! A round of a search: solves all partitions of one size in parallel, and combines their scans.

use super::objective::Objective;
use super::partition::Partition;
use super::search::PartitionSearch;
use crate::trace::Step;
use rayon::prelude::*;

impl PartitionSearch<'_, '_> {
    /// Searches all partitions of `size` of the `whole` variables in parallel. No partition sees the results of
    /// another, nor that the bounds have met, so the result does not depend on the order of threads. Returns whether
    /// the constraints may be satisfiable.
    pub(super) fn round(&mut self, objective: &mut Objective, size: usize, whole: usize) -> bool {
        let count = whole.div_ceil(size);
        let objectives = objective.split(size, count).into_iter().enumerate();
        let mut partitions: Vec<Partition> = objectives
            .map(|(index, objective)| {
                Partition::new(index * size..((index + 1) * size).min(whole), objective)
            })
            .collect();
        self.bounds().step(|| Step::Partitions { count, size });
        partitions.par_iter_mut().for_each(|partition| partition.solve(self, count == 1));
        for partition in &mut partitions {
            self.bounds().steps(std::mem::take(&mut partition.trace));
        }
        let possible = partitions.iter().all(|partition| !partition.contradiction);
        self.values.resize(whole, false);
        for partition in &mut partitions {
            if !partition.values.is_empty() {
                self.values[partition.positions.clone()].copy_from_slice(&partition.values);
            }
        }
        for (value, &fixed) in self.values.iter_mut().zip(self.fixed) {
            *value = if fixed == 0 { *value } else { fixed > 0 };
        }
        objective.join(partitions.into_iter().map(|partition| partition.objective));
        possible
    }

    /// Combines the best scans of the partitions to one scan, which is rarely the best one of the whole program. The
    /// mode bits, on which the partitions disagree, are tried with both values.
    pub(super) fn combine(&self) {
        let values = &self.values;
        let holds = |literal: i32| values[literal.unsigned_abs() as usize] == (literal > 0);
        let mut best = self.clauses.assignment(self.problem, holds);
        let mut most = self.problem.cost(&best);
        for &mode in self.modes {
            let value = &mut best.0[mode.0 as usize];
            *value ^= 1;
            let cost = self.problem.cost(&best);
            if cost > most {
                most = cost;
            } else {
                best.0[mode.0 as usize] ^= 1;
            }
        }
        self.bounds().record_assignment(best);
    }
}
