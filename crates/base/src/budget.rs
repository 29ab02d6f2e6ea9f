//! The time budget of an audit: its time limit, cancellation by the user, and which stages stopped early.

use std::fmt;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Why a stage stopped early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// The time limit, of this length, was reached.
    TimeLimit(Duration),
    /// The user cancelled the audit.
    Cancelled,
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StopReason::TimeLimit(limit) => write!(f, "the time limit of {limit:?}"),
            StopReason::Cancelled => f.write_str("a signal (Ctrl-C, SIGTERM)"),
        }
    }
}

/// Records that a stage stopped early.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EarlyStop {
    /// Why the stage stopped early.
    pub reason: StopReason,
    /// The stage, by its name in progress messages.
    pub stage: &'static str,
    /// What the stage did not finish, as one sentence for the report.
    pub unfinished: String,
}

/// The budget that every stage with a long running time gets. The stage calls [`Budget::must_stop`] regularly; if that
/// is true it stops with the results that are valid so far, and records with [`Budget::record_stop`] what it did not
/// finish.
pub struct Budget<'a> {
    limit: Option<Duration>,
    start: Instant,
    cancelled: &'a (dyn Fn() -> bool + Sync),
    cuts: Mutex<Vec<EarlyStop>>,
}

impl<'a> Budget<'a> {
    /// A time budget of `limit` that starts at `start`; `None`: no limit. If `cancelled` returns true, stages stop as
    /// at the limit. `cuts` are the records of stages that already stopped early.
    pub fn new(
        start: Instant,
        limit: Option<Duration>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
        cuts: Vec<EarlyStop>,
    ) -> Budget<'a> {
        Budget { limit, start, cancelled, cuts: Mutex::new(cuts) }
    }

    /// The moment at which the time limit is reached; `None` without a limit, or if it is too far away to be
    /// represented.
    #[must_use]
    pub fn deadline(&self) -> Option<Instant> {
        self.limit.and_then(|limit| self.start.checked_add(limit))
    }

    /// The reason to stop now. `None`: the stage may continue.
    #[must_use]
    pub fn stop_reason(&self) -> Option<StopReason> {
        if (self.cancelled)() {
            return Some(StopReason::Cancelled);
        }
        let limit = self.limit.filter(|&limit| self.start.elapsed() >= limit)?;
        Some(StopReason::TimeLimit(limit))
    }

    /// Whether the stage must stop now: the time limit was reached, or the user cancelled the audit.
    #[must_use]
    pub fn must_stop(&self) -> bool {
        self.stop_reason().is_some()
    }

    /// Whether an optional stage must stop, to leave the rest of the time to others: true once 1/`parts` of the time
    /// limit has passed, or if the user cancelled the audit.
    #[must_use]
    pub fn must_stop_at_part(&self, parts: u32) -> bool {
        (self.cancelled)() || self.limit.is_some_and(|limit| self.start.elapsed() >= limit / parts)
    }

    /// Records that this stage stopped early and what it did not finish (`open`), if there is a reason to stop;
    /// otherwise does nothing.
    pub fn record_stop(&self, stage: &'static str, open: impl Into<String>) {
        self.record_stop_at_part(1, stage, open);
    }

    /// Like [`Budget::record_stop`], for a stage that may use at most 1/`parts` of the time limit: it counts as stopped
    /// once that time has passed.
    pub fn record_stop_at_part(&self, parts: u32, stage: &'static str, open: impl Into<String>) {
        let by = match self.limit {
            _ if (self.cancelled)() => StopReason::Cancelled,
            Some(limit) if self.must_stop_at_part(parts) => StopReason::TimeLimit(limit),
            _ => return,
        };
        let mut cuts = self.cuts.lock().unwrap_or_else(PoisonError::into_inner);
        cuts.push(EarlyStop { reason: by, stage, unfinished: open.into() });
    }

    /// The records of all stages that stopped early: first those given to [`Budget::new`], then the others in the order
    /// in which they were recorded.
    #[must_use]
    pub fn early_stops(self) -> Vec<EarlyStop> {
        self.cuts.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_over_is_cut_short() {
        let budget = Budget::new(Instant::now(), None, &|| false, Vec::new());
        budget.record_stop("searching", "2 groups");
        assert!(!budget.must_stop() && budget.early_stops().is_empty());

        let limit = Some(Duration::ZERO);
        let budget = Budget::new(Instant::now(), limit, &|| false, Vec::new());
        budget.record_stop("searching", "2 groups");
        let cut = &budget.early_stops()[0];
        assert_eq!((cut.reason, cut.stage), (StopReason::TimeLimit(Duration::ZERO), "searching"));

        let budget = Budget::new(Instant::now(), limit, &|| true, Vec::new());
        assert_eq!(budget.stop_reason(), Some(StopReason::Cancelled));
    }
}
