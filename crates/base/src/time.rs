//! Exact times in integer picoseconds, and their conversion from and to decimal text.

use std::fmt;
use std::iter::Sum;
use std::str::FromStr;

/// A duration in whole picoseconds (ps). Sums and products are checked: an overflow (over 213 days) panics, because a
/// wrapped result would be a bound that is too low.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Picos(pub u64);

/// Why a text cannot be read as a time.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TimeError {
    /// The text is empty.
    #[error("the time is empty")]
    Empty,
    /// The number is negative.
    #[error("a time cannot be negative")]
    Negative,
    /// The text is not a number of decimal digits with at most one point.
    #[error("not a decimal number")]
    NotDecimal,
    /// The number has decimals below a picosecond.
    #[error("finer than a picosecond")]
    TooFine,
    /// The time in picoseconds does not fit into a `u64`.
    #[error("too large")]
    TooLarge,
    /// The duration has no unit, or an unknown one.
    #[error("give a unit: us, ms, s or min")]
    NoUnit,
}

/// The execution times of an instruction, from which the time of one execution follows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Times {
    /// The time when the instruction fires (the on-time). For an instruction with a variable number of units, the part
    /// that does not depend on this number.
    pub on: Picos,
    /// The time when control reaches the instruction but it does not fire (the off-time).
    pub off: Picos,
    /// The additional time for each unit if the instruction fires and its number of units is variable.
    pub per_unit: Picos,
}

impl Times {
    /// The times of an instruction whose time does not depend on a number of units.
    #[must_use]
    pub fn new(on: Picos, off: Picos) -> Times {
        Times { on, off, per_unit: Picos::ZERO }
    }

    /// The on-time of an instruction with this number of units (words, digits or points).
    #[must_use]
    pub fn with(self, units: u64) -> Picos {
        self.on + self.per_unit.times(units)
    }
}

impl Picos {
    /// A time of zero.
    pub const ZERO: Picos = Picos(0);

    /// Reads decimal microseconds (`1.52`) without rounding.
    ///
    /// # Errors
    /// If the text is negative or not a decimal number, has decimals below a picosecond, or is too large.
    pub fn from_us_text(text: &str) -> Result<Picos, TimeError> {
        decimal(text.trim(), 6)
    }

    /// Reads a duration with a unit from `ps` to `days` in any letter case (`10ms`, `1.5 us`, `200µs`, `2min`) without
    /// rounding.
    ///
    /// # Errors
    /// If the unit is missing or unknown, or the number is negative, is not decimal, has decimals below a picosecond,
    /// or is too large.
    ///
    /// # Examples
    /// ```
    /// use scanbound_base::time::Picos;
    ///
    /// assert_eq!(Picos::from_duration_text("1.5 us"), Ok(Picos(1_500_000)));
    /// assert!(Picos::from_duration_text("1.5").is_err());
    /// ```
    pub fn from_duration_text(text: &str) -> Result<Picos, TimeError> {
        let text = text.trim().to_lowercase();
        let units = [
            ("ps", 0, 1),
            ("ns", 3, 1),
            ("us", 6, 1),
            ("µs", 6, 1),
            ("μs", 6, 1),
            ("ms", 9, 1),
            ("days", 12, 86_400),
            ("s", 12, 1),
            ("min", 12, 60),
            ("h", 12, 3_600),
        ];
        for (unit, digits, times) in units {
            if let Some(number) = text.strip_suffix(unit) {
                let time = decimal(number.trim(), digits)?;
                return time.0.checked_mul(times).map(Picos).ok_or(TimeError::TooLarge);
            }
        }
        Err(if text.is_empty() { TimeError::Empty } else { TimeError::NoUnit })
    }

    /// The time multiplied by `n`.
    ///
    /// # Panics
    /// On overflow, as sums do.
    #[must_use]
    pub fn times(self, n: u64) -> Picos {
        Picos(self.0.checked_mul(n).expect("time overflow"))
    }

    /// The difference, or `None` if `other` is larger.
    #[must_use]
    pub fn checked_sub(self, other: Picos) -> Option<Picos> {
        self.0.checked_sub(other.0).map(Picos)
    }

    /// The time in decimal microseconds, without trailing zeros (`1.52`).
    #[must_use]
    pub fn us_text(self) -> String {
        decimal_text(self.0, 6)
    }

    /// The exact time in the largest of the units s, ms, us and ns of which it has at least one, otherwise in ns
    /// (`8.448 ms`, `20 ns`, `0.5 ns`). Zero is in us.
    #[must_use]
    pub fn best_text(self) -> String {
        self.text_like(self)
    }

