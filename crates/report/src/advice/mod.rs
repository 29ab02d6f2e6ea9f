//! Which statement lowers a bound most, in each format.

pub mod csv;
pub mod json;
pub mod text;
