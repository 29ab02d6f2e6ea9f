//! Timing tables, and the times of each instruction and each scan by these tables.

pub mod price;
pub mod table;
