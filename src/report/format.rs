//! What a format of reports is: its name, and what writes each kind of result in it.

use crate::audit::Audit;
use crate::audit::breakdown::By;
use crate::audit::difference::Difference;
use crate::audit::verdict::Check;
use crate::measured::Comparison;
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
    /// Writes an audit, and the check's result if there is one. A large one is written piece by piece.
    ///
    /// # Errors
    /// Where what is written to takes no more.
    pub audit: fn(&Audit, Option<&Check>, Extent, &mut dyn Write) -> io::Result<()>,
    /// Writes a comparison, with the same errors.
    pub compare: fn(&Comparison, &mut dyn Write) -> io::Result<()>,
    /// Writes what two versions differ in, with the same errors.
    pub diff: fn(&Difference, Extent, &mut dyn Write) -> io::Result<()>,
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
