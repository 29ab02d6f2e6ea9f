//! What the user states about the plant and the source does not say: ranges of words, interrupts a scan, points.

use crate::diagnostic::Diagnostic;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The user's statements. They are believed: a wrong one can make the bound too low, so reports list them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Facts {
    /// Device as written (`D100`) to the least and the largest value that it holds when the scan starts, signed.
    pub ranges: BTreeMap<String, (i64, i64)>,
    /// Interrupt label (`I0`) to how often its routine runs in one scan at most.
    pub interrupts: BTreeMap<String, u32>,
    /// Input points that the CPU refreshes.
    pub inputs: Option<u32>,
    /// Output points that the CPU refreshes.
    pub outputs: Option<u32>,
    /// Whether a flowchart PC reads its inputs once a pass, into an image, instead of at each test.
    pub latched: Option<bool>,
}

/// What a facts file may say, shown where it says something else.
const FORM: &str = "a facts file has the tables [ranges] (D100 = [0, 10]), [interrupts] (I0 = 2) and [io] (inputs = 64, outputs = 32)";

impl Facts {
    /// How often an interrupt routine runs in one scan at most, if that is stated; letter case does not count.
    #[must_use]
    pub fn interrupt(&self, label: &str) -> Option<u32> {
        let stated = self.interrupts.iter().filter(|(known, _)| known.eq_ignore_ascii_case(label));
        stated.map(|(_, &times)| times).max()
    }

    /// Reads a facts file in TOML. `name` is the file's name for the diagnostics, which are all faults at once.
    pub fn parse(name: &str, text: &str) -> Result<Facts, Vec<Diagnostic>> {
        let mut reader = Reader { name, text, faults: Vec::new() };
        let (table, errors) = DeTable::parse_recoverable(text);
        for error in errors {
            reader.fault(error.span(), format!("not TOML: {}", error.message()), FORM);
        }
        let mut facts = Facts::default();
        for (key, value) in table.get_ref() {
            let entries = value.get_ref().as_table();
            match (key.get_ref().as_ref(), entries) {
                ("ranges", Some(entries)) => reader.ranges(entries, &mut facts),
                ("interrupts", Some(entries)) => reader.interrupts(entries, &mut facts),
                ("io", Some(entries)) => reader.points(entries, &mut facts),
                ("ranges" | "interrupts" | "io", None) => {
                    reader.fault(Some(key.span()), format!("'{}' is a table", key.get_ref()), FORM);
                }
                (other, _) => {
                    let message = format!("'{other}' is not a fact");
                    let help = meant(other, &["ranges", "interrupts", "io"], FORM);
                    reader.fault(Some(key.span()), message, &help);
                }
            }
        }
        reader.faults.sort_by_key(|fault| fault.line);
        if reader.faults.is_empty() { Ok(facts) } else { Err(reader.faults) }
    }
}

struct Reader<'a> {
    name: &'a str,
    text: &'a str,
    faults: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn ranges(&mut self, entries: &DeTable<'_>, facts: &mut Facts) {
        for (device, value) in entries {
            let numbers: Option<Vec<i64>> = value
                .get_ref()
                .as_array()
                .and_then(|array| array.iter().map(|item| integer(item.get_ref())).collect());
            match numbers.as_deref() {
                Some(&[low, high]) if low <= high => {
                    facts.ranges.insert(device.get_ref().to_string(), (low, high));
                }
                Some(&[low, high]) => self.fault(
                    Some(value.span()),
                    format!("the range of {} is empty: {low} is above {high}", device.get_ref()),
                    "give the least value first",
                ),
                _ => self.fault(
                    Some(value.span()),
                    format!("the range of {} is not two whole numbers", device.get_ref()),
                    "write D100 = [0, 10]; a device with a point in its name goes in quotes: \"D10.A\"",
                ),
            }
        }
    }

    fn interrupts(&mut self, entries: &DeTable<'_>, facts: &mut Facts) {
        for (label, value) in entries {
            if let Some(times) = self.count(label.get_ref(), value) {
                facts.interrupts.insert(label.get_ref().to_string(), times);
            }
        }
    }

    fn points(&mut self, entries: &DeTable<'_>, facts: &mut Facts) {
        for (key, value) in entries {
            match key.get_ref().as_ref() {
                "inputs" => facts.inputs = self.count("inputs", value),
                "outputs" => facts.outputs = self.count("outputs", value),
                "latched" => match value.get_ref().as_bool() {
                    Some(latched) => facts.latched = Some(latched),
                    None => self.fault(
                        Some(value.span()),
                        "latched is true or false".to_owned(),
                        "write latched = true if the PC reads its inputs once a pass, into an image",
                    ),
                },
                other => self.fault(
                    Some(key.span()),
                    format!("'{other}' is not known in [io]"),
                    &meant(
                        other,
                        &["inputs", "outputs", "latched"],
                        "write inputs = 64 and outputs = 32, the points that the CPU refreshes",
                    ),
                ),
            }
        }
    }

    fn count(&mut self, what: &str, value: &Spanned<DeValue<'_>>) -> Option<u32> {
        let number = integer(value.get_ref()).and_then(|n| u32::try_from(n).ok());
        if number.is_none() {
            self.fault(
                Some(value.span()),
                format!("{what} is not a whole number from 0 on"),
                "write a count, such as I0 = 2",
            );
        }
        number
    }

    fn fault(&mut self, span: Option<Range<usize>>, message: String, help: &str) {
        let Some(span) = span else {
            self.faults.push(Diagnostic::file("facts", self.name, message, help));
            return;
        };
        let start = self.text[..span.start].rfind('\n').map_or(0, |at| at + 1);
        let end = self.text[span.start..].find('\n').map_or(self.text.len(), |at| span.start + at);
        let line = self.text[..start].matches('\n').count() + 1;
        let text = self.text[start..end].trim_end_matches('\r');
        let mut fault = Diagnostic::line(
            "facts",
            self.name,
            u32::try_from(line).unwrap_or(u32::MAX),
            text,
            message,
            help,
        );
        fault.span = Some((
            (span.start - start).min(text.len()),
            (span.end.min(end) - start).min(text.len()),
        ));
        self.faults.push(fault);
    }
}

