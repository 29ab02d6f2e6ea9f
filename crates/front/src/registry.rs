//! The fronts together: finds which front a file belongs to, and reads a project by it.

use scanbound_base::code::Code;
use std::borrow::Cow;

use super::faults::shown;
use super::{Dialect, Front, Input, Project, Reading, Sniff, foreign, text};
use scanbound_base::diagnostic::Diagnostic;

/// Some fronts, as a registry lists them.
#[derive(Clone, Copy)]
pub struct Fronts(pub &'static [&'static dyn Front]);

/// What a file is.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A program.
    Program(&'static Dialect),
    /// Device comments.
    Comments,
}

impl Fronts {
    /// All dialects, for help texts and messages.
    pub fn dialects(self) -> impl Iterator<Item = &'static Dialect> {
        self.0.iter().flat_map(|front| front.dialects())
    }

    /// Words that files hold, to tell code pages apart before it is known to which front a file belongs.
    fn marks(self) -> Vec<&'static str> {
        self.0.iter().flat_map(|front| front.marks()).collect()
    }

    /// The text of a file's beginning, faults replaced.
    #[must_use]
    pub fn beginning(self, bytes: &[u8]) -> Cow<'_, str> {
        text::beginning(bytes, &self.marks())
    }

    fn is_beside(self, name: &str, beginning: &str) -> bool {
        self.0.iter().any(|front| front.is_beside(name, beginning))
    }

    /// What a file is, found from its beginning.
    ///
    /// # Errors
    /// Why it is nothing that can be read: it is empty, no text, in no known dialect, or in two.
    pub fn detect(self, input: &Input) -> Result<Kind, Diagnostic> {
        if input.bytes.is_empty() {
            if self.is_beside(&input.name, "") {
                return Ok(Kind::Comments);
            }
            return Err(empty(input, "the file is empty"));
        }
        let is_image = |dialect: &&Dialect| match dialect.sniff {
            Sniff::Bytes(sniff) => sniff(&input.bytes),
            Sniff::Text(_) => false,
        };
        if let Some(dialect) = self.dialects().find(is_image) {
            return Ok(Kind::Program(dialect));
        }
        let marks = self.marks();
        let beginning = match text::checked_beginning(input, &marks) {
            Ok(beginning) => beginning,
            Err(fault) => {
                let code = fault.code;
                let known = foreign::fault(input, "");
                return Err(known.map_or(fault, |known| Diagnostic { code, ..known }));
            }
        };
        let is_written = |dialect: &&Dialect| match dialect.sniff {
            Sniff::Text(sniff) => sniff(&beginning),
            Sniff::Bytes(_) => false,
        };
        let found: Vec<&'static Dialect> = self.dialects().filter(is_written).collect();
        match found[..] {
            [dialect] => Ok(Kind::Program(dialect)),
            [] if self.is_beside(&input.name, &beginning) => Ok(Kind::Comments),
            [] if beginning.trim().is_empty() => {
                Err(empty(input, "the file holds nothing but blanks"))
            }
            [] => Err(match text::decoded(input, &marks) {
                Err(fault) if beginning.contains(char::REPLACEMENT_CHARACTER) => fault,
                _ => foreign::fault(input, &beginning)
                    .unwrap_or_else(|| self.unknown(input, &beginning)),
            }),
            [..] => Err(Diagnostic::file(
                Code::TwoDialects,
                &input.name,
                format!(
                    "this could be {}",
                    found.iter().map(|one| one.name).collect::<Vec<_>>().join(" or ")
                ),
                "name the dialect with --dialect",
            )),
        }
    }

    fn unknown(self, input: &Input, beginning: &str) -> Diagnostic {
        let line = beginning.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        let mut fault = Diagnostic::file(
            Code::UnknownDialect,
            &input.name,
            "this is no program in a known dialect",
            format!("expected {}; name the dialect with --dialect if it is one", self.expected()),
        );
        fault.text = shown(line);
        fault
    }

    fn expected(self) -> String {
        self.dialects().map(|dialect| dialect.what).collect::<Vec<_>>().join("; ")
    }

    /// The dialect of a name.
    fn named(self, name: &str) -> Result<&'static Dialect, Diagnostic> {
        self.dialects().find(|dialect| dialect.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.dialects().map(|dialect| dialect.name).collect();
            Diagnostic::file(
                Code::NoSuchDialect,
                "",
                format!("there is no dialect '{}'", shown(name)),
                format!("the dialects are {}", names.join(", ")),
            )
        })
    }

    /// Reads a project's files: the programs in the given order, and device comments. The dialect is found
    /// from the content unless it is named.
    ///
    /// # Errors
    /// The faults of all files, and their warnings.
    pub fn read(
        self,
        inputs: &[Input],
        dialect: Option<&str>,
        reading: Reading,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        let named =
            dialect.map(|name| self.named(name)).transpose().map_err(|fault| vec![fault])?;
        let mut errors = Vec::new();
        let mut programs: Vec<(&'static Dialect, &Input)> = Vec::new();
        let mut beside = Vec::new();
        for input in inputs {
            match self.kind(input, named) {
                Ok(Kind::Program(dialect)) => programs.push((dialect, input)),
                Ok(Kind::Comments) => beside.push(input),
                Err(fault) => errors.push(fault),
            }
        }
        let Some(&(dialect, first)) = programs.first() else {
            if errors.is_empty() {
                errors.push(self.no_program(beside.first().copied()));
            }
            return Err(errors);
        };
        let (same, other): (Vec<_>, Vec<_>) =
            programs.into_iter().partition(|(other, _)| other.name == dialect.name);
        errors.extend(other.into_iter().map(|(other, input)| {
            Diagnostic::file(
                Code::MixedDialects,
                &input.name,
                format!("this is {}, {} is {}", other.name, first.name, dialect.name),
                "the files of one scan come from one project: audit them by themselves",
            )
        }));
        // Faults within programs are reported together with those of whole files.
        let same: Vec<&Input> = same.into_iter().map(|(_, input)| input).collect();
        let is_own = |own: &Dialect| own.name == dialect.name;
        let front = self.0.iter().find(|front| front.dialects().iter().any(is_own));
        match front.map(|front| front.read(dialect, &same, &beside, reading)) {
            Some(Ok(project)) if errors.is_empty() => Ok(project),
            Some(Err(more)) => {
                errors.extend(more);
                Err(errors)
            }
            _ => Err(errors),
        }
    }

    fn no_program(self, comments: Option<&Input>) -> Diagnostic {
        match comments {
            Some(input) => Diagnostic::file(
                Code::CommentsAlone,
                &input.name,
                "these are device comments, no program",
                "give the program's files as well",
            ),
            None => Diagnostic::file(
                Code::NoProgram,
                "",
                "no program was given",
                format!("name at least one file: {}", self.expected()),
            ),
        }
    }

    /// That a file is written in another dialect than the one that the user named; with the first line that this one does
    /// not have, if it can be read that far.
    fn other_dialect(self, input: &Input, found: &Dialect, named: &Dialect) -> Diagnostic {
        let is_named = |own: &Dialect| own.name == named.name;
        let front = self.0.iter().find(|front| front.dialects().iter().any(is_named));
        let is_text = matches!(named.sniff, Sniff::Text(_));
        let faults = front
            .filter(|_| is_text)
            .map(|front| front.read(named, &[input], &[], Reading::default()));
        let faults = faults.and_then(Result::err).unwrap_or_default();
        let (message, help) = (
            format!("this is {}, not {}", found.name, named.name),
            "leave --dialect out, or name the one it is",
        );
        match faults.into_iter().find(|fault| fault.line.is_some()) {
            Some(first) => Diagnostic {
                code: Code::OtherDialect,
                message: format!("{message}: {}", first.message),
                help: help.to_owned(),
                ..first
            },
            None => Diagnostic::file(Code::OtherDialect, &input.name, message, help),
        }
    }

    /// What a file is, where the user may have named the dialect.
    fn kind(self, input: &Input, named: Option<&'static Dialect>) -> Result<Kind, Diagnostic> {
        let found = self.detect(input);
        let Some(named) = named else { return found };
        match found {
            Ok(Kind::Comments) => Ok(Kind::Comments),
            Ok(Kind::Program(found)) if found.name != named.name => {
                Err(self.other_dialect(input, found, named))
            }
            Err(fault) if fault.code == Code::EmptyFile => Err(fault),
            Err(_) if matches!(named.sniff, Sniff::Bytes(_)) => Ok(Kind::Program(named)),
            Err(fault) if matches!(fault.code, Code::BinaryFile | Code::Encoding) => Err(fault),
            _ => Ok(Kind::Program(named)),
        }
    }
}

fn empty(input: &Input, message: &str) -> Diagnostic {
    Diagnostic::file(Code::EmptyFile, &input.name, message, "export the program again")
}
