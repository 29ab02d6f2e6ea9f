//! The least time of each scan, and the watchdog.

use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use std::sync::Arc;

/// An instruction that sets the watchdog or the constant scan time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettingUse {
    /// Its place.
    pub at: Location,
    /// Its text.
    pub instruction: Arc<str>,
    /// The smallest and the largest time that it sets, if known.
    pub times: Option<(Picos, Picos)>,
    /// The device that holds the time, if the time is unknown.
    pub from: Option<String>,
}

/// A part of a scan that was run, between restarts of the watchdog, and the longest time to which the watchdog can be
/// set in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// A lower bound on its time.
    pub took: Picos,
    /// The largest possible watchdog time. `None` if unknown.
    pub watchdog: Option<Picos>,
    /// Whether the run begins at power-up.
    pub is_reached: bool,
}

/// The watchdog of a program.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Watchdog {
    /// Its time unless the program sets another: stated, or from the table.
    pub default: Option<Picos>,
    /// Whether the user states it.
    pub is_stated: bool,
    /// The device that holds it. Empty if there is none.
    pub device: &'static str,
    /// The instructions that set it.
    pub settings: Vec<SettingUse>,
    /// The smallest time to which it can be set, if known.
    pub least: Option<Picos>,
    /// The number of instructions that restart it.
    pub restarts: usize,
    /// If there are any: an upper bound on the time without a restart, with all points that the CPU can have.
    pub upper: Option<Picos>,
    /// Parts of real runs without a restart.
    pub found: Vec<Stretch>,
}

/// The minimum scan time: constant scan.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cycle {
    /// An upper bound on the constant scan time, if one is set.
    pub upper: Option<Picos>,
    /// The most that interrupts add that occur just before the wait ends.
    pub interrupts: Picos,
    /// Some scan is extended to at least this time.
    pub lower: Option<Picos>,
    /// The instructions that set its time.
    pub settings: Vec<SettingUse>,
    /// The instructions that switch it on.
    pub switches: Vec<SettingUse>,
    /// The devices of its time and of its switch. Empty if there are none.
    pub devices: [&'static str; 2],
    /// Whether the program may switch it on with an unknown time.
    pub is_unknown: bool,
    /// Whether the user states it.
    pub is_stated: bool,
    /// The name of the CPU parameter that may set it, if nobody states whether it does.
    pub unstated: Option<&'static str>,
}

impl Cycle {
    /// An upper bound on a scan that waits: all interrupts of a scan may occur just before the wait ends.
    #[must_use]
    pub fn longest(&self) -> Option<Picos> {
        self.upper.map(|time| time + self.interrupts)
    }
}
