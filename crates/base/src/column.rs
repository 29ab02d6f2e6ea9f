//! Columns of CSV files whose headings name a unit of time, and the times in these columns.

use std::fmt;
use std::ops::Range;

/// A unit of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    /// The abbreviation, such as `ms`.
    pub name: &'static str,
    /// The exponent: one unit is 10 to this power picoseconds.
    digits: u32,
}

/// All units that a heading may name.
pub const UNITS: [Unit; 5] = [
    Unit { name: "s", digits: 12 },
    Unit { name: "ms", digits: 9 },
    Unit { name: "us", digits: 6 },
    Unit { name: "ns", digits: 3 },
    Unit { name: "ps", digits: 0 },
];

impl Unit {
    /// Finds a unit by its abbreviation or another usual spelling of it (`usec`, `sec`). Letter case matters,
    /// surrounding blanks do not. `None` if there is no such unit.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Unit> {
        let name = match name.trim() {
            "µs" | "μs" | "usec" => "us",
            "sec" | "seconds" => "s",
            "msec" => "ms",
            "nsec" => "ns",
            name => name,
        };
        UNITS.into_iter().find(|unit| unit.name == name)
    }

    /// The unit that a column heading names after its words: `scan_us`, `Time [s]`, `t (ms)`, `Time, us`. `None` if it
    /// names none, or consists of a unit alone (`us`).
    #[must_use]
    pub fn of_heading(head: &str) -> Option<Unit> {
        let head = head.trim().trim_end_matches([']', ')']);
        let at = head.rfind([' ', '_', '[', '(', ',', '/', '-'])?;
        Unit::from_name(&head[at + 1..])
    }

    /// The words of a heading without its unit, in lower case.
    #[must_use]
    pub fn words_of_heading(head: &str) -> String {
        let whole = head.trim();
        let words = match Unit::of_heading(whole) {
            Some(_) => {
                whole.rfind([' ', '_', '[', '(', ',', '/', '-']).map_or(whole, |at| &whole[..at])
            }
            None => whole,
        };
        words.trim_matches([' ', '_', '[', '(', ',', '/', '-']).to_lowercase()
    }

    /// Converts a decimal number in this unit, with optional sign and exponent, to picoseconds, rounded to the nearest,
    /// halves away from zero. `None` if the text is not such a number, or the number is too large (from 10^30 ps on).
    #[must_use]
    pub fn read(self, text: &str) -> Option<i128> {
        let text = text.trim();
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
            None => (text, 0),
        };
        let (negative, mantissa) = match mantissa.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, mantissa.strip_prefix('+').unwrap_or(mantissa)),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
        if !digits(whole) || !digits(fraction) || (whole.is_empty() && fraction.is_empty()) {
            return None;
        }
        let digits = format!("{whole}{fraction}");
        let digits = digits.trim_start_matches('0');
        // The position of the decimal point in a value in picoseconds, counted in digits.
        let point = i64::try_from(digits.len()).ok()? - i64::try_from(fraction.len()).ok()?
            + i64::from(exponent)
            + i64::from(self.digits);
        let value: i128 = if digits.is_empty() || point < 0 {
            0
        } else if point > 30 {
            return None;
        } else {
            let kept = usize::try_from(point).ok()?;
            let padded = format!("{digits:0<kept$}");
            let value = format!("0{}", &padded[..kept]).parse::<i128>().ok()?;
            let round = padded[kept..].starts_with(|c| c >= '5');
            value + i128::from(round)
        };
        Some(if negative { -value } else { value })
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name)
    }
}

/// The byte range of cell number `number` (from 0) in a line of a CSV file, without surrounding blanks and quotation
/// marks. A delimiter between quotation marks ends no cell. `None` if the line has fewer cells.
#[must_use]
pub fn cell(line: &str, delimiter: u8, number: usize) -> Option<Range<usize>> {
    let (mut quoted, mut begin, mut seen) = (false, 0, 0);
    let ends = line.bytes().enumerate().filter(|&(_, byte)| {
        quoted ^= byte == b'"';
        byte == delimiter && !quoted
    });
    let ends: Vec<usize> = ends.map(|(at, _)| at).chain([line.len()]).collect();
    for end in ends {
        if seen == number {
            let text = &line[begin..end];
            let inner = text.trim().trim_matches('"').trim();
            let from = begin + text.find(inner)?;
            return Some(from..from + inner.len());
        }
        (begin, seen) = (end + 1, seen + 1);
    }
    None
}

/// The line number, from 1, at which a CSV record begins. `at` is the position that the CSV reader gives, which counts
/// blank lines and comments before a record as part of it; this function skips them. `comment` is the first byte of a
/// comment. Without a position: 1.
#[must_use]
pub fn line_of(bytes: &[u8], at: Option<&csv::Position>, comment: u8) -> u32 {
    let Some(at) = at else { return 1 };
    let begin = usize::try_from(at.byte()).unwrap_or(usize::MAX).min(bytes.len());
    let lines = bytes[begin..].split(|&byte| byte == b'\n');
    let is_other = |line: &&[u8]| line.first() == Some(&comment) || line.trim_ascii().is_empty();
    let skipped = lines.take_while(is_other);
    u32::try_from(at.line() + skipped.count() as u64).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_found_in_their_line() {
        let line = "a, b ,\"c,d\",,e";
        let found = |number| cell(line, b',', number).map(|bytes| &line[bytes]);
        assert_eq!([0, 1, 2, 3, 4].map(found), ["a", "b", "c,d", "", "e"].map(Some));
        assert_eq!(found(5), None);
    }

    #[test]
    fn heads_name_their_unit_in_any_of_the_usual_ways() {
        for (head, words, unit) in [
            ("scan_us", "scan", "us"),
            ("Time [s]", "time", "s"),
            ("t (ms)", "t", "ms"),
            ("Scan time, µs", "scan time", "us"),
            ("Time[ns]", "time", "ns"),
        ] {
            assert_eq!(Unit::of_heading(head).map(|unit| unit.name), Some(unit), "{head}");
            assert_eq!(Unit::words_of_heading(head), words);
        }
        for head in ["scan", "scan time", "logic", "us", "scan_min", ""] {
            assert_eq!(Unit::of_heading(head), None, "{head}");
        }
        assert_eq!(Unit::words_of_heading("D0"), "d0");
    }

    #[test]
    fn times_are_read_to_the_nearest_picosecond() {
        let us = Unit::from_name("us").expect("a unit");
        let s = Unit::from_name("s").expect("a unit");
        for (unit, text, ps) in [
            (us, "8448", 8_448_000_000),
            (us, " 8448.0000015 ", 8_448_000_002),
            (us, "-.5", -500_000),
            (s, "8.448e-03", 8_448_000_000),
            (s, "1E2", 100_000_000_000_000),
            (s, "0.0000000000004", 0),
            (s, "0.0000000000005", 1),
            (s, "1e-99", 0),
            (s, "0", 0),
            (s, "+000.1000", 100_000_000_000),
        ] {
            assert_eq!(unit.read(text), Some(ps), "{text}");
        }
        for text in ["", "-", ".", "1,5", "abc", "1e", "1e40", "0x1", "1 2", "nan"] {
            assert_eq!(s.read(text), None, "{text}");
        }
    }
}
