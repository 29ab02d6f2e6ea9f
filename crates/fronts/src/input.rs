//! Reads the files and directories that the user names, for programs that hand them to the library.
//!
//! A program that drops out of a scan makes its bound too low. So what is named is read or is an error, and so is
//! what lies in a named directory, unless a pattern leaves it out or it is plainly no program (`plain`).

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
use scanbound_front::{BEGINNING, Input, Kind};

/// Larger files are refused: the largest programs have a million steps, about a third of this.
const LARGEST: u64 = 256 << 20;
/// What stands for stdin among the paths that a user names.
pub const STDIN: &str = "-";
/// Most names that one message lists.
const LISTED: usize = 20;
/// How deep directories are looked through for programs that nobody named.
const DEPTH: usize = 8;

/// What was read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Gathered {
    /// The files, in the order in which they were named; a directory's in the order of their names.
    pub inputs: Vec<Input>,
    /// What was left out, and why; which order was taken.
    pub warnings: Vec<Diagnostic>,
}

/// Reads files, and of directories all that may be a program or holds device comments.
///
/// # Errors
/// Every path that cannot be read, that is named twice, or that is a directory without a program; every file of a
/// directory that may be a program and cannot be read as one; and what was noticed besides.
pub fn gather(paths: &[PathBuf], ignore: &Ignore) -> Result<Gathered, Vec<Diagnostic>> {
    let gathered = survey(paths, ignore);
    match gathered.warnings.iter().any(|fault| fault.severity == Severity::Error) {
        true => Err(gathered.warnings),
        false => Ok(gathered),
    }
}

/// The same where what cannot be read does not keep the rest from being looked at: faults stand among the warnings.
#[must_use]
pub fn survey(paths: &[PathBuf], ignore: &Ignore) -> Gathered {
    let named = paths.iter().filter_map(|path| fs::canonicalize(path).ok()).collect();
    let mut gathering =
        Gathering { ignore, named, inputs: Vec::new(), seen: BTreeSet::new(), found: Vec::new() };
    for path in paths {
        if path.is_dir() && !is_stdin(path) {
            gathering.directory(path);
        } else if !is_stdin(path) && ignore.matches(path, None) {
            gathering.left_out(path, "left out by --ignore");
        } else if let Some(bytes) = gathering.read(path) {
            gathering.inputs.push(Input { name: name(path), bytes });
        }
    }
    let Gathering { inputs, mut found, .. } = gathering;
    found.extend(copies(&inputs));
    found.extend(ignore.unused().map(|pattern| {
        let message = format!("--ignore {pattern} leaves nothing out");
        let help = "a pattern without / is held against file names, one with / against paths from the directory that is named";
        Diagnostic::file(Code::UnusedIgnore, "", message, help).warning()
    }));
    let failed = found.iter().any(|fault| fault.severity == Severity::Error);
    if inputs.is_empty() && !failed && !paths.is_empty() {
        let message = "every file that was named is left out by --ignore";
        found.push(Diagnostic::file(Code::NoProgram, "", message, "take a pattern away"));
    }
    Gathered { inputs, warnings: found }
}

/// Reads one file of measurements or of one program, or stdin.
///
/// # Errors
/// Why it cannot be read.
pub fn one(path: &Path) -> io::Result<Input> {
    Ok(Input { name: name(path), bytes: whole(path, MOST_MEASURED)? })
}

/// Reads a whole file that is not a program: facts, a table, a plan.
///
/// # Errors
/// Why it cannot be read: among others, that it is no regular file, or larger than any such file.
pub fn aside(path: &Path) -> io::Result<Vec<u8>> {
    whole(path, MOST_ASIDE)
}

/// Files of measurements are no larger.
const MOST_MEASURED: u64 = 4 << 30;
/// Facts, tables, plans and nets are no larger.
const MOST_ASIDE: u64 = 64 << 20;

/// A file, if it has no more bytes.
fn whole(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let bytes = bytes(path, most + 1)?;
    match bytes.len() as u64 > most {
        true => Err(io::Error::other(format!("it is larger than {} MiB", most >> 20))),
        false => Ok(bytes),
    }
}

