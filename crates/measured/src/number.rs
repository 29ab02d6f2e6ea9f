//! Numbers and dates in the notations of different countries. An ambiguous one is refused, never guessed.

use scanbound_base::column::Unit;

/// The decimal separator. The other separator groups thousands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decimal {
    /// `8,448.5`
    Point,
    /// `8.448,5`
    Comma,
}

/// What one cell shows about the decimal separator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SeparatorEvidence {
    Nothing,
    Surely(Decimal),
    /// One separator followed by three digits, which can mean either: `8,448`.
    Either(char),
}

/// What the cells of a column show together, each with the first line and cell that shows it.
#[derive(Debug, Default)]
pub(super) struct Signs {
    point: Option<(u32, String)>,
    comma: Option<(u32, String)>,
    either: Option<(u32, String, char)>,
    /// Whether some numbers are not of the form of `either`.
    others: bool,
}

/// A cell whose separators are ambiguous: its line, its text, and the reason.
pub(super) type Doubt = (u32, String, String);

impl Decimal {
    /// The number without grouping and with a decimal point. `None` if a group does not have three digits.
    fn plain(self, text: &str) -> Option<String> {
        let (group, point) = match self {
            Decimal::Point => (',', '.'),
            Decimal::Comma => ('.', ','),
        };
        let (mantissa, exponent) = split_exponent(text.trim());
        let (sign, digits) = split_sign(mantissa);
        let (whole, fraction) = digits.split_once(point).unwrap_or((digits, ""));
        if fraction.contains([group, point]) || (whole.contains(group) && !is_grouped(whole, group))
        {
            return None;
        }
        let whole = whole.replace(group, "");
        let point = if digits.contains(point) { "." } else { "" };
        Some([sign, &whole, point, fraction, exponent].concat())
    }

    /// Reads a number with this unit, in picoseconds.
    pub(super) fn read(self, text: &str, unit: Unit) -> Option<i128> {
        unit.read(&self.plain(text)?)
    }

    /// Reads a number without a unit, such as a voltage, in units of 10^-12.
    pub(super) fn level(self, text: &str) -> Option<i128> {
        self.read(text, Unit::from_name("s")?)
    }
}

impl Signs {
    /// Adds a cell.
    pub(super) fn cell(&mut self, line: u32, cell: &str) {
        match shown(cell.trim()) {
            SeparatorEvidence::Nothing => self.others = true,
            SeparatorEvidence::Surely(Decimal::Point) => {
                self.others = true;
                self.point.get_or_insert_with(|| (line, cell.to_owned()));
            }
            SeparatorEvidence::Surely(Decimal::Comma) => {
                self.others = true;
                self.comma.get_or_insert_with(|| (line, cell.to_owned()));
            }
            SeparatorEvidence::Either(separator) => {
                let other = self.either.as_ref().is_some_and(|(_, _, first)| *first != separator);
                self.others |= other;
                if separator == ',' || self.either.is_none() {
                    self.either.get_or_insert_with(|| (line, cell.to_owned(), separator)).2 =
                        separator;
                }
            }
        }
    }

    /// The decimal separator that the cells show together. If semicolons separate cells, a comma is commonly the
    /// decimal separator, and a point alone proves nothing.
    pub(super) fn decimal(self, semicolons: bool) -> Result<Decimal, Doubt> {
        match (self.point, self.comma, self.either) {
            (Some((line, cell)), Some((_, other)), _) => {
                Err((line, cell, format!("and '{other}' use different decimal separators")))
            }
            (Some(_), None, _) => Ok(Decimal::Point),
            (None, Some(_), _) => Ok(Decimal::Comma),
            (None, None, Some((line, cell, separator))) => {
                if separator == '.' && (!semicolons || self.others) {
                    return Ok(Decimal::Point);
                }
                let [whole, fraction] = [cell.replace(separator, ""), cell.replace(separator, ".")];
                Err((line, cell, format!("may mean {whole} or {fraction}")))
            }
            (None, None, None) => Ok(Decimal::Point),
        }
    }
}

