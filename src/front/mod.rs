//! Dialects: what a source file is written in, found from its content, and the readers of each.

mod encoding;
mod faults;
pub mod flowchart;
mod foreign;
pub mod input;
pub mod melsec;
pub mod minasec;
pub mod omron;
mod place;

use std::borrow::Cow;

use crate::base::diagnostic::Diagnostic;
pub(crate) use faults::Faults;
use faults::shown;
use melsec::source::RawProject;
pub use place::Places;
pub(crate) use place::{Pointer, within};

/// So many bytes at the beginning tell what a file is.
pub const BEGINNING: usize = 64 * 1024;

/// A file as it was handed over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// Its name as the user gave it.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// A dialect: a way in which programs are written down.
#[derive(Debug, Clone, Copy)]
pub struct Dialect {
    /// Its name for `--dialect` and reports.
    pub name: &'static str,
    /// What it is, in words.
    pub what: &'static str,
    /// Whether a file that begins so is written in it.
    pub sniff: fn(&str) -> bool,
}

/// What a file is.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A program.
    Program(&'static Dialect),
    /// Device comments.
    Comments,
}

/// All dialects.
static DIALECTS: [Dialect; 10] = {
    let [csv, gx3, list] = melsec::DIALECTS;
    let [assembly, hex, binary] = minasec::DIALECTS;
    let [c200h, cx, cxt] = omron::DIALECTS;
    let [flowchart] = flowchart::DIALECTS;
    [csv, gx3, list, assembly, hex, binary, c200h, cx, cxt, flowchart]
};

/// All dialects, for help texts and messages.
#[must_use]
pub fn dialects() -> &'static [Dialect] {
    &DIALECTS
}

/// What a file is, found from its beginning.
///
/// # Errors
/// Why it is nothing that can be read: it is empty, no text, in no known dialect, or in two.
pub fn detect(input: &Input) -> Result<Kind, Diagnostic> {
    if input.bytes.is_empty() {
        if is_comments_by_name(input) {
            return Ok(Kind::Comments);
        }
        return Err(Diagnostic::file(
            "empty-file",
            &input.name,
            "the file is empty",
            "export the program again",
        ));
    }
    if minasec::machine_code::is_image(&input.bytes) {
        return Ok(Kind::Program(minasec::machine_code::image_dialect()));
    }
    let beginning = match beginning(input) {
        Ok(beginning) => beginning,
        Err(fault) => {
            let code = fault.code;
            return Err(
                foreign::fault(input, "").map_or(fault, |known| Diagnostic { code, ..known })
            );
        }
    };
    let found: Vec<&'static Dialect> =
        DIALECTS.iter().filter(|dialect| (dialect.sniff)(&beginning)).collect();
    match found[..] {
        [dialect] => Ok(Kind::Program(dialect)),
        [] if melsec::is_comments(&beginning) || omron::is_symbols(&beginning) => {
            Ok(Kind::Comments)
        }
        [] if beginning.trim().is_empty() && is_comments_by_name(input) => Ok(Kind::Comments),
        [] if beginning.trim().is_empty() => Err(Diagnostic::file(
            "empty-file",
            &input.name,
            "the file holds nothing but blanks",
            "export the program again",
        )),
        [] => Err(match decoded(input) {
            Err(fault) if beginning.contains(char::REPLACEMENT_CHARACTER) => fault,
            _ => foreign::fault(input, &beginning).unwrap_or_else(|| unknown(input, &beginning)),
        }),
        [..] => Err(Diagnostic::file(
            "two-dialects",
            &input.name,
            format!(
                "this could be {}",
                found.iter().map(|one| one.name).collect::<Vec<_>>().join(" or ")
            ),
            "name the dialect with --dialect",
        )),
    }
}

/// Whether a file has the name that tools give device comments.
fn is_comments_by_name(input: &Input) -> bool {
    stem(&input.name).eq_ignore_ascii_case("COMMENT")
}

/// Warns of comments that hold nothing.
fn empty_comments(comments: &[&Input]) -> Vec<Diagnostic> {
    let empty =
        comments.iter().filter(|input| beginning(input).is_ok_and(|text| text.trim().is_empty()));
    let told = empty.map(|input| {
        let help = "export the comments again if devices have any";
        Diagnostic::file("empty-file", &input.name, "the device comments are empty", help).warning()
    });
    told.collect()
}

