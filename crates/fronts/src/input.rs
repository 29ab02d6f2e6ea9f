//! Reads the files and directories that the user names.
//!
//! A program that is missing from a scan makes its bound too low. So every named file must be readable, and so must
//! every file in a named directory, unless an `--ignore` pattern excludes it or it is clearly not a program (`plain`).

mod ignore;
mod plain;

use scanbound_base::code::Code;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::detect;
pub use ignore::Ignore;
use scanbound_base::diagnostic::{Diagnostic, Severity};
use scanbound_front::{BEGINNING, FileKind, Input};

/// The largest size of a program or a file with device comments, in bytes. The largest programs have a million steps,
/// about a third of this size.
const LARGEST: u64 = 256 << 20;
/// The path that means standard input.
pub const STDIN: &str = "-";
/// The largest number of file names of each kind in the warning about files that were left out.
const LISTED: usize = 20;
/// How many levels of subdirectories are searched for programs that the user did not name.
const DEPTH: usize = 8;

/// The files that were read, and findings about files that were left out.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Gathered {
    /// The files that were read, in the order in which the user named them; those of a directory in the order of their
    /// names.
    pub inputs: Vec<Input>,
    /// Warnings: files that were left out, an order that was assumed, files with the same content, patterns of
    /// `--ignore` that match nothing. From [`survey`] also errors.
    pub warnings: Vec<Diagnostic>,
}

/// Reads the named files, and from named directories all that may be a program or device comments.
///
/// # Errors
/// Each path that cannot be read, is too large, is named twice, or is a directory without a program; each file of a
/// directory that may be a program but cannot be read as one, or is in a subdirectory; and that `--ignore` excludes all
/// files. The list includes the warnings.
pub fn gather(paths: &[PathBuf], ignore: &Ignore) -> Result<Gathered, Vec<Diagnostic>> {
    let gathered = survey(paths, ignore);
    match gathered.warnings.iter().any(|fault| fault.severity == Severity::Error) {
        true => Err(gathered.warnings),
        false => Ok(gathered),
    }
}

/// As [`gather`], but returns the files that could be read even if there are errors, and the errors among the warnings.
#[must_use]
pub fn survey(paths: &[PathBuf], ignore: &Ignore) -> Gathered {
    let named = paths.iter().filter_map(|path| fs::canonicalize(path).ok()).collect();
    let mut gathering =
        Gathering { ignore, named, inputs: Vec::new(), seen: BTreeSet::new(), found: Vec::new() };
    for path in paths {
        if path.is_dir() && !is_stdin(path) {
            gathering.directory(path);
        } else if !is_stdin(path) && ignore.matches(path, None) {
            gathering.left_out(path, "excluded by --ignore");
        } else if let Some(bytes) = gathering.read(path) {
            gathering.inputs.push(Input { name: name(path), bytes });
        }
    }
    let Gathering { inputs, mut found, .. } = gathering;
    found.extend(same_content_warnings(&inputs));
    found.extend(ignore.unused().map(|pattern| {
        let message = format!("--ignore {pattern} matches no file");
        let help = "a pattern without / is compared with file names; a pattern with / is compared with paths below the named directory";
        Diagnostic::file(Code::UnusedIgnore, "", message, help).warning()
    }));
    let failed = found.iter().any(|fault| fault.severity == Severity::Error);
    if inputs.is_empty() && !failed && !paths.is_empty() {
        let message = "--ignore excludes every file that was named";
        found.push(Diagnostic::file(Code::NoProgram, "", message, "remove a pattern"));
    }
    Gathered { inputs, warnings: found }
}

/// Reads one program or one file of measurements, or standard input.
///
/// # Errors
/// The file cannot be read, or is larger than 4 GiB.
pub fn read_one(path: &Path) -> io::Result<Input> {
    Ok(Input { name: name(path), bytes: whole(path, MAX_MEASUREMENT_FILE)? })
}

/// Reads a small file that is not a program, such as facts, a timing table or a calibration plan, or standard input.
///
/// # Errors
/// The file cannot be read, is not a regular file, or is larger than 64 MiB.
pub fn read_small(path: &Path) -> io::Result<Vec<u8>> {
    whole(path, MAX_OTHER_FILE)
}

