//! What a program does to the limits of its own scan time: it restarts the watchdog, sets the watchdog time, or sets a
//! constant scan time.

use scanbound_base::time::Picos;
use std::collections::{BTreeMap, BTreeSet};

/// How the program changes the limits of its scan time. Instructions are indices into `Program::instructions`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ScanControl {
    /// Instructions that restart the watchdog when they fire.
    pub restarts: BTreeSet<usize>,
    /// Instructions that set the watchdog time when they fire, and the time. It applies to this scan after a restart,
    /// and to all later scans.
    pub watchdog: BTreeMap<usize, Setting>,
    /// Instructions that extend the watchdog time of the current scan each time they fire, with the smallest and the
    /// largest extension.
    pub extensions: BTreeMap<usize, (Picos, Picos)>,
    /// Instructions that set the constant scan time when they fire, and the time.
    pub constant: BTreeMap<usize, Setting>,
    /// Instructions that switch the constant scan on or off.
    pub switches: BTreeMap<usize, Switch>,
    /// Instructions that write one of `devices` only if an index register holds a value that the program does not write
    /// to it. `Some`: how such an instruction then changes the relay that enables the constant scan. `None`: the
    /// instruction writes words, so it may set either time.
    pub by_index: BTreeMap<usize, Option<Switch>>,
    /// Three devices: the register of the watchdog time, the register of the constant scan time, and the relay that
    /// enables the constant scan. Empty if the CPU has none.
    pub devices: [&'static str; 3],
    /// Other names of the same devices, in the same order. Empty if they have none.
    pub other_names: [&'static str; 3],
    /// Whether an instruction may let interrupts wait beyond the end of a scan.
    pub holds_interrupts: bool,
    /// The name of the CPU parameter that sets a minimum scan time, if the CPU has one.
    pub by_parameters: Option<&'static str>,
}

/// The time to which the watchdog or the constant scan is set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Setting {
    /// A time from the first value to the second one.
    Range(Picos, Picos),
    /// The unknown value of this device.
    Device(String),
    /// An unknown result of the instruction.
    Computed,
    /// Any time, but the instruction may also leave it as it is: which devices it writes is unknown.
    Possible,
}

impl Setting {
    /// The smallest and the largest time that the instruction may set. `None` if unknown.
    #[must_use]
    pub fn range(&self) -> Option<(Picos, Picos)> {
        match self {
            Setting::Range(least, most) => Some((*least, *most)),
            Setting::Device(_) | Setting::Computed | Setting::Possible => None,
        }
    }
}

/// How an instruction changes the relay that enables a constant scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switch {
    /// The relay is set to the instruction's condition.
    Condition,
    /// The relay is set when the instruction fires.
    On,
    /// The relay is reset when the instruction fires.
    Off,
    /// The relay may be reset when the instruction fires: which devices it resets is unknown.
    PossiblyOff,
    /// The relay may get any value.
    Unknown,
}

impl ScanControl {
    /// Lets index registers hold any values when a scan starts: each instruction of `by_index` may then set both times,
    /// or change the relay in the way given there. Empties `by_index`.
    pub fn distrust_indices(&mut self) {
        for (at, switch) in std::mem::take(&mut self.by_index) {
            match switch {
                Some(switch) => _ = self.switches.entry(at).or_insert(switch),
                None => {
                    self.watchdog.entry(at).or_insert(Setting::Possible);
                    self.constant.entry(at).or_insert(Setting::Possible);
                }
            }
        }
    }

    /// Whether an execution of an instruction counts as fired if it is unknown whether it fired. Restarts and
    /// extensions of the watchdog count as fired; settings of times and switches count as not fired; for all others the
    /// result is `value`, what the scan found.
    #[must_use]
    pub fn may_have_fired(&self, instruction: usize, value: bool) -> bool {
        let sets = self.watchdog.contains_key(&instruction)
            || self.constant.contains_key(&instruction)
            || self.switches.contains_key(&instruction);
        let helps =
            self.restarts.contains(&instruction) || self.extensions.contains_key(&instruction);
        helps || (value && !sets)
    }

    /// Whether the program restarts the watchdog, sets its time or extends it.
    #[must_use]
    pub fn sets_watchdog(&self) -> bool {
        !self.restarts.is_empty() || !self.watchdog.is_empty() || !self.extensions.is_empty()
    }

    /// Whether the program may cause a constant scan: an instruction may switch it on, or, if no instruction switches
    /// it or all only possibly switch it off, the program certainly sets the constant scan time.
    #[must_use]
    pub fn may_be_constant(&self) -> bool {
        match self.switches.values().all(|switch| *switch == Switch::PossiblyOff) {
            // The relay is not switched by the program: something else enables the constant scan that the program sets.
            true => self.constant.values().any(|setting| *setting != Setting::Possible),
            false => {
                let switches_on = |one| !matches!(one, &Switch::Off | &Switch::PossiblyOff);
                self.switches.values().any(switches_on)
            }
        }
    }
}
