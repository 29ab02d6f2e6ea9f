//! What a search asked and what it found, step by step, for those who want to follow it.

use scanbound_base::time::Picos;
use std::time::Duration;

/// The most steps of a group that are kept; further ones are counted.
const MOST: usize = 5_000;

/// The steps of a search, in an order that does not depend on threads.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Trace {
    /// The first of them.
    pub steps: Vec<Step>,
    /// How many more there were.
    pub left_out: usize,
}

/// A step of a search. Items are indices into the group's `Problem::items`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// Whether these items can hold together was asked.
    Asked {
        /// The items, ascending.
        items: Vec<usize>,
        /// What they cost together, with what the group always costs.
        total: Picos,
        /// The answer.
        together: bool,
        /// How long it took.
        time: Duration,
        /// The best scan known then: the paper's T_MAX.
        most: Picos,
    },
    /// The search by subsets has used up its budget: the cores take over with the bounds that it leaves.
    TakenOver,
    /// The core-guided search begins a round of so many partitions.
    Partitions {
        /// How many.
        count: usize,
        /// How many variables each has.
        size: usize,
    },
    /// The core-guided search looks for cores that propagation shows over the whole program.
    Propagation,
    /// The core-guided search goes on case by case.
    Cases,
    /// Items that cannot hold together.
    Core {
        /// The items, ascending.
        items: Vec<usize>,
        /// How many counts of earlier cores exclude each other with them.
        counts: usize,
        /// The core's weight: what it takes off the upper bound.
        weight: Picos,
    },
    /// What is known at the end of a round.
    Bounds {
        /// No scan costs more.
        upper: Picos,
        /// A scan costs as much.
        lower: Picos,
    },
}

impl Trace {
    /// One more step.
    pub fn push(&mut self, step: Step) {
        if self.steps.len() < MOST {
            self.steps.push(step);
        } else {
            self.left_out += 1;
        }
    }

    /// The steps of another search behind these.
    pub fn append(&mut self, other: Trace) {
        self.left_out += other.left_out;
        other.steps.into_iter().for_each(|step| self.push(step));
    }
}