/// The size limit of a file of measurements, in bytes.
const MAX_MEASUREMENT_FILE: u64 = 4 << 30;
/// The largest file of facts, tables, plans and nets, in bytes.
const MAX_OTHER_FILE: u64 = 64 << 20;

/// Reads a file of at most `most` bytes.
fn whole(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let bytes = bytes(path, most + 1)?;
    match bytes.len() as u64 > most {
        true => Err(io::Error::other(format!("the file is larger than {} MiB", most >> 20))),
        false => Ok(bytes),
    }
}

/// One warning for each program whose content equals that of an earlier one.
fn same_content_warnings(inputs: &[Input]) -> Vec<Diagnostic> {
    let mut seen: BTreeMap<&[u8], &Input> = BTreeMap::new();
    let mut found = Vec::new();
    for input in inputs.iter().filter(|input| !input.bytes.is_empty()) {
        match seen.get(&*input.bytes) {
            Some(first) if !matches!(detect(input), Ok(FileKind::Comments)) => {
                let message = format!(
                    "this file has the same content as {}: the bound includes both",
                    first.name
                );
                let help = format!(
                    "if the PLC runs the program only once, give only one of the two files, {}",
                    leave_out(&base(&input.name))
                );
                found.push(
                    Diagnostic::file(Code::SameContent, &input.name, message, help).warning(),
                );
            }
            Some(_) => {}
            None => {
                seen.insert(&input.bytes, input);
            }
        }
    }
    found
}

/// A file name without its directory.
fn base(name: &str) -> String {
    name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned()
}

fn is_stdin(path: &Path) -> bool {
    path == Path::new(STDIN)
}

struct Gathering<'a> {
    ignore: &'a Ignore,
    /// All named paths, in canonical form. A subdirectory or file that is itself named is not searched or reported as a
    /// part of another directory.
    named: BTreeSet<PathBuf>,
    inputs: Vec<Input>,
    seen: BTreeSet<PathBuf>,
    found: Vec<Diagnostic>,
}

/// The names of the files of one directory, by what was done with them: for the warning about files that were left out
/// and the warning about the order of programs.
#[derive(Default)]
struct Listing {
    programs: Vec<String>,
    comments: Vec<String>,
    plain: Vec<String>,
    ignored: Vec<String>,
}

