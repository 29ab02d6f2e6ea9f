//! What an audit may take: until when it may go on, whether it was called off, and which stages that cut short.

use std::fmt;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What ended a stage before it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The time allowed was over.
    TimeLimit(Duration),
    /// The user called it off.
    CalledOff,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            End::TimeLimit(limit) => write!(f, "the time limit of {limit:?}"),
            End::CalledOff => f.write_str("a signal (Ctrl-C, SIGTERM)"),
        }
    }
}

/// A stage that was cut short.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cut {
    /// By what.
    pub by: End,
    /// Which stage, by its name in progress messages.
    pub stage: &'static str,
    /// What it left open, one sentence.
    pub open: String,
}

/// Handed to every stage that can take long. A stage asks `reached` now and then, stops with what is valid by then,
/// and says with `cut` what it left open.
pub struct Budget<'a> {
    limit: Option<Duration>,
    start: Instant,
    cancelled: &'a (dyn Fn() -> bool + Sync),
    cuts: Mutex<Vec<Cut>>,
}

impl<'a> Budget<'a> {
    /// A budget that runs from `start`; `cuts` are those of stages that are over.
    pub fn new(
        start: Instant,
        limit: Option<Duration>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
        cuts: Vec<Cut>,
    ) -> Budget<'a> {
        Budget { limit, start, cancelled, cuts: Mutex::new(cuts) }
    }

    /// When the time is over.
    #[must_use]
    pub fn deadline(&self) -> Option<Instant> {
        self.limit.map(|limit| self.start + limit)
    }

    /// What says stop, if anything does.
    #[must_use]
    pub fn end(&self) -> Option<End> {
        if (self.cancelled)() {
            return Some(End::CalledOff);
        }
        let limit = self.limit.filter(|&limit| self.start.elapsed() >= limit)?;
        Some(End::TimeLimit(limit))
    }

    /// Whether to stop with what is valid by now.
    #[must_use]
    pub fn reached(&self) -> bool {
        self.end().is_some()
    }

    /// Whether a stage that the others can do without is to leave them the rest of the time: one part of so
    /// many is over.
    #[must_use]
    pub fn reached_part(&self, parts: u32) -> bool {
        (self.cancelled)() || self.limit.is_some_and(|limit| self.start.elapsed() >= limit / parts)
    }

    /// Takes note that a stage was cut short, if something says stop, and of what it left open.
    pub fn cut(&self, stage: &'static str, open: impl Into<String>) {
        self.cut_part(1, stage, open);
    }

    /// The same if one part of so many of the time allowed is over.
    pub fn cut_part(&self, parts: u32, stage: &'static str, open: impl Into<String>) {
        let by = match self.limit {
            _ if (self.cancelled)() => End::CalledOff,
            Some(limit) if self.reached_part(parts) => End::TimeLimit(limit),
            _ => return,
        };
        let mut cuts = self.cuts.lock().unwrap_or_else(PoisonError::into_inner);
        cuts.push(Cut { by, stage, open: open.into() });
    }

    /// The stages that were cut short, in order.
    #[must_use]
    pub fn cuts(self) -> Vec<Cut> {
        self.cuts.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_over_is_cut_short() {
        let budget = Budget::new(Instant::now(), None, &|| false, Vec::new());
        budget.cut("searching", "2 groups");
        assert!(!budget.reached() && budget.cuts().is_empty());

        let limit = Some(Duration::ZERO);
        let budget = Budget::new(Instant::now(), limit, &|| false, Vec::new());
        budget.cut("searching", "2 groups");
        let cut = &budget.cuts()[0];
        assert_eq!((cut.by, cut.stage), (End::TimeLimit(Duration::ZERO), "searching"));

        let budget = Budget::new(Instant::now(), limit, &|| true, Vec::new());
        assert_eq!(budget.end(), Some(End::CalledOff));
    }
}
