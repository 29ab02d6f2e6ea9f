//! A list of fronts: finds the front of a file by its content, and reads a project with it.

use scanbound_base::code::Code;
use std::borrow::Cow;
use std::collections::BTreeSet;

use super::encoding::Named as Encoding;
use super::faults::shown;
use super::front::{Dialect, Front, Project, Sniff, SourceOptions};
use super::input::Input;
use super::{foreign, text};
use scanbound_base::diagnostic::Diagnostic;

/// The fronts that may read a file. Each file is read by the front whose dialect it is in.
#[derive(Clone, Copy)]
pub struct Fronts(pub &'static [&'static dyn Front]);

/// What a file contains.
#[derive(Debug, Clone, Copy)]
pub enum FileKind {
    /// A program in this dialect.
    Program(&'static Dialect),
    /// Device comments.
    Comments,
}

impl Fronts {
    /// All dialects of all fronts.
    pub fn dialects(self) -> impl Iterator<Item = &'static Dialect> {
        self.0.iter().flat_map(|front| front.dialects())
    }

    /// The known words of all fronts, to recognise the code page before the front is known.
    fn known_words(self) -> Vec<&'static str> {
        self.0.iter().flat_map(|front| front.known_words()).collect()
    }

    /// The first 64 KiB of a file as text; invalid bytes are replaced.
    #[must_use]
    pub fn beginning(self, bytes: &[u8]) -> Cow<'_, str> {
        text::beginning(bytes, &self.known_words())
    }

    fn is_comment_file(self, name: &str, beginning: &str) -> bool {
        self.0.iter().any(|front| front.is_comment_file(name, beginning))
    }

    /// Recognises whether a file is a program, and in which dialect, or holds device comments. Dialects of binary files
    /// see the whole file, and the first one that accepts it has it; all others see its first 64 KiB.
    ///
    /// # Errors
    /// The file is empty (unless its name is that of a file with device comments), is not text, is in no known dialect,
    /// or fits two dialects of text files.
    pub fn detect(self, input: &Input) -> Result<FileKind, Diagnostic> {
        if input.bytes.is_empty() {
            if self.is_comment_file(&input.name, "") {
                return Ok(FileKind::Comments);
            }
            return Err(empty(input, "the file is empty"));
        }
        let is_image = |dialect: &&Dialect| match dialect.sniff {
            Sniff::Bytes(sniff) => sniff(&input.bytes),
            Sniff::Text(_) => false,
        };
        if let Some(dialect) = self.dialects().find(is_image) {
            return Ok(FileKind::Program(dialect));
        }
        let known_words = self.known_words();
        let beginning = match text::checked_beginning(input, &known_words) {
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
            [dialect] => Ok(FileKind::Program(dialect)),
            [] if self.is_comment_file(&input.name, &beginning) => Ok(FileKind::Comments),
            [] if beginning.trim().is_empty() => Err(empty(input, "the file contains only blanks")),
            [] => Err(match text::decoded(input, &known_words) {
                Err(fault) if beginning.contains(char::REPLACEMENT_CHARACTER) => fault,
                _ => foreign::fault(input, &beginning)
                    .unwrap_or_else(|| self.unknown(input, &beginning)),
            }),
            [..] => Err(Diagnostic::file(
                Code::TwoDialects,
                &input.name,
                format!(
                    "the dialect of this file is not clear: it may be {}",
                    found.iter().map(|one| one.name).collect::<Vec<_>>().join(" or ")
                ),
                "state the dialect with --dialect",
            )),
        }
    }

    fn unknown(self, input: &Input, beginning: &str) -> Diagnostic {
        let line = beginning.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
        let mut fault = Diagnostic::file(
            Code::UnknownDialect,
            &input.name,
            "this is not a program in a known dialect",
            format!(
                "give {}; if the file is one of these, state the dialect with --dialect",
                self.expected()
            ),
        );
        fault.text = shown(line);
        fault
    }

    fn expected(self) -> String {
        self.dialects().map(|dialect| dialect.what).collect::<Vec<_>>().join("; ")
    }

    /// Finds a dialect by its name. The error lists the known names.
    fn dialect_named(self, name: &str) -> Result<&'static Dialect, Diagnostic> {
        self.dialects().find(|dialect| dialect.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.dialects().map(|dialect| dialect.name).collect();
            Diagnostic::file(
                Code::NoSuchDialect,
                "",
                format!("unknown dialect '{}'", shown(name)),
                format!("use one of {}", names.join(", ")),
            )
        })
    }

    /// Reads a project's files: programs in the given order, all in one dialect, and device comments. If `dialect` is
    /// `None`, it is recognised by the content; otherwise files that are recognised as another dialect are errors.
    ///
    /// # Errors
    /// There is no such dialect or no program; a file cannot be read, or is not in the dialect of the first program.
    /// The list has the errors of all files, as far as they can be found; warnings may be among them.
    pub fn read(
        self,
        inputs: &[Input],
        dialect: Option<&str>,
        reading: SourceOptions,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        let named = dialect
            .map(|name| self.dialect_named(name))
            .transpose()
            .map_err(|fault| vec![fault])?;
        let mut errors = Vec::new();
        let mut programs: Vec<(&'static Dialect, &Input)> = Vec::new();
        let mut comment_files = Vec::new();
        for input in inputs {
            match self.kind(input, named) {
                Ok(FileKind::Program(dialect)) => programs.push((dialect, input)),
                Ok(FileKind::Comments) => comment_files.push(input),
                Err(fault) => errors.push(fault),
            }
        }
        let Some(&(dialect, first)) = programs.first() else {
            if errors.is_empty() {
                errors.push(self.no_program(comment_files.first().copied()));
            }
            return Err(errors);
        };
        let (same, other): (Vec<_>, Vec<_>) =
            programs.into_iter().partition(|(other, _)| other.name == dialect.name);
        errors.extend(other.into_iter().map(|(other, input)| {
            Diagnostic::file(
                Code::MixedDialects,
                &input.name,
                format!(
                    "this file is in the dialect {}, but {} is in the dialect {}",
                    other.name, first.name, dialect.name
                ),
                "audit the files of each project separately: all files of one audit must come from one project",
            )
        }));
        // If some files cannot be read at all, the errors within the other programs are still reported.
        let same: Vec<&Input> = same.into_iter().map(|(_, input)| input).collect();
        let is_own = |own: &Dialect| own.name == dialect.name;
        let front = self.0.iter().find(|front| front.dialects().iter().any(is_own));
        match front.map(|front| front.read(dialect, &same, &comment_files, reading)) {
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
                "this file has device comments, not a program",
                "give the program files too",
            ),
            None => Diagnostic::file(
                Code::NoProgram,
                "",
                "there is no program among the arguments",
                format!("give at least one file: {}", self.expected()),
            ),
        }
    }

    /// The error for a file that is in another dialect than the user stated. If the file is read in the stated dialect
    /// with errors in fewer than half of its lines, and none in line 1, the result is the first of these errors.
    /// Otherwise the error names both dialects and, if there is one, the first error in a line. A dialect of binary
    /// files is not tried.
    fn other_dialect(self, input: &Input, found: &Dialect, named: &Dialect) -> Diagnostic {
        let is_named = |own: &Dialect| own.name == named.name;
        let front = self.0.iter().find(|front| front.dialects().iter().any(is_named));
        let is_text = matches!(named.sniff, Sniff::Text(_));
        let faults = front
            .filter(|_| is_text)
            .map(|front| front.read(named, &[input], &[], SourceOptions::default()));
        let faults = faults.and_then(Result::err).unwrap_or_default();
        let (message, help) = (
            format!("this file is in the dialect {}, not {}", found.name, named.name),
            "omit --dialect, or state the right dialect",
        );
        let wrong: BTreeSet<u32> = faults.iter().filter_map(|fault| fault.line).collect();
        let text = String::from_utf8_lossy(&input.bytes);
        let lines = text.lines().filter(|line| !line.trim().is_empty()).count();
        match faults.into_iter().find(|fault| fault.line.is_some()) {
            Some(first) if 2 * wrong.len() < lines && !wrong.contains(&1) => first,
            Some(first) => Diagnostic {
                code: Code::OtherDialect,
                message: format!(
                    "{message}; as {}, this line has an error: {}",
                    named.name, first.message
                ),
                help: help.to_owned(),
                ..first
            },
            None => Diagnostic::file(Code::OtherDialect, &input.name, message, help),
        }
    }

    /// Recognises what a file is. If the user named a dialect, a file that is empty or recognised as another dialect is
    /// an error, and device comments remain device comments. Any other file is taken as a program in the named dialect,
    /// except that a dialect of text files refuses binary and undecodable files.
    fn kind(self, input: &Input, named: Option<&'static Dialect>) -> Result<FileKind, Diagnostic> {
        let found = self.detect(input);
        let Some(named) = named else { return found };
        match found {
            Ok(FileKind::Comments) => Ok(FileKind::Comments),
            Ok(FileKind::Program(found)) if found.name != named.name => {
                Err(self.other_dialect(input, found, named))
            }
            Err(fault) if fault.code == Code::EmptyFile => Err(fault),
            Err(_) if matches!(named.sniff, Sniff::Bytes(_)) => Ok(FileKind::Program(named)),
            Err(fault) if matches!(fault.code, Code::BinaryFile | Code::Encoding) => Err(fault),
            _ => Ok(FileKind::Program(named)),
        }
    }
}

fn empty(input: &Input, message: &str) -> Diagnostic {
    Diagnostic::file(Code::EmptyFile, &input.name, message, "export the program again")
}

impl Input {
    /// Converts text in this encoding to UTF-8. A file stays unchanged if it is UTF-8, declares an encoding, is not
    /// valid in this one, or is a binary image that one of the fronts reads.
    pub fn recode(&mut self, encoding: Encoding, fronts: Fronts) {
        let mut images = fronts.dialects().filter_map(|dialect| match dialect.sniff {
            Sniff::Bytes(sniff) => Some(sniff),
            Sniff::Text(_) => None,
        });
        if images.any(|is_image| is_image(&self.bytes)) {
            return;
        }
        if let Some(text) = encoding.recoded(&self.bytes) {
            self.bytes = text.into_bytes();
        }
    }
}
