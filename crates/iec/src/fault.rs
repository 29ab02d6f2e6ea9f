//! What is wrong with a text, before it is known which file it stands in.

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// A fault at a line.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Fault {
    /// Its code.
    pub code: Code,
    /// The line, from 1.
    pub line: u32,
    /// What stands there, as far as it matters.
    pub text: String,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl Fault {
    /// A fault of syntax.
    pub fn new(line: u32, message: impl Into<String>) -> Fault {
        Fault {
            code: Code::Syntax,
            line,
            text: String::new(),
            message: message.into(),
            help: "write it as IEC 61131-3 has it, or export it anew".to_owned(),
        }
    }

    /// The same with what to do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = help.into();
        self
    }

    /// The same with another code.
    #[must_use]
    pub fn code(mut self, code: Code) -> Fault {
        self.code = code;
        self
    }

    /// The same with what stands there.
    #[must_use]
    pub fn text(mut self, text: impl Into<String>) -> Fault {
        self.text = text.into();
        self
    }

    /// The same with the part of the program that it is in named in front.
    #[must_use]
    pub fn within(mut self, place: &str) -> Fault {
        self.message = format!("{place}: {}", self.message);
        self
    }

    /// As a finding about a file.
    #[must_use]
    pub fn in_file(self, file: &str) -> Diagnostic {
        Diagnostic::line(self.code, file, self.line, self.text, self.message, self.help)
    }
}

/// The most characters of a piece of the source that a message repeats.
const SHORT: usize = 60;

/// A piece of the source as messages repeat it: one line, and not too long.
#[must_use]
pub fn short(text: &str) -> String {
    let mut words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((at, _)) = words.char_indices().nth(SHORT) {
        words.truncate(at);
        words.push('…');
    }
    words
}

/// The fault of code in a pragma where none is carried out, or nothing is stated of it.
pub(crate) fn foreign(text: &str, line: u32) -> Fault {
    let told = format!("what the pragma {} does is not known", short(text));
    Fault::new(line, told).code(Code::Pragma).text(text)
}
