//! Translates a net to code for a PLC, in the order of the paper's translator:
//!
//! emergency stops, transitions, boxes, timers, counters. Each element is a group of instructions that ends in OUT, TIM
//! or CNT.

mod assign;
mod c200h;
mod cx;
mod list;
mod melsec;
mod plcopen;
mod relay;
mod tables;

pub use assign::assign;
pub use c200h::write as c200h;
pub use cx::write as cx;
pub use list::{Element, Instruction, Listing, Operand, Operation, listing};
pub use melsec::write as melsec;
pub use plcopen::write as plcopen;
pub use relay::Spelling;
pub use tables::{assignment, gates};

#[cfg(test)]
mod tests;
