//! Reports of a comparison of measured scan times with the bound, a file an output format.

pub mod csv;
pub mod json;
pub mod text;
