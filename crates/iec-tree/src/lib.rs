//! The typed tree of IEC 61131-3: every name is the id of a declaration, every expression has its type, every
//! conversion, call target and way of passing is a node, and every node has its line.
//!
//! [`resolve`] makes it of the syntax tree; behind it nothing compares names. What is wrong with a statement is a node,
//! too: it matters only where the statement is executed.

pub mod accesses;
pub mod blocks;
pub mod charts;
pub mod code;
pub mod constants;
pub mod declarations;
pub mod elementary;
pub mod ids;
pub mod resolve;
pub mod show;
pub mod standard;
pub mod tree;
pub mod types;
