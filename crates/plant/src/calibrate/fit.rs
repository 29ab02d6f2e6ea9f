//! From readings to times: intervals from the register's resolution and the scatter, and signs that a run was
//! disturbed.

use super::language::RESULTS;
use super::plan::{Measure, Part, Plan, State};
pub use super::resolve::Interval;
use super::resolve::resolved;
use super::result::Words;
use scanbound_base::time::Picos;
use std::collections::BTreeMap;

/// One step of the scan-time register, in picoseconds.
const STEP: i128 = 100_000_000;
/// The margin, in percent, that is added if the time depends on data that may be slower than the measured data.
pub const MARGIN: u64 = 20;

/// The measured times of one table row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RowTimes {
    /// The row.
    pub row: String,
    /// The on-time without units, for the slowest data measured.
    pub on: Interval,
    /// The off-time.
    pub off: Interval,
    /// The time of each unit, if it was measured with few and with many units.
    pub per_unit: Option<Interval>,
    /// Whether its time depends on its data.
    pub by_data: bool,
    /// The lines whose copies were measured.
    pub lines: Vec<String>,
    /// For the first line: the number of copies, and of iterations of the loop.
    pub repeated: [u64; 2],
}

/// The smallest and the largest reading of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Reading {
    least: i128,
    most: i128,
}

/// How reliable a run is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Check {
    /// The part's file.
    pub file: String,
    /// The median difference between the readings of a step, in steps of the register.
    pub scatter: u64,
    /// Lines in whose steps the readings differ much more than that.
    pub outliers: Vec<String>,
    /// Whether a block that was measured at the beginning and at the end gave the same time.
    pub steady: bool,
    /// For a block of many instructions: its measured time per iteration, and the sum of the instructions' single
    /// times.
    pub sum: Option<[Interval; 2]>,
}

impl Check {
    /// Whether the sum of the single times agrees with the time of the whole block.
    #[must_use]
    pub fn sum_agrees(&self) -> bool {
        self.sum
            .is_none_or(|[measured, said]| measured.low <= said.high && said.low <= measured.high)
    }

    /// Whether no sign of a disturbance was found.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.steady && self.outliers.is_empty() && self.sum_agrees()
    }
}

/// The result of evaluating all readings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fit {
    /// The rows, in the order in which they were measured.
    pub rows: Vec<RowTimes>,
    /// The time of an empty scan: its largest reading counts.
    pub empty: Option<Interval>,
    /// How reliable each part's run is.
    pub checks: Vec<Check>,
}

/// Why readings give no times.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Unfit {
    /// Results of a part are missing.
    Missing {
        /// The part's file.
        part: String,
        /// The first missing register.
        register: u32,
    },
    /// A step was not measured.
    Unmeasured {
        /// The part's file.
        part: String,
        /// The step.
        step: u32,
    },
    /// The number of results differs from the number of parts.
    Parts {
        /// How many parts the plan has.
        parts: usize,
        /// How many results there are.
        results: usize,
    },
}

impl std::fmt::Display for Unfit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Unfit::Missing { part, register } => write!(
                f,
                "the results of {part} lack D{register}: export all registers that scanbound calibrate write named"
            ),
            Unfit::Unmeasured { part, step } => write!(
                f,
                "step {step} of {part} has not been measured: let the program run until D1000 stops changing"
            ),
            Unfit::Parts { parts, results } => write!(
                f,
                "the calibration has {parts} parts, but {results} result files were given: give one file for each part, in the order of the parts"
            ),
        }
    }
}

/// The times that follow from the readings. There is one result for each part.
///
/// # Errors
/// Results are missing.
pub fn fit(plan: &Plan, results: &[Words]) -> Result<Fit, Unfit> {
    if results.len() != plan.parts.len() {
        return Err(Unfit::Parts { parts: plan.parts.len(), results: results.len() });
    }
    let mut measured: Vec<(&Measure, Interval)> = Vec::new();
    let mut checks = Vec::new();
    for (part, words) in plan.parts.iter().zip(results) {
        let readings = readings(part, words)?;
        let of = |step: u32| readings[step as usize];
        let each = |measure: &Measure| {
            each(of(measure.full), of(measure.base), measure.copies * measure.loops)
        };
        measured.extend(part.measures.iter().map(|measure| (measure, each(measure))));
        checks.push((part, readings));
    }
    let measured = resolved(measured);
    let empty = checks.iter().flat_map(|(part, readings)| &readings[..part.empty as usize]);
    let empty = empty.map(|one| scan_of(*one)).reduce(slower);
    let checks = checks.iter().map(|(part, readings)| check(part, readings, &measured)).collect();
    Ok(Fit { rows: rows(&measured), empty, checks })
}

fn readings(part: &Part, words: &Words) -> Result<Vec<Reading>, Unfit> {
    let file = || part.file.clone();
    let word = |register: u32| {
        let word = words.0.get(&register).copied();
        word.map(i128::from).ok_or_else(|| Unfit::Missing { part: file(), register })
    };
    let step = |step: u32| {
        let (least, most) = (word(RESULTS + 2 * step)?, word(RESULTS + 2 * step + 1)?);
        match least <= most && most > 0 {
            true => Ok(Reading { least, most }),
            false => Err(Unfit::Unmeasured { part: file(), step }),
        }
    };
    (0..part.steps).map(step).collect()
}

