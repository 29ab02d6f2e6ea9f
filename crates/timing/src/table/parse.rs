//! Reads a timing table from CSV text and a price from the command line. All faults are reported at once.

use scanbound_base::code::Code;
use std::borrow::Cow;

use rustc_hash::FxHashMap;

use super::{CLASSES, Evidence, Factor, MostPoints, Row, Table, folded};
use scanbound_base::checksum::sha256;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::{Picos, TimeError};

/// The result of reading a table, with its warnings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parsed {
    /// The table. If it amends a built-in table, it contains that table's rows too.
    pub table: Table,
    /// Findings that do not prevent the use of the table.
    pub warnings: Vec<Diagnostic>,
}

/// Times of an instruction given on the command line (`--time`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// The name of the table row that these times replace.
    pub name: String,
    /// The on-time: the time if the instruction fires.
    pub on: Picos,
    /// The off-time: the time if control reaches the instruction but it does not fire.
    pub off: Picos,
}

/// The largest time that a row may have: far longer than any watchdog waits, and short enough that sums do not
/// overflow.
const LONGEST: Picos = Picos(10_000_000_000_000);
/// The largest number of faults of a table that are listed. Further ones are only counted.
const MAX_FAULTS: usize = 1000;
/// The largest number of unknown columns that are listed. Further ones are only counted.
const MAX_WARNINGS: usize = 20;
/// The largest number of characters of a line that a message shows.
const SHOWN: usize = 200;

/// The columns of a table that are used. Others are ignored with a warning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Instruction,
    On,
    Off,
    PerUnit,
    Unit,
    Evidence,
    Source,
}

impl Column {
    const ALL: [Column; 7] = [
        Column::Instruction,
        Column::On,
        Column::Off,
        Column::PerUnit,
        Column::Unit,
        Column::Evidence,
        Column::Source,
    ];

    /// The column's heading.
    fn name(self) -> &'static str {
        match self {
            Column::Instruction => "instruction",
            Column::On => "on_us",
            Column::Off => "off_us",
            Column::PerUnit => "per_unit_us",
            Column::Unit => "unit",
            Column::Evidence => "evidence",
            Column::Source => "source",
        }
    }
}

/// `@` rows with one number. The module `price` charges them for a scan, except `@watchdog` and the two delays, which
/// are no part of a scan. A test checks that all others are charged.
pub(crate) const SINGLE: [&str; 15] = [
    "@end",
    "@further-program",
    "@network",
    "@program",
    "@rung",
    "@interrupt-entry",
    "@input",
    "@input8",
    "@input16",
    "@output",
    "@output8",
    "@output16",
    "@watchdog",
    "@input-delay",
    "@output-delay",
];
/// `@` rows that may occur several times, each with a name after a colon: what the row is for, or the base unit.
pub(crate) const VARIED: [&str; 8] =
    ["@end", "@network", "@input", "@input8", "@input16", "@output", "@output8", "@output16"];
/// Rows whose second field is a number of points.
pub(crate) const POINTS: [&str; 2] = ["@max-inputs", "@max-outputs"];
/// The largest number of inputs or outputs that a table may give. No PLC has more.
const MAX_POINTS: u32 = 65_536;
/// Rows whose second field is text.
const TEXT: [&str; 6] = ["@base", "@cpu", "@date", "@family", "@note", "@title"];

const HEAD_HELP: &str = "begin the table with the line instruction,on_us,off_us (separated by commas; further columns: per_unit_us,unit,evidence,source)";
const TIME_HELP: &str =
    "write decimal microseconds with a point, such as 1.52, no finer than 0.000001";

/// The kind of a row, by its name: what its fields contain.
enum RowKind {
    Times,
    Single,
    Factor,
    Points,
    Text,
    Unknown,
}

