//! The faults of one file as they are found: all of them, up to a limit, then how many more.

use super::within;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::{Diagnostic, Severity};

/// Most errors, and most warnings, that are listed of one file.
const LIMIT: usize = 50;
/// Behind so many errors that are not told a file is given up.
const HOPELESS: usize = 1000;
/// Most characters of a source line that are shown.
const SHOWN: usize = 120;

/// Collects the faults of one file.
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
    /// None yet.
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

    /// The file they are about.
    pub fn file(&self) -> &'a str {
        self.file
    }

    /// Adds one; those beyond a limit are only counted.
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

    /// An error at a line; `text` is shortened for showing.
    pub fn at(&mut self, code: Code, line: u32, text: &str, message: &str, help: &str) {
        if self.errors.len() < LIMIT {
            self.errors.push(Diagnostic::line(code, self.file, line, shown(text), message, help));
        } else {
            self.dropped_errors += 1;
        }
    }

    /// The same with the caret at a part of the line: a slice of it.
    pub fn within(
        &mut self,
        code: Code,
        number: u32,
        line: &str,
        part: &str,
        (message, help): (&str, &str),
    ) {
        let mut found = Diagnostic::line(code, self.file, number, line.trim_end(), message, help);
        found.span = within(line, part).map(|range| (range.start, range.end));
        self.push(found);
    }

    /// Whether there are so many errors that it is no use to look for more; the report then says "or more".
    pub fn give_up(&mut self) -> bool {
        self.given_up = self.dropped_errors >= HOPELESS;
        self.given_up
    }

    /// Whether the file cannot be taken.
    pub fn any_error(&self) -> bool {
        !self.errors.is_empty()
    }

    /// All that was found, errors first, and these by their lines: stages look at a file one after another.
    pub fn in_order(mut self) -> Vec<Diagnostic> {
        self.errors.sort_by_key(|fault| (fault.line, fault.step));
        self.into_diagnostics()
    }

    /// All that was found, errors first.
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
                "see to the first ones; the others often follow from them",
            ));
        }
        all.extend(self.warnings);
        if self.dropped_warnings > 0 {
            all.push(
                Diagnostic::file(
                    Code::MoreWarnings,
                    self.file,
                    format!("and {} more warnings in this file", self.dropped_warnings),
                    "see to the first ones; the others often follow from them",
                )
                .warning(),
            );
        }
        all
    }
}

/// The text as it can be shown in one line: control characters as blanks, the end cut off if it is long.
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
            faults.at(Code::NoTime, line, "text", "wrong", "mend it");
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
