//! Sound worst-case scan times of PLC programs.
//!
//! The road, a module a stage: a [`dialect`] reads source text into a [`program::Program`]; [`price`] gives
//! every instruction its times from a [`table`]; [`scan`] executes one scan symbolically and yields a
//! [`model::ScanModel`]; [`groups`] slices it; [`solve`] finds each group's maximum; [`replay`] checks each
//! witness. [`audit`](mod@audit) is all that as one call; [`verdict`] holds its result against a limit, [`compare`]
//! against measurements, and [`report`] shows it.

pub mod audit;
pub mod budget;
pub mod column;
pub mod compare;
pub mod diagnostic;
pub mod dialect;
pub mod emulate;
pub mod facts;
pub mod groups;
pub mod input;
pub mod model;
pub mod price;
pub mod program;
pub mod render;
pub mod replay;
pub mod report;
pub mod scan;
pub mod solve;
pub mod table;
pub mod time;
pub mod verdict;
