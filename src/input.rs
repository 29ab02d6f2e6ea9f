//! Reads the files and directories that the user names, for programs that hand them to the library.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::diagnostic::{Diagnostic, Severity};
use crate::dialect::{BEGINNING, Input, Kind, detect};

/// Larger files are refused: the largest programs have a million steps, about a third of this.
const LARGEST: u64 = 256 << 20;

/// What was read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Gathered {
    /// The files, in the order in which they were named; a directory's in the order of their names.
    pub inputs: Vec<Input>,
    /// What was left out, and why; which order was taken.
    pub warnings: Vec<Diagnostic>,
}

/// Reads files, and of directories those that hold programs or device comments.
///
/// # Errors
/// Every path that cannot be read, that is named twice, or that is a directory without a program; and what
/// was noticed besides.
pub fn gather(paths: &[PathBuf]) -> Result<Gathered, Vec<Diagnostic>> {
    let mut gathering = Gathering::default();
    for path in paths {
        if path.is_dir() {
            gathering.directory(path);
        } else if let Some(bytes) = gathering.read(path) {
            gathering.inputs.push(Input { name: name(path), bytes });
        }
    }
    let Gathering { inputs, found, .. } = gathering;
    if found.iter().any(|fault| fault.severity == Severity::Error) {
        return Err(found);
    }
    Ok(Gathered { inputs, warnings: found })
}

#[derive(Default)]
struct Gathering {
    inputs: Vec<Input>,
    seen: BTreeSet<PathBuf>,
    found: Vec<Diagnostic>,
}

