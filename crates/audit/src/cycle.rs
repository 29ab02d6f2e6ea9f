//! The least time of each scan, and the watchdog.

use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use std::sync::Arc;

/// An instruction that sets the watchdog or the constant scan time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettingUse {
    /// The place of the instruction.
    pub at: Location,
    /// The text of the instruction.
    pub instruction: Arc<str>,
    /// The smallest and the largest time that the instruction sets. `None` if unknown.
    pub times: Option<(Picos, Picos)>,
    /// The device from which the instruction takes the time, if the time is unknown.
    pub from: Option<String>,
}

/// A part of a simulated scan between two restarts of the watchdog, and the largest watchdog time that can be set in
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// A lower bound on the time of the part, from a simulated scan.
    pub took: Picos,
    /// The largest possible watchdog time. `None` if unknown.
    pub watchdog: Option<Picos>,
    /// Whether the run begins at power-up.
    pub is_reached: bool,
}

/// The watchdog of a program.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Watchdog {
    /// The watchdog time unless the program sets a different one: as stated, or from the table.
    pub default: Option<Picos>,
    /// Whether the user states the watchdog time.
    pub is_stated: bool,
    /// The device that holds the watchdog time. Empty if there is none.
    pub device: &'static str,
    /// The instructions that set the watchdog time.
    pub settings: Vec<SettingUse>,
    /// The smallest time to which the program can set the watchdog. `None` if unknown.
    pub least: Option<Picos>,
    /// The number of instructions that restart the watchdog.
    pub restarts: usize,
    /// An upper bound on the time without a watchdog restart, with all points that the CPU can have. `None` if nothing
    /// restarts it.
    pub upper: Option<Picos>,
    /// Parts of real runs without a restart.
    pub found: Vec<Stretch>,
}

/// The constant scan: a minimum scan time, for which each scan waits.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cycle {
    /// An upper bound on the constant scan time. `None` if none is set.
    pub upper: Option<Picos>,
    /// The longest time that interrupts just before the end of the wait can add.
    pub interrupts: Picos,
    /// A lower bound on the constant scan time: some scan waits until this time has passed.
    pub lower: Option<Picos>,
    /// The scan that was found to wait for the constant scan time. `None` if there is none, or the time is stated.
    pub waits: Option<WaitingScan>,
    /// The instructions that set the constant scan time.
    pub settings: Vec<SettingUse>,
    /// The instructions that switch the constant scan on.
    pub switches: Vec<SettingUse>,
    /// The device of the constant scan time, and the relay that switches the constant scan on. Empty if there are none.
    pub devices: [&'static str; 2],
    /// Whether the program may switch the constant scan on with an unknown time.
    pub is_unknown: bool,
    /// Whether the user states the constant scan time.
    pub is_stated: bool,
    /// The name of the CPU parameter that may set a constant scan time, if it is not stated whether it does.
    pub unstated: Option<&'static str>,
}

/// A scan of a run from power-up in which the inputs do not change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WaitingScan {
    /// The number of the scan; the first one after power-up has the number 1.
    pub number: usize,
    /// Whether all inputs are on. If not, all are off.
    pub inputs_on: bool,
}

impl Cycle {
    /// An upper bound on a scan that waits for the constant scan time: all interrupts of a scan may occur just before
    /// the wait ends.
    #[must_use]
    pub fn longest(&self) -> Option<Picos> {
        self.upper.map(|time| time + self.interrupts)
    }
}
