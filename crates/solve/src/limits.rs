//! What ends a search.

use scanbound_base::time::Picos;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// What ends a search, and who learns of its progress.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// When to stop with what is proved.
    pub deadline: Option<Instant>,
    /// Asked now and then; true stops the search as the deadline does.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Told of every better bound: upper and lower.
    pub progress: &'a (dyn Fn(Picos, Picos) + Sync),
    /// Whether the steps of the search are kept.
    pub trace: bool,
    /// What a group's search may take at most, if that is limited.
    pub decisions: Option<&'a Decisions>,
}

/// Decisions that a satisfiability solver may still make: the same on every machine, as time is not.
#[derive(Debug)]
pub struct Decisions {
    left: AtomicU64,
}

impl Decisions {
    /// So many.
    #[must_use]
    pub fn new(most: u64) -> Decisions {
        Decisions { left: AtomicU64::new(most) }
    }

    /// As many as are left here, to be spent apart.
    pub(super) fn again(&self) -> Decisions {
        Decisions::new(self.left.load(Ordering::Relaxed))
    }

    /// Spends some.
    pub(super) fn spend(&self, decisions: u64) {
        let less = |left: u64| Some(left.saturating_sub(decisions));
        let _ = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
    }

    /// Whether none is left.
    #[must_use]
    pub fn are_spent(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }
}

impl Default for Limits<'_> {
    /// No limit, and no progress is reported.
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