impl Gathering {
    /// A file's bytes, unless it cannot be read or was read before.
    fn read(&mut self, path: &Path) -> Option<Vec<u8>> {
        let bytes = match bytes(path, LARGEST + 1) {
            Ok(bytes) if bytes.len() as u64 > LARGEST => {
                self.found.push(Diagnostic::file(
                    "too-large",
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
                "named-twice",
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
            "unreadable",
            &name(path),
            format!("cannot be read: {error}"),
            "check the path and its permissions",
        ));
    }

    fn directory(&mut self, directory: &Path) {
        let entries: io::Result<Vec<PathBuf>> =
            fs::read_dir(directory).and_then(|all| all.map(|entry| Ok(entry?.path())).collect());
        let mut entries = match entries {
            Ok(entries) => entries,
            Err(error) => return self.unreadable(directory, &error),
        };
        entries.sort();
        let mut programs = Vec::new();
        let before = self.found.len();
        for path in entries {
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if file.starts_with('.') {
                continue;
            }
            if path.is_dir() {
                self.ignored(&path, "it is a directory");
            } else if let Some(kind) = self.kind(&path)
                && let Some(bytes) = self.read(&path)
            {
                self.inputs.push(Input { name: name(&path), bytes });
                if matches!(kind, Kind::Program(_)) {
                    programs.push(file);
                }
            }
        }
        let failed = self.found[before..].iter().any(|fault| fault.severity == Severity::Error);
        match &programs[..] {
            [] if failed => {}
            [] => self.found.push(Diagnostic::file(
                "no-program",
                &name(directory),
                "there is no program in this directory",
                "export the programs to it, or name the files themselves",
            )),
            [_] => {}
            [..] => self.found.push(
                Diagnostic::file(
                    "name-order",
                    &name(directory),
                    format!("the programs are taken to run in the order of their names: {}", programs.join(", ")),
                    "name the files themselves, in the order in which the PLC runs them, if it is another",
                )
                .warning(),
            ),
        }
    }

    /// What a file of a directory is, from its beginning; `None`, and a diagnostic, if it is left out.
    fn kind(&mut self, path: &Path) -> Option<Kind> {
        let bytes = match bytes(path, BEGINNING as u64) {
            Ok(bytes) => bytes,
            Err(error) => {
                self.unreadable(path, &error);
                return None;
            }
        };
        match detect(&Input { name: name(path), bytes }) {
            Ok(kind) => Some(kind),
            // A damaged export must not drop out of the scan unnoticed.
            Err(fault) if fault.code != "unknown-dialect" && is_export(path) => {
                self.found.push(fault);
                None
            }
            Err(fault) => {
                self.ignored(path, &fault.message);
                None
            }
        }
    }

    fn ignored(&mut self, path: &Path, why: &str) {
        let fault = Diagnostic::file(
            "ignored",
            &name(path),
            format!("left out: {why}"),
            "name it itself if it belongs to the scan",
        );
        self.found.push(fault.warning());
    }
}

/// Whether a file is named as programs are exported.
fn is_export(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

fn name(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// At most so many bytes of a file.
fn bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CSV: &str = "a\nPLC Information:,Q26UDV\nStep No.,Line Statement,Instruction,I/O(Device),Blank,PI Statement,Note\n0,,END,,,,\n";

    /// A directory of these files, taken away again.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str, files: &[(&str, &[u8])]) -> Self {
            let path =
                std::env::temp_dir().join(format!("scanbound-{}-{name}", std::process::id()));
            fs::create_dir_all(path.join("sub")).unwrap();
            for (name, bytes) in files {
                fs::write(path.join(name), bytes).unwrap();
            }
            Scratch(path)
        }

        fn gather(&self) -> Result<Gathered, Vec<Diagnostic>> {
            gather(std::slice::from_ref(&self.0))
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn told(found: &[Diagnostic]) -> Vec<(&str, String)> {
        let file = |d: &Diagnostic| name(Path::new(Path::new(&d.file).file_name().unwrap()));
        found.iter().map(|d| (d.code, file(d))).collect()
    }

    #[test]
    fn a_directory_is_its_programs_in_name_order_and_its_comments() {
        let scratch = Scratch::new(
            "order",
            &[
                ("b.csv", CSV.as_bytes()),
                ("a.csv", CSV.as_bytes()),
                ("COMMENT.csv", b"Device Name,Comment\nX0,start\n"),
                ("labels.csv", b"Class,Label Name\nVAR,a\n"),
                ("notes.txt", b"call the customer"),
                ("empty.log", b""),
                (".hidden", b"LD X0\nEND\n"),
            ],
        );
        let gathered = scratch.gather().unwrap();
        let names: Vec<_> =
            gathered.inputs.iter().map(|input| input.name.rsplit('/').next().unwrap()).collect();
        assert_eq!(names, ["COMMENT.csv", "a.csv", "b.csv"]);
        let warnings = told(&gathered.warnings);
        let codes: Vec<_> = warnings.iter().map(|(code, file)| (*code, file.as_str())).collect();
        let directory = name(Path::new(scratch.0.file_name().unwrap()));
        assert_eq!(
            codes,
            [
                ("ignored", "empty.log"),
                ("ignored", "labels.csv"),
                ("ignored", "notes.txt"),
                ("ignored", "sub"),
                ("name-order", directory.as_str())
            ]
        );
        assert_eq!(gathered.inputs[1].bytes, CSV.as_bytes());
    }

    #[test]
    fn a_damaged_export_is_not_left_out() {
        let scratch = Scratch::new(
            "damaged",
            &[
                ("a.csv", CSV.as_bytes()),
                ("b.csv", b""),
                ("c.csv", b"a\xFF\xFF\xFFb\n"),
                ("d.CSV", b"\0\0\0\0"),
            ],
        );
        let found = scratch.gather().unwrap_err();
        let errors: Vec<_> =
            found.iter().filter(|d| d.severity == Severity::Error).cloned().collect();
        let errors = told(&errors);
        let errors: Vec<_> = errors.iter().map(|(code, file)| (*code, file.as_str())).collect();
        assert_eq!(
            errors,
            [("empty-file", "b.csv"), ("encoding", "c.csv"), ("binary-file", "d.CSV")]
        );
    }

    #[test]
    fn paths_that_give_nothing_or_the_same_twice() {
        let scratch = Scratch::new("twice", &[("a.csv", CSV.as_bytes())]);
        let a = scratch.0.join("a.csv");
        let found =
            gather(&[a.clone(), scratch.0.clone(), scratch.0.join("none"), scratch.0.join("sub")]);
        let codes: Vec<_> = found.unwrap_err().iter().map(|d| d.code).collect();
        assert_eq!(codes, ["named-twice", "ignored", "unreadable", "no-program"]);
        assert_eq!(gather(&[a]).unwrap().inputs.len(), 1);
    }
}
