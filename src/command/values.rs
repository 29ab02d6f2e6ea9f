//! Parses values of options. The message for a wrong value says what would be right.

use super::Failure;
use anyhow::anyhow;
use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser};
use scanbound::base::time::Picos;
use scanbound::front::minasec::Minasec;
use scanbound::front::{Dialect, FRONTS, Front};
use scanbound::report::{FORMATS, format::Format};
use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

/// The longest permitted delay of a terminal, in picoseconds: a thousand seconds. Sums with it stay representable.
const LONGEST_DELAY: u64 = 1_000_000_000_000_000;

/// The most limits of counts for which the bound is computed.
const MAX_COUNTS: usize = 8;

/// The format that `--format` names, otherwise the one that a file's suffix names, otherwise the first. The names and
/// aliases of the formats are their suffixes.
pub fn format_or_suffix<F: ValueEnum>(named: Option<F>, file: Option<&Path>) -> Result<F, Failure> {
    if let Some(format) = named {
        return Ok(format);
    }
    let suffix = file.and_then(|file| Some((file, file.extension()?.to_str()?)));
    let Some((file, suffix)) = suffix else { return Ok(F::value_variants()[0].clone()) };
    F::from_str(suffix, true).map_err(|_| {
        let all = F::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let known: Vec<String> = all
            .flat_map(|one| {
                one.get_name_and_aliases().map(|end| format!(".{end}")).collect::<Vec<_>>()
            })
            .collect();
        let (file, known) = (file.display(), known.join(", "));
        anyhow!("{file}: no format of this command has this suffix: use one of {known}").into()
    })
}

/// A whole number, at least 1.
pub fn positive<T: FromStr + PartialOrd + From<u8>>(text: &str) -> Result<T, String> {
    let number = text.trim().parse().ok().filter(|number| *number >= T::from(1));
    number.ok_or_else(|| "give a whole number from 1 on".to_owned())
}

/// A whole number.
pub fn count<T: FromStr>(text: &str) -> Result<T, String> {
    text.trim().parse().map_err(|_| "give a whole number from 0 on".to_owned())
}

/// Limits for unknown counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Most(pub Vec<u32>);

/// Parses limits for unknown counts: a few whole numbers.
pub fn most(text: &str) -> Result<Most, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|one| one.trim().parse().ok()).collect();
    let few = numbers.filter(|all| all.len() <= MAX_COUNTS);
    few.map(Most)
        .ok_or_else(|| format!("give up to {MAX_COUNTS} whole numbers from 0 on, such as 20,100"))
}

/// A setting of two rotary switches.
pub fn two_digits(text: &str) -> Result<u8, String> {
    let number = text.trim().parse().ok().filter(|&number| number < 100);
    number.ok_or_else(|| "give a whole number from 0 to 99".to_owned())
}

/// A time with its unit.
pub fn duration(text: &str) -> Result<Picos, String> {
    text.parse().map_err(|error| format!("{error}; write it as 10ms or 1.5us"))
}

/// A time that this program may run.
pub fn span(text: &str) -> Result<Duration, String> {
    let time = duration(text)?;
    Ok(Duration::from_nanos(time.0.div_ceil(1_000)))
}

/// A limit on the scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// A time.
    Time(Picos),
    /// The CPU's default watchdog time.
    Watchdog,
}

/// A time with its unit, or the CPU's watchdog.
pub fn limit(text: &str) -> Result<Limit, String> {
    match text.trim().eq_ignore_ascii_case("watchdog") {
        true => Ok(Limit::Watchdog),
        false => duration(text).map(Limit::Time).map_err(|error| format!("{error}, or watchdog")),
    }
}

/// A delay outside the scan.
pub fn delay(text: &str) -> Result<Picos, String> {
    let longest = Picos(LONGEST_DELAY);
    match duration(text)? {
        delay if delay <= longest => Ok(delay),
        _ => Err(format!("longer than {longest}")),
    }
}

/// The name of a dialect.
pub fn dialect() -> PossibleValuesParser {
    named(FRONTS.dialects())
}

/// The name of a format of reports.
pub fn format() -> PossibleValuesParser {
    let value = |format: &Format| PossibleValue::new(format.name).help(format.about);
    PossibleValuesParser::new(FORMATS.iter().map(value))
}

/// The name of one of a MINASEC-U's dialects.
pub fn minasec() -> PossibleValuesParser {
    named(Minasec.dialects().iter())
}

fn named(dialects: impl Iterator<Item = &'static Dialect>) -> PossibleValuesParser {
    PossibleValuesParser::new(dialects.map(|dialect| dialect.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_value_is_told_what_would_be_right() {
        assert_eq!(positive::<u16>("3"), Ok(3));
        for bad in ["0", "-1", "x", "", "70000"] {
            assert_eq!(positive::<u16>(bad), Err("give a whole number from 1 on".to_owned()));
        }
        assert_eq!(count::<usize>("0"), Ok(0));
        assert!(count::<usize>("-1").is_err());
        assert_eq!(most("20, 5"), Ok(Most(vec![20, 5])));
        for bad in ["", "20,", "-1", "1,2,3,4,5,6,7,8,9", "4294967296"] {
            let told = most(bad).expect_err(bad);
            assert_eq!(told, "give up to 8 whole numbers from 0 on, such as 20,100");
        }
        assert_eq!((two_digits("99"), two_digits("100").is_err()), (Ok(99), true));
        assert_eq!(duration("10ms"), Ok(Picos(10_000_000_000)));
        assert_eq!(limit("10 MS"), Ok(Limit::Time(Picos(10_000_000_000))));
        assert_eq!(limit("Watchdog"), Ok(Limit::Watchdog));
        assert!(limit("10").expect_err("no unit").ends_with("10ms or 1.5us, or watchdog"));
        assert_eq!(delay("1001s"), Err("longer than 1000 s".to_owned()));
        let told = duration("-1ms").expect_err("negative");
        assert_eq!(told, "a time cannot be negative; write it as 10ms or 1.5us");
    }
}
