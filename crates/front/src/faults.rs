//! Collects the errors and warnings of one file, up to a limit; beyond it they are only counted.

use super::slice_range;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::{Diagnostic, Severity};

/// The largest number of errors, and of warnings, that are listed for one file.
const LIMIT: usize = 50;
/// If a file has this many errors that are not listed, the rest of the file is not read.
const HOPELESS: usize = 1000;
/// The largest number of characters of a source line that a message shows.
const SHOWN: usize = 120;

/// The errors and warnings of one file. At most 50 of each are kept; further ones are counted.
#[derive(Debug, Clone)]
pub struct Faults<'a> {
    file: &'a str,
    errors: Vec<Diagnostic>,
    warnings: Vec<Diagnostic>,
    dropped_errors: usize,
    dropped_warnings: usize,
    given_up: bool,
}

impl<'a> Faults<'a> {
    /// An empty collection for this file.
    pub fn new(file: &'a str) -> Self {
        Faults {
            file,
            errors: Vec::new(),
            warnings: Vec::new(),
            dropped_errors: 0,
            dropped_warnings: 0,
            given_up: false,
        }
    }

    /// The name of the file.
    pub fn file(&self) -> &'a str {
        self.file
    }

    /// Adds an error or a warning; beyond the limit it is only counted.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let (list, dropped) = match diagnostic.severity {
            Severity::Error => (&mut self.errors, &mut self.dropped_errors),
            Severity::Warning => (&mut self.warnings, &mut self.dropped_warnings),
        };
        if list.len() < LIMIT {
            list.push(diagnostic);
        } else {
            *dropped += 1;
        }
    }

    /// Adds an error for a whole line; of `text`, the message shows at most 120 characters.
    pub fn error_in_line(&mut self, code: Code, line: u32, text: &str, message: &str, help: &str) {
        if self.errors.len() < LIMIT {
            self.errors.push(Diagnostic::line(code, self.file, line, shown(text), message, help));
        } else {
            self.dropped_errors += 1;
        }
    }

    /// Adds an error in line `number`, whose text is `line`. Its caret is at `part`, which must be a slice of `line`;
    /// otherwise there is no caret.
    pub fn error_at(
        &mut self,
        code: Code,
        number: u32,
        line: &str,
        part: &str,
        (message, help): (&str, &str),
    ) {
        let mut found = Diagnostic::line(code, self.file, number, line.trim_end(), message, help);
        found.span = slice_range(line, part).map(|range| (range.start, range.end));
        self.push(found);
    }

    /// Whether at least 1000 errors were not listed, so that reading should stop. If so, the note on further errors
    /// says "at least".
    pub fn give_up(&mut self) -> bool {
        self.given_up = self.dropped_errors >= HOPELESS;
        self.given_up
    }

    /// Whether there is any error, not only warnings, so that the file cannot be used.
    pub fn any_error(&self) -> bool {
        !self.errors.is_empty()
    }

    /// The collected list: errors in the order of their lines, then warnings; after each of the two, a note of how many
    /// more there are, if any. Use it if several stages read the same file.
    pub fn in_order(mut self) -> Vec<Diagnostic> {
        self.errors.sort_by_key(|fault| (fault.line, fault.step));
        self.into_diagnostics()
    }

    /// The collected list: errors in the order in which they were found, then warnings; after each of the two, a note
    /// of how many more there are, if any.
    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        let mut all = self.errors;
        if self.dropped_errors > 0 {
            all.push(Diagnostic::file(
                Code::MoreErrors,
                self.file,
                match self.given_up {
                    false => format!("and {} more errors in this file", self.dropped_errors),
                    true => {
                        format!("and at least {} more errors in this file", self.dropped_errors)
                    }
                },
                "correct the first errors or warnings of the file; the others often follow from these",
            ));
        }
        all.extend(self.warnings);
        if self.dropped_warnings > 0 {
            all.push(
                Diagnostic::file(
                    Code::MoreWarnings,
                    self.file,
                    format!("and {} more warnings in this file", self.dropped_warnings),
                    "correct the first errors or warnings of the file; the others often follow from these",
                )
                .warning(),
            );
        }
        all
    }
}

/// The text on one line for a message: control characters become blanks, and a text of more than 120 characters is cut.
pub fn shown(text: &str) -> String {
    let mut out: String =
        text.chars().take(SHOWN).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(SHOWN).is_some() {
        out.push('…');
    }
    out.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_the_limit_faults_are_counted() {
        let mut faults = Faults::new("a.csv");
        for line in 1..=60 {
            faults.error_in_line(Code::NoTime, line, "text", "wrong", "mend it");
        }
        faults.push(Diagnostic::file(Code::NameOrder, "a.csv", "odd", "look").warning());
        let all = faults.into_diagnostics();
        assert_eq!(all.len(), 52);
        assert_eq!(all[50].message, "and 10 more errors in this file");
        assert_eq!(all[51].severity, Severity::Warning);
    }

    #[test]
    fn long_and_broken_text_is_made_fit_to_show() {
        assert_eq!(shown("\"0\"\t\"LD\"\r"), "\"0\" \"LD\"");
        assert_eq!(shown(&"あ".repeat(500)).chars().count(), SHOWN + 1);
    }
}
