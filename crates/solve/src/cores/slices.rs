//! Combines soft literals that exclude each other by propagation, before the solver is asked.
//!
//! Of mutually exclusive literals at most one is true, so all but one of them lose their weight. A slice takes the
//! weight of the lightest literal from each of them, and puts it once on a new soft literal: that any of them is true.
//! This literal may be a member of further slices. So of the mutually exclusive steps of a chart, the cost of the most
//! expensive one remains. The steps of a chart within a step are combined before those of the chart around it: the
//! literal that excludes most others is taken first, together with those that exclude the same literals.

use super::objective::Objective;
use crate::propagator::Propagator;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;

/// If there are more soft literals than this, they are not compared with each other.
pub const MAX_SOFT: usize = 4_000;

/// A slice: the weight that its members lose in exchange for one literal for all of them. Members are indices of soft
/// literals, followed by indices of slices.
struct Slice {
    members: Vec<usize>,
    weight: u64,
}

/// The slices found for some soft literals, in the order in which they are to be applied.
#[derive(Default)]
pub struct Slices {
    /// The soft literals that are false in every scan that the trail allows.
    never: Vec<i32>,
    slices: Vec<Slice>,
    /// By how much the slices and the literals in `never` lower the bound, in picoseconds.
    pub off: u64,
}

impl Slices {
    /// The slices of these soft literals, which must be unassigned on the trail. The result is empty if there are more
    /// than [`MAX_SOFT`] soft literals.
    pub fn of(softs: &[(i32, u64)], trail: &mut Propagator) -> Slices {
        let mut found = Slices::default();
        if softs.len() > MAX_SOFT {
            return found;
        }
        let mut table = ExclusionTable::new(softs);
        let places = softs.iter().enumerate().map(|(at, &(literal, _))| (literal, at));
        let places: FxHashMap<i32, usize> = places.collect();
        for (at, &(literal, weight)) in softs.iter().enumerate() {
            let (level, known) = (trail.level(), trail.length());
            if trail.assume(literal).is_some() {
                found.never.push(literal);
                found.off += weight;
                table.weights[at] = 0;
                continue;
            }
            for &implied in trail.since(known) {
                if let Some(&other) = places.get(&-implied) {
                    table.exclude(at, other);
                }
            }
            trail.retract_to(level);
        }
        for at in 0..softs.len() {
            if table.weights[at] == 0 {
                table.forget(at);
            }
        }
        while let Some(members) = table.next() {
            let weight = members.iter().map(|&at| table.weights[at]).min().unwrap_or_default();
            found.off += weight * (members.len() as u64 - 1);
            table.take(&members, weight);
            found.slices.push(Slice { members, weight });
        }
        found
    }

    /// Applies the slices to an objective; `softs` must be the soft literals for which they were found.
    pub fn take(&self, softs: &[(i32, u64)], objective: &mut Objective) {
        for &literal in &self.never {
            objective.subtract_core(&[literal]);
        }
        let mut literals: Vec<i32> = softs.iter().map(|soft| soft.0).collect();
        for slice in &self.slices {
            let members: Vec<i32> = slice.members.iter().map(|&at| literals[at]).collect();
            literals.push(objective.slice(&members, slice.weight));
        }
    }
}

/// Which literals exclude each other, and the weight that each still has. Indices are those of the soft literals,
/// followed by those of the slices.
struct ExclusionTable {
    weights: Vec<u64>,
    excluded: Vec<Vec<u64>>,
    /// The number of exclusions in each row.
    counts: Vec<u32>,
    /// The number of machine words in a row of the table, which has a bit for each literal.
    words: usize,
    softs: usize,
}

fn has(row: &[u64], at: usize) -> bool {
    row[at / 64] >> (at % 64) & 1 == 1
}

fn common(one: &[u64], other: &[u64]) -> u32 {
    one.iter().zip(other).map(|(one, other)| (one & other).count_ones()).sum()
}

