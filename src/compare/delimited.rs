//! Reads scan times, time stamps or a captured signal from CSV, as PulseView, sigrok-cli and others write it.
//!
//! What libsigrok's CSV holds is from its writer (src/output/csv.c): comment lines that begin with `;` name the
//! channels and the sample rate; the columns are headed `logic` unless asked otherwise; the time column counts in
//! the next of milli-, micro-, nanoseconds, by a sample period that was cut to a whole number of these, so that
//! at 24 MHz it runs 1.6 % slow. The sample's number times the true period is taken instead.

use super::Measurements;
use super::capture::{Edges, Origin, Selection, fault};
use crate::column::{UNITS, Unit};
use crate::diagnostic::Diagnostic;
use crate::dialect::Faults;
use crate::emulate::vcd::EMULATED;
use crate::time::Picos;
use csv::StringRecord;
use std::borrow::Cow;

/// Words by which a column of scan times is known.
const SCAN_WORDS: [&str; 4] = ["scan", "cycle", "emulated", "measured"];
/// Words by which a column of time stamps is known.
const STAMP_WORDS: [&str; 5] = ["time", "timestamp", "time stamp", "start", "t"];
/// The units as libsigrok writes them for a head.
const LONG_UNITS: [(&str, &str); 4] =
    [("milliseconds", "ms"), ("microseconds", "us"), ("nanoseconds", "ns"), ("picoseconds", "ps")];

/// Reads a file as the selection says.
pub(super) fn read(
    name: &str,
    bytes: &[u8],
    selection: &Selection<'_>,
) -> Result<Measurements, Vec<Diagnostic>> {
    let text = decoded(bytes);
    let table = Table::read(name, &text)?;
    match selection.signal {
        Some(signal) => table.signal(signal, selection),
        None => table.column(selection),
    }
}

/// The file's columns' names, what its comments say, and its rows as text: captures can be large.
struct Table<'a> {
    name: &'a str,
    text: &'a str,
    delimiter: u8,
    comment: u8,
    /// Whether the first row names the columns.
    headed: bool,
    heads: Vec<String>,
    sigrok: Option<Sigrok>,
    emulated: bool,
}

/// What libsigrok's comments say.
#[derive(Debug, Clone, Default)]
struct Sigrok {
    channels: Vec<String>,
    /// In hertz.
    rate: Option<u64>,
}

