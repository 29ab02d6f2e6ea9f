//! Faults in a source text, before the file's name is attached.

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// A fault at a line of a source text.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Fault {
    /// Its code in the list of diagnostics.
    pub code: Code,
    /// The line, from 1.
    pub line: u32,
    /// The source text at fault; empty if it is not shown.
    pub text: String,
    /// The message: what is wrong.
    pub message: String,
    /// The help: what the user should do.
    pub help: String,
}

impl Fault {
    /// A syntax error with the default help and no source text.
    pub fn new(line: u32, message: impl Into<String>) -> Fault {
        Fault {
            code: Code::Syntax,
            line,
            text: String::new(),
            message: message.into(),
            help: "write it as IEC 61131-3 requires, or export it again".to_owned(),
        }
    }

    /// Replaces the help.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = help.into();
        self
    }

    /// Replaces the code.
    #[must_use]
    pub fn code(mut self, code: Code) -> Fault {
        self.code = code;
        self
    }

    /// Replaces the source text.
    #[must_use]
    pub fn text(mut self, text: impl Into<String>) -> Fault {
        self.text = text.into();
        self
    }

    /// Puts `place`, the part of the program, in front of the message.
    #[must_use]
    pub fn within(mut self, place: &str) -> Fault {
        self.message = format!("{place}: {}", self.message);
        self
    }

    /// Converts the fault to a diagnostic for a file.
    #[must_use]
    pub fn in_file(self, file: &str) -> Diagnostic {
        Diagnostic::line(self.code, file, self.line, self.text, self.message, self.help)
    }
}

/// The maximum number of characters of source text that a message quotes.
const SHORT: usize = 60;

/// Source text as messages quote it: on one line, and cut with "…" after 60 characters.
#[must_use]
pub fn short(text: &str) -> String {
    let mut words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((at, _)) = words.char_indices().nth(SHORT) {
        words.truncate(at);
        words.push('…');
    }
    words
}

/// The fault of a pragma that may contain code, where pragmas are not allowed or no fact states its effect.
pub(crate) fn foreign(text: &str, line: u32) -> Fault {
    let told = format!("the effect of the pragma {} is not known", short(text));
    Fault::new(line, told).code(Code::Pragma).text(text)
}