fn kind(name: &str) -> RowKind {
    let Some(rest) = name.strip_prefix('@') else { return RowKind::Times };
    let lower = name.to_ascii_lowercase();
    if CLASSES.contains(&&lower[1..]) || (rest.starts_with('+') && rest.len() > 1) {
        RowKind::Times
    } else if SINGLE.contains(&lower.as_str())
        || lower
            .split_once(':')
            .is_some_and(|(kind, name)| VARIED.contains(&kind) && !name.trim().is_empty())
    {
        RowKind::Single
    } else if lower == "@factor" {
        RowKind::Factor
    } else if POINTS.contains(&lower.as_str()) {
        RowKind::Points
    } else if TEXT.contains(&lower.as_str()) {
        RowKind::Text
    } else {
        RowKind::Unknown
    }
}

impl Table {
    /// Reads a table. `file` is its name for the diagnostics and for the report.
    ///
    /// # Errors
    /// All faults at once, with the warnings. Beyond a thousand they are only counted.
    ///
    /// # Examples
    /// ```
    /// use scanbound_base::time::Picos;
    /// use scanbound_timing::table::Table;
    ///
    /// let parsed = Table::parse("my.csv", b"instruction,on_us,off_us\nMOV,1.5,0.3\n").expect("a right table");
    /// let row = parsed.table.row("MOV").expect("the row");
    /// assert_eq!((row.on, row.off), (Picos(1_500_000), Picos(300_000)));
    /// ```
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Parsed, Vec<Diagnostic>> {
        let text =
            std::str::from_utf8(bytes).map_err(|error| vec![encoding(file, bytes, &error)])?;
        let mut reader = Reader::new(file);
        reader.read(text.strip_prefix('\u{feff}').unwrap_or(text));
        let mut parsed = reader.finish()?;
        parsed.table.sha256 = sha256(bytes);
        Ok(parsed)
    }
}

fn encoding(file: &str, bytes: &[u8], error: &std::str::Utf8Error) -> Diagnostic {
    let good = &bytes[..error.valid_up_to()];
    let line = 1 + good.iter().filter(|&&byte| byte == b'\n').count();
    let start = good.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    Diagnostic::line(
        Code::TableEncoding,
        file,
        u32::try_from(line).unwrap_or(u32::MAX),
        shown(&String::from_utf8_lossy(&good[start..])),
        "the table is not valid UTF-8 from here on",
        "save the table as \"CSV UTF-8\"",
    )
}

fn shown(line: &str) -> String {
    line.chars().take(SHOWN).collect()
}

/// The fields of one line of a table, by column. A column that the line lacks is empty.
struct Fields<'a> {
    line: u32,
    text: &'a str,
    cells: [Cow<'a, str>; Column::ALL.len()],
}

impl Fields<'_> {
    fn get(&self, column: Column) -> &str {
        &self.cells[column as usize]
    }
}

struct Reader<'a> {
    file: &'a str,
    table: Table,
    columns: Vec<Option<Column>>,
    seen: FxHashMap<String, u32>,
    read: Vec<Row>,
    faults: Vec<Diagnostic>,
    unlisted: usize,
    warnings: Vec<Diagnostic>,
}

impl<'a> Reader<'a> {
    fn new(file: &'a str) -> Self {
        Reader {
            file,
            table: Table { name: file.to_owned(), ..Table::default() },
            columns: Vec::new(),
            seen: FxHashMap::default(),
            read: Vec::new(),
            faults: Vec::new(),
            unlisted: 0,
            warnings: Vec::new(),
        }
    }

    fn fault(&mut self, diagnostic: Diagnostic) {
        if self.faults.len() < MAX_FAULTS {
            self.faults.push(diagnostic);
        } else {
            self.unlisted += 1;
        }
    }

    fn fault_at(
        &mut self,
        fields: &Fields<'_>,
        code: Code,
        part: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let text = shown(fields.text);
        let mut found = Diagnostic::line(code, self.file, fields.line, text, message, help);
        // Compare addresses, not text: an equal text may occur earlier in the line.
        let at = (part.as_ptr() as usize).checked_sub(fields.text.as_ptr() as usize);
        let end = at.map(|at| at + part.len()).filter(|&end| end <= found.text.len());
        found.span = at.zip(end).filter(|_| !part.is_empty());
        if found.span.is_none() {
            found = found.mark(part);
        }
        self.fault(found);
    }

