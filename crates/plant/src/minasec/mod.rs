//! Emulates a MINASEC-U, clock by clock: what its devices do and how long its scans take.
//!
//! What is emulated, after the machine's description:
//!
//! - Each word takes one period of the clock. Halfway through it, at the clock's rising edge, the word reads its
//!   device, and the accumulator or the device written changes.
//! - Inputs pass a filter, and are latched when a scan begins. Outputs have latches, which words read and write;
//!   the terminals take these when a scan ends.
//! - An on-delay timer's contact closes when its coil has been on for the delay that its trimmer sets, at whatever
//!   moment that is, and opens with the coil.
//! - The counter counts when its clock input rises while the count does not equal the setting; two BCD digits, so
//!   99 is followed by 0. Its clear holds it at 0. It keeps its count without power. All else begins at 0.
//! - Power, the reset switch and the counter's clear button act at any moment.
//!
//! Where the description leaves room: the filter is an integrator (an edge passes after the filter's time, what is
//! shorter does not pass); a timer that is switched off is discharged at once; the first scan begins with the
//! power, or when the reset switch is released, and latches its inputs then.
//!
//! All times are whole picoseconds. Nothing here is a measurement: reports call it emulated.

mod clock;
mod counter;
mod filter;
mod machine;
pub mod stimulus;
pub mod trace;
pub mod vcd;

pub use clock::{Clock, Fraction};
pub use machine::{Machine, Observer, Scan, View};

use scanbound_base::time::Picos;
use std::ops::RangeInclusive;

/// The delays that T0's trimmer can set: 100 kΩ to 1.1 MΩ at 1 µF.
pub const T0_RANGE: RangeInclusive<Picos> = Picos(100_000_000_000)..=Picos(1_100_000_000_000);
/// The delays that T1's trimmer can set: 100 kΩ to 1.1 MΩ at 10 µF.
pub const T1_RANGE: RangeInclusive<Picos> = Picos(1_000_000_000_000)..=Picos(11_000_000_000_000);
/// The input filter's time constant: 10 kΩ at 1 µF.
pub const FILTER: Picos = Picos(10_000_000_000);

/// The settings of the board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settings {
    /// The oscillator.
    pub clock: Clock,
    /// T0's delay.
    pub t0: Picos,
    /// T1's delay.
    pub t1: Picos,
    /// The count at which the counter stops, 0 to 99: the two rotary switches.
    pub setting: u8,
    /// The count at power-up, 0 to 99, which the counter kept without power.
    pub count: u8,
    /// The delay of the input filter.
    pub filter: Picos,
}

impl Default for Settings {
    /// The settings of the description's test: 1 s, 1 s, 10.
    fn default() -> Settings {
        Settings {
            clock: Clock::default(),
            t0: Picos(1_000_000_000_000),
            t1: Picos(1_000_000_000_000),
            setting: 10,
            count: 0,
            filter: FILTER,
        }
    }
}

impl Settings {
    /// The settings that the board cannot have, as messages.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut delay = |name: &str, time: Picos, range: RangeInclusive<Picos>| {
            if !range.contains(&time) {
                faults.push(format!(
                    "{name} can be set from {} to {}, not to {time}",
                    range.start(),
                    range.end()
                ));
            }
        };
        delay("T0", self.t0, T0_RANGE);
        delay("T1", self.t1, T1_RANGE);
        for (name, number) in [("setting", self.setting), ("count", self.count)] {
            if number > 99 {
                faults.push(format!("the counter's {name} is {number}, but can be at most 99"));
            }
        }
        faults.extend(self.clock.faults());
        faults
    }
}

#[cfg(test)]
mod switch_tests;
#[cfg(test)]
mod tests;