impl Gathering<'_> {
    /// Reads a program or comment file. Reports an error and returns `None` if it cannot be read, is too large or was
    /// read before.
    fn read(&mut self, path: &Path) -> Option<Vec<u8>> {
        let bytes = match bytes(path, LARGEST + 1) {
            Ok(bytes) if bytes.len() as u64 > LARGEST => {
                self.found.push(Diagnostic::file(
                    Code::TooLarge,
                    &name(path),
                    format!("the file is larger than {} MiB", LARGEST >> 20),
                    "check the path: no program is so large",
                ));
                return None;
            }
            Ok(bytes) => bytes,
            Err(error) => {
                self.unreadable(path, &error);
                return None;
            }
        };
        let identity = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if !self.seen.insert(identity) {
            self.found.push(Diagnostic::file(
                Code::NamedTwice,
                &name(path),
                "this file is given twice",
                "give each file once: otherwise its program runs twice in the scan",
            ));
            return None;
        }
        Some(bytes)
    }

    fn unreadable(&mut self, path: &Path, error: &io::Error) {
        self.found.push(Diagnostic::file(
            Code::Unreadable,
            &name(path),
            format!("cannot be read: {error}"),
            "check the path and its permissions",
        ));
    }

    fn left_out(&mut self, path: &Path, why: &str) {
        let help = "remove the pattern if the file is part of the scan: the bound does not include this file";
        self.found.push(Diagnostic::file(Code::LeftOut, &name(path), why, help).warning());
    }

    fn directory(&mut self, directory: &Path) {
        let entries = match entries(directory) {
            Ok(entries) => entries,
            Err(error) => return self.unreadable(directory, &error),
        };
        let before = self.found.len();
        let mut listing = Listing::default();
        for path in entries {
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if self.ignore.matches(&path, Some(directory)) {
                listing.ignored.push(file);
            } else if path.is_dir() {
                self.within(&path, directory, file, &mut listing);
            } else {
                self.entry(&path, file, &mut listing);
            }
        }
        let failed = self.found[before..].iter().any(|fault| fault.severity == Severity::Error);
        self.found.extend(listing.note(directory));
        match &listing.programs[..] {
            [] if failed => {}
            [] => self.found.push(Diagnostic::file(
                Code::NoProgram,
                &name(directory),
                "this directory contains no program",
                "export the programs to this directory, or give the files instead",
            )),
            [_] => {}
            programs => self.found.push(
                Diagnostic::file(
                    Code::NameOrder,
                    &name(directory),
                    format!(
                        "the bound assumes that the programs run in the order of their file names: {}",
                        in_short(programs)
                    ),
                    "if the PLC runs the programs in a different order, give the files in that order",
                )
                .warning(),
            ),
        }
    }

    /// Handles a file of a directory: reads it, reports it as an error, or lists it as not a program.
    fn entry(&mut self, path: &Path, file: String, listing: &mut Listing) {
        match classify(path) {
            Err(error) => self.unreadable(path, &error),
            Ok(FileClass::Program | FileClass::Comments) if plain::is_named(path) => {
                let help =
                    format!("give the file itself if it is part of the scan, {}", leave_out(&file));
                let message = "the name of this file is not that of a program file, but its content looks like a program";
                self.found.push(Diagnostic::file(Code::OddName, &name(path), message, help));
            }
            Ok(FileClass::Program) => {
                if let Some(bytes) = self.read(path) {
                    self.inputs.push(Input { name: name(path), bytes });
                    listing.programs.push(file);
                }
            }
            Ok(FileClass::Comments) => {
                if let Some(bytes) = self.read(path) {
                    self.inputs.push(Input { name: name(path), bytes });
                    listing.comments.push(file);
                }
            }
            Ok(FileClass::Plain) => listing.plain.push(file),
            Ok(FileClass::Unreadable(mut fault)) => {
                fault.help = match fault.code {
                    Code::UnknownDialect => "if the file is a program, export it again".to_owned(),
                    _ => fault.help,
                };
                fault.help = format!("{}, {}", fault.help, leave_out(&file));
                self.found.push(fault);
            }
        }
    }

    /// Handles a subdirectory. Its programs are not read, because their place in the order of programs is unknown: a
    /// file in it that may be a program is an error.
    fn within(&mut self, path: &Path, directory: &Path, file: String, listing: &mut Listing) {
        let mut visited = BTreeSet::new();
        let mut looker = ProgramSearch { gathering: self, root: directory, visited: &mut visited };
        match looker.first(path, DEPTH) {
            Err((at, error)) => self.unreadable(&at, &error),
            Ok(None) => {
                let own = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
                if !self.named.iter().any(|named| named.starts_with(&own)) {
                    listing.plain.push(format!("{file}/"));
                }
            }
            Ok(Some(first)) => {
                let message = format!(
                    "this directory is not read, but {} in it may be a program",
                    name(first.strip_prefix(path).unwrap_or(&first))
                );
                let help = format!(
                    "if the programs in the directory are part of the scan, give the directory too, at the place where its programs run, {}",
                    leave_out(&file)
                );
                self.found.push(Diagnostic::file(
                    Code::NestedDirectory,
                    &name(path),
                    message,
                    help,
                ));
            }
        }
    }
}

/// Searches subdirectories for a file that may be a program.
struct ProgramSearch<'a, 'g> {
    gathering: &'a Gathering<'g>,
    root: &'a Path,
    /// The directories that were searched, so that circular links end the search.
    visited: &'a mut BTreeSet<PathBuf>,
}

