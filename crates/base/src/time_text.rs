//! Formats times for people: up to four digits and the usual unit (`324.2 ms`, `2.6 h`, `4.7 days`).

use super::time::Picos;

const SECOND: u64 = 1_000_000_000_000;

/// The units with their length in picoseconds, and the shortest time that is shown in each; the largest unit first.
const UNITS: [(&str, u64, u64); 8] = [
    ("days", 86_400 * SECOND, 2 * 86_400 * SECOND),
    ("h", 3_600 * SECOND, 2 * 3_600 * SECOND),
    ("min", 60 * SECOND, 120 * SECOND),
    ("s", SECOND, SECOND),
    ("ms", 1_000_000_000, 1_000_000_000),
    ("us", 1_000_000, 1_000_000),
    ("ns", 1_000, 1_000),
    ("ps", 1, 0),
];

/// The number of significant digits with which a time is shown.
const DIGITS: u32 = 4;

/// A unit and a number of decimals, with which all times of a column are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scale {
    unit: &'static str,
    size: u64,
    decimals: u32,
}

impl Scale {
    /// The scale that shows this time with four significant digits, or fewer if the digits are finer than a picosecond.
    #[must_use]
    pub fn of(time: Picos) -> Scale {
        if time == Picos::ZERO {
            return Scale { unit: "us", size: 1_000_000, decimals: 1 };
        }
        let least = |&&(_, _, least): &&(&str, u64, u64)| time.0 >= least;
        let &(unit, size, _) = UNITS.iter().find(least).unwrap_or(&("ps", 1, 0));
        let whole = (time.0 / size).max(1).ilog10() + 1;
        // Picoseconds are integers, so they have no decimals.
        let most = if size == 1 { 0 } else { DIGITS };
        Scale { unit, size, decimals: DIGITS.saturating_sub(whole).min(most) }
    }

    /// The smallest time above 0 that the scale can show, in picoseconds.
    fn step(self) -> u64 {
        (self.size / 10u64.pow(self.decimals)).max(1)
    }

    /// Formats this many steps, each of [`Scale::step`].
    fn text(self, steps: u64) -> String {
        let unit = 10u64.pow(self.decimals);
        let (whole, part) = (steps / unit, steps % unit);
        match self.decimals {
            0 => format!("{whole} {}", self.unit),
            n => format!("{whole}.{part:0width$} {}", self.unit, width = n as usize),
        }
    }

    /// Formats the time in this scale, rounded to the nearest step.
    #[must_use]
    pub fn about(self, time: Picos) -> String {
        let step = u128::from(self.step());
        let steps = (u128::from(time.0) + step / 2) / step;
        self.text(u64::try_from(steps).unwrap_or(u64::MAX))
    }

    /// Formats the time in this scale, rounded up.
    #[must_use]
    pub fn up(self, time: Picos) -> String {
        self.text(time.0.div_ceil(self.step()))
    }

    /// Formats the parts of a sum so that the numbers shown add up to the sum shown, which is rounded up. A part that
    /// is too small for the scale is shown in a smaller unit.
    #[must_use]
    pub fn parts(self, parts: &[Picos]) -> Vec<String> {
        let step = self.step();
        let whole: u128 = parts.iter().map(|part| u128::from(part.0)).sum();
        let mut steps: Vec<u64> = parts.iter().map(|part| part.0 / step).collect();
        let sum_shown: u128 = steps.iter().map(|&one| u128::from(one)).sum();
        let missing = whole.div_ceil(u128::from(step)).saturating_sub(sum_shown);
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by_key(|&index| std::cmp::Reverse(parts[index].0 % step));
        for index in order.into_iter().take(usize::try_from(missing).unwrap_or(usize::MAX)) {
            steps[index] += 1;
        }
        let text = |(part, steps): (&Picos, u64)| match (part.0, steps) {
            (1.., 0) => about(*part),
            _ => self.text(steps),
        };
        parts.iter().zip(steps).map(text).collect()
    }
}

/// Formats an upper bound in its usual unit: rounds up to four digits.
#[must_use]
pub fn at_most(time: Picos) -> String {
    trimmed(time, Scale::up)
}

/// Formats a lower bound in its usual unit: rounds down to four digits.
#[must_use]
pub fn at_least(time: Picos) -> String {
    trimmed(time, |scale, time| scale.text(time.0 / scale.step()))
}

/// Formats a time that is not a bound in its usual unit: rounds to the nearest, with four digits.
#[must_use]
pub fn about(time: Picos) -> String {
    trimmed(time, Scale::about)
}

fn trimmed(time: Picos, tell: impl Fn(Scale, Picos) -> String) -> String {
    let text = tell(Scale::of(time), time);
    let Some((number, unit)) = text.split_once(' ') else { return text };
    let number = match number.contains('.') {
        true => number.trim_end_matches('0').trim_end_matches('.'),
        false => number,
    };
    match (number, unit) {
        // Rounding reached the next larger unit.
        ("1000", "us") => "1 ms".to_owned(),
        ("1000", "ms") => "1 s".to_owned(),
        ("1000", "ns") => "1 us".to_owned(),
        _ => format!("{number} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_the_unit_and_the_digits_that_people_use() {
        for (ps, sum_shown) in [
            (0, "0 us"),
            (1, "1 ps"),
            (1_520_000, "1.52 us"),
            (998_917_014, "999 us"),
            (999_960_001, "1 ms"),
            (324_123_321_714, "324.2 ms"),
            (8_448_000_000, "8.448 ms"),
            (1_162_712_458_868, "1.163 s"),
            (119 * SECOND, "119 s"),
            (200 * SECOND, "3.334 min"),
            (9_400 * SECOND, "2.612 h"),
            (406_080 * SECOND, "4.7 days"),
        ] {
            assert_eq!(at_most(Picos(ps)), sum_shown);
        }
        assert_eq!(at_least(Picos(324_123_321_714)), "324.1 ms");
        assert_eq!(about(Picos(324_163_321_714)), "324.2 ms");
        assert_eq!(at_most(Picos(u64::MAX)), "213.6 days");
    }

    #[test]
    fn what_is_shown_of_parts_adds_up_to_what_is_shown_of_the_whole() {
        let parts = [99_840_000_000, 333_333_333, 333_333_333, 333_333_334, 15].map(Picos);
        let whole: Picos = parts.iter().copied().sum();
        let scale = Scale::of(whole);
        let sum_shown = scale.parts(&parts);
        assert_eq!(sum_shown, ["99.9 ms", "0.3 ms", "0.3 ms", "0.4 ms", "15 ps"].map(String::from));
        assert_eq!(scale.up(whole), "100.9 ms");
    }
}
