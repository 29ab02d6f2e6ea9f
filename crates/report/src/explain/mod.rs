//! What is known of an instruction, in each format.

pub mod json;
pub mod text;
