//! Sound worst-case scan times of PLC programs.
//!
//! The road, a room a stage: a [`front`] reads source text into a [`program::Program`]; [`timing`] gives every
//! instruction its times from a table; [`scan`] executes one scan symbolically, yields a
//! [`scan::model::ScanModel`], and slices it into groups; [`solve`] finds each group's maximum; [`replay`] checks
//! each witness. [`audit`](mod@audit) is all that as one call, and holds its result against a limit; [`measured`] holds
//! it against measurements; [`report`] shows it. [`minasec`] emulates one machine; [`base`] is what all stand on.

pub mod audit;
pub mod base;
pub mod front;
pub mod measured;
pub mod minasec;
pub mod program;
pub mod replay;
pub mod report;
pub mod scan;
pub mod solve;
pub mod timing;
