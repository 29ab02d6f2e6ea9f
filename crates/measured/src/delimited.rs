//! Reads scan times, time stamps or a captured signal from CSV, as PulseView, oscilloscopes and others write it.

use super::Measurements;
use super::heading::{self, Heading};
use super::number::{Decimal, Signs, Stamp};
use super::signal::{Edges, Origin, Selection, fault};
use super::sigrok::{Sigrok, cut_period, sigrok};
use csv::StringRecord;
use scanbound_base::code::Code;
use scanbound_base::column::{UNITS, Unit, line_of};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_front::Faults;
use scanbound_plant::minasec::vcd::EMULATED;
use std::borrow::Cow;

/// Words in the heading by which a column of scan times is recognised.
const SCAN_WORDS: [&str; 4] = ["scan", "cycle", "emulated", "measured"];
/// Words in the heading by which a column of time stamps is recognised.
const STAMP_WORDS: [&str; 7] =
    ["time", "timestamp", "time stamp", "start", "t", "date", "date/time"];
/// The units as libsigrok writes them in a heading.
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
    let mut found = match selection.signal {
        Some(signal) => table.signal(signal, selection),
        None => table.column(selection),
    }?;
    found.warnings.extend(cut_short(name, &text));
    Ok(found)
}

/// Warns if the file seems to be truncated within its last row: the row has no line end, and is shorter than all
/// others. A number without its last digits would be a different number.
fn cut_short(name: &str, text: &str) -> Option<Diagnostic> {
    if text.ends_with(['\n', '\r']) {
        return None;
    }
    let lines: Vec<usize> =
        text.lines().map(|line| line.trim_end().len()).filter(|&one| one > 0).collect();
    // The first row may be the heading.
    let (&last, others) = lines.get(1..)?.split_last()?;
    let is_shorter = !others.is_empty() && others.iter().all(|&one| one > last);
    let message = "the last row is shorter than all others: the file may be truncated";
    let help = "export the capture again, or delete this row";
    is_shorter.then(|| fault(name, message, help).warning())
}

/// The columns' names, what comments say, and the rows as text, because captures can be large.
struct Table<'a> {
    name: &'a str,
    /// The rows, and the number of lines before them in the file.
    text: &'a str,
    before: u32,
    delimiter: u8,
    comment: u8,
    /// Whether the first row names the columns.
    headed: bool,
    heads: Vec<String>,
    /// If the first column counts samples: the time of the first sample, and the time between two.
    counted: Option<(i128, i128)>,
    sigrok: Option<Sigrok>,
    emulated: bool,
}

impl<'a> Table<'a> {
    fn read(name: &'a str, text: &'a str) -> Result<Table<'a>, Vec<Diagnostic>> {
        let is_comment = |line: &&str| line.starts_with([';', '#']) || line.trim().is_empty();
        let comments: Vec<&str> = text.lines().take_while(is_comment).collect();
        let Some(first) = text.lines().nth(comments.len()) else {
            return Err(vec![fault(name, "the file has no rows", "capture some scans first")]);
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
            before: 0,
            delimiter,
            comment,
            headed: false,
            heads: Vec::new(),
            counted: None,
            sigrok,
            emulated: comments.iter().any(|comment| comment.contains(EMULATED)),
        };
        if let Some(heading) = heading(text, comments.len(), delimiter) {
            let skipped = comments.len() + heading.rows;
            let end = |(at, line): (usize, &str)| (at, at + line.len());
            let lines = text.split_inclusive('\n').scan(0, |at, line| {
                let begin = *at;
                *at += line.len();
                Some(end((begin, line)))
            });
            let from = lines.take(skipped).last().map_or(0, |(_, end)| end);
            (table.text, table.before) = (&text[from..], skipped as u32);
            (table.heads, table.counted) = (heading.heads, heading.counted);
            return Ok(table);
        }
        let row = table.records().next().transpose()?.map(|(_, row)| row).unwrap_or_default();
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

