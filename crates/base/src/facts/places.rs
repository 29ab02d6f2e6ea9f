//! Where in its file each fact stands, for what is found wrong with it later.

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use std::collections::BTreeMap;
use std::ops::Range;

/// The part of a fact that a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// What stands in front of the equals sign.
    Key,
    /// What stands behind it.
    Value,
}

/// A facts file's text, and where its facts stand in it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Places {
    file: String,
    text: String,
    /// Where each line begins.
    lines: Vec<usize>,
    /// Key and value by table and key.
    facts: BTreeMap<String, BTreeMap<String, [Range<usize>; 2]>>,
}

impl Places {
    /// Those of a file that is about to be read.
    pub(super) fn new(file: &str, text: &str) -> Places {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let lines = [0].into_iter().chain(breaks.map(|(at, _)| at + 1)).collect();
        Places { file: file.to_owned(), text: text.to_owned(), lines, facts: BTreeMap::new() }
    }

    /// Notes where a fact stands.
    pub(super) fn put(&mut self, table: &str, key: &str, places: [Range<usize>; 2]) {
        if !self.facts.contains_key(table) {
            self.facts.insert(table.to_owned(), BTreeMap::new());
        }
        if let Some(facts) = self.facts.get_mut(table) {
            facts.insert(key.to_owned(), places);
        }
    }

    /// Forgets where a fact stands that is now stated elsewhere.
    pub(super) fn forget(&mut self, table: &str, key: &str) {
        if let Some(facts) = self.facts.get_mut(table) {
            facts.retain(|known, _| !known.eq_ignore_ascii_case(key));
        }
    }

    /// A finding about a fact, at its place; about no file where it was not stated in one.
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

    /// A finding about a part of the text.
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
        // A long line is shown around what is meant.
        let (from, text) = around(text, span.start - start);
        let own = |at: usize| (at - start).saturating_sub(from).min(text.len());
        let mut fault = Diagnostic::line(code, &self.file, number, text, message, help);
        fault.span = Some((own(span.start), own(span.end.min(end))));
        fault
    }
}

/// More of a line than so many bytes to either side of what is meant is not shown.
const SHOWN: usize = 200;

/// The part of a line around a place, and where it begins.
fn around(text: &str, at: usize) -> (usize, &str) {
    let at = at.min(text.len());
    let from = (0..=at.saturating_sub(SHOWN)).rev().find(|&from| text.is_char_boundary(from));
    let from = from.unwrap_or(0);
    let end = at.saturating_add(SHOWN).min(text.len());
    let end = (end..=text.len()).find(|&end| text.is_char_boundary(end)).unwrap_or(text.len());
    (from, &text[from..end])
}