/// The time of the scan itself: the register may be wrong by one step in either direction.
fn scan_of(reading: Reading) -> Interval {
    let picos = |time: i128| Picos(u64::try_from(time.max(0)).unwrap_or(u64::MAX));
    Interval { low: picos((reading.least - 1) * STEP), high: picos((reading.most + 1) * STEP) }
}

/// The time of one of `times` executions that the first step has in addition to the second. Disturbances only make a
/// scan longer, and the register may be wrong by one step in either direction.
fn each(full: Reading, base: Reading, times: u64) -> Interval {
    let times = i128::from(times.max(1));
    let low = ((full.least - base.most - 2) * STEP).max(0) / times;
    let high = ((full.most - base.least + 2) * STEP).max(0);
    // Rounded up.
    let high = (high + times - 1) / times;
    let picos = |time: i128| Picos(u64::try_from(time).unwrap_or(u64::MAX));
    Interval { low: picos(low), high: picos(high) }
}

/// The rows from all measurements of each.
fn rows(measured: &[(&Measure, Interval)]) -> Vec<RowTimes> {
    let mut order: Vec<&str> = Vec::new();
    let mut by_row: BTreeMap<&str, Vec<(&Measure, Interval)>> = BTreeMap::new();
    for (measure, interval) in measured {
        if !by_row.contains_key(&*measure.row) {
            order.push(&measure.row);
        }
        by_row.entry(&measure.row).or_default().push((measure, *interval));
    }
    order.into_iter().filter_map(|row| found(row, by_row.get(row)?)).collect()
}

/// The slower of two.
pub(super) fn slower(one: Interval, other: Interval) -> Interval {
    Interval { low: one.low.max(other.low), high: one.high.max(other.high) }
}

fn found(row: &str, measured: &[(&Measure, Interval)]) -> Option<RowTimes> {
    let (first, _) = measured.first()?;
    let off = measured.iter().filter(|(one, _)| one.state == State::Off).map(|(_, time)| *time);
    let mut off = off.reduce(slower)?;
    // By the number of units: the slowest of all data and forms.
    let mut by_units: BTreeMap<u64, Interval> = BTreeMap::new();
    for (one, time) in measured.iter().filter(|(one, _)| one.state != State::Off) {
        let known = by_units.entry(one.units).or_insert(*time);
        *known = slower(*known, *time);
    }
    let (few, few_time) = by_units.first_key_value().map(|(units, time)| (*units, *time))?;
    let (many, many_time) = by_units.last_key_value().map(|(units, time)| (*units, *time))?;
    let (on, per_unit) = match many.checked_sub(few).filter(|more| *more > 0) {
        None => (few_time, None),
        Some(more) => {
            let low = many_time.low.0.saturating_sub(few_time.high.0) / more;
            let high = many_time.high.0.saturating_sub(few_time.low.0).div_ceil(more);
            // The rest if each unit takes the least time, so that neither part is too small.
            let base = Interval {
                low: Picos(few_time.low.0.saturating_sub(high * few)),
                high: Picos(few_time.high.0.saturating_sub(low * few)),
            };
            (base, Some(Interval { low: Picos(low), high: Picos(high) }))
        }
    };
    // An instruction in a routine is not reached while the routine is not called, so it has only one time.
    if first.own != first.line {
        off = on;
    }
    let mut lines: Vec<String> = Vec::new();
    for (one, _) in measured {
        if !lines.contains(&one.line) {
            lines.push(one.line.clone());
        }
    }
    Some(RowTimes {
        row: row.to_owned(),
        on,
        off,
        per_unit,
        by_data: measured.iter().any(|(one, _)| one.by_data),
        lines,
        repeated: [first.copies, first.loops],
    })
}

/// How reliable a part's run is.
fn check(part: &Part, readings: &[Reading], measured: &[(&Measure, Interval)]) -> Check {
    let apart = |reading: &Reading| reading.most - reading.least;
    let mut scatter: Vec<i128> = readings.iter().map(apart).collect();
    scatter.sort_unstable();
    let usual = scatter.get(scatter.len() / 2).copied().unwrap_or(0);
    let far = 3 * usual + 4;
    let is_far = |step: u32| apart(&readings[step as usize]) > far;
    let mut outliers: Vec<String> = Vec::new();
    for measure in &part.measures {
        if (is_far(measure.full) || is_far(measure.base)) && !outliers.contains(&measure.line) {
            outliers.push(measure.line.clone());
        }
    }
    let [first, last] = part.reference.map(|step| readings[step as usize]);
    let steady = first.least <= last.most + 1 && last.least <= first.most + 1;
    let sum = part.sum.as_ref().map(|sum| {
        let whole = each(readings[sum.full as usize], readings[sum.base as usize], sum.loops);
        let time = |line: &String| {
            let on =
                |one: &&(&Measure, Interval)| one.0.line == *line && one.0.state == State::On(0);
            measured.iter().find(on).map(|(_, time)| *time)
        };
        let times: Vec<Interval> = sum.lines.iter().filter_map(time).collect();
        let said = Interval {
            low: times.iter().map(|time| time.low).sum(),
            high: times.iter().map(|time| time.high).sum(),
        };
        [whole, said]
    });
    let scatter = u64::try_from(usual).unwrap_or(0);
    Check { file: part.file.clone(), scatter, outliers, steady, sum }
}