    /// The rows behind the heading, each with its line. A row with more cells than the heading is refused: a decimal
    /// comma would split a number into two cells.
    fn rows(&self) -> impl Iterator<Item = Result<(u32, StringRecord), Vec<Diagnostic>>> {
        let columns = self.heads.len();
        self.records().map(move |record| {
            let (line, row) = record?;
            if row.iter().skip(columns).all(str::is_empty) {
                return Ok((line, row));
            }
            let message = format!("this row has {} cells, but the first row has {columns}", row.len());
            let help = "a number with a comma needs another separator between cells (; or tabs) or quotation marks";
            let mut faults = Faults::new(self.name);
            faults.error_in_line(Code::Capture, line, &joined(&row), &message, help);
            Err(faults.into_diagnostics())
        })
    }

    fn records(&self) -> impl Iterator<Item = Result<(u32, StringRecord), Vec<Diagnostic>>> {
        let (name, before, text, comment) = (self.name, self.before, self.text, self.comment);
        csv::ReaderBuilder::new()
            .delimiter(self.delimiter)
            .comment(Some(self.comment))
            .has_headers(self.headed)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(self.text.as_bytes())
            .into_records()
            .map(move |record| match record {
                Ok(record) => {
                    let line = line_of(text.as_bytes(), record.position(), comment);
                    Ok((before + line, record))
                }
                Err(error) => {
                    let message = format!("not CSV: {error}");
                    Err(vec![fault(name, message, "export the capture again")])
                }
            })
    }

