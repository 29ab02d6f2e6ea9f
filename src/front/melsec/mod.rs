//! The MELSEC dialects: GX Works2 and GX Works3 CSV exports, and list text.

pub mod catalog;
mod comments;
mod csv;
pub mod decode;
pub mod device;
mod list;
pub mod operand;
pub mod project;
pub mod source;
mod words;

use super::Dialect;

/// The name of list text.
const LIST: &str = "melsec-list";

/// The dialects, as they are told from each other.
pub(super) const DIALECTS: [Dialect; 3] = [
    Dialect {
        name: "melsec-csv",
        what: "a program's CSV from GX Works2 or GX Developer",
        sniff: |text| csv::layout(text).is_some_and(|layout| layout.tool == csv::Tool::Works2),
    },
    Dialect {
        name: "melsec-gx3-csv",
        what: "a program's CSV from GX Works3",
        sniff: |text| csv::layout(text).is_some_and(|layout| layout.tool == csv::Tool::Works3),
    },
    Dialect {
        name: LIST,
        what: "MELSEC list text (LD X0, one instruction a line)",
        sniff: list::sniff,
    },
];

/// Whether the beginning of a file is that of device comments.
pub(super) fn is_comments(beginning: &str) -> bool {
    comments::sniff(beginning)
}

/// Words that files in these dialects hold, to tell code pages by.
pub(super) fn marks() -> impl Iterator<Item = &'static str> {
    csv::MARKS.into_iter().chain(comments::MARKS)
}
