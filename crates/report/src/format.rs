//! A format of reports: its name, and the functions that write each kind of result.

use scanbound_audit::Audit;
use scanbound_audit::breakdown::By;
use scanbound_audit::difference::Difference;
use scanbound_audit::verdict::Check;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_measured::Comparison;
use std::io::{self, Write};

/// A format of reports.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// The name of the format for `--format`.
    pub name: &'static str,
    /// The purpose of the format, in a few words.
    pub about: &'static str,
    /// The file name suffixes of the format, without the dot.
    pub suffixes: &'static [&'static str],
    /// Whether the format draws the project's rungs ([`Audit::ladder`]).
    pub draws: bool,
    /// Whether the format replaces control characters in names and comments, so that none has to be removed before.
    pub escapes: bool,
    /// Writes an audit, and the check's result if there is one. A large audit is written piece by piece.
    ///
    /// # Errors
    /// If writing fails.
    pub audit: fn(&Audit, Option<&Check>, Extent, &mut dyn Write) -> io::Result<()>,
    /// Writes a comparison. Errors as for `audit`.
    pub compare: fn(&Comparison, &mut dyn Write) -> io::Result<()>,
    /// Writes the difference of two versions. Errors as for `audit`.
    pub diff: fn(&Difference, Extent, &mut dyn Write) -> io::Result<()>,
    /// Begins one document with the checks of several projects.
    pub checks: fn() -> Box<dyn Checks>,
    /// Whether such a document is also written for a single project that cannot be read.
    pub tells_faults: bool,
}

/// One document with the checks of several projects. Each project is written as soon as possible.
pub trait Checks {
    /// Adds a project.
    ///
    /// # Errors
    /// If writing fails.
    fn add(&mut self, project: &Project<'_>, extent: Extent, out: &mut dyn Write)
    -> io::Result<()>;

    /// Ends the document.
    ///
    /// # Errors
    /// If writing fails.
    fn end(&mut self, out: &mut dyn Write) -> io::Result<()>;
}

/// A project that was checked.
pub struct Project<'a> {
    /// The file by which the project is named.
    pub file: &'a str,
    /// The check's exit code.
    pub exit_code: u8,
    /// The result of the check.
    pub checked: Checked<'a>,
}

/// The result of a project's check.
pub enum Checked<'a> {
    /// The project was audited.
    Audited(&'a Audit, &'a Check),
    /// The project has these errors.
    Faulty(&'a [Diagnostic]),
    /// The check failed for this reason.
    Failed(String),
}

/// Reports of several projects, one after another, each under a heading.
pub(super) struct InARow {
    pub(super) heading: fn(&str) -> String,
    /// The text about an error of a project that was not audited.
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
    /// What fits on a screen: the answer, the assumptions, where the time goes, what to do.
    Short,
    /// Each section with its most important entries.
    Usual,
    /// Everything.
    Full,
}

/// The width and the detail of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// The largest number of groups, of rungs in a group, and of rungs of the whole bound.
    pub top: usize,
    /// The largest number of entries of other lists.
    pub values: usize,
    /// How much of everything else is shown.
    pub detail: Detail,
    /// How the bound is divided into parts, if that is requested.
    pub by: Option<By>,
    /// The number of columns of the page.
    pub width: usize,
    /// The number of lines of the page.
    pub height: usize,
}

impl Default for Extent {
    fn default() -> Self {
        Extent { top: 10, values: 12, detail: Detail::Usual, by: None, width: 80, height: 24 }
    }
}
