//! Audits and comparisons in every format. Reports are pure functions of the audit and compute nothing.
//!
//! A format is a file and its line in `FORMATS`.

pub mod advice;
mod columns;
pub mod compare;
pub mod cpus;
pub mod csv;
pub mod diff;
pub mod doctor;
pub mod explain;
pub mod facts;
mod findings;
pub mod format;
pub mod formats;
pub mod github;
pub mod html;
pub mod json;
pub mod junit;
pub mod ladder;
pub mod live;
pub mod markdown;
pub mod method;
pub mod netcheck;
pub mod page;
mod path;
pub mod render;
mod response;
pub mod sarif;
pub mod schema;
pub mod sfc;
mod sheet;
pub mod snet;
pub mod tables;
pub mod text;
mod wrap;

/// A text on lines of at most so many columns.
#[must_use]
pub fn wrapped(text: &str, width: usize) -> String {
    wrap::paragraph(0, text, width)
}

/// All formats; the first is taken where none is asked for.
pub const FORMATS: &[format::Format] = &[
    text::FORMAT,
    json::FORMAT,
    csv::FORMAT,
    sarif::FORMAT,
    junit::FORMAT,
    github::FORMAT,
    markdown::FORMAT,
    html::FORMAT,
];
