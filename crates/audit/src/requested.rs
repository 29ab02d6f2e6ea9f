//! Parts of an [`Audit`](super::Audit) that are computed only on request: other bounds of the same program.

use super::exclusive_relays::StartUnknown;
use super::solved_bound::SolvedBound;
use super::unknown::Unknown;
use scanbound_base::time::Picos;
use std::fmt;

/// How much the bound is lowered by the fact that the steps of charts (SFC) are mutually exclusive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coactivity {
    /// The bound if steps and stored actions were not mutually exclusive.
    pub without: SolvedBound,
    /// The steps that are active and the stored actions that are on when the longest scan starts.
    pub active: Vec<String>,
}

/// A task, and the bounds of its time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TaskUse {
    /// The name of the task.
    pub name: String,
    /// The interval in which the task is due. `None` if it is not cyclic.
    pub interval: Option<Picos>,
    /// The priority of the task: 0 is the highest. `None` if the project does not state it.
    pub priority: Option<i64>,
    /// The programs that the task calls, in this order.
    pub programs: Vec<String>,
    /// An upper bound on a run of the task that nothing interrupts. `None` if it may never end.
    pub upper: Option<Picos>,
    /// A lower bound: some run of the task takes this long.
    pub lower: Picos,
    /// The tasks that can interrupt this task.
    pub interrupted_by: Vec<String>,
    /// The tasks of the same priority for which this task may have to wait.
    pub waits_for: Vec<String>,
    /// The longest time from the task's due time to its end, computed from the bounds and intervals of all tasks that
    /// may run first. `Err` has the reason if there is none.
    pub response: Result<Picos, String>,
}

/// The bounds of the scan if additional facts are stated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WhatIf {
    /// The limits that were tried for numbers of iterations or units and for indices, ascending.
    pub most: Vec<u32>,
    /// The values that are limited, one after the other. In each step, the values of all earlier steps are limited,
    /// too.
    pub steps: Vec<LimitedCount>,
    /// The assumptions that change the bound too little to be listed. `None` if there are none, or their effect was not
    /// computed.
    pub minor: Option<Minor>,
    /// The devices for which the bound would be lower if the user stated that only the program writes them. `None` if
    /// there are none, or this was not computed.
    pub own: Option<InternalDevices>,
}

/// One step of [`WhatIf::steps`]: an unknown value that is limited, in addition to those of the steps before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LimitedCount {
    /// The value that is limited: a number of iterations or units, or an index.
    pub unknown: Unknown,
    /// The bound for each limit in [`WhatIf::most`], in the same order. `None` if the audit with that limit gave no
    /// bound: the program contradicts the limit, or the time was over.
    pub solved: Vec<Option<SolvedBound>>,
}

/// Assumptions of which each alone hardly changes the bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Minor {
    /// The number of the assumptions.
    pub count: usize,
    /// The bound without any of the assumptions.
    pub without: SolvedBound,
}

/// Devices for which the bound would be lower if only the program wrote them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InternalDevices {
    /// The names of the words and relays.
    pub devices: Vec<String>,
    /// The bound if the user states that only the program writes the devices in `devices`.
    pub bound: SolvedBound,
}

/// How a net changes the bound of its code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetBound {
    /// The file of the net.
    pub net: String,
    /// The bound if relays could be on in any combination when a scan starts.
    pub without: Picos,
    /// The bound without the net: combinations of relays are excluded only if the audit itself finds that they cannot
    /// occur.
    pub alone: Picos,
    /// Sets of mutually exclusive elements that the net states, that the code preserves and that the bound uses.
    pub used: Vec<Set>,
    /// Sets that the net states and that are not used.
    pub unused: Vec<UnusedSet>,
    /// For each place of the net: whether it is marked when the longest scan starts. A counter counts as marked once it
    /// has counted. `None` if the place has no relay, or that scan does not depend on the relay.
    pub places: Vec<Option<bool>>,
    /// The names of the marked places.
    pub marked: Vec<String>,
}

/// Elements of a net, with their relays, that are never all on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Set {
    /// The names of the elements of the set.
    pub elements: Vec<String>,
    /// The names of the relays that represent the elements, in the same order. Empty for an element without a relay.
    pub relays: Vec<String>,
    /// Whether all elements are boxes, timers or counters, and none is a transition.
    pub is_of_places: bool,
    /// The largest number of the elements that can be on at once: one, or all but one.
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
    /// The CPU does not have the relay of the element with this name, or the element has no address.
    NoRelay(String),
    /// The value of this element's relay at the start of a scan is unknown.
    StartUnknown(String, StartUnknown),
    /// The program never turns on this element's relay, so other writers may turn it on at any time.
    NeverOn(String),
    /// No scan depends on the value of this element's relay at the start of the scan.
    NotRead(String),
    /// One scan of the code can turn on all relays of the set, although no set is violated when it starts.
    Broken,
    /// The time limit was reached before the set was decided.
    NoTime,
}

impl Why {
    /// The element because of which the set is not used. `None` if several elements are the reason.
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
            Why::NoRelay(_) => "the element has no address, or the CPU has no relay with its address".to_owned(),
            Why::StartUnknown(_, why) => why.to_string(),
            Why::NeverOn(_) => "the code never turns this relay on, so another writer must do so, and may do so at any time (the code sets initial marks only if it is translated with --initial first-scan)".to_owned(),
            Why::NotRead(_) => "no scan depends on the value of this relay at the start of the scan".to_owned(),
            Why::Broken => "it is not proved that scans preserve this set: in the model, a scan may leave all its relays on".to_owned(),
            Why::NoTime => "the search for exclusive relays ended, at its time limit or because the scan is too complex, before it was decided whether scans preserve the set".to_owned(),
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
