//! The common part of the property tests: generators of programs, the steps from a program to its bound, and searches
//! for a scan above it.
#![allow(missing_docs, clippy::missing_errors_doc)] // only tests use it

pub mod audited;
pub mod bound;
pub mod chart_run;
pub mod charts;
pub mod counting;
pub mod few;
pub mod flowcharts;
pub mod hostile;
pub mod iec;
pub mod ir;
pub mod lines;
pub mod list;
pub mod macros;
pub mod melsec;
pub mod model_bound;
pub mod omron_plc;
pub mod passed;
pub mod plc;
pub mod real;
pub mod search;
pub mod snet;
pub mod tape;
