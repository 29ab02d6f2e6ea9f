//! Programs in structured text of the whole language, with objects: a tree of their own, which writes itself as text
//! and is run by an interpreter made from the standard and the manuals of controllers alone.

pub mod draw;
pub mod place;
pub mod print;
pub mod project;
pub mod reduce;
pub mod run;
pub mod standard;
pub mod tree;
