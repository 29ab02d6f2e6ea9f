//! The clock of a machine that executes one word per clock cycle, as the user states it.

use super::{Evidence, Table};
use scanbound_base::time::Picos;
use std::fmt;
use std::str::FromStr;

/// The divisor of a MINASEC-U's clock in the switch position SLOW.
const SLOW: u64 = 32_768;

/// The clock that the user states (`--clock`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StatedClock {
    /// The switch position FAST: the clock of the table, unchanged.
    Fast,
    /// The switch position SLOW: the clock of the table, divided by 32,768.
    Slow,
    /// A clock with this period.
    Period {
        /// The period of the clock, rounded up if the user gave a frequency.
        period: Picos,
        /// The period or frequency as the user wrote it.
        text: String,
    },
}

impl FromStr for StatedClock {
    type Err = String;
    fn from_str(text: &str) -> Result<StatedClock, String> {
        let text = text.trim();
        match text.to_ascii_lowercase().as_str() {
            "fast" => return Ok(StatedClock::Fast),
            "slow" => return Ok(StatedClock::Slow),
            _ => {}
        }
        let fault = || {
            format!(
                "'{text}' is not a clock: give a frequency (30.3kHz), a period (33us) of at most 10 s, fast or slow"
            )
        };
        let period = match text.strip_suffix("Hz") {
            Some(number) => period(number.trim()).ok_or_else(fault)?,
            None => Picos::from_duration_text(text).map_err(|_| fault())?,
        };
        // No such machine is slower. Longer periods could make the sum over a scan too large to represent.
        if period == Picos::ZERO || period > Picos(10_000_000_000_000) {
            return Err(fault());
        }
        Ok(StatedClock::Period { period, text: text.to_owned() })
    }
}

/// The period of a frequency such as `30.3k`, `0.0303 M` or `30300` (Hz), rounded up. `None` if the text is not a
/// frequency above 0.
fn period(text: &str) -> Option<Picos> {
    let (number, digits) = match text.strip_suffix(['k', 'M']) {
        Some(number) if text.ends_with('k') => (number, 3),
        Some(number) => (number, 6),
        None => (text, 0),
    };
    // Parsed like a duration, the frequency is in microhertz.
    let number = Picos::from_us_text(number.trim()).ok()?;
    let microhertz = u128::from(number.0) * 10_u128.pow(digits);
    let picos = 1_000_000_000_000_u128 * 1_000_000;
    (microhertz > 0)
        .then(|| picos.div_ceil(microhertz))
        .and_then(|ps| u64::try_from(ps).ok())
        .map(Picos)
}

impl fmt::Display for StatedClock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StatedClock::Fast => f.write_str("the clock is on FAST"),
            StatedClock::Slow => write!(f, "the clock is on SLOW: divided by {SLOW}"),
            StatedClock::Period { period, text } => {
                write!(f, "the clock is {text}: each program word takes {period}")
            }
        }
    }
}

impl Table {
    /// Replaces the table's clock by the stated one: the times of all rows but `@` rows change. A stated period is used
    /// as it is: the table's tolerance (its factor) applies only to the table's clock, so it is removed.
    pub fn set_clock(&mut self, clock: &StatedClock) {
        let words = self.rows.iter_mut().filter(|row| !row.name.starts_with('@'));
        match clock {
            StatedClock::Fast => {}
            StatedClock::Slow => words.for_each(|row| {
                (row.on, row.off) = (row.on.times(SLOW), row.off.times(SLOW));
                row.source = format!("{}; SLOW divides the clock by {SLOW}", row.source);
            }),
            StatedClock::Period { period, text } => {
                words.for_each(|row| {
                    (row.on, row.off) = (*period, *period);
                    row.evidence = Evidence::Stated;
                    row.source = format!("clock of {text}, stated on the command line");
                });
                self.factor = None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(text: &str) -> Result<StatedClock, String> {
        text.parse()
    }

    #[test]
    fn frequencies_become_periods_that_are_not_too_short() {
        for (text, ps) in [
            ("30.3kHz", 33_003_301),
            ("30303.030303 Hz", 33_000_001),
            ("0.03 MHz", 33_333_334),
            ("33us", 33_000_000),
            ("33.0004 us", 33_000_400),
        ] {
            let Ok(StatedClock::Period { period, .. }) = clock(text) else { panic!("{text}") };
            assert_eq!(period, Picos(ps), "{text}");
        }
        assert_eq!(clock("SLOW"), Ok(StatedClock::Slow));
        for bad in ["", "0Hz", "30", "-1kHz", "kHz", "1GHz ", "0us", "1e3Hz", "99s", "medium"] {
            assert!(clock(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_stated_clock_takes_the_place_of_the_tables_and_its_tolerance() {
        let mut table = Table::builtin("minasec-u").expect("a table");
        table.set_clock(&clock("30.3kHz").expect("a clock"));
        let row = table.row("ANDI").expect("a row");
        assert_eq!((row.on, row.evidence), (Picos(33_003_301), Evidence::Stated));
        assert_eq!(table.factor, None);
        assert_eq!(table.row("@input-delay").map(|row| row.on), Some(Picos(19_000_000_000)));
        let mut table = Table::builtin("minasec-u").expect("a table");
        table.set_clock(&StatedClock::Slow);
        assert_eq!(table.row("STI").map(|row| row.off), Some(Picos(1_081_344_000_000)));
        assert!(table.factor.is_some());
    }
}