    fn read(&mut self, text: &str) {
        let numbered = text.lines().zip(1u32..).map(|(line, number)| (number, line));
        let mut lines = numbered
            .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
        let Some((number, head)) = lines.next() else {
            let message = "the table is empty";
            self.fault(Diagnostic::file(Code::TableEmpty, self.file, message, HEAD_HELP));
            return;
        };
        if !self.head(number, head) {
            return;
        }
        for (number, line) in lines {
            self.line(number, line);
        }
        if self.seen.is_empty() && self.faults.is_empty() {
            let help = "give a row for each instruction, such as MOV,1.52,0.3";
            self.fault(Diagnostic::file(
                Code::TableEmpty,
                self.file,
                "the table has no rows",
                help,
            ));
        }
    }

    /// Reads the heading. Returns false if required columns are missing.
    fn head(&mut self, number: u32, line: &str) -> bool {
        let fields = split(line).unwrap_or_default();
        let file = self.file;
        let at_line = |message: String, help: &str| {
            Diagnostic::line(Code::TableColumn, file, number, shown(line), message, help)
        };
        let mut unknown = 0_usize;
        let mut seen = [false; Column::ALL.len()];
        for field in &fields {
            let name = field.to_ascii_lowercase();
            let known = Column::ALL.into_iter().find(|column| column.name() == name);
            let twice =
                known.is_some_and(|column| std::mem::replace(&mut seen[column as usize], true));
            if twice && self.faults.len() >= MAX_FAULTS {
                self.unlisted += 1;
            } else if twice {
                let message = format!("the column {name} occurs twice");
                let help = "remove one of the two columns";
                self.fault(at_line(message, help));
            } else if known.is_none() {
                unknown += 1;
                if unknown > MAX_WARNINGS {
                    self.columns.push(known);
                    continue;
                }
                let message = format!("the column '{}' is unknown and ignored", shown(field));
                let help = format!("columns are {}", Column::ALL.map(Column::name).join(", "));
                self.warnings.push(at_line(message, &help).mark(field).warning());
            }
            self.columns.push(known);
        }
        if let Some(more) = unknown.checked_sub(MAX_WARNINGS).filter(|&more| more > 0) {
            let message = format!("and {more} further columns are unknown and ignored");
            let help = "remove columns that do not belong to a timing table";
            self.warnings
                .push(Diagnostic::file(Code::TableColumn, self.file, message, help).warning());
        }
        let missing: Vec<&str> = Column::ALL
            .into_iter()
            .take(3)
            .filter(|&column| !seen[column as usize])
            .map(Column::name)
            .collect();
        if missing.is_empty() {
            return true;
        }
        self.warnings.clear();
        let columns = if missing.len() == 1 { "column" } else { "columns" };
        let message =
            format!("the first line of the table lacks the {columns} {}", missing.join(", "));
        self.fault(at_line(message, HEAD_HELP));
        false
    }

    fn line(&mut self, number: u32, text: &str) {
        let mut fields = Fields { line: number, text, cells: Default::default() };
        let Some(cells) = split(text) else {
            let help =
                "close the double quote on the same line; write a double quote inside quotes twice";
            self.fault_at(&fields, Code::TableRow, "", "a double quote is not closed", help);
            return;
        };
        if cells.len() > self.columns.len()
            && cells[self.columns.len()..].iter().any(|c| !c.is_empty())
        {
            let message = format!(
                "the row has {} fields, but the table has {} columns",
                cells.len(),
                self.columns.len()
            );
            let help = "put text that holds a comma in double quotes; write decimals with a point";
            self.fault_at(&fields, Code::TableRow, "", message, help);
            return;
        }
        for (column, cell) in self.columns.iter().zip(cells) {
            if let Some(column) = column {
                fields.cells[*column as usize] = cell;
            }
        }
        self.row(&fields);
    }

