//! Nets as text, one element a line: `docs/snet.md` has the grammar.

mod names;
mod read;
mod token;
mod write;

pub use read::read;
pub use token::is_name;
pub use write::write;

#[cfg(test)]
mod tests;
