//! What a format of reports is: its name, and what writes each kind of result in it.

use scanbound_audit::Audit;
use scanbound_audit::breakdown::By;
use scanbound_audit::difference::Difference;
use scanbound_audit::verdict::Check;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_measured::Comparison;
use std::io::{self, Write};

/// A format: its name, and what writes each kind of result in it.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// Its name, as `--format` takes it.
    pub name: &'static str,
    /// What it is for, a few words.
    pub about: &'static str,
    /// Ends of file names, without the dot, that mean it.
    pub suffixes: &'static [&'static str],
    /// Whether it draws the project's rungs ([`Audit::ladder`]).
    pub draws: bool,
    /// Whether it writes control characters of names and comments as something else, so that none has to be taken out.
    pub escapes: bool,
    /// Writes an audit, and the check's result if there is one. A large one is written piece by piece.
    ///
    /// # Errors
    /// Where what is written to takes no more.
    pub audit: fn(&Audit, Option<&Check>, Extent, &mut dyn Write) -> io::Result<()>,
    /// Writes a comparison, with the same errors.
    pub compare: fn(&Comparison, &mut dyn Write) -> io::Result<()>,
    /// Writes what two versions differ in, with the same errors.
    pub diff: fn(&Difference, Extent, &mut dyn Write) -> io::Result<()>,
    /// Begins one document of several projects' checks.
    pub checks: fn() -> Box<dyn Checks>,
    /// Whether such a document is written, too, of a single project that cannot be read.
    pub tells_faults: bool,
}

/// One document of several projects' checks. What can be written at once need not be kept until the last.
pub trait Checks {
    /// Adds a project.
    ///
    /// # Errors
    /// Where what is written to takes no more.
    fn add(&mut self, project: &Project<'_>, extent: Extent, out: &mut dyn Write)
    -> io::Result<()>;

    /// Ends the document, with the same errors.
    ///
    /// # Errors
    /// Where what is written to takes no more.
    fn end(&mut self, out: &mut dyn Write) -> io::Result<()>;
}

/// A project that was checked.
pub struct Project<'a> {
    /// The file that tells it from others.
    pub file: &'a str,
    /// The check's exit code.
    pub exit_code: u8,
    /// What became of it.
    pub checked: Checked<'a>,
}

/// What became of a project's check.
pub enum Checked<'a> {
    /// It was audited.
    Audited(&'a Audit, &'a Check),
    /// It was not, for these faults.
    Faulty(&'a [Diagnostic]),
    /// It was not, for what this says.
    Failed(String),
}

/// Reports one behind the other, each headed by its project.
pub(super) struct InARow {
    pub(super) heading: fn(&str) -> String,
    /// What is told of a project that was not audited.
    pub(super) fault: fn(&str) -> String,
    pub(super) audit: fn(&Audit, Option<&Check>, Extent, &mut dyn Write) -> io::Result<()>,
}

impl Checks for InARow {
    fn add(
        &mut self,
        project: &Project<'_>,
        extent: Extent,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        out.write_all((self.heading)(project.file).as_bytes())?;
        match &project.checked {
            Checked::Audited(audit, check) => (self.audit)(audit, Some(check), extent, out)?,
            Checked::Faulty(faults) => {
                for fault in *faults {
                    out.write_all((self.fault)(&fault.brief()).as_bytes())?;
                }
            }
            Checked::Failed(why) => out.write_all((self.fault)(why).as_bytes())?,
        }
        out.write_all(b"\n")
    }

    fn end(&mut self, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }
}

/// How much of a report is shown to people.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// What fits on a screen: the answer, what it rests on, where the time goes, what to do.
    Short,
    /// Each section, the weightiest entries of it.
    Usual,
    /// All that there is.
    Full,
}

/// How much is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Groups, and rungs a group; rungs of the whole.
    pub top: usize,
    /// Entries of a list.
    pub values: usize,
    /// How much of all else.
    pub detail: Detail,
    /// What the bound is shared out to, if that is asked for.
    pub by: Option<By>,
    /// The columns of the page.
    pub width: usize,
    /// Its lines.
    pub height: usize,
}

impl Default for Extent {
    fn default() -> Self {
        Extent { top: 10, values: 12, detail: Detail::Usual, by: None, width: 80, height: 24 }
    }
}
