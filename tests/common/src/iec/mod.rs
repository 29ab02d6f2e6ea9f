//! Random IEC 61131-3 programs, drawings of them, and a machine that runs both.

pub mod control;
pub mod drawn;
pub mod generate;
pub mod list;
pub mod machine;
pub mod probe;
pub mod ring;
pub mod st;
pub mod xml;
