//! Audits and comparisons in every format. Reports are pure functions of the audit and compute nothing.
//!
//! A format is a file and its line in `formats!`.

pub mod advice;
mod columns;
pub mod compare;
pub mod cpus;
pub mod diff;
pub mod doctor;
pub mod explain;
pub mod facts;
mod findings;
pub mod format;
pub mod formats;
pub mod ladder;
pub mod live;
pub mod method;
pub mod netcheck;
pub mod page;
mod path;
pub mod render;
mod response;
pub mod schema;
pub mod sfc;
pub mod snet;
pub mod tables;
mod wrap;

/// A text on lines of at most so many columns.
#[must_use]
pub fn wrapped(text: &str, width: usize) -> String {
    wrap::paragraph(0, text, width)
}

/// Declares the formats' modules and lists what each has as its `FORMAT`.
macro_rules! formats {
    ($($name:ident,)*) => {
        $(pub mod $name;)*

        /// All formats; the first is taken where none is asked for.
        pub const FORMATS: &[format::Format] = &[$($name::FORMAT),*];
    };
}

formats! {
    text,
    json,
    csv,
    sarif,
    junit,
    github,
    markdown,
    html,
}
