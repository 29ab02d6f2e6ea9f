//! Runs charts by the standard's rules alone, to compare what the analysis says of them.

pub mod control;
pub mod evaluate;
pub mod run;
