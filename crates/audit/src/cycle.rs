//! The constant scan time, which each scan takes at least, and the watchdog.

use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use std::sync::Arc;

/// An instruction that sets the watchdog time or the constant scan time, or that switches the constant scan on or off.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettingUse {
    /// The place of the instruction.
    pub at: Location,
    /// The text of the instruction.
    pub instruction: Arc<str>,
    /// The smallest and the largest time that the instruction sets. `None` if unknown, or if it sets no time.
    pub times: Option<(Picos, Picos)>,
    /// The device from which the instruction takes the time. `None` if the time is known, computed, or not set.
    pub from: Option<String>,
}

/// The longest part of one simulated scan without a restart of the watchdog, and the largest watchdog time that can be
/// set in this scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stretch {
    /// A lower bound on the time of the part. 0 if an interrupt may restart the watchdog at any moment.
    pub took: Picos,
    /// The largest watchdog time that can be set in the scan, with the extensions that it executes. `None` if unknown.
    pub watchdog: Option<Picos>,
    /// Whether a run from power-up leads to the scan.
    pub is_reached: bool,
}

/// The possible watchdog times of a program, and how long its scans run without a restart of the watchdog.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Watchdog {
    /// The watchdog time unless the program sets a different one: as stated, otherwise from the table. `None` if
    /// neither gives it.
    pub default: Option<Picos>,
    /// Whether the user states the watchdog time.
    pub is_stated: bool,
    /// The register that holds the watchdog time. Empty if the CPU has none.
    pub device: &'static str,
    /// The instructions that set the watchdog time.
    pub settings: Vec<SettingUse>,
    /// The smallest possible watchdog time, by default or as the program sets it. 0 if the program sets an unknown time
    /// and none is stated. `None` if the program sets none and the default is unknown.
    pub least: Option<Picos>,
    /// The number of instructions that restart the watchdog.
    pub restarts: usize,
    /// An upper bound on the time without a watchdog restart, with all points that the CPU can have. `None` if no
    /// instruction restarts the watchdog.
    pub upper: Option<Picos>,
    /// The longest part without a restart of each simulated scan. Empty if no instruction of the program concerns the
    /// watchdog or the constant scan.
    pub found: Vec<Stretch>,
}

/// The constant scan: a minimum scan time, for which each scan waits.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cycle {
    /// The largest constant scan time that is stated, or that the program can set. `None` if there is none or only an
    /// unknown one (`is_unknown`).
    pub upper: Option<Picos>,
    /// The time of all interrupts that a scan is charged. It is added to the constant scan time, because the interrupts
    /// may occur just before the wait ends.
    pub interrupts: Picos,
    /// A constant scan time that is stated, or that a simulated run set: some scan waits until this time has passed.
    /// `None` if there is none.
    pub lower: Option<Picos>,
    /// The scan that was found to wait for the constant scan time. `None` if there is none, or the time is stated.
    pub waits: Option<WaitingScan>,
    /// The instructions that set the constant scan time.
    pub settings: Vec<SettingUse>,
    /// The instructions that switch the constant scan on or off.
    pub switches: Vec<SettingUse>,
    /// The register of the constant scan time, and the relay that switches the constant scan on. An empty text if the
    /// CPU has none.
    pub devices: [&'static str; 2],
    /// Whether the program may switch the constant scan on with an unknown time, and no time is stated.
    pub is_unknown: bool,
    /// Whether the user states the constant scan time.
    pub is_stated: bool,
    /// The name of the CPU parameter that may set a constant scan time, if it is not stated whether it does.
    pub unstated: Option<&'static str>,
}

/// A scan of a simulated run from power-up. In all scans of this run, the inputs have the same values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WaitingScan {
    /// The number of the scan; the first one after power-up has the number 1.
    pub number: usize,
    /// Whether all inputs are on. If not, all are off.
    pub inputs_on: bool,
}

impl Cycle {
    /// An upper bound on a scan that waits for the constant scan time: all interrupts of a scan may occur just before
    /// the wait ends. `None` if no constant scan time is known.
    #[must_use]
    pub fn longest(&self) -> Option<Picos> {
        self.upper.map(|time| time + self.interrupts)
    }
}