/// The help, headed by the known name that is most like a wrong one, if any is.
fn meant(wrong: &str, known: &[&str], help: &str) -> String {
    let likeness =
        |name: &&&str| Some(strsim::jaro_winkler(wrong, name)).filter(|&likeness| likeness > 0.8);
    let nearest = known.iter().filter(|name| likeness(name).is_some());
    let nearest =
        nearest.max_by(|a, b| likeness(a).partial_cmp(&likeness(b)).unwrap_or(Ordering::Equal));
    nearest.map_or(String::new(), |name| format!("did you mean {name}? ")) + help
}

fn integer(value: &DeValue<'_>) -> Option<i64> {
    let number = value.as_integer()?;
    i64::from_str_radix(number.as_str(), number.radix()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fact_is_read() {
        let text = "[ranges]\nD100 = [0, 10]\n'Z0' = [-1, 0x1F]\n[interrupts]\nI0 = 2\n[io]\ninputs = 64\noutputs = 32\nlatched = true\n";
        let facts = Facts::parse("facts.toml", text).expect("the facts are well-formed");
        assert_eq!(
            facts,
            Facts {
                ranges: [("D100".to_owned(), (0, 10)), ("Z0".to_owned(), (-1, 31))].into(),
                interrupts: [("I0".to_owned(), 2)].into(),
                inputs: Some(64),
                outputs: Some(32),
                latched: Some(true),
            }
        );
        assert_eq!((facts.interrupt("i0"), facts.interrupt("I1")), (Some(2), None));
        assert_eq!(Facts::parse("facts.toml", ""), Ok(Facts::default()));
    }

    #[test]
    fn all_faults_are_told_at_once_in_order() {
        let text = "speed = 3\n[ranges]\nD1 = [3, 1]\nD2 = 5\n[interrupts]\nI0 = -1\n[io]\nmodules = 3\nlatched = 1\n";
        let faults = Facts::parse("facts.toml", text).expect_err("six faults");
        let told: Vec<(Option<u32>, &str)> =
            faults.iter().map(|fault| (fault.line, fault.message.as_str())).collect();
        assert_eq!(
            told,
            [
                (Some(1), "'speed' is not a fact"),
                (Some(3), "the range of D1 is empty: 3 is above 1"),
                (Some(4), "the range of D2 is not two whole numbers"),
                (Some(6), "I0 is not a whole number from 0 on"),
                (Some(8), "'modules' is not known in [io]"),
                (Some(9), "latched is true or false"),
            ]
        );
        assert_eq!(faults[1].text, "D1 = [3, 1]");
        assert_eq!(faults[1].span, Some((5, 11)));
    }

    #[test]
    fn what_is_not_toml_is_told_with_its_line() {
        let faults =
            Facts::parse("facts.toml", "[ranges]\nD1 = [0, 1\nD2 == 3\n").expect_err("not TOML");
        assert!(faults.iter().all(|fault| fault.line.is_some()));
        assert!(faults.iter().any(|fault| fault.message.starts_with("not TOML")));
    }
}
