//! A finding about the input: where it is, what is wrong, and what to do.

use super::code::Code;

/// The severity of a finding. A single `Error` stops the audit (exit code 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The input is accepted.
    Warning,
    /// The input is rejected.
    Error,
}

/// A finding about one place in one input file. Rendering is done elsewhere.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// The stable short name of this type of finding, such as `unknown-instruction`.
    pub code: Code,
    /// Whether the input is rejected (error) or accepted (warning).
    pub severity: Severity,
    /// The file's name as the user gave it. Empty if the finding is about no file, for example about an option.
    pub file: String,
    /// The line in the file, from 1; `None` if the finding is about the whole file.
    pub line: Option<u32>,
    /// The step number that the PLC's own editor gives the instruction. `None` if the file gives none.
    pub step: Option<u32>,
    /// The source text of the line, or the part of it that matters.
    pub text: String,
    /// The byte range within `text` that is wrong. `None`: no part is marked.
    pub span: Option<(usize, usize)>,
    /// What is wrong: one sentence without a full stop.
    pub message: String,
    /// What the user can do.
    pub help: String,
}

/// The longest word of a message or help text, in bytes. A longer word is text of the source, and is cut.
const LONGEST_WORD: usize = 160;
/// The largest number of bytes of a source line that a finding keeps.
const LONGEST_LINE: usize = 20_000;

/// Cuts those words of a text (what blanks separate) that have more than [`LONGEST_WORD`] bytes to this length.
fn in_short(message: String) -> String {
    if message.split(' ').all(|word| word.len() <= LONGEST_WORD) {
        return message;
    }
    let words = message.split(' ').map(|word| cut(word.to_owned(), LONGEST_WORD));
    words.collect::<Vec<_>>().join(" ")
}

/// Shortens a text to at most `most` bytes, at a character boundary, and adds an ellipsis. A shorter text stays as it
/// is.
fn cut(mut text: String, most: usize) -> String {
    if text.len() > most {
        let end = (0..=most).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
        text.truncate(end);
        text.push('…');
    }
    text
}

impl Diagnostic {
    /// Creates an error about a whole file. An empty name: it is about no file, but for example about an option. Very
    /// long words of the message and the help are cut.
    pub fn file(
        code: Code,
        file: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            file: file.to_owned(),
            line: None,
            step: None,
            text: String::new(),
            span: None,
            message: in_short(message.into()),
            help: in_short(help.into()),
        }
    }

    /// Creates an error at a line, counted from 1; `text` is the source text of the line, which is cut if it is very
    /// long.
    pub fn line(
        code: Code,
        file: &str,
        line: u32,
        text: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Diagnostic {
            line: Some(line),
            text: cut(text.into(), LONGEST_LINE),
            ..Diagnostic::file(code, file, message, help)
        }
    }

    /// Marks a byte range of the text as the part that is wrong.
    #[must_use]
    pub fn span(mut self, bytes: std::ops::Range<usize>) -> Self {
        self.span = Some((bytes.start, bytes.end));
        self
    }

    /// Marks the first occurrence of `part` in the text as wrong, in place of an earlier mark. If it does not occur or
    /// is empty, no part is marked.
    #[must_use]
    pub fn mark(mut self, part: &str) -> Self {
        self.span =
            self.text.find(part).filter(|_| !part.is_empty()).map(|at| (at, at + part.len()));
        self
    }

    /// Adds the step number that the PLC's own editor gives the instruction.
    #[must_use]
    pub fn at_step(mut self, step: Option<u32>) -> Self {
        self.step = step;
        self
    }

    /// The file, line, message and help in one line of text.
    #[must_use]
    pub fn brief(&self) -> String {
        let line = self.line.map_or(String::new(), |line| format!(":{line}"));
        let place =
            if self.file.is_empty() { String::new() } else { format!("{}{line}: ", self.file) };
        let help = if self.help.is_empty() { String::new() } else { format!("; {}", self.help) };
        format!("{place}{}{help}", self.message)
    }

    /// Turns the error into a warning.
    #[must_use]
    pub fn warning(mut self) -> Self {
        self.severity = Severity::Warning;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_words_are_cut() {
        let message = format!("'{}' is no constant", "7".repeat(1_000_000));
        let found = Diagnostic::line(Code::Syntax, "a.st", 1, &message, &message, "write\nit");
        assert!(found.message.ends_with("777… is no constant"), "{}", found.message.len());
        assert!(found.message.len() < 200 && found.text.len() < 30_000);
        assert_eq!(found.help, "write\nit");
        let plain = Diagnostic::file(Code::Syntax, "a.st", "あ ".repeat(500), "");
        assert_eq!(plain.message, "あ ".repeat(500));
    }
}
