//! One program by every table of its family, in each format.

pub mod csv;
pub mod json;
pub mod text;