impl<'a> Table<'a> {
    fn read(name: &'a str, text: &'a str) -> Result<Table<'a>, Vec<Diagnostic>> {
        let is_comment = |line: &&str| line.starts_with([';', '#']) || line.trim().is_empty();
        let comments: Vec<&str> = text.lines().take_while(is_comment).collect();
        let Some(first) = text.lines().nth(comments.len()) else {
            return Err(vec![fault(name, "the file holds no rows", "capture some scans first")]);
        };
        let sigrok = sigrok(&comments);
        let delimiter = if first.contains('\t') {
            b'\t'
        } else if first.contains(';') && !first.contains(',') {
            b';'
        } else {
            b','
        };
        let comment = comments.iter().find_map(|line| line.trim().bytes().next()).unwrap_or(b'#');
        let mut table = Table {
            name,
            text,
            delimiter,
            comment,
            headed: false,
            heads: Vec::new(),
            sigrok,
            emulated: comments.iter().any(|comment| comment.contains(EMULATED)),
        };
        let (_, row) = table.rows().next().transpose()?.unwrap_or_default();
        table.headed = row.iter().any(|cell| UNITS[0].read(cell).is_none());
        table.heads = row
            .iter()
            .map(|cell| if table.headed { cell.to_owned() } else { String::new() })
            .collect();
        if let Some(sigrok) = &table.sigrok {
            sigrok.name_columns(&mut table.heads);
        }
        table.emulated |= table.heads.iter().any(|head| head.starts_with("emulated"));
        Ok(table)
    }

    /// The rows behind the heads, each with its line.
    fn rows(&self) -> impl Iterator<Item = Result<(u32, StringRecord), Vec<Diagnostic>>> {
        let name = self.name;
        csv::ReaderBuilder::new()
            .delimiter(self.delimiter)
            .comment(Some(self.comment))
            .has_headers(self.headed)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(self.text.as_bytes())
            .into_records()
            .map(move |record| match record {
                Ok(record) => Ok((record.position().map_or(0, |at| at.line() as u32), record)),
                Err(error) => {
                    let message = format!("not CSV: {error}");
                    Err(vec![fault(name, message, "export the capture again")])
                }
            })
    }

    fn origin(&self, resolution: Option<Picos>) -> Origin<'a> {
        Origin { name: self.name, resolution, emulated: self.emulated }
    }

    /// The column of a name: its head, or its head without the unit.
    fn find(&self, wanted: &str) -> Result<usize, Vec<Diagnostic>> {
        let same = |head: &str| head.trim().eq_ignore_ascii_case(wanted.trim());
        let whole = self.heads.iter().position(|head| same(head));
        let words = || self.heads.iter().position(|head| same(&Unit::words_of_head(head)));
        whole.or_else(words).ok_or_else(|| {
            let message = format!("there is no column '{wanted}'");
            vec![fault(self.name, message, format!("the columns are {}", self.columns()))]
        })
    }

    fn columns(&self) -> String {
        if self.heads.iter().all(String::is_empty) {
            return format!("{} without names", self.heads.len());
        }
        self.heads.iter().map(|head| format!("'{head}'")).collect::<Vec<_>>().join(", ")
    }

    /// Scan times, or time stamps, from a column.
    fn column(&self, selection: &Selection<'_>) -> Result<Measurements, Vec<Diagnostic>> {
        let column = match selection.column {
            Some(wanted) => self.find(wanted)?,
            None => self.likely(selection.pulses)?,
        };
        let unit = self.unit(column, selection.unit)?;
        let mut faults = Faults::new(self.name);
        let mut values = Vec::new();
        for row in self.rows() {
            let (line, row) = row?;
            let cell = row.get(column).unwrap_or_default();
            match unit.read(cell) {
                Some(value) if selection.pulses || value > 0 => values.push(value),
                read => {
                    let what = if read.is_some() { "no scan time" } else { "no number" };
                    let row = row.iter().collect::<Vec<_>>().join(",");
                    let help = "each row holds a decimal number with a point, larger than 0";
                    faults.at("capture", line, &row, &format!("'{cell}' is {what}"), help);
                }
            }
        }
        if faults.any_error() {
            return Err(faults.into_diagnostics());
        }
        let head = &self.heads[column];
        let shown =
            if head.is_empty() { "the only column".into() } else { format!("column {head}") };
        let origin = self.origin(None);
        if selection.pulses {
            return origin
                .of_stamps(format!("between the time stamps of {shown} ({unit})"), &values);
        }
        let times: Option<Vec<Picos>> =
            values.iter().map(|&value| u64::try_from(value).ok().map(Picos)).collect();
        match times {
            Some(times) if !times.is_empty() => {
                Ok(origin.measurements(format!("{shown} ({unit})"), times))
            }
            Some(_) => {
                Err(vec![fault(self.name, "the file holds no rows", "capture some scans first")])
            }
            None => Err(vec![fault(self.name, "a scan time is too large", "is the unit right?")]),
        }
    }

    /// The column that holds scan times, or time stamps, by its name.
    fn likely(&self, pulses: bool) -> Result<usize, Vec<Diagnostic>> {
        if self.heads.len() == 1 {
            return Ok(0);
        }
        let words: &[&str] = if pulses { &STAMP_WORDS } else { &SCAN_WORDS };
        let is_likely = |head: &&String| {
            let own = Unit::words_of_head(head);
            Unit::of_head(head).is_some()
                && words.iter().any(|word| if pulses { own == *word } else { own.contains(word) })
        };
        let found: Vec<usize> = self
            .heads
            .iter()
            .enumerate()
            .filter(|(_, head)| is_likely(head))
            .map(|(column, _)| column)
            .collect();
        match found[..] {
            [column] => Ok(column),
            _ => {
                let message = if found.is_empty() {
                    "no column is known to hold scan times"
                } else {
                    "several columns may hold scan times"
                };
                let help = format!(
                    "name it with --column, with --pulses if it holds time stamps, or name a captured signal with --signal; the columns are {}",
                    self.columns()
                );
                Err(vec![fault(self.name, message, help)])
            }
        }
    }

    /// A column's unit: the one that its head names, or the one given.
    fn unit(&self, column: usize, given: Option<Unit>) -> Result<Unit, Vec<Diagnostic>> {
        let head = &self.heads[column];
        match (unit_of(head), given) {
            (Some(own), Some(given)) if own != given => {
                let message = format!("the head '{head}' says {own}, --unit says {given}");
                Err(vec![fault(self.name, message, "leave --unit out, or mend the head")])
            }
            (Some(unit), _) | (None, Some(unit)) => Ok(unit),
            (None, None) => {
                let message = if head.is_empty() {
                    "the column has no name that tells its unit".to_owned()
                } else {
                    format!("the column '{head}' does not name its unit")
                };
                let units = UNITS.map(|unit| unit.name).join(", ");
                Err(vec![fault(
                    self.name,
                    message,
                    format!(
                        "give it with --unit, one of {units}; the last file named is taken for the measurements"
                    ),
                )])
            }
        }
    }

    /// Scan times between the edges of a captured signal.
    fn signal(
        &self,
        signal: &str,
        selection: &Selection<'_>,
    ) -> Result<Measurements, Vec<Diagnostic>> {
        let column = self.find(signal)?;
        let clock = self.clock(selection)?;
        let mut faults = Faults::new(self.name);
        let mut edges = Edges::new(selection.edge);
        let mut last = i128::MIN;
        for (sample, row) in self.rows().enumerate() {
            let (line, row) = row?;
            let text = || row.iter().collect::<Vec<_>>().join(",");
            let level = match row.get(column).unwrap_or_default() {
                "0" => false,
                "1" => true,
                other => {
                    let message = format!("'{other}' is no level");
                    let help = "a captured signal is 0 or 1: is it a logic channel?";
                    faults.at("capture", line, &text(), &message, help);
                    continue;
                }
            };
            match clock.at(sample as u64, &row) {
                Some(at) if at > last => {
                    last = at;
                    edges.level(at, Some(level));
                }
                Some(_) => {
                    let help = "the samples come in order of time: export the capture again";
                    faults.at(
                        "capture",
                        line,
                        &text(),
                        "this row is not later than the last",
                        help,
                    );
                }
                None => {
                    let help = "each row begins with the time as a decimal number";
                    faults.at("capture", line, &text(), "the time is no number", help);
                }
            }
        }
        if faults.any_error() {
            return Err(faults.into_diagnostics());
        }
        self.origin(clock.resolution()).of_edges(signal, &edges)
    }

    /// How a row's time is told.
    fn clock(&self, selection: &Selection<'_>) -> Result<RowClock, Vec<Diagnostic>> {
        let stamps = |column: usize| {
            let head = &self.heads[column];
            let words = Unit::words_of_head(head);
            unit_of(head).is_some() && (STAMP_WORDS.contains(&words.as_str()) || words.is_empty())
        };
        let rate = self.sigrok.as_ref().and_then(|sigrok| sigrok.rate);
        let channels = self.sigrok.as_ref().map_or(0, |sigrok| sigrok.channels.len());
        if let Some(rate) = rate {
            let has_time = channels > 0 && self.heads.len() > channels;
            return Ok(if has_time {
                RowClock::Counted { column: 0, rate, period: cut_period(rate) }
            } else {
                RowClock::Sampled { rate }
            });
        }
        let named = (0..self.heads.len())
            .find(|&column| stamps(column) || is_long_unit(&self.heads[column]));
        let plain = || {
            let is_time = |head: &String| STAMP_WORDS.contains(&head.to_lowercase().as_str());
            self.heads.iter().position(is_time)
        };
        match (named, selection.unit) {
            (Some(column), given) => {
                Ok(RowClock::Stamped { column, unit: self.unit(column, given)? })
            }
            (None, Some(unit)) if plain().is_some() => {
                Ok(RowClock::Stamped { column: plain().unwrap_or(0), unit })
            }
            _ => {
                let help = format!(
                    "a column is headed by Time and its unit (Time [s]), or a comment gives the sample rate (; Samplerate: 1 MHz); the columns are {}",
                    self.columns()
                );
                Err(vec![fault(self.name, "nothing tells the samples' time", help)])
            }
        }
    }
}