impl ExclusionTable {
    fn new(softs: &[(i32, u64)]) -> ExclusionTable {
        let words = (2 * softs.len()).div_ceil(64);
        ExclusionTable {
            weights: softs.iter().map(|soft| soft.1).collect(),
            excluded: vec![vec![0; words]; softs.len()],
            counts: vec![0; softs.len()],
            words,
            softs: softs.len(),
        }
    }

    fn exclude(&mut self, one: usize, other: usize) {
        if one != other && !has(&self.excluded[one], other) {
            self.set(one, other);
            self.set(other, one);
        }
    }

    fn set(&mut self, one: usize, other: usize) {
        self.excluded[one][other / 64] |= 1 << (other % 64);
        self.counts[one] += 1;
    }

    /// The members of the next slice: the literal that excludes most others, and of these the ones that exclude each
    /// other and mostly the same literals. `None` if no two literals exclude each other, or there are already as many
    /// slices as soft literals.
    fn next(&self) -> Option<Vec<usize>> {
        if self.weights.len() >= 2 * self.softs {
            return None;
        }
        let open = (0..self.weights.len()).filter(|&at| self.weights[at] > 0);
        let most = open.map(|at| (self.counts[at], Reverse(at))).max();
        let (count, Reverse(first)) = most.filter(|&(count, _)| count > 0)?;
        let own = &self.excluded[first];
        let mut alike: Vec<_> = (0..self.weights.len())
            .filter(|&at| has(own, at))
            .map(|at| (Reverse(common(own, &self.excluded[at])), Reverse(self.weights[at]), at))
            .collect();
        alike.sort_unstable();
        let mut members = vec![first];
        let mut left = own.clone();
        for (Reverse(common), _, at) in alike {
            if has(&left, at) && (members.len() == 1 || 2 * common >= count) {
                members.push(at);
                left.iter_mut().zip(&self.excluded[at]).for_each(|(left, own)| *left &= own);
            }
        }
        Some(members)
    }

    /// Removes the exclusions of a literal that has no weight left.
    fn forget(&mut self, at: usize) {
        let gone = std::mem::take(&mut self.excluded[at]);
        for other in (0..self.weights.len()).filter(|&other| has(&gone, other)) {
            self.excluded[other][at / 64] &= !(1 << (at % 64));
            self.counts[other] -= 1;
        }
    }

    /// Subtracts the weight of a slice from its members, and adds a soft literal that says that one of them is true.
    fn take(&mut self, members: &[usize], weight: u64) {
        let mut row = vec![u64::MAX; self.words];
        for &at in members {
            row.iter_mut().zip(&self.excluded[at]).for_each(|(left, own)| *left &= own);
        }
        for &at in members {
            self.weights[at] -= weight;
            if self.weights[at] == 0 {
                self.forget(at);
                row[at / 64] &= !(1 << (at % 64));
            }
        }
        let own = self.weights.len();
        self.weights.push(weight);
        for at in (0..own).filter(|&at| has(&row, at)) {
            self.set(at, own);
        }
        self.counts.push(row.iter().map(|word| word.count_ones()).sum());
        self.excluded.push(row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_within_steps_cost_their_most_expensive_step() {
        // A chart of steps 1 and 2, and a chart of steps 3 and 4 that runs within step 1.
        let clauses: &[&[i32]] = &[&[-1, -2], &[-3, 1], &[-4, 1], &[-3, -4]];
        let mut trail = Propagator::default();
        clauses.iter().for_each(|clause| trail.add(clause));
        trail.retract_to(0);
        // In step 1: 10 by itself, plus 5 or 7. In step 2: 12.
        let slices = Slices::of(&[(1, 10), (3, 5), (4, 7), (2, 12)], &mut trail);
        assert_eq!(slices.off, 10 + 5 + 7 + 12 - 17);
        assert_eq!(trail.level(), 0);
    }

    #[test]
    fn what_cannot_be_true_is_lost() {
        let mut trail = Propagator::default();
        for clause in [[-1, 2], [-1, -2]] {
            trail.add(&clause);
        }
        assert_eq!(Slices::of(&[(1, 10), (3, 5)], &mut trail).off, 10);
    }
}
