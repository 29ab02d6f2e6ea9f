//! Reads what the plant does: a CSV of times and of the inputs and switches that change then.

use crate::column::Unit;
use crate::diagnostic::Diagnostic;
use crate::dialect::minasec::{Device, Kind};
use crate::time::Picos;

/// What a change is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// An input terminal, 0 to 7.
    Input(u8),
    /// The power supply. On from the beginning.
    Power,
    /// The switch in its position RESET.
    Reset,
    /// The button that clears the count.
    ClearCount,
}

/// A change of an input or a switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// When.
    pub at: Picos,
    /// Of what.
    pub what: What,
    /// To what.
    pub on: bool,
}

/// What the plant does. Inputs and switches are off, and power is on, until the first change.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Stimulus {
    /// The changes, in order of time.
    pub changes: Vec<Change>,
}

/// What a stimulus looks like.
const FORM: &str = "the first row names the columns: the time with its unit (time_ms), X00 to X07, POWER, RESET, CNTCLR; the others hold times, and 0 or 1 where something changes";

impl Stimulus {
    /// Reads a stimulus. A cell that is empty, or beyond the end of its row, changes nothing.
    ///
    /// # Errors
    /// All faults, each with its line.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Stimulus, Vec<Diagnostic>> {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(bytes);
        let whole =
            |message: String, help: &str| vec![Diagnostic::file("stimulus", name, message, help)];
        let heads = match reader.headers() {
            Ok(heads) if !heads.is_empty() => heads.clone(),
            Ok(_) => return Err(whole("the file is empty".into(), FORM)),
            Err(error) => return Err(whole(format!("not CSV: {error}"), FORM)),
        };
        let mut faults = Vec::new();
        let time = heads.iter().position(|head| Unit::words_of_head(head) == "time");
        let unit = time.and_then(|column| Unit::of_head(&heads[column]));
        let Some((time, unit)) = time.zip(unit) else {
            return Err(whole("no column is a time with its unit".into(), FORM));
        };
        let mut columns = Vec::new();
        for (column, head) in heads.iter().enumerate().filter(|(column, _)| *column != time) {
            match what(head) {
                Some(what) => columns.push((column, what)),
                None => faults.push(
                    Diagnostic::line(
                        "stimulus-column",
                        name,
                        1,
                        heads.iter().collect::<Vec<_>>().join(","),
                        format!("'{head}' is no input and no switch"),
                        FORM,
                    )
                    .mark(head),
                ),
            }
        }
        let mut stimulus = Stimulus::default();
        for record in reader.records() {
            let record = match record {
                Ok(record) => record,
                Err(error) => {
                    faults.extend(whole(format!("not CSV: {error}"), FORM));
                    break;
                }
            };
            let line = record.position().map_or(0, |at| at.line() as u32);
            let text = record.iter().collect::<Vec<_>>().join(",");
            let mut fault = |message: String, part: &str, help: &str| {
                faults.push(
                    Diagnostic::line("stimulus-row", name, line, &*text, message, help).mark(part),
                );
            };
            let cell = record.get(time).unwrap_or_default();
            let at = unit.read(cell).and_then(|ps| u64::try_from(ps).ok()).map(Picos);
            let Some(at) = at else {
                fault(format!("'{cell}' is no time"), cell, "give a decimal number from 0 on");
                continue;
            };
            if stimulus.changes.last().is_some_and(|last| last.at > at) {
                fault("this row is before the last".into(), cell, "give the rows in order of time");
                continue;
            }
            for &(column, what) in &columns {
                let on = match record.get(column).unwrap_or_default() {
                    "" => continue,
                    "0" => false,
                    "1" => true,
                    other => {
                        fault(
                            format!("'{other}' is neither 0 nor 1"),
                            other,
                            "leave the cell empty where nothing changes",
                        );
                        continue;
                    }
                };
                stimulus.changes.push(Change { at, what, on });
            }
        }
        if faults.is_empty() { Ok(stimulus) } else { Err(faults) }
    }
}

fn what(head: &str) -> Option<What> {
    match head.to_ascii_uppercase().as_str() {
        "POWER" => Some(What::Power),
        "RESET" => Some(What::Reset),
        "CNTCLR" => Some(What::ClearCount),
        _ => Device::from_name(head)
            .filter(|device| device.kind() == Kind::Input)
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
        assert_eq!(
            faults("time_s,X00,Y00\n1,1\n0.5,0\nx,1\n-1,1\n2,2\n"),
            [
                (1, "'Y00' is no input and no switch".to_owned()),
                (3, "this row is before the last".to_owned()),
                (4, "'x' is no time".to_owned()),
                (5, "'-1' is no time".to_owned()),
                (6, "'2' is neither 0 nor 1".to_owned()),
            ]
        );
    }
}