/// How a row's time is told.
enum RowClock {
    /// By a column with a unit.
    Stamped { column: usize, unit: Unit },
    /// By the rows' number.
    Sampled { rate: u64 },
    /// By a column that counts samples times a period cut to a whole number of its unit.
    Counted { column: usize, rate: u64, period: u64 },
}

impl RowClock {
    fn at(&self, sample: u64, row: &StringRecord) -> Option<i128> {
        let of_sample = |sample: i128, rate: u64| sample * 1_000_000_000_000 / i128::from(rate);
        match self {
            RowClock::Stamped { column, unit } => unit.read(row.get(*column)?),
            RowClock::Sampled { rate } => Some(of_sample(i128::from(sample), *rate)),
            RowClock::Counted { column, rate, period } => {
                let count: i128 = row.get(*column)?.parse().ok()?;
                Some(of_sample(count / i128::from(*period), *rate))
            }
        }
    }

    fn resolution(&self) -> Option<Picos> {
        match self {
            RowClock::Stamped { .. } => None,
            RowClock::Sampled { rate } | RowClock::Counted { rate, .. } => {
                Some(Picos(1_000_000_000_000_u64.div_ceil(*rate)))
            }
        }
    }
}

/// The sample period as libsigrok's time column counts it.
fn cut_period(rate: u64) -> u64 {
    let mut unit = 1_u64;
    while unit < rate {
        unit = unit.saturating_mul(1000);
    }
    (unit / rate).max(1)
}