fn unknown(input: &Input, beginning: &str) -> Diagnostic {
    let line = beginning.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let mut fault = Diagnostic::file(
        "unknown-dialect",
        &input.name,
        "this is no program in a known dialect",
        format!("expected {}; name the dialect with --dialect if it is one", expected()),
    );
    fault.text = shown(line);
    fault
}

/// A project in the form in which its dialect is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Project {
    /// MELSEC: mnemonics and operands as written.
    Melsec(RawProject),
    /// MINASEC-U: the program memory.
    Minasec(Box<minasec::Source>),
    /// OMRON: mnemonics and operands as written.
    Omron(omron::source::RawProject),
    /// Flowchart PC: the instructions, with what they name.
    Flowchart(flowchart::Source),
}

/// Reads a project's files: the programs in the given order, and device comments. The dialect is found
/// from the content unless it is named.
///
/// # Errors
/// The faults of all files, and their warnings.
pub fn read(inputs: &[Input], dialect: Option<&str>) -> Result<Project, Vec<Diagnostic>> {
    let named = match dialect {
        None => None,
        Some(name) => match DIALECTS.iter().find(|dialect| dialect.name == name) {
            Some(dialect) => Some(dialect),
            None => {
                return Err(vec![Diagnostic::file(
                    "no-such-dialect",
                    "",
                    format!("there is no dialect '{}'", shown(name)),
                    format!("the dialects are {}", names()),
                )]);
            }
        },
    };
    let mut errors = Vec::new();
    let mut programs: Vec<(&'static Dialect, &Input)> = Vec::new();
    let mut comments = Vec::new();
    for input in inputs {
        match kind(input, named) {
            Ok(Kind::Program(dialect)) => programs.push((dialect, input)),
            Ok(Kind::Comments) => comments.push(input),
            Err(fault) => errors.push(fault),
        }
    }
    if let Some(((dialect, first), rest)) = programs.split_first() {
        errors.extend(rest.iter().filter(|(other, _)| other.name != dialect.name).map(
            |(other, input)| {
                Diagnostic::file(
                    "mixed-dialects",
                    &input.name,
                    format!("this is {}, {} is {}", other.name, first.name, dialect.name),
                    "the files of one scan come from one project: audit them by themselves",
                )
            },
        ));
    } else if errors.is_empty() {
        errors.push(match comments.first() {
            Some(input) => Diagnostic::file(
                "comments-alone",
                &input.name,
                "these are device comments, no program",
                "give the program's files as well",
            ),
            None => Diagnostic::file(
                "no-program",
                "",
                "no program was given",
                format!("name at least one file: {}", expected()),
            ),
        });
    }
    // The faults within the programs are told at once with those of whole files.
    let read = programs.first().map(|(dialect, _)| {
        let same: Vec<&Input> = programs
            .iter()
            .filter(|(other, _)| other.name == dialect.name)
            .map(|(_, input)| *input)
            .collect();
        if minasec::is_dialect(dialect.name) {
            minasec::read(dialect, &same).map(|source| Project::Minasec(Box::new(source)))
        } else if omron::DIALECTS.iter().any(|one| one.name == dialect.name) {
            omron::project::read(dialect, &same, &comments).map(Project::Omron)
        } else if dialect.name == flowchart::NAME {
            flowchart::read(&same).map(Project::Flowchart)
        } else {
            melsec::project::read(dialect, &same, &comments).map(Project::Melsec)
        }
    });
    match read {
        Some(Ok(mut project)) if errors.is_empty() => {
            match &mut project {
                Project::Melsec(project) => project.warnings.extend(empty_comments(&comments)),
                Project::Omron(project) => project.warnings.extend(empty_comments(&comments)),
                Project::Minasec(_) | Project::Flowchart(_) => {}
            }
            Ok(project)
        }
        Some(Err(more)) => {
            errors.extend(more);
            Err(errors)
        }
        _ => Err(errors),
    }
}

/// Reads a MELSEC project's files, as [`read`] does.
///
/// # Errors
/// The faults of all files, and a project of another dialect.
pub fn read_project(
    inputs: &[Input],
    dialect: Option<&str>,
) -> Result<RawProject, Vec<Diagnostic>> {
    match read(inputs, dialect)? {
        Project::Melsec(project) => Ok(project),
        Project::Minasec(source) => Err(vec![Diagnostic::file(
            "other-dialect",
            &source.name,
            format!("this is {}, not MELSEC", source.dialect),
            "give the program's MELSEC export",
        )]),
        Project::Omron(project) => Err(vec![Diagnostic::file(
            "other-dialect",
            project.files.first().map_or("", |file| &file.name),
            format!("this is {}, not MELSEC", project.dialect),
            "give the program's MELSEC export",
        )]),
        Project::Flowchart(source) => Err(vec![Diagnostic::file(
            "other-dialect",
            &source.name,
            format!("this is {}, not MELSEC", flowchart::NAME),
            "give the program's MELSEC export",
        )]),
    }
}

/// What a file is, where the user may have named the dialect.
fn kind(input: &Input, named: Option<&'static Dialect>) -> Result<Kind, Diagnostic> {
    let found = detect(input);
    let Some(named) = named else { return found };
    match found {
        Ok(Kind::Comments) => Ok(Kind::Comments),
        Ok(Kind::Program(found)) if found.name != named.name => Err(Diagnostic::file(
            "other-dialect",
            &input.name,
            format!("this is {}, not {}", found.name, named.name),
            "leave --dialect out, or name the one it is",
        )),
        Err(fault) if fault.code == "empty-file" => Err(fault),
        Err(_) if named.name == minasec::BINARY => Ok(Kind::Program(named)),
        Err(fault) if matches!(fault.code, "binary-file" | "encoding") => Err(fault),
        _ => Ok(Kind::Program(named)),
    }
}

/// The beginning of the file as text.
fn beginning(input: &Input) -> Result<Cow<'_, str>, Diagnostic> {
    let text = encoding::beginning(&input.bytes, BEGINNING, &marks());
    let stray = text.chars().filter(|&c| is_binary(c)).count();
    if stray > 0 && stray * 100 > text.chars().count() {
        let (message, help) = match input.bytes[..] {
            [0xD0, 0xCF, 0x11, 0xE0, ..] | [b'P', b'K', 3, 4, ..] => (
                "this is a tool's own file, no text",
                "open it in the tool and export its programs as CSV",
            ),
            _ => (
                "this is binary data, no text",
                "give the program as the tool exports it to CSV or text",
            ),
        };
        return Err(Diagnostic::file("binary-file", &input.name, message, help));
    }
    Ok(text)
}