    fn row(&mut self, fields: &Fields<'_>) {
        let name = fields.get(Column::Instruction);
        if name.is_empty() {
            let help = "give the instruction, such as MOV, in the column instruction";
            self.fault_at(fields, Code::TableRow, "", "the row has no instruction", help);
            return;
        }
        let kind = kind(name);
        let lower = name.to_ascii_lowercase();
        let before = self.seen.insert(folded(name).into_owned(), fields.line);
        if let Some(first) = before.filter(|_| !matches!(lower.as_str(), "@note" | "@cpu")) {
            let message = format!("{name} has a second row here: the first one is in line {first}");
            let help = "keep only one row for each name; a variant such as OUT:T is another name";
            self.fault_at(fields, Code::TableDuplicate, name, message, help);
        }
        match kind {
            RowKind::Text => self.text(fields, &lower),
            RowKind::Factor => self.factor(fields),
            RowKind::Points => self.points(fields, &lower),
            RowKind::Single | RowKind::Times => {
                self.times(fields, name, matches!(kind, RowKind::Single))
            }
            RowKind::Unknown => {
                let message = format!("'{name}' is not a known @ row");
                let singles = SINGLE.join(" ");
                let help = format!(
                    "use a row of the whole scan ({singles} @end:NAME @network:NAME @input16:BASE @factor {} {}), a timing class ({}), or @+TAG",
                    POINTS.join(" "),
                    TEXT.join(" "),
                    CLASSES.map(|class| format!("@{class}")).join(" ")
                );
                self.fault_at(fields, Code::TableRow, name, message, help);
            }
        }
    }

    fn times(&mut self, fields: &Fields<'_>, name: &str, single: bool) {
        let on = self.time(fields, Column::On, true);
        let off = self.time(fields, Column::Off, false);
        let per_unit = self.time(fields, Column::PerUnit, false);
        let evidence = self.evidence(fields);
        let second = [(Column::Off, off), (Column::PerUnit, per_unit)];
        if single
            && let Some(&(column, _)) = second.iter().find(|(_, time)| matches!(time, Ok(Some(_))))
        {
            let cell = fields.get(column);
            let message = format!(
                "the row {name} takes only one time, in on_us, but its column {} is not empty",
                column.name()
            );
            self.fault_at(fields, Code::TableRow, cell, message, "leave the field empty");
        }
        let (Ok(Some(on)), Ok(off), Ok(per_unit), Some(evidence)) = (on, off, per_unit, evidence)
        else {
            return;
        };
        self.read.push(Row {
            name: name.to_owned(),
            on,
            off: off.unwrap_or(on),
            per_unit: per_unit.unwrap_or(Picos::ZERO),
            unit: fields.get(Column::Unit).to_owned(),
            evidence,
            source: fields.get(Column::Source).to_owned(),
            table: self.file.to_owned(),
            amends: false,
        });
    }

    /// The time in a column. `Ok(None)` if the field is empty and need not be filled, `Err` if a fault was reported.
    fn time(
        &mut self,
        fields: &Fields<'_>,
        column: Column,
        required: bool,
    ) -> Result<Option<Picos>, ()> {
        let (cell, column) = (fields.get(column), column.name());
        if cell.is_empty() && !required {
            return Ok(None);
        }
        let message = match Picos::from_us_text(cell) {
            Ok(time) if time <= LONGEST => return Ok(Some(time)),
            Ok(_) | Err(TimeError::TooLarge) => {
                format!("{column} is {}, but a time can be at most 10 s", shown(cell))
            }
            Err(TimeError::Empty) => format!("{column} is missing"),
            Err(TimeError::Negative) => {
                format!("{column} is {}: {}", shown(cell), TimeError::Negative)
            }
            Err(error) => format!("{column} is '{}': {error}", shown(cell)),
        };
        self.fault_at(fields, Code::TableTime, cell, message, TIME_HELP);
        Err(())
    }

