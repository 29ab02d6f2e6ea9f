//! Reads a stimulus: a CSV of times, and of what is set from outside then.

use scanbound_base::code::Code;
use scanbound_base::column::{Unit, cell, line_of};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_front::Faults;

/// What a stimulus may set, and to which values.
pub(crate) struct Form<'f, T, V> {
    /// What the file has to look like, for messages.
    pub(crate) help: &'f str,
    /// What a column of this heading sets, or why it sets nothing.
    pub(crate) column: &'f dyn Fn(&str) -> Result<T, String>,
    /// The value in a cell of such a column, or why it is none.
    pub(crate) value: &'f dyn Fn(&T, &str) -> Result<V, String>,
}

/// Reads the changes in order of time: when, what, and to which value. An empty or missing cell changes nothing.
///
/// # Errors
/// All faults, each with its line.
pub(crate) fn read<T: Clone, V>(
    name: &str,
    bytes: &[u8],
    form: &Form<'_, T, V>,
) -> Result<Vec<(Picos, T, V)>, Vec<Diagnostic>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let whole =
        |message: String, help: &str| vec![Diagnostic::file(Code::Stimulus, name, message, help)];
    let heads = match reader.headers() {
        Ok(heads) if !heads.is_empty() => heads.clone(),
        Ok(_) => return Err(whole("the file is empty".into(), form.help)),
        Err(error) => return Err(whole(format!("not CSV: {error}"), form.help)),
    };
    let text = String::from_utf8_lossy(bytes);
    let lines: Vec<&str> = text.lines().collect();
    let mut faults = Faults::new(name);
    let at_cell = |code, line: u32, column: usize, message: String, help: &str| {
        let shown = lines.get((line as usize).wrapping_sub(1)).copied().unwrap_or_default();
        let found = Diagnostic::line(code, name, line, shown.trim_end(), message, help);
        match cell(shown, b',', column) {
            Some(bytes) if !bytes.is_empty() => found.span(bytes),
            _ => found,
        }
    };
    let head = line_of(bytes, heads.position(), b'#');
    let time = heads.iter().position(|head| Unit::words_of_heading(head) == "time");
    let unit = time.and_then(|column| Unit::of_heading(&heads[column]));
    let Some((time, unit)) = time.zip(unit) else {
        return Err(whole("no column has the time and its unit (time_ms)".into(), form.help));
    };
    let mut columns = Vec::new();
    for (column, word) in heads.iter().enumerate().filter(|(column, _)| *column != time) {
        match (form.column)(word) {
            Ok(what) => columns.push((column, what)),
            Err(message) => {
                faults.push(at_cell(Code::StimulusColumn, head, column, message, form.help));
            }
        }
    }
    let mut changes: Vec<(Picos, T, V)> = Vec::new();
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                let line = error.position().map(|at| at.line() as u32);
                let message = format!("not CSV: {error}");
                let found = Diagnostic::file(Code::Stimulus, name, message, form.help);
                faults.push(Diagnostic { line, ..found });
                break;
            }
        };
        let line = line_of(bytes, record.position(), b'#');
        let mut fault = |message: String, column: usize, help: &str| {
            faults.push(at_cell(Code::StimulusRow, line, column, message, help));
        };
        if let Some(extra) = (heads.len()..record.len()).find(|&n| !record[n].is_empty()) {
            let message = format!(
                "this row has {} cells, but the first row has {}",
                record.len(),
                heads.len()
            );
            fault(message, extra, "give each cell a column; numbers have a decimal point");
            continue;
        }
        let cell = record.get(time).unwrap_or_default();
        let at = unit.read(cell).and_then(|ps| u64::try_from(ps).ok()).map(Picos);
        let Some(at) = at else {
            fault(
                format!("'{cell}' is not a time"),
                time,
                "give a decimal number that is not negative",
            );
            continue;
        };
        if changes.last().is_some_and(|(last, ..)| *last > at) {
            fault(
                "the time of this row is earlier than that of the row before".into(),
                time,
                "put the rows in order of time",
            );
            continue;
        }
        for (column, what) in &columns {
            let text = record.get(*column).unwrap_or_default();
            if text.is_empty() {
                continue;
            }
            match (form.value)(what, text) {
                Ok(value) => changes.push((at, what.clone(), value)),
                Err(message) => {
                    fault(message, *column, "leave the cell empty where nothing changes");
                }
            }
        }
    }
    if faults.any_error() { Err(faults.into_diagnostics()) } else { Ok(changes) }
}