fn split_exponent(text: &str) -> (&str, &str) {
    text.split_at(text.find(['e', 'E']).unwrap_or(text.len()))
}

fn split_sign(text: &str) -> (&str, &str) {
    text.split_at(usize::from(text.starts_with(['+', '-'])))
}

/// Whether digits are grouped by threes: `1,234,567`.
fn is_grouped(digits: &str, separator: char) -> bool {
    let mut groups = digits.split(separator);
    let first = groups.next().unwrap_or_default();
    (1..=3).contains(&first.len()) && groups.all(|group| group.len() == 3)
}

fn shown(cell: &str) -> SeparatorEvidence {
    let (mantissa, exponent) = split_exponent(cell);
    let (_, digits) = split_sign(mantissa);
    let is_mark = |c: char| c == '.' || c == ',';
    if !digits.chars().all(|c| c.is_ascii_digit() || is_mark(c)) {
        return SeparatorEvidence::Nothing;
    }
    let of = |mark: char| if mark == '.' { Decimal::Point } else { Decimal::Comma };
    let other = |mark: char| if mark == '.' { Decimal::Comma } else { Decimal::Point };
    let marks: Vec<char> = digits.chars().filter(|&c| is_mark(c)).collect();
    match marks[..] {
        [] => SeparatorEvidence::Nothing,
        [mark] => {
            let (whole, fraction) = digits.split_once(mark).unwrap_or((digits, ""));
            let groups = (1..=3).contains(&whole.len()) && !whole.starts_with('0');
            if groups && fraction.len() == 3 && exponent.is_empty() {
                SeparatorEvidence::Either(mark)
            } else {
                SeparatorEvidence::Surely(of(mark))
            }
        }
        // The last of several separators is the decimal one if it differs from those before.
        [first, .., last] if first != last => SeparatorEvidence::Surely(of(last)),
        [first, ..] => SeparatorEvidence::Surely(other(first)),
    }
}

/// A date and time, or a time of day, as ISO 8601 writes it: `2026-11-21T17:42:31.25Z`, `17:42:31,25`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stamp {
    /// Picoseconds since the beginning of 1970 in its zone, or of the day.
    pub(super) at: i128,
    /// The resolution of the notation, in picoseconds.
    pub(super) step: u64,
    /// Whether it has a date, and whether it has a zone. This must not change within a file.
    pub(super) form: (bool, bool),
}

impl Stamp {
    /// Reads a stamp; `None` if the text is no stamp.
    pub(super) fn read(text: &str) -> Option<Stamp> {
        let text = text.trim();
        let (date, time) = match text.split_once(['T', ' ']) {
            Some((date, time)) => (Some(date), time.trim_start()),
            None => (None, text),
        };
        let days = date.map_or(Some(0), days)?;
        let zone_at = time.find(['Z', '+', '-']).unwrap_or(time.len());
        let (clock, zone) = time.split_at(zone_at);
        let offset = match zone {
            "" | "Z" => 0,
            zone => {
                let sign = if zone.starts_with('-') { -1 } else { 1 };
                let (hours, minutes) = match zone[1..].split_once(':') {
                    Some(parts) => parts,
                    None if zone.len() == 5 => zone[1..].split_at(2),
                    None => (&zone[1..], "00"),
                };
                sign * (number(hours, 2, 23)? * 60 + number(minutes, 2, 59)?)
            }
        };
        let mut parts = clock.trim_end().splitn(3, ':');
        let (hours, minutes) = (number(parts.next()?, 2, 23)?, number(parts.next()?, 2, 59)?);
        let seconds = parts.next()?;
        let (whole, fraction) = seconds.split_once(['.', ',']).unwrap_or((seconds, ""));
        if fraction.len() > 12 || !fraction.bytes().all(|b| b.is_ascii_digit()) {
            return None;
        }
        let whole = number(whole, 2, 60)?;
        let picos: i128 = format!("0{fraction:0<12}").parse().ok()?;
        let minutes = i128::from(days) * 1440 + i128::from(hours * 60 + minutes - offset);
        Some(Stamp {
            at: (minutes * 60 + i128::from(whole)) * 1_000_000_000_000 + picos,
            step: 10_u64.pow(12 - fraction.len() as u32),
            form: (date.is_some(), !zone.is_empty()),
        })
    }
}

