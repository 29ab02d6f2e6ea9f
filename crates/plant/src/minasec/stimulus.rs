//! Reads a stimulus: a CSV of times, and of the inputs and switches that change then.

use crate::stimulus::{Form, read};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::time::Picos;
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
        let column = |word: &str| {
            what(word).ok_or_else(|| format!("'{word}' is neither an input nor a switch"))
        };
        let value = |_: &What, text: &str| match text {
            "0" => Ok(false),
            "1" => Ok(true),
            other => Err(format!("'{other}' is not 0 or 1")),
        };
        let form = Form { help: FORM, column: &column, value: &value };
        let changes = read(name, bytes, &form)?;
        let change = |(at, what, on)| Change { at, what, on };
        Ok(Stimulus { changes: changes.into_iter().map(change).collect() })
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
