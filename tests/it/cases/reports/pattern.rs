//! Lines of reports by patterns: what stands fixed, and figures by their names.

use std::collections::BTreeMap;

/// What a pattern found, by the names that it has for it.
pub type Found = BTreeMap<String, String>;

/// A line without runs of blanks.
pub fn normal(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What the names of a pattern stand for in a line; none where it does not fit. `{t:NAME}` is a time with its unit,
/// `{p:NAME}` a percentage, `{n:NAME}` a whole number, `{w:NAME}` a word, `{*}` anything. What stands in `[[` and `]]`
/// may be missing.
pub fn fits(pattern: &str, line: &str) -> Option<Found> {
    go(pattern, line).map(|found| found.into_iter().collect())
}

fn go(pattern: &str, line: &str) -> Option<Vec<(String, String)>> {
    let Some(first) = pattern.chars().next() else {
        return line.is_empty().then(Vec::new);
    };
    if let Some(rest) = pattern.strip_prefix("[[") {
        let end = closing(rest);
        let (inner, behind) = (&rest[..end], &rest[end + 2..]);
        return go(&format!("{inner}{behind}"), line).or_else(|| go(behind, line));
    }
    if let Some(rest) = pattern.strip_prefix('{') {
        let (token, behind) = rest.split_once('}').expect("a pattern closes what it opens");
        let (kind, name) = token.split_once(':').unwrap_or((token, ""));
        let lengths: Vec<usize> = match kind {
            "t" => time(line).into_iter().collect(),
            "p" => percentage(line).into_iter().collect(),
            "n" => Some(digits(line)).filter(|&n| n > 0).into_iter().collect(),
            "w" => {
                Some(line.find(' ').unwrap_or(line.len())).filter(|&n| n > 0).into_iter().collect()
            }
            "*" => line.char_indices().map(|(at, _)| at).chain([line.len()]).collect(),
            other => panic!("no pattern has {other}"),
        };
        for length in lengths {
            if let Some(mut found) = go(behind, &line[length..]) {
                if !name.is_empty() {
                    found.push((name.to_owned(), line[..length].to_owned()));
                }
                return Some(found);
            }
        }
        return None;
    }
    go(&pattern[first.len_utf8()..], line.strip_prefix(first)?)
}

/// Where the optional part ends that begins a text; others may lie in it.
fn closing(rest: &str) -> usize {
    let (mut depth, mut at) = (1, 0);
    while let Some(next) = rest[at..].find(['[', ']']).map(|next| at + next) {
        let mark = &rest[next..rest.len().min(next + 2)];
        match mark {
            "[[" => depth += 1,
            "]]" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return next;
        }
        at = next + if matches!(mark, "[[" | "]]") { 2 } else { 1 };
    }
    panic!("a pattern closes what it opens");
}

fn digits(text: &str) -> usize {
    text.bytes().take_while(u8::is_ascii_digit).count()
}

fn decimal(text: &str) -> Option<usize> {
    let whole = Some(digits(text)).filter(|&n| n > 0)?;
    match text[whole..].strip_prefix('.').map(digits) {
        Some(n) if n > 0 => Some(whole + 1 + n),
        _ => Some(whole),
    }
}

fn time(text: &str) -> Option<usize> {
    let number = decimal(text)?;
    let behind = text[number..].strip_prefix(' ')?;
    let unit = UNITS.iter().find(|(unit, _)| {
        behind.strip_prefix(unit).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
    })?;
    Some(number + 1 + unit.0.len())
}

fn percentage(text: &str) -> Option<usize> {
    let number = decimal(text)?;
    text[number..].starts_with(" %").then_some(number + 2)
}

const UNITS: [(&str, u128); 8] = [
    ("days", 86_400_000_000_000_000),
    ("min", 60_000_000_000_000),
    ("h", 3_600_000_000_000_000),
    ("ms", 1_000_000_000),
    ("us", 1_000_000),
    ("ns", 1_000),
    ("ps", 1),
    ("s", 1_000_000_000_000),
];

/// A time as it is shown.
#[derive(Debug, Clone)]
pub struct Shown {
    pub ps: u128,
    /// What its last digit is worth; of times of four digits or fewer that of the fourth, since zeros at the end are
    /// left out.
    pub step: u128,
    /// What its last digit is worth as it stands there.
    pub digit: u128,
    pub unit: &'static str,
}

/// A time that a pattern found.
pub fn shown(text: &str) -> Shown {
    let (number, unit) = text.split_once(' ').expect("a number and a unit");
    let &(unit, size) = UNITS.iter().find(|(name, _)| *name == unit).expect("a unit");
    let (whole, part) = number.split_once('.').unwrap_or((number, ""));
    let scale = 10u128.pow(u32::try_from(part.len()).expect("few digits"));
    let value = format!("{whole}{part}").parse::<u128>().expect("a number");
    assert_eq!(value * size % scale, 0, "{text} is no number of picoseconds");
    let decimals = part.len().max(4usize.saturating_sub(whole.len()));
    let step = (size / 10u128.pow(u32::try_from(decimals).expect("few"))).max(1);
    Shown { ps: value * size / scale, step, digit: (size / scale).max(1), unit }
}

/// Whether a text shows a time rounded up to its last digit, or as it is.
pub fn up(text: &str, ps: u64) -> bool {
    let (shown, ps) = (shown(text), u128::from(ps));
    shown.ps >= ps && shown.ps - ps < shown.step
}

/// The same in a column of times with the same decimals.
pub fn up_in_column(text: &str, ps: u64) -> bool {
    let (shown, ps) = (shown(text), u128::from(ps));
    shown.ps >= ps && shown.ps - ps < shown.digit
}

/// The same rounded down.
pub fn down(text: &str, ps: u64) -> bool {
    let (shown, ps) = (shown(text), u128::from(ps));
    shown.ps <= ps && ps - shown.ps < shown.step
}

/// The same to the nearest.
pub fn near(text: &str, ps: u64) -> bool {
    let (shown, ps) = (shown(text), u128::from(ps));
    shown.ps.abs_diff(ps) * 2 <= shown.step
}

/// The same as a part of a whole, in a column of times with the same decimals: one step off at most.
pub fn part(text: &str, ps: u64) -> bool {
    let (shown, ps) = (shown(text), u128::from(ps));
    shown.ps.abs_diff(ps) <= shown.digit
}

/// The time to the picosecond.
pub fn exactly(text: &str, ps: u64) -> bool {
    shown(text).ps == u128::from(ps)
}

/// A share in percent as reports show it: of thousandths, rounded to the nearest.
pub fn share(part: u64, whole: u64) -> String {
    let (part, whole) = (u128::from(part), u128::from(whole));
    let thousandths = (part * 2000 + whole).checked_div(whole * 2).unwrap_or(0);
    format!("{}.{} %", thousandths / 10, thousandths % 10)
}

#[test]
fn patterns_find_what_they_name() {
    let found =
        fits("takes {t:time}[[ ({p:share} of it)]], {n:count} more{*}", "takes 1.5 ms, 3 more of")
            .expect("it fits");
    assert_eq!((found["time"].as_str(), found["count"].as_str()), ("1.5 ms", "3"));
    let found = fits("takes {t:time}[[ ({p:share} of it)]]", "takes 1.5 ms (7.2 % of it)");
    assert_eq!(found.expect("it fits")["share"], "7.2 %");
    assert_eq!(fits("takes {t:time}", "takes 1.5 msec"), None);
    assert!(up("1.235 ms", 1_234_100_000) && !up("1.235 ms", 1_235_100_000));
    assert!(down("999 us", 999_050_000) && near("999 us", 998_970_000));
    assert_eq!(share(1, 3), "33.3 %");
}
