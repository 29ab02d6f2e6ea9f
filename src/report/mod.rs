//! Audits and comparisons in every format (`formats`). Reports are pure functions of the audit and compute nothing.

mod columns;
pub mod compare;
pub mod csv;
pub mod format;
pub mod formats;
pub mod json;
pub mod method;
pub mod render;
mod response;
pub mod tables;
pub mod text;
mod way;
