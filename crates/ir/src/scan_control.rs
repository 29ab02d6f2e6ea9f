//! What a program does to the time that its own scan may take: it restarts the watchdog, sets it, or sets a constant scan time.

use scanbound_base::time::Picos;
use std::collections::{BTreeMap, BTreeSet};

/// What a program does to the time that its own scan may take. Instructions are indices into `Program::instructions`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ScanControl {
    /// What restarts the watchdog when it fires.
    pub restarts: BTreeSet<usize>,
    /// What sets the watchdog's time when it fires, for this scan behind a restart and for all that follow.
    pub watchdog: BTreeMap<usize, Setting>,
    /// What makes the watchdog's time longer in the scan in which it fires, each time.
    pub extensions: BTreeMap<usize, (Picos, Picos)>,
    /// What sets the constant scan time when it fires.
    pub constant: BTreeMap<usize, Setting>,
    /// What switches the constant scan on or off.
    pub switches: BTreeMap<usize, Switch>,
    /// The device that holds the watchdog's time, that of the constant scan time, and the relay that switches it on; empty
    /// where the CPU has none.
    pub devices: [&'static str; 3],
    /// What the CPU's parameters call a least time for each scan, where they may set one.
    pub by_parameters: Option<&'static str>,
}

/// What a register is set to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Setting {
    /// A time from the first to the second.
    Range(Picos, Picos),
    /// What this device holds, of which nothing is known.
    Device(String),
    /// What this instruction computes, or leads elsewhere.
    Computed(String),
}

impl Setting {
    /// The least and the largest time, where these are known.
    #[must_use]
    pub fn range(&self) -> Option<(Picos, Picos)> {
        match self {
            Setting::Range(least, most) => Some((*least, *most)),
            Setting::Device(_) | Setting::Computed(_) => None,
        }
    }
}

/// What an instruction does to the relay that switches a constant scan on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switch {
    /// It takes the instruction's condition.
    Condition,
    /// It is set when the instruction fires.
    On,
    /// It is cleared when the instruction fires.
    Off,
    /// It may take any value.
    Unknown,
}

impl ScanControl {
    /// Whether an execution counts as having fired of which it is not known whether it did: what makes the watchdog
    /// last longer may have, what else it asks for has not surely.
    #[must_use]
    pub fn may_have_fired(&self, instruction: usize, value: bool) -> bool {
        let sets = self.watchdog.contains_key(&instruction)
            || self.constant.contains_key(&instruction)
            || self.switches.contains_key(&instruction);
        let helps =
            self.restarts.contains(&instruction) || self.extensions.contains_key(&instruction);
        helps || (value && !sets)
    }

    /// Whether the program restarts the watchdog or sets its time.
    #[must_use]
    pub fn sets_watchdog(&self) -> bool {
        !self.restarts.is_empty() || !self.watchdog.is_empty() || !self.extensions.is_empty()
    }

    /// Whether the constant scan may be switched on.
    #[must_use]
    pub fn may_be_constant(&self) -> bool {
        match self.switches.is_empty() {
            // Somebody else switches it on for which it is set.
            true => self.constant.values().any(|setting| setting.range().is_some()),
            false => self.switches.values().any(|switch| *switch != Switch::Off),
        }
    }
}