    fn origin(&self, resolution: Option<Picos>) -> Origin<'a> {
        Origin { name: self.name, resolution, emulated: self.emulated }
    }

    /// The column of this name: its heading, or its heading without the unit.
    fn find(&self, wanted: &str) -> Result<usize, Vec<Diagnostic>> {
        let same = |head: &str| head.trim().eq_ignore_ascii_case(wanted.trim());
        let whole = self.heads.iter().position(|head| same(head));
        let words = || self.heads.iter().position(|head| same(&Unit::words_of_heading(head)));
        // The heading of an analog channel contains its unit: `CH1(V)`.
        let bare = |head: &String| same(head.split(['(', '[']).next().unwrap_or_default());
        let bare = || self.heads.iter().position(bare);
        whole.or_else(words).or_else(bare).ok_or_else(|| {
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
        if selection.pulses && self.is_dated(column)? {
            return self.dates(column);
        }
        let unit = self.unit(column, selection.unit)?;
        let decimal = self.decimal(&[column], selection)?;
        let mut faults = Faults::new(self.name);
        let mut values = Vec::new();
        for row in self.rows() {
            let (line, row) = row?;
            let cell = row.get(column).unwrap_or_default();
            match decimal.read(cell, unit) {
                Some(value) if selection.pulses || value > 0 => values.push(value),
                read => {
                    let what = if read.is_some() { "not a scan time" } else { "not a number" };
                    let help =
                        "each row must hold a decimal number, and a scan time must be above 0";
                    faults.error_in_line(
                        Code::Capture,
                        line,
                        &joined(&row),
                        &format!("'{cell}' is {what}"),
                        help,
                    );
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
                Err(vec![fault(self.name, "the file has no rows", "capture some scans first")])
            }
            None => {
                Err(vec![fault(self.name, "a scan time is too large", "check the unit (--unit)")])
            }
        }
    }

    /// The decimal separator in these columns: as stated, or as their cells show together.
    fn decimal(
        &self,
        columns: &[usize],
        selection: &Selection<'_>,
    ) -> Result<Decimal, Vec<Diagnostic>> {
        if let Some(decimal) = selection.decimal {
            return Ok(decimal);
        }
        let mut signs = Signs::default();
        for row in self.rows() {
            let (line, row) = row?;
            for cell in columns.iter().filter_map(|&column| row.get(column)) {
                signs.cell(line, cell);
            }
        }
        signs.decimal(self.delimiter == b';').map_err(|(line, cell, why)| {
            let mut found = fault(
                self.name,
                format!("'{cell}' {why}"),
                "give the decimal separator: --decimal point or --decimal comma",
            );
            found.line = Some(line);
            vec![found]
        })
    }

    /// Whether a column holds dates or times of day.
    fn is_dated(&self, column: usize) -> Result<bool, Vec<Diagnostic>> {
        let Some(first) = self.rows().next() else { return Ok(false) };
        let (_, row) = first?;
        Ok(row.get(column).and_then(Stamp::read).is_some())
    }

    /// Scan times between dates or times of day.
    fn dates(&self, column: usize) -> Result<Measurements, Vec<Diagnostic>> {
        let (mut faults, mut stamps) = (Faults::new(self.name), Vec::<Stamp>::new());
        for row in self.rows() {
            let (line, row) = row?;
            let cell = row.get(column).unwrap_or_default();
            match Stamp::read(cell) {
                Some(stamp) if stamps.first().is_none_or(|first| first.form == stamp.form) => {
                    stamps.push(stamp);
                }
                _ => {
                    let message =
                        format!("'{cell}' is not a date and time of the same form as before");
                    let help = "each row holds a time stamp such as 2026-11-21T17:42:31.250";
                    faults.error_in_line(Code::Capture, line, &joined(&row), &message, help);
                }
            }
        }
        if faults.any_error() {
            return Err(faults.into_diagnostics());
        }
        let values: Vec<i128> = stamps.iter().map(|stamp| stamp.at).collect();
        let step = stamps.iter().map(|stamp| stamp.step).min().map(Picos);
        let how = format!("between the time stamps of column {}", self.heads[column]);
        self.origin(step).of_stamps(how, &values)
    }

    /// The column that probably holds scan times, or time stamps, by its name.
    fn likely(&self, pulses: bool) -> Result<usize, Vec<Diagnostic>> {
        if self.heads.len() == 1 {
            return Ok(0);
        }
        let words: &[&str] = if pulses { &STAMP_WORDS } else { &SCAN_WORDS };
        let is_likely = |head: &&String| {
            let own = Unit::words_of_heading(head);
            (Unit::of_heading(head).is_some() || pulses)
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
                let what = if pulses { "time stamps" } else { "scan times" };
                let message = match found.is_empty() {
                    true => format!("the name of no column shows that it holds {what}"),
                    false => format!("several columns may hold {what}"),
                };
                let help = format!(
                    "name the column with --column (and --pulses if it contains time stamps), or a captured signal with --signal; the columns are {}",
                    self.columns()
                );
                Err(vec![fault(self.name, message, help)])
            }
        }
    }

    /// A column's unit: that in its heading, or the given one.
    fn unit(&self, column: usize, given: Option<Unit>) -> Result<Unit, Vec<Diagnostic>> {
        let head = &self.heads[column];
        match (unit_of(head), given) {
            (Some(own), Some(given)) if own != given => {
                let message =
                    format!("the heading '{head}' has the unit {own}, but --unit is {given}");
                Err(vec![fault(self.name, message, "omit --unit, or correct the heading")])
            }
            (Some(unit), _) | (None, Some(unit)) => Ok(unit),
            (None, None) => {
                let message = if head.is_empty() {
                    "the column has no name, so its unit is unknown".to_owned()
                } else {
                    format!("the heading '{head}' has no unit")
                };
                let units = UNITS.map(|unit| unit.name).join(", ");
                Err(vec![fault(
                    self.name,
                    message,
                    format!(
                        "give it with --unit, one of {units} (the last file on the command line is read as the measurements)"
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
        let gate = selection.during.map(|name| self.find(name)).transpose()?;
        let decimal = match selection.threshold {
            Some(_) => self.decimal(&[vec![column], clock.column()].concat(), selection)?,
            None => self.decimal(&clock.column(), selection)?,
        };
        let mut faults = Faults::new(self.name);
        let mut edges = Edges::new(selection.edge);
        let mut last = i128::MIN;
        for (sample, row) in self.rows().enumerate() {
            let (line, row) = row?;
            let text = || joined(&row);
            let cell = row.get(column).unwrap_or_default();
            let level = match (selection.threshold, cell) {
                (Some(threshold), _) => decimal.level(cell).map(|value| threshold.level(value)),
                (None, "0") => Some(Some(false)),
                (None, "1") => Some(Some(true)),
                (None, _) => None,
            };
            let Some(level) = level else {
                let message = format!("'{cell}' is not a level");
                let help = match selection.threshold {
                    Some(_) => "each row of an analog signal must contain a number",
                    None => {
                        "a digital signal must be 0 or 1; for an analog one give the switching level: --threshold 2.5 or 0.8..2.0"
                    }
                };
                faults.error_in_line(Code::Capture, line, &text(), &message, help);
                continue;
            };
            match clock.at(sample as u64, &row, decimal) {
                Some(at) if at > last => {
                    last = at;
                    if let Some(level) = level {
                        edges.level(at, Some(level));
                    }
                    let still = gate.is_some_and(|gate| row.get(gate) != Some("1"));
                    edges.stands(still, still);
                }
                Some(_) => {
                    let help = "the samples come in order of time: export the capture again";
                    faults.error_in_line(
                        Code::Capture,
                        line,
                        &text(),
                        "the time of this row is not later than that of the row before",
                        help,
                    );
                }
                None => {
                    let (message, help) = match clock {
                        RowClock::Dated { .. } => (
                            "the time is not a time stamp of the same form as before",
                            "each row has a time stamp such as 2026-11-21T17:42:31.250, all with or all without a date and a zone",
                        ),
                        _ => (
                            "the time is not a number",
                            "each row begins with the time as a decimal number, or as a time stamp such as 2026-11-21T17:42:31.250",
                        ),
                    };
                    faults.error_in_line(Code::Capture, line, &text(), message, help);
                }
            }
        }
        if faults.any_error() {
            return Err(faults.into_diagnostics());
        }
        self.origin(clock.resolution()).of_edges(signal, &edges)
    }

    /// The clock of a column of dates or times of day. All are written like the first one, and its digits give the
    /// resolution.
    fn dated(&self, column: usize) -> Result<RowClock, Vec<Diagnostic>> {
        let mut clock = None;
        for row in self.rows() {
            let Some(stamp) = row?.1.get(column).and_then(Stamp::read) else { continue };
            let (form, step) = *clock.get_or_insert((stamp.form, stamp.step));
            clock = Some((form, step.min(stamp.step)));
        }
        let (form, step) = clock.unwrap_or_default();
        Ok(RowClock::Dated { column, form, step })
    }

    /// How the time of a row is determined.
    fn clock(&self, selection: &Selection<'_>) -> Result<RowClock, Vec<Diagnostic>> {
        let stamps = |column: usize| {
            let head = &self.heads[column];
            let words = Unit::words_of_heading(head);
            unit_of(head).is_some() && (STAMP_WORDS.contains(&words.as_str()) || words.is_empty())
        };
        let rate = self.sigrok.as_ref().and_then(|sigrok| sigrok.rate);
        let channels = self.sigrok.as_ref().map_or(0, |sigrok| sigrok.channels.len());
        if let Some((start, step)) = self.counted {
            return Ok(RowClock::Steps { start, step });
        }
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
        for column in named.into_iter().chain(plain()) {
            if self.is_dated(column)? {
                return self.dated(column);
            }
        }
        match (named, selection.unit) {
            (Some(column), given) => {
                Ok(RowClock::Stamped { column, unit: self.unit(column, given)? })
            }
            (None, Some(unit)) if plain().is_some() => {
                Ok(RowClock::Stamped { column: plain().unwrap_or(0), unit })
            }
            _ => {
                let help = format!(
                    "give a column named Time with its unit (Time [s]), or a comment with the sample rate (; Samplerate: 1 MHz); the columns are {}",
                    self.columns()
                );
                Err(vec![fault(self.name, "the file does not give the times of the samples", help)])
            }
        }
    }
}

/// How the time of a row is determined.
enum RowClock {
    /// From a column with a unit.
    Stamped { column: usize, unit: Unit },
    /// From a column of dates or times of day, all with or without a date and a zone. `step` is the resolution in
    /// picoseconds.
    Dated { column: usize, form: (bool, bool), step: u64 },
    /// From a first column that counts steps of `step` picoseconds from `start`.
    Steps { start: i128, step: i128 },
    /// From the row's number.
    Sampled { rate: u64 },
    /// From a column that counts samples times a period that is truncated to a whole number of its unit.
    Counted { column: usize, rate: u64, period: u64 },
}

impl RowClock {
    fn at(&self, sample: u64, row: &StringRecord, decimal: Decimal) -> Option<i128> {
        let of_sample = |sample: i128, rate: u64| sample * 1_000_000_000_000 / i128::from(rate);
        match self {
            RowClock::Stamped { column, unit } => decimal.read(row.get(*column)?, *unit),
            RowClock::Dated { column, form, .. } => {
                let stamp = Stamp::read(row.get(*column)?)?;
                (stamp.form == *form).then_some(stamp.at)
            }
            RowClock::Steps { start, step } => {
                let count: i128 = row.get(0)?.parse().ok()?;
                start.checked_add(count.checked_mul(*step)?)
            }
            RowClock::Sampled { rate } => Some(of_sample(i128::from(sample), *rate)),
            RowClock::Counted { column, rate, period } => {
                let count: i128 = row.get(*column)?.parse().ok()?;
                Some(of_sample(count / i128::from(*period), *rate))
            }
        }
    }

    /// The column with the time as a number.
    fn column(&self) -> Vec<usize> {
        match self {
            RowClock::Stamped { column, .. } => vec![*column],
            _ => Vec::new(),
        }
    }

    fn resolution(&self) -> Option<Picos> {
        match self {
            RowClock::Stamped { .. } => None,
            RowClock::Dated { step, .. } => Some(Picos(*step)),
            RowClock::Steps { step, .. } => u64::try_from(*step).ok().map(Picos),
            RowClock::Sampled { rate } | RowClock::Counted { rate, .. } => {
                Some(Picos(1_000_000_000_000_u64.div_ceil(*rate)))
            }
        }
    }
}

fn unit_of(head: &str) -> Option<Unit> {
    let long = LONG_UNITS.iter().find(|(long, _)| head.trim().eq_ignore_ascii_case(long));
    long.and_then(|(_, short)| Unit::from_name(short)).or_else(|| Unit::of_heading(head))
}

fn is_long_unit(head: &str) -> bool {
    LONG_UNITS.iter().any(|(long, _)| head.trim().eq_ignore_ascii_case(long))
}

/// The multi-row heading of a known maker's file, after the comments.
fn heading(text: &str, comments: usize, delimiter: u8) -> Option<Heading> {
    let rows: Vec<Vec<String>> = text
        .lines()
        .skip(comments)
        .take(heading::ROWS)
        .map(|line| {
            let cells = line.split(char::from(delimiter));
            cells.map(|cell| cell.trim().trim_matches('"').trim().to_owned()).collect()
        })
        .collect();
    heading::read(&rows)
}

/// A row in messages.
fn joined(row: &StringRecord) -> String {
    row.iter().collect::<Vec<_>>().join(",")
}

/// The file as text: UTF-8, otherwise the encoding of Windows tools.
fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let (text, _, broken) = encoding_rs::UTF_8.decode(bytes);
    if broken { encoding_rs::WINDOWS_1252.decode(bytes).0 } else { text }
}
