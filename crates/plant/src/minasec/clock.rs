//! The oscillator: its nominal period, the tolerance of a board's period, and its jitter.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use scanbound_base::time::Picos;
use std::fmt;
use std::str::FromStr;

/// By how much SLOW divides the clock: 14 stages of the 74HC4060 and one flip-flop.
pub const SLOW: u64 = 32_768;

/// A share in millionths, written in percent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Fraction(pub u32);

impl Fraction {
    /// This share of a time, rounded down.
    #[must_use]
    pub fn of(self, time: Picos) -> Picos {
        let part = u128::from(time.0) * u128::from(self.0) / 1_000_000;
        Picos(u64::try_from(part).unwrap_or(u64::MAX))
    }
}

impl FromStr for Fraction {
    type Err = String;
    fn from_str(text: &str) -> Result<Fraction, String> {
        let fault = || format!("'{text}' is not a share: give percent, such as 5% or 0.02%");
        let number = text.trim().strip_suffix('%').ok_or_else(fault)?.trim();
        let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
        let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        if whole.is_empty() || !digits(whole) || !digits(fraction) || fraction.len() > 4 {
            return Err(fault());
        }
        format!("{whole}{fraction:0<4}").parse().map(Fraction).map_err(|_| fault())
    }
}

impl fmt::Display for Fraction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{}.{:04}", self.0 / 10_000, self.0 % 10_000);
        write!(f, "{} %", text.trim_end_matches('0').trim_end_matches('.'))
    }
}

/// The oscillator.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clock {
    /// The period of FAST, in which one word is executed. All periods are equal unless there is jitter.
    pub period: Picos,
    /// Whether the switch is on SLOW.
    pub slow: bool,
    /// How far the period of a board may differ from the nominal one: drawn once, uniformly, with the seed.
    pub tolerance: Fraction,
    /// How far each period may differ from the board's: drawn for each, uniformly, with the seed.
    pub jitter: Fraction,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl Default for Clock {
    /// FAST without tolerance: f = 1 / (2.2 R C), 15 kΩ and 1 nF.
    fn default() -> Clock {
        Clock {
            period: Picos(33_000_000),
            slow: false,
            tolerance: Fraction(0),
            jitter: Fraction(0),
            seed: 0,
        }
    }
}

impl Clock {
    /// The settings that no oscillator can have, as messages.
    #[must_use]
    pub(super) fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        if !(Picos(1_000_000)..=Picos(1_000_000_000)).contains(&self.period) {
            faults.push(format!(
                "the oscillator cannot have a period of {}: give 1 us to 1 ms",
                self.period
            ));
        }
        for (name, part) in [("tolerance", self.tolerance), ("jitter", self.jitter)] {
            if part > Fraction(500_000) {
                faults.push(format!("a {name} of {part} is too large: give at most 50 %"));
            }
        }
        faults
    }

    /// The longest period that can be drawn.
    #[must_use]
    pub fn longest(&self) -> Picos {
        let base = self.base();
        let board = base + self.tolerance.of(base);
        board + self.jitter.of(board)
    }

    fn base(&self) -> Picos {
        self.period.times(if self.slow { SLOW } else { 1 })
    }
}

/// The oscillator of one board.
#[derive(Debug, Clone)]
pub(super) struct Oscillator {
    /// The board's period.
    pub(super) period: u64,
    /// The largest difference of a period from it.
    jitter: u64,
    random: Pcg64Mcg,
}

impl Oscillator {
    pub(super) fn new(clock: &Clock) -> Oscillator {
        let mut random = Pcg64Mcg::seed_from_u64(clock.seed);
        let base = clock.base();
        let spread = clock.tolerance.of(base).0;
        let drawn = u128::from(random.next_u64()) * (2 * u128::from(spread) + 1);
        let period = base.0 - spread + (drawn >> 64) as u64;
        let jitter = clock.jitter.of(Picos(period)).0;
        Oscillator { period, jitter, random }
    }

    /// Whether all periods are equal.
    pub(super) fn is_steady(&self) -> bool {
        self.jitter == 0
    }

    /// The next periods. Each is one of 65,536 values, evenly spaced around the board's period.
    pub(super) fn periods(&mut self, periods: &mut [u64]) {
        let span = 2 * u128::from(self.jitter) + 1;
        let least = self.period - self.jitter;
        for four in periods.chunks_mut(4) {
            let mut bits = self.random.next_u64();
            for period in four {
                *period = least + ((u128::from(bits & 0xFFFF) * span) >> 16) as u64;
                bits >>= 16;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_read_and_written_in_percent() {
        assert_eq!("5%".parse(), Ok(Fraction(50_000)));
        assert_eq!("0.02 %".parse(), Ok(Fraction(200)));
        assert_eq!(Fraction(200).to_string(), "0.02 %");
        assert_eq!(Fraction(50_000).to_string(), "5 %");
        for bad in ["5", "%", "-1%", "0.00001%", "x%"] {
            assert!(bad.parse::<Fraction>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_board_lies_within_the_tolerance_and_trembles_within_the_jitter() {
        let mut seen = std::collections::BTreeSet::new();
        for seed in 0..50 {
            let clock = Clock {
                tolerance: Fraction(50_000),
                jitter: Fraction(1_000),
                seed,
                ..Clock::default()
            };
            let mut oscillator = Oscillator::new(&clock);
            assert!((31_350_000..=34_650_000).contains(&oscillator.period));
            seen.insert(oscillator.period);
            let mut periods = [0; 256];
            oscillator.periods(&mut periods);
            let (low, high) =
                (oscillator.period - oscillator.jitter, oscillator.period + oscillator.jitter);
            assert!(periods.iter().all(|period| (low..=high).contains(period)));
            assert!(periods.iter().any(|&period| period != periods[0]));
            assert!(periods.iter().all(|&period| Picos(period) <= clock.longest()));
        }
        assert!(seen.len() > 40);
    }

    #[test]
    fn the_same_seed_gives_the_same_board_everywhere() {
        let clock = Clock { tolerance: Fraction(50_000), seed: 1, ..Clock::default() };
        assert_eq!(Oscillator::new(&clock).period, 34_177_167);
    }
}
