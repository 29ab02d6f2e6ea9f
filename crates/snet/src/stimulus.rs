//! Reads the inputs of a simulation: a CSV of times at which outer gates change.

use super::Diagram;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// A change of an outer gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// The time in milliseconds.
    pub ms: u64,
    /// The outer gate, an index into `Diagram::outers`.
    pub outer: usize,
    /// Its new value.
    pub on: bool,
}

const FORM: &str = "write the column names in the first row (time_ms or time_s, then outer gates), and in each other row a time, and 0 or 1 where a gate changes";

/// Reads the changes for a net, in order of time. An empty cell means no change.
///
/// # Errors
/// All errors with their lines.
pub fn parse(diagram: &Diagram, name: &str, bytes: &[u8]) -> Result<Vec<Change>, Vec<Diagnostic>> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .has_headers(false)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let lines: Vec<&str> = text.lines().collect();
    let mut faults = Vec::new();
    let mut columns: Option<(u64, Vec<usize>)> = None;
    let mut changes = Vec::new();
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                let message = format!("not CSV: {error}");
                return Err(vec![Diagnostic::file(Code::Stimulus, name, message, FORM)]);
            }
        };
        let line = record.position().map_or(1, |at| u32::try_from(at.line()).unwrap_or(u32::MAX));
        let shown = lines.get(line as usize - 1).copied().unwrap_or_default();
        let fault = |code, part: &str, message: String| {
            Diagnostic::line(code, name, line, shown, message, FORM).mark(part)
        };
        let Some((unit, outers)) = &columns else {
            let unit = match record.get(0) {
                Some("time_ms") => 1,
                Some("time_s") => 1000,
                other => {
                    let part = other.unwrap_or_default();
                    let message = format!("the first column is '{part}', but must be the time");
                    return Err(vec![fault(Code::Stimulus, part, message)]);
                }
            };
            let mut outers = Vec::new();
            for word in record.iter().skip(1) {
                match diagram.outers.iter().position(|outer| outer.head.name == word) {
                    Some(outer) => outers.push(outer),
                    None => {
                        let message = format!("'{word}' is not an outer gate of the net");
                        faults.push(fault(Code::StimulusColumn, word, message));
                    }
                }
            }
            if !faults.is_empty() {
                return Err(faults);
            }
            columns = Some((unit, outers));
            continue;
        };
        let time = record.get(0).unwrap_or_default();
        let Some(ms) = milliseconds(time, *unit) else {
            let message = format!("'{time}' is not a time");
            faults.push(fault(Code::StimulusRow, time, message));
            continue;
        };
        if record.len() > outers.len() + 1 {
            let message = format!(
                "this row has {} cells, but the heading row has {}",
                record.len(),
                outers.len() + 1
            );
            faults.push(fault(Code::StimulusRow, "", message));
            continue;
        }
        for (&outer, cell) in outers.iter().zip(record.iter().skip(1)) {
            let on = match cell {
                "" => continue,
                "0" => false,
                "1" => true,
                _ => {
                    let message = format!("'{cell}' is not 0 or 1");
                    faults.push(fault(Code::StimulusRow, cell, message));
                    continue;
                }
            };
            changes.push(Change { ms, outer, on });
        }
    }
    if columns.is_none() {
        faults.push(Diagnostic::file(Code::Stimulus, name, "the file is empty", FORM));
    }
    changes.sort_by_key(|change| change.ms);
    if faults.is_empty() { Ok(changes) } else { Err(faults) }
}

/// Converts a decimal number to whole milliseconds; `unit` is the number of milliseconds in one.
fn milliseconds(text: &str, unit: u64) -> Option<u64> {
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !digits(whole) || !digits(part) || part.len() > 3 {
        return None;
    }
    let thousandths: u64 = format!("{part:0<3}").parse().ok()?;
    whole.parse::<u64>().ok()?.checked_mul(unit)?.checked_add(thousandths * unit / 1000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::read;

    #[test]
    fn changes_come_in_order_and_faults_with_their_line() {
        let diagram =
            read("a.snet", "outer E1\nouter 停止\nbox A\ntransition T : A ->\n").expect("it");
        let read = |text: &str| parse(&diagram, "s.csv", text.as_bytes());
        let text = "time_s,停止,E1\n# a comment\n1.5,1,\n0.25,,1\n2,0,0\n";
        let changes = read(text).expect("a stimulus");
        let told: Vec<(u64, usize, bool)> =
            changes.iter().map(|one| (one.ms, one.outer, one.on)).collect();
        assert_eq!(told, [(250, 0, true), (1500, 1, true), (2000, 1, false), (2000, 0, false)]);
        let lines = |text: &str| -> Vec<Option<u32>> {
            read(text).expect_err("faults").iter().map(|fault| fault.line).collect()
        };
        assert_eq!(lines("time_ms,E1\n1,2\nx,1\n5,1,1\n"), [Some(2), Some(3), Some(4)]);
        assert_eq!(lines("time_ms,E9,Z\n"), [Some(1), Some(1)]);
        assert_eq!((lines("t,E1\n"), lines("")), (vec![Some(1)], vec![None]));
    }
}
