//! The trace of a search: its queries and results, step by step.

use scanbound_base::time::Picos;
use std::time::Duration;

/// The largest number of steps that are kept for a group; further steps are only counted.
const MAX_STEPS: usize = 5_000;

/// The steps of a search, in an order that does not depend on threads.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Trace {
    /// The first steps of the search, at most 5,000.
    pub steps: Vec<Step>,
    /// The number of further steps, which are not kept.
    pub left_out: usize,
}

/// A step of a search. Items are indices into [`Problem::items`](crate::Problem::items) of the group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// The search by subsets asked whether these items can be true together.
    Asked {
        /// The items, ascending.
        items: Vec<usize>,
        /// The cost if these items are true and no others: their weights and the constant cost of the group, minus what
        /// is deducted for units.
        total: Picos,
        /// Whether the items can be true together.
        together: bool,
        /// The time that the query took.
        time: Duration,
        /// The cost of the best scan found so far, including this query's: the paper's T_MAX.
        most: Picos,
    },
    /// The search by subsets has reached its effort limit; the core-guided search continues with its bounds.
    TakenOver,
    /// The core-guided search begins a round with this many partitions.
    Partitions {
        /// The number of partitions, which follow each other in the order of execution.
        count: usize,
        /// The number of variables of each (the last may have fewer).
        size: usize,
    },
    /// The core-guided search looks for cores by propagation over the whole program.
    Propagation,
    /// The core-guided search continues case by case: a case is the scans in which some bits have fixed values.
    Cases,
    /// A core was found: items, and perhaps counts of earlier cores, that cannot all be true.
    Core {
        /// The items, ascending; those that were combined with others are left out.
        items: Vec<usize>,
        /// The number of other literals of the core, such as totalizer outputs of earlier cores.
        counts: usize,
        /// The weight of the core, by which the upper bound falls.
        weight: Picos,
    },
    /// The bounds at the end of a round.
    Bounds {
        /// The upper bound.
        upper: Picos,
        /// The cost of the best scan found so far; 0 if none was found.
        lower: Picos,
    },
}

impl Trace {
    /// Appends a step; only counts it if there are already 5,000.
    pub fn push(&mut self, step: Step) {
        if self.steps.len() < MAX_STEPS {
            self.steps.push(step);
        } else {
            self.left_out += 1;
        }
    }

    /// Appends the steps of another search; those beyond 5,000 are only counted.
    pub fn append(&mut self, other: Trace) {
        self.left_out += other.left_out;
        other.steps.into_iter().for_each(|step| self.push(step));
    }
}