    /// The exact time in the unit in which [`Picos::best_text`] shows `other`, so that times shown side by side have
    /// one unit.
    #[must_use]
    pub fn text_like(self, other: Picos) -> String {
        let (digits, unit) = match other.0 {
            0 => (6, "us"),
            n if n >= 1_000_000_000_000 => (12, "s"),
            n if n >= 1_000_000_000 => (9, "ms"),
            n if n >= 1_000_000 => (6, "us"),
            _ => (3, "ns"),
        };
        format!("{} {unit}", decimal_text(self.0, digits))
    }
}

fn decimal(text: &str, digits: usize) -> Result<Picos, TimeError> {
    if text.is_empty() {
        return Err(TimeError::Empty);
    }
    if let Some(rest) = text.strip_prefix('-') {
        return Err(if rest.is_empty() { TimeError::NotDecimal } else { TimeError::Negative });
    }
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let all_digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if !all_digits(whole) || !all_digits(fraction) || (whole.is_empty() && fraction.is_empty()) {
        return Err(TimeError::NotDecimal);
    }
    let fraction = fraction.trim_end_matches('0');
    if fraction.len() > digits {
        return Err(TimeError::TooFine);
    }
    let number = |digits: &str| match digits {
        "" => Some(0),
        digits => digits.parse::<u64>().ok(),
    };
    let fine = number(fraction).map(|number| number * power_of_ten(digits - fraction.len()));
    let whole = number(whole).and_then(|number| number.checked_mul(power_of_ten(digits)));
    let sum = whole.zip(fine).and_then(|(whole, fine)| whole.checked_add(fine));
    sum.map(Picos).ok_or(TimeError::TooLarge)
}

/// 10 to the power `zeros`, which is at most 12.
fn power_of_ten(zeros: usize) -> u64 {
    10u64.pow(zeros as u32)
}

fn decimal_text(value: u64, digits: usize) -> String {
    let unit = power_of_ten(digits);
    let (whole, fraction) = (value / unit, value % unit);
    if fraction == 0 {
        return whole.to_string();
    }
    format!("{whole}.{fraction:0digits$}").trim_end_matches('0').to_owned()
}

impl std::ops::Add for Picos {
    type Output = Picos;
    fn add(self, other: Picos) -> Picos {
        Picos(self.0.checked_add(other.0).expect("time overflow"))
    }
}

impl std::ops::AddAssign for Picos {
    fn add_assign(&mut self, other: Picos) {
        *self = *self + other;
    }
}

impl Sum for Picos {
    fn sum<I: Iterator<Item = Picos>>(times: I) -> Picos {
        times.fold(Picos::ZERO, |a, b| a + b)
    }
}

impl fmt::Display for Picos {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.best_text())
    }
}

impl FromStr for Picos {
    type Err = TimeError;
    fn from_str(text: &str) -> Result<Picos, TimeError> {
        Picos::from_duration_text(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn microseconds_are_read_exactly() {
        assert_eq!(Picos::from_us_text("1.52"), Ok(Picos(1_520_000)));
        assert_eq!(Picos::from_us_text("0.0019"), Ok(Picos(1_900)));
        assert_eq!(Picos::from_us_text(" 50.000 "), Ok(Picos(50_000_000)));
        assert_eq!(Picos::from_us_text(".5"), Ok(Picos(500_000)));
    }

    #[test]
    fn what_is_no_time_is_refused_with_its_reason() {
        assert_eq!(Picos::from_us_text(""), Err(TimeError::Empty));
        assert_eq!(Picos::from_us_text("-1"), Err(TimeError::Negative));
        assert_eq!(Picos::from_us_text("1e3"), Err(TimeError::NotDecimal));
        assert_eq!(Picos::from_us_text("0.0000001"), Err(TimeError::TooFine));
        assert_eq!(Picos::from_us_text("99999999999999999"), Err(TimeError::TooLarge));
        assert_eq!(Picos::from_duration_text("10"), Err(TimeError::NoUnit));
    }

    #[test]
    fn durations_have_units_and_texts_round_trip() {
        for (text, ps) in
            [("10MS", 10_000_000_000), ("200µs", 200_000_000), ("1.5min", 90_000_000_000_000)]
        {
            assert_eq!(text.parse::<Picos>(), Ok(Picos(ps)));
        }
        for ps in [0, 1, 999, 1_000, 1_520_000, 8_448_000_000, 1_000_000_000_001] {
            assert_eq!(Picos(ps).best_text().parse::<Picos>(), Ok(Picos(ps)));
        }
        assert_eq!(Picos(917_474_134).text_like(Picos(1_091_023_762)), "0.917474134 ms");
    }
}
