//! The limits that end a search.

use scanbound_base::time::Picos;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// The limits of a search, and the callback for its progress.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// The time at which to stop with what is proved.
    pub deadline: Option<Instant>,
    /// Called regularly; if it returns true, the search stops as at the deadline.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Called with every better pair of bounds: upper, lower.
    pub progress: &'a (dyn Fn(Picos, Picos) + Sync),
    /// Whether to record the steps of the search.
    pub trace: bool,
    /// The largest number of decisions for the group. `None` if unlimited.
    pub decisions: Option<&'a Decisions>,
}

/// A limit on the decisions of a SAT solver. Unlike a time limit, it gives the same result on every machine.
#[derive(Debug)]
pub struct Decisions {
    left: AtomicU64,
}

impl Decisions {
    /// A limit of `most` decisions.
    #[must_use]
    pub fn new(most: u64) -> Decisions {
        Decisions { left: AtomicU64::new(most) }
    }

    /// A new limit with as many decisions as this one still has.
    pub(super) fn remaining(&self) -> Decisions {
        Decisions::new(self.left.load(Ordering::Relaxed))
    }

    /// Uses up some decisions.
    pub(super) fn spend(&self, decisions: u64) {
        let less = |left: u64| Some(left.saturating_sub(decisions));
        let _ = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
    }

    /// Whether no decisions remain.
    #[must_use]
    pub fn are_spent(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }
}

impl Default for Limits<'_> {
    /// No limits, and no progress reports.
    fn default() -> Self {
        Limits {
            deadline: None,
            cancelled: &|| false,
            progress: &|_, _| {},
            trace: false,
            decisions: None,
        }
    }
}

impl Limits<'_> {
    /// Whether to stop with what is proved.
    pub fn reached(&self) -> bool {
        self.decisions.is_some_and(Decisions::are_spent)
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
            || (self.cancelled)()
    }
}
