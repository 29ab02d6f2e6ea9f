//! The list of all fronts, and the reading of the files and directories that a user names.

pub mod input;

use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{FileKind, Fronts, Input, Project, SourceOptions};

/// All fronts. A new front is a crate and a line here.
pub static FRONTS: Fronts = Fronts(&[
    &scanbound_front_melsec::FRONT,
    &scanbound_front_minasec::FRONT,
    &scanbound_front_omron::FRONT,
    &scanbound_front_flowchart::FRONT,
    &scanbound_front_iec::FRONT,
]);

/// Recognises, with [`Fronts::detect`] and all fronts, the dialect of a program or that a file holds device comments.
///
/// # Errors
/// As [`Fronts::detect`].
pub fn detect(input: &Input) -> Result<FileKind, Diagnostic> {
    FRONTS.detect(input)
}

/// Reads a project's files with [`Fronts::read`], all fronts and [`SourceOptions::default`], which refuses a comment
/// within a comment. If `dialect` is `None`, it is recognised by the content.
///
/// # Errors
/// As [`Fronts::read`].
pub fn read(inputs: &[Input], dialect: Option<&str>) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
    FRONTS.read(inputs, dialect, SourceOptions::default())
}

#[cfg(test)]
mod tests;
