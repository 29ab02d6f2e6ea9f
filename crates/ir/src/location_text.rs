//! Formats source positions; the file name is added if the project has several files.

use super::{Program, SourceFile};
use scanbound_base::location::Location;

/// The file name without its directories, if no other file has the same name; else the full name.
#[must_use]
pub fn short_file_name<'a>(name: &'a str, all: impl Iterator<Item = &'a str>) -> &'a str {
    let last = |name: &'a str| name.rsplit(['/', '\\']).next().unwrap_or(name);
    let own = last(name);
    if all.filter(|other| last(other) == own).count() == 1 { own } else { name }
}

impl Program {
    /// The position as text: `line 5`, or `MAIN.csv:5` (with the short file name) if the project has several files.
    #[must_use]
    pub fn location_text(&self, at: Location) -> String {
        match self.files.len() {
            // Programs built by tests may have no files.
            0 | 1 => format!("line {}", at.line),
            _ => format!("{}:{}", self.short_name(at.of(&self.files)), at.line),
        }
    }

    /// The name of one of the program's files, without its directories if that is unambiguous.
    #[must_use]
    pub fn short_name<'a>(&'a self, file: &'a SourceFile) -> &'a str {
        short_file_name(&file.name, self.files.iter().map(|file| file.name.as_str()))
    }
}
