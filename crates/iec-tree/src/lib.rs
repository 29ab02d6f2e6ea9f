//! The typed tree of IEC 61131-3: every name is the id of a declaration, every expression has a type; conversions, call
//! targets and passing modes are nodes, and every node has its line.
//!
//! [`resolve`] builds it from the syntax tree; later stages compare no names. A faulty statement is a node, too: its
//! fault matters only if the statement is executed.

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
