//! All fronts in one list, and the reading of the files and directories that a user names.

pub mod input;

use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{Fronts, Input, Kind, Project, Reading};

/// All fronts. A new front is a crate and its line here.
pub static FRONTS: Fronts = Fronts(&[
    &scanbound_front_melsec::FRONT,
    &scanbound_front_minasec::FRONT,
    &scanbound_front_omron::FRONT,
    &scanbound_front_flowchart::FRONT,
    &scanbound_front_iec::FRONT,
]);

/// What a file is, as [`Fronts::detect`] finds it.
///
/// # Errors
/// As there.
pub fn detect(input: &Input) -> Result<Kind, Diagnostic> {
    FRONTS.detect(input)
}

/// Reads a project's files, as [`Fronts::read`] does.
///
/// # Errors
/// As there.
pub fn read(inputs: &[Input], dialect: Option<&str>) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
    FRONTS.read(inputs, dialect, Reading::default())
}
