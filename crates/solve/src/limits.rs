//! The limits that end a search.

use scanbound_base::time::Picos;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// The limits of a search, the callback for its progress, and whether to record a trace.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// The time at which to stop with what is proved; `None`: no deadline.
    pub deadline: Option<Instant>,
    /// Called regularly; if it returns true, the search stops as at the deadline. The short search by subsets of a
    /// small group asks only at its beginning.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Called with the upper and the lower bound of the group each time that one of them becomes better.
    pub progress: &'a (dyn Fn(Picos, Picos) + Sync),
    /// Whether to record the steps of the search in [`Maximum::trace`](crate::Maximum::trace).
    pub trace: bool,
    /// The largest number of solver decisions, counted approximately. [`maxima`](fn@crate::maxima) gives each group as
    /// many as are left here. `None` if unlimited.
    pub decisions: Option<&'a Decisions>,
}

/// A limit on the decisions (guesses of a variable's value) of a SAT solver, counted down as it is used. Unlike a time
/// limit, it gives the same result on every machine.
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

    /// Subtracts used decisions, down to 0.
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
    /// Whether to stop with what is proved: the decisions are spent, the deadline is over, or the caller cancelled.
    pub fn reached(&self) -> bool {
        self.decisions.is_some_and(Decisions::are_spent)
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
            || (self.cancelled)()
    }
}
