//! What instructions take: timing tables, and each instruction's and each scan's price by them.

pub mod price;
pub mod table;
