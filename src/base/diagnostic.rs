//! One fault of the input: where it stands, what is wrong, and what to do about it.

use super::code::Code;

/// How bad a finding is. Any `Error` stops the audit (exit 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The input is taken all the same.
    Warning,
    /// The input cannot be taken.
    Error,
}

/// One finding about one place of one input file. Rendering is elsewhere (`render`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// A stable short name, such as `unknown-instruction`.
    pub code: Code,
    /// How bad it is.
    pub severity: Severity,
    /// The file's name as the user gave it.
    pub file: String,
    /// The line in the file, from 1; `None` if the finding is about the whole file.
    pub line: Option<u32>,
    /// The PLC's step number, where the file gives one.
    pub step: Option<u32>,
    /// The source text of the line, or the part of it that matters.
    pub text: String,
    /// Byte range within `text` that is at fault.
    pub span: Option<(usize, usize)>,
    /// What is wrong, one sentence without a full stop.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl Diagnostic {
    /// An error about a whole file.
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
            message: message.into(),
            help: help.into(),
        }
    }

    /// An error at a line, `text` being the line's text.
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
            text: text.into(),
            ..Diagnostic::file(code, file, message, help)
        }
    }

    /// Marks these bytes of the text as what is at fault.
    #[must_use]
    pub fn span(mut self, bytes: std::ops::Range<usize>) -> Self {
        self.span = Some((bytes.start, bytes.end));
        self
    }

    /// Marks the part of the text that is at fault, if it occurs there.
    #[must_use]
    pub fn mark(mut self, part: &str) -> Self {
        self.span =
            self.text.find(part).filter(|_| !part.is_empty()).map(|at| (at, at + part.len()));
        self
    }

    /// Gives the PLC's step number.
    #[must_use]
    pub fn at_step(mut self, step: Option<u32>) -> Self {
        self.step = step;
        self
    }

    /// What is wrong and what to do in one line, behind its place.
    #[must_use]
    pub fn brief(&self) -> String {
        let line = self.line.map_or(String::new(), |line| format!(":{line}"));
        let place =
            if self.file.is_empty() { String::new() } else { format!("{}{line}: ", self.file) };
        let help = if self.help.is_empty() { String::new() } else { format!("; {}", self.help) };
        format!("{place}{}{help}", self.message)
    }

    /// The same as a warning.
    #[must_use]
    pub fn warning(mut self) -> Self {
        self.severity = Severity::Warning;
        self
    }
}
