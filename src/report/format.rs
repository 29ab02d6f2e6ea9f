//! What a format of reports is: its name, and what writes each kind of result in it.

use crate::audit::Audit;
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
    /// Writes an audit, and the check's result if there is one. A large one is written piece by piece.
    ///
    /// # Errors
    /// Where what is written to takes no more.
    pub audit: fn(&Audit, Option<&Check>, Extent, &mut dyn Write) -> io::Result<()>,
    /// Writes a comparison, with the same errors.
    pub compare: fn(&Comparison, &mut dyn Write) -> io::Result<()>,
}

/// How much is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Groups, and rungs a group.
    pub top: usize,
    /// Values of the scan a line, assumed times, kinds of approximations.
    pub values: usize,
}

impl Default for Extent {
    fn default() -> Self {
        Extent { top: 10, values: 12 }
    }
}
