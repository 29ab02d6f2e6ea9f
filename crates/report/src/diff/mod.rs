//! The difference of two versions as text, JSON and CSV; the other formats show it by its findings.

pub mod csv;
pub mod json;
pub mod text;
