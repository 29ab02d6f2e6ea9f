//! What is wrong with a text, before it is known which file it stands in.

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// A fault at a line.
#[derive(Debug, Clone, PartialEq, Eq)]
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
            message: told(&message.into()),
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

/// A message in which nothing has a name that nobody wrote: what lists and drawings keep for themselves is told by where it
/// comes from.
fn told(message: &str) -> String {
    let mut found = String::new();
    let mut rest = message;
    while let Some(at) = rest.find('~') {
        found += &rest[..at];
        rest = &rest[at + 1..];
        let own = rest.strip_prefix("result ").unwrap_or(rest);
        let end = own.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(own.len());
        let (name, behind) = own.split_at(end);
        match origin(name) {
            Some(origin) => {
                found += &origin;
                rest = behind;
            }
            None => found.push('~'),
        }
    }
    found + rest
}

/// Where what is kept under a name comes from: `n7_OUT` of a block, `v7_` of what forks, `e7` of an edge.
fn origin(name: &str) -> Option<String> {
    let parts: Vec<&str> = name.split('_').collect();
    let number = |part: &str, letters: &str| {
        let digits = part.strip_prefix(letters)?;
        (!digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()))
            .then_some(digits.to_owned())
    };
    let place = |letters: &str| {
        parts.iter().enumerate().rev().find_map(|(at, part)| Some((at, number(part, letters)?)))
    };
    if let Some((at, id)) = place("n") {
        let output = parts[at + 1..].join("_");
        return Some(match output.is_empty() {
            true => format!("the result of the block with localId {id}"),
            false => format!("output {output} of the block with localId {id}"),
        });
    }
    let (_, id) = place("v").or_else(|| place("e"))?;
    Some(format!("what leads on from localId {id}"))
}

#[cfg(test)]
mod tests {
    use super::told;

    #[test]
    fn what_is_kept_is_told_by_where_it_comes_from() {
        let told_of = told("there is no ~result t3_n2_QQ");
        assert_eq!(told_of, "there is no output QQ of the block with localId 2");
        assert_eq!(told("~v5_OUT AND a ~ b"), "what leads on from localId 5 AND a ~ b");
    }
}
