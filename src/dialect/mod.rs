//! Dialects: what a source file is written in, found from its content, and the readers of each.

pub mod melsec;
