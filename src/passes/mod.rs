//! Passes, from program to program: what is the same for every dialect.

pub mod values;