/// The text of a file's beginning, faults replaced.
pub(crate) fn text_of_beginning(bytes: &[u8]) -> Cow<'_, str> {
    encoding::beginning(bytes, BEGINNING, &marks())
}

/// Whether no text has such a character.
fn is_binary(c: char) -> bool {
    c.is_control() && !matches!(c, '\t' | '\n' | '\r' | '\u{C}' | '\u{1A}')
}

/// The whole file as text.
fn decoded(input: &Input) -> Result<Cow<'_, str>, Diagnostic> {
    encoding::decode(&input.bytes, &marks()).map_err(|fault| {
        let mut diagnostic = Diagnostic::file(
            "encoding",
            &input.name,
            if fault.cut {
                format!("the file ends within a character of {}", fault.tried)
            } else {
                format!("the byte at offset {} is no text in {}", fault.offset, fault.tried)
            },
            "the file was cut off or its encoding changed on the way: export it again",
        );
        diagnostic.line = Some(fault.line);
        diagnostic
    })
}

fn marks() -> Vec<&'static str> {
    melsec::marks().collect()
}

/// A file's name without directory and extension.
fn stem(name: &str) -> &str {
    let base = name.rsplit(['/', '\\']).next().unwrap_or(name);
    match base.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem,
        _ => base,
    }
}

fn names() -> String {
    DIALECTS.iter().map(|dialect| dialect.name).collect::<Vec<_>>().join(", ")
}

fn expected() -> String {
    DIALECTS.iter().map(|dialect| dialect.what).collect::<Vec<_>>().join("; ")
}