impl ProgramSearch<'_, '_> {
    /// The first file in a directory, or at most `depth` levels below it, that may be a program and is not named
    /// itself. A directory that is deeper counts as such a file. Hidden directories, and what `--ignore` excludes, are
    /// skipped. `None` if there is none.
    fn first(
        &mut self,
        directory: &Path,
        depth: usize,
    ) -> Result<Option<PathBuf>, (PathBuf, io::Error)> {
        let at = |error| (directory.to_owned(), error);
        let identity = fs::canonicalize(directory).map_err(at)?;
        if self.gathering.named.contains(&identity) || !self.visited.insert(identity) {
            return Ok(None);
        }
        for path in entries(directory).map_err(at)? {
            let hidden =
                path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
            if self.gathering.ignore.matches(&path, Some(self.root)) {
                continue;
            }
            if path.is_dir() {
                if hidden {
                    continue;
                }
                if depth == 0 {
                    return Ok(Some(path));
                }
                if let Some(found) = self.first(&path, depth - 1)? {
                    return Ok(Some(found));
                }
                continue;
            }
            let named =
                fs::canonicalize(&path).is_ok_and(|path| self.gathering.named.contains(&path));
            match classify(&path).map_err(|error| (path.clone(), error))? {
                FileClass::Program | FileClass::Unreadable(_) if !named => return Ok(Some(path)),
                _ => {}
            }
        }
        Ok(None)
    }
}

impl Listing {
    /// One warning that lists the files of a directory that are not programs. `None` if no file was left out or
    /// ignored.
    fn note(&self, directory: &Path) -> Option<Diagnostic> {
        let parts: Vec<String> = [
            (&self.plain, "left out because they are not programs"),
            (&self.ignored, "excluded by --ignore"),
            (&self.comments, "device comments"),
        ]
        .into_iter()
        .filter(|(files, _)| !files.is_empty())
        .map(|(files, what)| format!("{what}: {}", first_names(files)))
        .collect();
        let (message, help) =
            (parts.join("; "), "give the path of a file if the file is part of the scan");
        (self.plain.len() + self.ignored.len() > 0)
            .then(|| Diagnostic::file(Code::LeftOut, &name(directory), message, help).warning())
    }
}

/// What a file of a directory contains.
enum FileClass {
    Program,
    Comments,
    /// The content is clearly not a program.
    Plain,
    /// Possibly a program, but one that cannot be read.
    Unreadable(Diagnostic),
}

/// Recognises a file by its name and its beginning.
fn classify(path: &Path) -> io::Result<FileClass> {
    if !fs::metadata(path)?.is_file() {
        // Opening a pipe would block.
        return Ok(FileClass::Plain);
    }
    let input = Input { name: name(path), bytes: bytes(path, BEGINNING as u64)? };
    Ok(match detect(&input) {
        Ok(FileKind::Program(_)) => FileClass::Program,
        Ok(FileKind::Comments) => FileClass::Comments,
        Err(_) if plain::is_named(path) || plain::is_content(&input.bytes) => FileClass::Plain,
        Err(fault) => FileClass::Unreadable(fault),
    })
}

fn entries(directory: &Path) -> io::Result<Vec<PathBuf>> {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(directory)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    entries.sort();
    Ok(entries)
}

fn leave_out(file: &str) -> String {
    format!("or exclude it with --ignore '{}'", ignore::escaped(file))
}

fn first_names(names: &[String]) -> String {
    match names.len().checked_sub(LISTED) {
        None | Some(0) => names.join(", "),
        Some(more) => format!("{}, and {more} more", names[..LISTED].join(", ")),
    }
}

fn name(path: &Path) -> String {
    if is_stdin(path) {
        return "stdin".to_owned();
    }
    path.to_string_lossy().into_owned()
}

/// The first bytes of a file or of standard input, at most `most`. A pipe or a device is an error.
fn bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    if is_stdin(path) {
        io::stdin().take(most).read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    let kind = fs::metadata(path)?.file_type();
    if !kind.is_file() && !kind.is_dir() {
        // Opening a pipe would block, and a device may never end.
        let text =
            "give a file, or - for stdin in place of a program: this path is a pipe or a device";
        return Err(io::Error::other(text));
    }
    File::open(path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The largest number of file names that a message about the order shows.
const MAX_NAMED: usize = 6;

/// The names of files for a message; of many files only the first names.
fn in_short(names: &[String]) -> String {
    let mut text = names[..names.len().min(MAX_NAMED)].join(", ");
    if names.len() > MAX_NAMED {
        text += &format!(" and {} more", names.len() - MAX_NAMED);
    }
    text
}

#[cfg(test)]
mod tests;
