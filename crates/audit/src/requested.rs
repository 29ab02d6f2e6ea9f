//! What an audit has only if it was requested: other bounds of the same program.

use super::exclusive_relays::StartUnknown;
use super::solved_bound::SolvedBound;
use super::unknown::Unknown;
use scanbound_base::time::Picos;
use std::fmt;

/// How mutual exclusion in charts affects the bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coactivity {
    /// The bound if steps and stored actions were not mutually exclusive.
    pub without: SolvedBound,
    /// The steps that are active and the stored actions that are on when the longest scan starts.
    pub active: Vec<String>,
}

/// A task and its bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TaskUse {
    /// Its name.
    pub name: String,
    /// Its interval, if it is cyclic.
    pub interval: Option<Picos>,
    /// Its priority: 0 is the highest.
    pub priority: Option<i64>,
    /// The programs that it calls, in their order.
    pub programs: Vec<String>,
    /// No run of it takes longer if nothing interrupts it. `None` if it may never end.
    pub upper: Option<Picos>,
    /// Some run of it takes this long.
    pub lower: Picos,
    /// The tasks that interrupt it.
    pub interrupted_by: Vec<String>,
    /// The tasks of the same priority that it may have to wait for.
    pub waits_for: Vec<String>,
    /// The longest time from its due time to its end, computed from the bounds and intervals of those tasks. `Err` has
    /// the reason if there is none.
    pub response: Result<Picos, String>,
}

/// Bounds with additional statements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WhatIf {
    /// The limits of counts that were tried, ascending.
    pub most: Vec<u32>,
    /// One count after the other. In each step, those of all earlier steps are limited, too.
    pub steps: Vec<Step>,
    /// The assumptions that are too small to be listed, together.
    pub minor: Option<Minor>,
    /// What would lower the bound if the user stated that only the program writes it.
    pub own: Option<Own>,
}

/// A count that is limited in addition to those before it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// The count.
    pub unknown: Unknown,
    /// The bound for each of [`WhatIf::most`]. `None` if the count cannot have that limit.
    pub solved: Vec<Option<SolvedBound>>,
}

/// Assumptions that hardly change the bound, each alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Minor {
    /// The number of them.
    pub count: usize,
    /// The bound without all of them.
    pub without: SolvedBound,
}

/// Devices that would lower the bound if only the program wrote them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Own {
    /// The names of the words and relays.
    pub devices: Vec<String>,
    /// The bound if that is stated for all of them.
    pub bound: SolvedBound,
}

/// How a net changes the bound of its code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetBound {
    /// The net's file.
    pub net: String,
    /// The bound if relays could be on in any combination when a scan starts.
    pub without: Picos,
    /// The bound without the net: combinations are excluded only if the audit finds that itself.
    pub alone: Picos,
    /// Sets that the net states and the code preserves.
    pub used: Vec<Set>,
    /// Sets that the net states and that are not used.
    pub unused: Vec<UnusedSet>,
    /// For each place of the net: whether it is marked when the longest scan starts, if that scan depends on it. A
    /// counter counts as marked once it has counted.
    pub places: Vec<Option<bool>>,
    /// The names of the marked places.
    pub marked: Vec<String>,
}

/// Elements of a net, with their relays, that are never all on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Set {
    /// Their names.
    pub elements: Vec<String>,
    /// Their relays.
    pub relays: Vec<String>,
    /// Whether all of them are boxes, timers or counters, and none a transition.
    pub is_of_places: bool,
    /// The largest number of them that can be on at once: one, or all but one.
    pub most: usize,
}

/// A set that the net states and that is not used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnusedSet {
    /// Elements that are never all on, according to the net.
    pub set: Set,
    /// Why the set is not used.
    pub why: Why,
}

/// Why a set that the net states is not used.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Why {
    /// The CPU has no such relay, or the element has no address.
    NoRelay(String),
    /// The value of this element's relay at the start of a scan is unknown.
    StartUnknown(String, StartUnknown),
    /// The program never turns on this element's relay, so others may do so at any time.
    NeverOn(String),
    /// No scan depends on the start value of this element's relay.
    NotRead(String),
    /// A scan of the code violates it.
    Broken,
    /// The time was over.
    NoTime,
}

impl Why {
    /// The element because of which the set is not used, if it is only one.
    #[must_use]
    pub fn element(&self) -> Option<&str> {
        match self {
            Why::NoRelay(name)
            | Why::StartUnknown(name, _)
            | Why::NeverOn(name)
            | Why::NotRead(name) => Some(name),
            Why::Broken | Why::NoTime => None,
        }
    }

    /// The reason, without the name of the element.
    #[must_use]
    pub fn reason(&self) -> String {
        match self {
            Why::NoRelay(_) => "it has no relay in this code".to_owned(),
            Why::StartUnknown(_, why) => why.to_string(),
            Why::NeverOn(_) => "the code never turns it on, so others may do so at any time (the code sets initial marks only if it is translated with --initial first-scan)".to_owned(),
            Why::NotRead(_) => "no scan depends on its value from the scan before".to_owned(),
            Why::Broken => "a scan of the code can turn them all on".to_owned(),
            Why::NoTime => "not decided within the time limit".to_owned(),
        }
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(name) = self.element() {
            write!(f, "{name}: ")?;
        }
        f.write_str(&self.reason())
    }
}
