//! Places of the source in words: with the file where there are several.

use super::{Program, SourceFile};
use scanbound_base::location::Location;

/// A file's name without its directories, where that tells it from the others.
#[must_use]
pub fn short<'a>(name: &'a str, all: impl Iterator<Item = &'a str>) -> &'a str {
    let last = |name: &'a str| name.rsplit(['/', '\\']).next().unwrap_or(name);
    let own = last(name);
    if all.filter(|other| last(other) == own).count() == 1 { own } else { name }
}

impl Program {
    /// `line 5`, or `MAIN.csv:5` where there are several files.
    #[must_use]
    pub fn told(&self, at: Location) -> String {
        match self.files.len() {
            // Programs made by hand may have no files.
            0 | 1 => format!("line {}", at.line),
            _ => format!("{}:{}", self.short_name(at.of(&self.files)), at.line),
        }
    }

    /// The name of one of the program's files, without its directories where that tells it from the others.
    #[must_use]
    pub fn short_name<'a>(&'a self, file: &'a SourceFile) -> &'a str {
        short(&file.name, self.files.iter().map(|file| file.name.as_str()))
    }
}