/// Warns of programs that are the same as one before them.
fn copies(inputs: &[Input]) -> Vec<Diagnostic> {
    let mut seen: BTreeMap<&[u8], &Input> = BTreeMap::new();
    let mut found = Vec::new();
    for input in inputs.iter().filter(|input| !input.bytes.is_empty()) {
        match seen.get(&*input.bytes) {
            Some(first) if !matches!(detect(input), Ok(Kind::Comments)) => {
                let message =
                    format!("this file holds the same as {}: both are in the bound", first.name);
                let help = format!(
                    "leave one of them out if the PLC runs it once, {}",
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

/// A name without its directories.
fn base(name: &str) -> String {
    name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned()
}

fn is_stdin(path: &Path) -> bool {
    path == Path::new(STDIN)
}

struct Gathering<'a> {
    ignore: &'a Ignore,
    /// What the user names, so that a directory within another is known to be read by itself.
    named: BTreeSet<PathBuf>,
    inputs: Vec<Input>,
    seen: BTreeSet<PathBuf>,
    found: Vec<Diagnostic>,
}

/// What one warning says of all of a directory's files.
#[derive(Default)]
struct Listing {
    programs: Vec<String>,
    comments: Vec<String>,
    plain: Vec<String>,
    ignored: Vec<String>,
}

impl Gathering<'_> {
    /// A file's bytes, unless it cannot be read or was read before.
    fn read(&mut self, path: &Path) -> Option<Vec<u8>> {
        let bytes = match bytes(path, LARGEST + 1) {
            Ok(bytes) if bytes.len() as u64 > LARGEST => {
                self.found.push(Diagnostic::file(
                    Code::TooLarge,
                    &name(path),
                    format!("the file is larger than {} MiB", LARGEST >> 20),
                    "no program is that large: check the path",
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
                "this file is named twice",
                "name each file once: it would run twice in a scan",
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
        let help = "it is not in the bound: take the pattern away if it belongs to the scan";
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
                "there is no program in this directory",
                "export the programs to it, or name the files themselves",
            )),
            [_] => {}
            programs => self.found.push(
                Diagnostic::file(
                    Code::NameOrder,
                    &name(directory),
                    format!(
                        "the programs are taken to run in the order of their names: {}",
                        in_short(programs)
                    ),
                    "name the files themselves, in the order in which the PLC runs them, if it is another",
                )
                .warning(),
            ),
        }
    }

    /// A file of a directory: read, refused, or listed as no program.
    fn entry(&mut self, path: &Path, file: String, listing: &mut Listing) {
        match what(path) {
            Err(error) => self.unreadable(path, &error),
            Ok(What::Program | What::Comments) if plain::is_named(path) => {
                let help =
                    format!("name it itself if it belongs to the scan, {}", leave_out(&file));
                let message = "its name is not a program's, but it reads like one";
                self.found.push(Diagnostic::file(Code::OddName, &name(path), message, help));
            }
            Ok(What::Program) => {
                if let Some(bytes) = self.read(path) {
                    self.inputs.push(Input { name: name(path), bytes });
                    listing.programs.push(file);
                }
            }
            Ok(What::Comments) => {
                if let Some(bytes) = self.read(path) {
                    self.inputs.push(Input { name: name(path), bytes });
                    listing.comments.push(file);
                }
            }
            Ok(What::Plain) => listing.plain.push(file),
            Ok(What::Unreadable(mut fault)) => {
                fault.help = match fault.code {
                    Code::UnknownDialect => "export the program again if it is one".to_owned(),
                    _ => fault.help,
                };
                fault.help = format!("{}, {}", fault.help, leave_out(&file));
                self.found.push(fault);
            }
        }
    }

    /// A directory within a directory: its programs have no place in the order.
    fn within(&mut self, path: &Path, directory: &Path, file: String, listing: &mut Listing) {
        let mut visited = BTreeSet::new();
        let mut looker = Looker { gathering: self, root: directory, visited: &mut visited };
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
                    "this directory is not read, and {} in it may be a program",
                    name(first.strip_prefix(path).unwrap_or(&first))
                );
                let help = format!(
                    "name it as well, where its programs run, if it belongs to the scan, {}",
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

/// Looks through directories for what may be a program.
struct Looker<'a, 'g> {
    gathering: &'a Gathering<'g>,
    root: &'a Path,
    /// What was looked through, so that links in a circle end.
    visited: &'a mut BTreeSet<PathBuf>,
}

impl Looker<'_, '_> {
    /// The first file in a directory that nobody named and that may be a program.
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
            match what(&path).map_err(|error| (path.clone(), error))? {
                What::Program | What::Unreadable(_) if !named => return Ok(Some(path)),
                _ => {}
            }
        }
        Ok(None)
    }
}

impl Listing {
    /// The one warning on the files that are no programs.
    fn note(&self, directory: &Path) -> Option<Diagnostic> {
        let parts: Vec<String> = [
            (&self.plain, "no programs and left out"),
            (&self.ignored, "left out by --ignore"),
            (&self.comments, "device comments"),
        ]
        .into_iter()
        .filter(|(files, _)| !files.is_empty())
        .map(|(files, what)| format!("{what}: {}", few(files)))
        .collect();
        let (message, help) = (parts.join("; "), "name a file itself if it belongs to the scan");
        (self.plain.len() + self.ignored.len() > 0)
            .then(|| Diagnostic::file(Code::LeftOut, &name(directory), message, help).warning())
    }
}

/// What a file of a directory is.
enum What {
    Program,
    Comments,
    /// Plainly no program.
    Plain,
    /// It may be a program, but not one that can be read.
    Unreadable(Diagnostic),
}

/// What a file is, from its name and its beginning.
fn what(path: &Path) -> io::Result<What> {
    if !fs::metadata(path)?.is_file() {
        // A pipe would keep its reader waiting.
        return Ok(What::Plain);
    }
    let input = Input { name: name(path), bytes: bytes(path, BEGINNING as u64)? };
    Ok(match detect(&input) {
        Ok(Kind::Program(_)) => What::Program,
        Ok(Kind::Comments) => What::Comments,
        Err(_) if plain::is_named(path) || plain::is_content(&input.bytes) => What::Plain,
        Err(fault) => What::Unreadable(fault),
    })
}

fn entries(directory: &Path) -> io::Result<Vec<PathBuf>> {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(directory)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    entries.sort();
    Ok(entries)
}

fn leave_out(file: &str) -> String {
    format!("or leave it out with --ignore '{}'", ignore::escaped(file))
}

fn few(names: &[String]) -> String {
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

/// At most so many bytes of a file.
fn bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    if is_stdin(path) {
        io::stdin().take(most).read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    let kind = fs::metadata(path)?.file_type();
    if !kind.is_file() && !kind.is_dir() {
        // A pipe would keep its reader waiting, a device may have no end.
        let told = "it is a pipe or a device, no file: give a file, or - for stdin where programs are named";
        return Err(io::Error::other(told));
    }
    File::open(path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// So many names tell an order.
const MOST_NAMED: usize = 6;

/// The names, of many the first.
fn in_short(names: &[String]) -> String {
    let mut told = names[..names.len().min(MOST_NAMED)].join(", ");
    if names.len() > MOST_NAMED {
        told += &format!(" and {} more", names.len() - MOST_NAMED);
    }
    told
}

#[cfg(test)]
mod tests;
