//! Reads a stimulus: a CSV of times, and of the inputs and switches that change then.

use scanbound_base::code::Code;
use scanbound_base::column::{Unit, cell, line_of};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
use scanbound_front::Faults;
use scanbound_front_minasec::{Device, DeviceKind};

/// The input or switch that changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// An input terminal, 0 to 7.
    Input(u8),
    /// The power supply. It is on at the beginning.
    Power,
    /// The switch in its position RESET.
    Reset,
    /// The same switch in its position HALT: the clock stands still.
    Halt,
    /// The button that gives a clock pulse by hand while the clock stands still.
    Step,
    /// The clock's switch in its position SLOW.
    Slow,
    /// The button that clears the count.
    ClearCount,
}

/// A change of an input or a switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// The time of the change.
    pub at: Picos,
    /// What changes.
    pub what: What,
    /// The new state.
    pub on: bool,
}

/// The stimulus: all changes. Until the first change, power is on and everything else is off.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Stimulus {
    /// The changes, in order of time.
    pub changes: Vec<Change>,
}

/// The form of a stimulus, for messages.
const FORM: &str = "the first row names the columns: the time with its unit (time_ms), X00 to X07, POWER, RESET, HALT, CLOCK, SLOW, CNTCLR; each other row holds a time, and 0 or 1 for each input or switch that changes";

impl Stimulus {
    /// Reads a stimulus. An empty or missing cell changes nothing.
    ///
    /// # Errors
    /// All faults, each with its line.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Stimulus, Vec<Diagnostic>> {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(bytes);
        let whole = |message: String, help: &str| {
            vec![Diagnostic::file(Code::Stimulus, name, message, help)]
        };
        let heads = match reader.headers() {
            Ok(heads) if !heads.is_empty() => heads.clone(),
            Ok(_) => return Err(whole("the file is empty".into(), FORM)),
            Err(error) => return Err(whole(format!("not CSV: {error}"), FORM)),
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
            return Err(whole("no column has the time and its unit (time_ms)".into(), FORM));
        };
        let mut columns = Vec::new();
        for (column, word) in heads.iter().enumerate().filter(|(column, _)| *column != time) {
            match what(word) {
                Some(what) => columns.push((column, what)),
                None => {
                    let message = format!("'{word}' is neither an input nor a switch");
                    faults.push(at_cell(Code::StimulusColumn, head, column, message, FORM));
                }
            }
        }
        let mut stimulus = Stimulus::default();
        for record in reader.records() {
            let record = match record {
                Ok(record) => record,
                Err(error) => {
                    let line = error.position().map(|at| at.line() as u32);
                    let message = format!("not CSV: {error}");
                    let found = Diagnostic::file(Code::Stimulus, name, message, FORM);
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
            if stimulus.changes.last().is_some_and(|last| last.at > at) {
                fault(
                    "the time of this row is earlier than that of the row before".into(),
                    time,
                    "put the rows in order of time",
                );
                continue;
            }
            for &(column, what) in &columns {
                let on = match record.get(column).unwrap_or_default() {
                    "" => continue,
                    "0" => false,
                    "1" => true,
                    other => {
                        fault(
                            format!("'{other}' is not 0 or 1"),
                            column,
                            "leave the cell empty where nothing changes",
                        );
                        continue;
                    }
                };
                stimulus.changes.push(Change { at, what, on });
            }
        }
        if faults.any_error() { Err(faults.into_diagnostics()) } else { Ok(stimulus) }
    }
}

fn what(head: &str) -> Option<What> {
    match head.to_ascii_uppercase().as_str() {
        "POWER" => Some(What::Power),
        "RESET" => Some(What::Reset),
        "HALT" => Some(What::Halt),
        "CLOCK" => Some(What::Step),
        "SLOW" => Some(What::Slow),
        "CNTCLR" => Some(What::ClearCount),
        _ => Device::from_name(head)
            .filter(|device| device.kind() == DeviceKind::Input)
            .map(|device| What::Input(device.address())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_changes_and_empty_cells_are_none() {
        let text = "# start, stop\ntime_ms, X00, x01, POWER\n0,0,0,1\n100.5,1\n\n200,,1,\n";
        let stimulus = Stimulus::parse("a.csv", text.as_bytes()).expect("a stimulus");
        let change = |ms: u64, what, on| Change { at: Picos(ms * 100_000_000), what, on };
        assert_eq!(
            stimulus.changes,
            [
                change(0, What::Input(0), false),
                change(0, What::Input(1), false),
                change(0, What::Power, true),
                change(1005, What::Input(0), true),
                change(2000, What::Input(1), true),
            ]
        );
    }

    #[test]
    fn faults_have_their_lines() {
        let faults = |text: &str| -> Vec<(u32, String)> {
            Stimulus::parse("a.csv", text.as_bytes())
                .expect_err("faults")
                .into_iter()
                .map(|fault| (fault.line.unwrap_or(0), fault.message))
                .collect()
        };
        assert_eq!(faults("")[0], (0, "the file is empty".to_owned()));
        assert_eq!(faults("time,X00\n0,1\n")[0].0, 0, "no unit");
        let marked =
            Stimulus::parse("a.csv", b"# y\ntime_s, X00 ,Y00\n1, 1\n 2 ,\"1,5\"\n3,1,,x\n");
        let marked: Vec<_> = marked
            .expect_err("faults")
            .into_iter()
            .map(|fault| {
                let (from, to) = fault.span.expect("a span");
                (fault.line, fault.text[from..to].to_owned())
            })
            .collect();
        let places = [(Some(2), "Y00"), (Some(4), "1,5"), (Some(5), "x")];
        assert_eq!(marked, places.map(|(line, text)| (line, text.to_owned())));
        assert_eq!(
            faults("time_s,X00,Y00\n1,1\n0.5,0\nx,1\n-1,1\n2,2\n"),
            [
                (1, "'Y00' is neither an input nor a switch".to_owned()),
                (3, "the time of this row is earlier than that of the row before".to_owned()),
                (4, "'x' is not a time".to_owned()),
                (5, "'-1' is not a time".to_owned()),
                (6, "'2' is not 0 or 1".to_owned()),
            ]
        );
    }
}