/// A whole number of exactly this many digits.
fn number(text: &str, digits: usize, most: i64) -> Option<i64> {
    let fits = text.len() == digits && text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|&value| fits && value <= most)
}

/// The days from 1970 to a date of the Gregorian calendar.
fn days(text: &str) -> Option<i64> {
    let mut parts = text.splitn(3, ['-', '/']);
    let year = number(parts.next()?, 4, 9999)?;
    let (month, day) = (number(parts.next()?, 2, 12)?, number(parts.next()?, 2, 31)?);
    if month == 0 || day == 0 {
        return None;
    }
    // Years are counted from March, so that the leap day is the last day of a year.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let leaps = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    Some(year * 365 + leaps + (month * 153 + 2) / 5 + day - 1 - 719_468)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decided(cells: &[&str], semicolons: bool) -> Result<Decimal, Doubt> {
        let mut signs = Signs::default();
        for (line, cell) in (1..).zip(cells) {
            signs.cell(line, cell);
        }
        signs.decimal(semicolons)
    }

    #[test]
    fn separators_are_taken_where_a_cell_decides_and_refused_where_none_does() {
        use Decimal::{Comma, Point};
        for (cells, semicolons, is) in [
            (&["8.448", "8.450"][..], false, Point),
            (&["8,448", "8,45"], false, Comma),
            (&["8,448", "0,448"], true, Comma),
            (&["8,448", "8,448.5"], false, Point),
            (&["8.448", "8.448,5"], true, Comma),
            (&["1,234,567"], false, Point),
            (&["1.234.567"], true, Comma),
            (&["8.448", "8"], true, Point),
            (&["8.448e3"], true, Point),
            (&["8448"], true, Point),
        ] {
            assert_eq!(decided(cells, semicolons), Ok(is), "{cells:?}");
        }
        for (cells, semicolons, line) in [
            (&["8,448", "8,450"][..], false, 1),
            (&["8.448", "9.001"], true, 1),
            (&["8", "8,448"], true, 2),
            (&["8.5", "8,5"], true, 1),
        ] {
            let doubt = decided(cells, semicolons).expect_err("a doubt");
            assert_eq!(doubt.0, line, "{cells:?}");
        }
    }

    #[test]
    fn numbers_lose_their_groups() {
        let us = Unit::from_name("us").expect("a unit");
        assert_eq!(Decimal::Point.read("8,448.5", us), Some(8_448_500_000));
        assert_eq!(Decimal::Comma.read("8.448,5", us), Some(8_448_500_000));
        assert_eq!(Decimal::Comma.read("-8,5e1", us), Some(-85_000_000));
        for text in ["84,48.5", "8,4480", "1,2,3", "8,", "8.5,1"] {
            assert_eq!(Decimal::Point.read(text, us), None, "{text}");
        }
    }

    #[test]
    fn stamps_are_read_to_the_picosecond() {
        let at = |text: &str| Stamp::read(text).map(|stamp| stamp.at);
        let second = 1_000_000_000_000;
        assert_eq!(at("1970-01-01T00:00:01Z"), Some(second));
        assert_eq!(at("2000-03-01 00:00:00.5"), Some(951_868_800 * second + second / 2));
        assert_eq!(at("2026-11-21T17:42:31+09:00"), at("2026-11-21T08:42:31Z"));
        assert_eq!(at("00:01:00,000000000001"), Some(60 * second + 1));
        assert_eq!(Stamp::read("00:00:00.001").map(|stamp| stamp.step), Some(1_000_000_000));
        for text in ["", "1.5", "2026-13-01T00:00:00", "24:00:00", "12:00", "2026-11-21", "1:2:3"] {
            assert_eq!(at(text), None, "{text}");
        }
    }
}