    fn evidence(&mut self, fields: &Fields<'_>) -> Option<Evidence> {
        let cell = fields.get(Column::Evidence);
        if cell.is_empty() {
            return Some(Evidence::Stated);
        }
        let known = Evidence::ALL.into_iter().find(|known| cell.eq_ignore_ascii_case(known.word()));
        if known.is_none() {
            let message = format!("'{}' is not a kind of evidence", shown(cell));
            let help =
                "write published, measured, stated or assumed, or leave the field empty (stated)";
            self.fault_at(fields, Code::TableEvidence, cell, message, help);
        }
        known
    }

    fn factor(&mut self, fields: &Fields<'_>) {
        let cell = fields.get(Column::On);
        let evidence = self.evidence(fields);
        let allowed = 1_000_000..=10_000_000;
        match Picos::from_us_text(cell) {
            Ok(Picos(millionths)) if allowed.contains(&millionths) => {
                if let Some(evidence) = evidence {
                    let (text, source) = (cell.to_owned(), fields.get(Column::Source).to_owned());
                    self.table.factor = Some(Factor { millionths, text, evidence, source });
                }
            }
            _ => {
                let message = format!("the factor '{}' is not a decimal from 1 to 10", shown(cell));
                let help = "write the factor for the whole scan, such as 1.05";
                self.fault_at(fields, Code::TableTime, cell, message, help);
            }
        }
    }

    fn points(&mut self, fields: &Fields<'_>, name: &str) {
        let cell = fields.get(Column::On);
        let evidence = self.evidence(fields);
        let Some(points) = cell.parse().ok().filter(|&points| points <= MAX_POINTS) else {
            let message = format!(
                "'{}' in the row {name} is not a number of points up to {MAX_POINTS}",
                shown(cell)
            );
            let help = format!("write a whole number up to {MAX_POINTS}, such as 4096");
            self.fault_at(fields, Code::TablePoints, cell, message, help);
            return;
        };
        let Some(evidence) = evidence else { return };
        let most = MostPoints { points, evidence, source: fields.get(Column::Source).to_owned() };
        match name {
            "@max-inputs" => self.table.most_inputs = Some(most),
            _ => self.table.most_outputs = Some(most),
        }
    }

    fn text(&mut self, fields: &Fields<'_>, name: &str) {
        let text = fields.get(Column::On).to_owned();
        if text.is_empty() || !fields.get(Column::Off).is_empty() {
            let message = format!(
                "the row {name} must have a text in the column on_us, and nothing in the column off_us"
            );
            let help = "put text that holds a comma in double quotes";
            self.fault_at(fields, Code::TableRow, name, message, help);
            return;
        }
        match name {
            "@title" => self.table.title = text,
            "@note" => self.table.notes.push(text),
            "@date" if is_date(&text) => self.table.date = Some(text),
            "@date" => {
                let message = format!("'{}' is not a date", shown(&text));
                let help = "write the date as year, month and day, such as 2026-11-21";
                self.fault_at(fields, Code::TableRow, &text, message, help);
            }
            "@cpu" => self.table.cpus.extend(text.split_whitespace().map(str::to_ascii_uppercase)),
            "@family" if super::builtin::families().contains(&*text.to_ascii_lowercase()) => {
                self.table.family = Some(text.to_ascii_lowercase());
            }
            "@family" => {
                let message =
                    format!("'{}' is not a CPU family that scanbound knows", shown(&text));
                let known: Vec<&str> = super::builtin::families().into_iter().collect();
                let help = format!("families are {}", known.join(", "));
                self.fault_at(fields, Code::TableRow, &text, message, help);
            }
            _ if super::builtin::text(&text).is_some() => {
                self.table.base = Some(text.to_ascii_lowercase());
            }
            _ => {
                let message = format!("there is no built-in table '{}' to amend", shown(&text));
                let help =
                    format!("the built-in tables are {}", super::builtin::names().join(", "));
                self.fault_at(fields, Code::TableBase, &text, message, help);
            }
        }
    }

