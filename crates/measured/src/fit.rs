//! Suggests a clock, or a scale of the table, that fits the measurements. It is never applied automatically.

use super::figures::{Bounds, Figures};
use scanbound_base::time::Picos;
use std::fmt;

/// A suggestion that fits the measurements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fit {
    /// For a machine that executes one word per clock cycle.
    Clock(Clock),
    /// For all other machines.
    Scale(Scale),
}

/// The clock's period, measured over whole scans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clock {
    /// In the shortest scan, minus the resolution, rounded down.
    pub shortest: Picos,
    /// In the mean of all scans.
    pub mean: Picos,
    /// In the longest scan, plus the resolution, rounded up. A bound needs this one.
    pub longest: Picos,
    /// The bound with this period.
    pub bound: Picos,
    /// Whether it is lower than the current bound.
    pub lowers: bool,
}

/// A factor by which all times of the table may be multiplied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scale {
    /// The smallest factor with which no measurement exceeds the bound, rounded up.
    pub least: Ratio,
    /// The largest factor with which no measurement is shorter than every scan must be, rounded down. `None` if
    /// conditions can avoid all of a scan.
    pub most: Option<Ratio>,
    /// The bound with the smallest factor.
    pub bound: Picos,
    /// Whether it is lower than the current bound.
    pub lowers: bool,
}

impl Scale {
    /// Whether one factor fits all measurements.
    #[must_use]
    pub fn explains(&self) -> bool {
        self.most.is_none_or(|most| self.least <= most)
    }
}

/// A ratio in millionths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Ratio(pub u64);

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{}.{:06}", self.0 / 1_000_000, self.0 % 1_000_000))
    }
}

impl Fit {
    /// The suggestion for these figures.
    pub(super) fn of(figures: &Figures, bounds: &Bounds, resolution: Picos) -> Fit {
        let longest = figures.most + resolution;
        let shortest = figures.least.0.saturating_sub(resolution.0);
        if let Some(words) = bounds.clocked {
            let period = Picos(longest.0.div_ceil(words));
            let bound = period.times(words);
            return Fit::Clock(Clock {
                shortest: Picos(shortest / words),
                mean: Picos((figures.mean.0 + words / 2) / words),
                longest: period,
                bound,
                lowers: bound < bounds.upper,
            });
        }
        let millionths = |part: u64| u128::from(part) * 1_000_000;
        let ratio = |value: u128| Ratio(u64::try_from(value).unwrap_or(u64::MAX));
        let least = ratio(millionths(longest.0).div_ceil(u128::from(bounds.upper.0.max(1))));
        let most = millionths(shortest).checked_div(u128::from(bounds.least.0)).map(ratio);
        let bound = (u128::from(bounds.upper.0) * u128::from(least.0)).div_ceil(1_000_000);
        let bound = Picos(u64::try_from(bound).unwrap_or(u64::MAX));
        Fit::Scale(Scale { least, most, bound, lowers: bound < bounds.upper })
    }
}
