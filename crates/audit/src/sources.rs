//! The files and the timing table of an audit, so that a later check can tell whether they are the same.

use super::request::Request;
use scanbound_base::checksum::sha256;
use scanbound_ir::Program;
use scanbound_timing::table::Table;

/// A file that the audit used: its name and checksum for the audit's record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// What the file is used for.
    pub what: SourceKind,
    /// The name of the file as the user gave it. For a built-in table: the name of the table.
    pub name: String,
    /// The date of the last change that a timing table states. `None` for other files.
    pub date: Option<String>,
    /// The SHA-256 of the file's bytes.
    pub sha256: String,
}

/// What an audit uses a file for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SourceKind {
    /// A file that contains a program.
    Program,
    /// Any other file of the project: names and comments of devices.
    Comments,
    /// The timing table.
    Table,
    /// The facts file.
    Facts,
}

impl SourceKind {
    /// The name of the kind in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            SourceKind::Program => "program",
            SourceKind::Comments => "comments",
            SourceKind::Table => "table",
            SourceKind::Facts => "facts",
        }
    }
}

/// The project's files, the timing table, and the facts file if there is one, in this order.
pub(super) fn sources(request: &Request<'_>, program: &Program, table: &Table) -> Vec<Source> {
    let inputs = request.inputs.iter().map(|input| Source {
        what: match program.files.iter().any(|file| file.name == input.name) {
            true => SourceKind::Program,
            false => SourceKind::Comments,
        },
        name: input.name.clone(),
        date: None,
        sha256: sha256(&input.bytes),
    });
    let table = Source {
        what: SourceKind::Table,
        name: table.name.clone(),
        date: table.date.clone(),
        sha256: table.sha256.clone(),
    };
    let facts = request.facts.read_from.iter().map(|(name, sha256)| Source {
        what: SourceKind::Facts,
        name: name.clone(),
        date: None,
        sha256: sha256.clone(),
    });
    inputs.chain([table]).chain(facts).collect()
}
