//! A program as a file has it: the words of the program memory and the line of each.

use super::word::{WORDS, Word};
use std::collections::BTreeMap;

/// Assembly.
pub const ASSEMBLY: &str = "minasec-asm";
/// Machine code as Intel HEX.
pub const HEX: &str = "minasec-hex";
/// Machine code as bytes.
pub const BINARY: &str = "minasec-bin";

/// A program as read from a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The file's name as the user gave it.
    pub name: String,
    /// The dialect's name.
    pub dialect: &'static str,
    /// The program memory. Words that the file does not give are 0, `LD X00`, as the description clears them.
    pub words: [Word; WORDS],
    /// The line of each word that the file gives, by address; for machine code without lines, the address + 1.
    pub lines: BTreeMap<u8, u32>,
}

impl Source {
    /// An empty program.
    #[must_use]
    pub fn new(name: &str, dialect: &'static str) -> Source {
        Source {
            name: name.to_owned(),
            dialect,
            words: [Word::default(); WORDS],
            lines: BTreeMap::new(),
        }
    }

    /// The memory's bytes.
    #[must_use]
    pub fn bytes(&self) -> [u8; WORDS] {
        self.words.map(|word| word.0)
    }

    /// How many words there are up to the last that is not empty.
    #[must_use]
    pub fn used(&self) -> usize {
        self.words.iter().rposition(|&word| word != Word::default()).map_or(0, |last| last + 1)
    }
}
