//! Lines with other kinds of operands: with an index, as digits of bits, in a module, in spare devices.

use super::{Language, Spare};

/// A change of a line's operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Change {
    /// Nothing.
    Plain,
    /// Each word gets an index.
    Indexed,
    /// This device replaces the first word, or the last.
    Word { device: String, last: bool },
    /// This device replaces that of the coil.
    Coil(String),
}

/// The changes that give a variant. Empty if no spare device is named for it.
pub(super) fn of(variant: Option<&str>, language: Language, spare: &Spare) -> Vec<Change> {
    let both = |device: &str| {
        [false, true].map(|last| Change::Word { device: device.to_owned(), last }).to_vec()
    };
    match variant {
        None | Some("M") => vec![Change::Plain],
        Some("indexed") if language != Language::Cs => vec![Change::Indexed],
        Some("digits") if language != Language::Cs => [both("K4M0"), both("K8M0")].concat(),
        Some("module") => spare.buffer().map(both).unwrap_or_default(),
        Some(letters @ ("D" | "T" | "C")) => vec![Change::Coil(format!("{letters}0"))],
        Some(letters) => {
            spare.named(letters).map(|device| Change::Coil(device.to_owned())).into_iter().collect()
        }
    }
}

impl Change {
    /// The changed line. `None` if it has no operand of that kind.
    pub(super) fn apply(&self, line: &str, language: Language) -> Option<String> {
        let is_word = |operand: &str| {
            operand
                .strip_prefix('D')
                .is_some_and(|rest| rest.bytes().all(|one| one.is_ascii_digit()))
        };
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let at: Vec<usize> = (1..words.len()).filter(|at| is_word(&words[*at])).collect();
        match self {
            Change::Plain => {}
            Change::Indexed => {
                at.first()?;
                at.iter().for_each(|at| words[*at] += "Z0");
            }
            Change::Word { device, last } => {
                let at = if *last { at.last() } else { at.first() };
                words[*at?].clone_from(device);
            }
            Change::Coil(device) => {
                let own = [language.coil(), language.state()];
                let is_own = own.contains(&words.get(1)?.as_str());
                let bit = words[1].starts_with('M') || words[1].starts_with('W');
                if !(is_own || bit || is_word(&words[1])) {
                    return None;
                }
                words[1].clone_from(device);
            }
        }
        Some(words.join(" "))
    }
}