fn unit_of(head: &str) -> Option<Unit> {
    let long = LONG_UNITS.iter().find(|(long, _)| head.trim().eq_ignore_ascii_case(long));
    long.and_then(|(_, short)| Unit::from_name(short)).or_else(|| Unit::of_head(head))
}

fn is_long_unit(head: &str) -> bool {
    LONG_UNITS.iter().any(|(long, _)| head.trim().eq_ignore_ascii_case(long))
}

impl Sigrok {
    /// Gives the channels' columns their names, where all are headed `logic` or not at all.
    fn name_columns(&self, heads: &mut [String]) {
        let Some(first) = heads.len().checked_sub(self.channels.len()).filter(|&first| first <= 1)
        else {
            return;
        };
        for (head, channel) in heads[first..].iter_mut().zip(&self.channels) {
            if head.is_empty() || head == "logic" {
                head.clone_from(channel);
            }
        }
    }
}

/// What libsigrok's comments say; `None` if they are not its.
fn sigrok(comments: &[&str]) -> Option<Sigrok> {
    let bodies = || comments.iter().map(|comment| comment.trim_start_matches([';', '#']).trim());
    bodies().find(|body| body.starts_with("CSV generated by"))?;
    let mut found = Sigrok::default();
    for body in bodies() {
        if let Some(rate) = body.strip_prefix("Samplerate:") {
            found.rate = hertz(rate.trim()).filter(|&rate| rate > 0);
        } else if let Some((_, names)) =
            body.strip_prefix("Channels").and_then(|rest| rest.split_once(':'))
        {
            found.channels = names.split(',').map(|name| name.trim().to_owned()).collect();
        }
    }
    Some(found)
}

/// A frequency in whole hertz.
fn hertz(text: &str) -> Option<u64> {
    let (number, unit) = text.split_once(' ')?;
    let digits = match unit.trim() {
        "Hz" => 0_u32,
        "kHz" => 3,
        "MHz" => 6,
        "GHz" => 9,
        _ => return None,
    };
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    let fraction = fraction.trim_end_matches('0');
    let places = digits.checked_sub(u32::try_from(fraction.len()).ok()?)?;
    format!("{whole}{fraction}").parse::<u64>().ok()?.checked_mul(10_u64.pow(places))
}

/// The file as text: UTF-8, else what Windows tools write.
fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let (text, _, broken) = encoding_rs::UTF_8.decode(bytes);
    if broken { encoding_rs::WINDOWS_1252.decode(bytes).0 } else { text }
}
