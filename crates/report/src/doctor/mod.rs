//! What of a project is read and what stands in the way of a bound, in each format.

pub mod csv;
pub mod json;
pub mod text;
