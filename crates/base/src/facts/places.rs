//! The position of each fact in its file, so that later findings about a fact can point to it.

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use std::collections::BTreeMap;
use std::ops::Range;

/// Whether a finding points to the key or to the value of a fact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The key, left of the equals sign.
    Key,
    /// The value, right of the equals sign.
    Value,
}

/// The text of a facts file and the byte ranges of its facts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FactPositions {
    file: String,
    text: String,
    /// The byte offset at which each line begins.
    lines: Vec<usize>,
    /// The byte ranges of key and value, by table and key.
    facts: BTreeMap<String, BTreeMap<String, [Range<usize>; 2]>>,
}

impl FactPositions {
    /// Prepares the positions for a file whose facts are about to be read.
    pub(super) fn new(file: &str, text: &str) -> FactPositions {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let lines = [0].into_iter().chain(breaks.map(|(at, _)| at + 1)).collect();
        FactPositions {
            file: file.to_owned(),
            text: text.to_owned(),
            lines,
            facts: BTreeMap::new(),
        }
    }

    /// Records the byte ranges of a fact's key and value.
    pub(super) fn record(&mut self, table: &str, key: &str, places: [Range<usize>; 2]) {
        if !self.facts.contains_key(table) {
            self.facts.insert(table.to_owned(), BTreeMap::new());
        }
        if let Some(facts) = self.facts.get_mut(table) {
            facts.insert(key.to_owned(), places);
        }
    }

    /// Forgets the position of a fact (letter case of the key does not matter), because another source (such as the
    /// command line) now states the fact.
    pub(super) fn forget(&mut self, table: &str, key: &str) {
        if let Some(facts) = self.facts.get_mut(table) {
            facts.retain(|known, _| !known.eq_ignore_ascii_case(key));
        }
    }

    /// An error about the fact with this table and key, at its position. If the position is unknown, as for facts from
    /// the command line: an error without file and line.
    pub(super) fn fault(
        &self,
        [table, key]: [&str; 2],
        part: Part,
        code: Code,
        message: String,
        help: &str,
    ) -> Diagnostic {
        let span = self.facts.get(table).and_then(|facts| facts.get(key)).map(|places| {
            let [key, value] = places.clone();
            if part == Part::Key { key } else { value }
        });
        match span {
            Some(span) => self.at(code, span, message, help),
            None => Diagnostic::file(code, "", message, help),
        }
    }

    /// An error at a byte range of the facts file. If the range goes over several lines, only its part of the first
    /// line is marked.
    pub(super) fn at(
        &self,
        code: Code,
        span: Range<usize>,
        message: String,
        help: &str,
    ) -> Diagnostic {
        let line = self.lines.partition_point(|&start| start <= span.start);
        let start = self.lines.get(line.wrapping_sub(1)).copied().unwrap_or(0);
        let end = self.lines.get(line).map_or(self.text.len(), |next| next - 1);
        let text = self.text[start..end].trim_end_matches('\r');
        let number = u32::try_from(line).unwrap_or(u32::MAX);
        // If the line is long, only the part around the error is shown.
        let (from, text) = excerpt(text, span.start - start);
        let own = |at: usize| (at - start).saturating_sub(from).min(text.len());
        let mut fault = Diagnostic::line(code, &self.file, number, text, message, help);
        fault.span = Some((own(span.start), own(span.end.min(end))));
        fault
    }
}

/// The largest number of bytes that are shown of a line on either side of an error.
const SHOWN: usize = 200;

/// The part of the line `text` with up to [`SHOWN`] bytes, and the rest of a character, on either side of byte `at`.
/// The number is the offset in the line at which this part begins.
fn excerpt(text: &str, at: usize) -> (usize, &str) {
    let at = at.min(text.len());
    let from = (0..=at.saturating_sub(SHOWN)).rev().find(|&from| text.is_char_boundary(from));
    let from = from.unwrap_or(0);
    let end = at.saturating_add(SHOWN).min(text.len());
    let end = (end..=text.len()).find(|&end| text.is_char_boundary(end)).unwrap_or(text.len());
    (from, &text[from..end])
}