    fn finish(mut self) -> Result<Parsed, Vec<Diagnostic>> {
        if self.unlisted > 0 {
            let message = format!("{} more errors are not listed", self.unlisted);
            let help = "correct the listed errors first";
            self.faults.push(Diagnostic::file(Code::TableFaults, self.file, message, help));
        }
        if !self.faults.is_empty() {
            self.faults.append(&mut self.warnings);
            return Err(self.faults);
        }
        let mut table = self.table;
        if let Some(mut base) = table.base.as_deref().and_then(Table::builtin) {
            base.name.clone_from(&table.name);
            base.base.clone_from(&table.base);
            if !table.title.is_empty() {
                base.title = table.title;
            }
            if !table.cpus.is_empty() {
                base.cpus = table.cpus;
            }
            base.date = table.date.or(base.date);
            base.family = table.family.or(base.family);
            base.factor = table.factor.or(base.factor);
            base.most_inputs = table.most_inputs.or(base.most_inputs);
            base.most_outputs = table.most_outputs.or(base.most_outputs);
            base.notes.append(&mut table.notes);
            table = base;
        }
        let amends = table.base.is_some();
        for row in self.read {
            table.replace(Row { amends, ..row });
        }
        Ok(Parsed { table, warnings: self.warnings })
    }
}

/// Whether a text is a date in the form `2026-11-21`.
fn is_date(text: &str) -> bool {
    let digits = |part: &str, most: u32| {
        part.bytes().all(|byte| byte.is_ascii_digit())
            && part.parse().is_ok_and(|number: u32| (1..=most).contains(&number))
    };
    match text.split('-').collect::<Vec<_>>()[..] {
        [year, month, day] => {
            (year.len(), month.len(), day.len()) == (4, 2, 2)
                && digits(year, 9999)
                && digits(month, 12)
                && digits(day, 31)
        }
        _ => false,
    }
}

/// A line's fields, trimmed; `None` if a double quote is not closed.
fn split(line: &str) -> Option<Vec<Cow<'_, str>>> {
    let quotes = line.bytes().filter(|&byte| byte == b'"').count();
    if quotes % 2 == 1 {
        return None;
    }
    if quotes == 0 {
        // Nearly every line has no quotes. Creating a CSV reader for each line would dominate the reading time.
        return Some(line.split(',').map(|field| Cow::Borrowed(field.trim())).collect());
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .buffer_capacity(line.len().max(1))
        .trim(csv::Trim::All)
        .from_reader(line.as_bytes());
    let mut record = csv::StringRecord::new();
    // The text is UTF-8 and rows may have any number of fields, so reading cannot fail.
    reader.read_record(&mut record).ok()?;
    Some(record.iter().map(|field| Cow::Owned(field.to_owned())).collect())
}

/// Reads times from the command line: `MOV=12.5us` for both, or with an off-time `MOV=12.5us/0.3us`.
///
/// # Errors
/// A message that says what is wrong.
pub fn parse_override(text: &str) -> Result<Override, String> {
    let form = "write NAME=12.5us or NAME=12.5us/0.3us";
    // A name such as LD= contains the sign, too.
    let (name, times) =
        text.rsplit_once('=').ok_or_else(|| format!("'{text}' has no time; {form}"))?;
    let name = name.trim();
    if name.is_empty() || name.starts_with('@') {
        return Err(format!("'{text}' has no instruction; {form}"));
    }
    let time = |text: &str| match Picos::from_duration_text(text) {
        Ok(time) if time <= LONGEST => Ok(time),
        Ok(_) => Err(format!("'{}' is more than 10 s for one instruction; {form}", text.trim())),
        Err(error) => Err(format!("'{}': {error}; {form}", text.trim())),
    };
    let (on, off) = match times.split_once('/') {
        Some((on, off)) => (time(on)?, time(off)?),
        None => (time(times)?, time(times)?),
    };
    Ok(Override { name: name.to_owned(), on, off })
}
