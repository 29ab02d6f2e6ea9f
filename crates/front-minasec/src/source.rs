//! A program as a file has it: the words of the program memory and the line of each.

use super::word::{WORDS, Word};
use std::collections::BTreeMap;

/// The dialect name of assembly.
pub const ASSEMBLY: &str = "minasec-asm";
/// The dialect name of Intel HEX.
pub const HEX: &str = "minasec-hex";
/// The dialect name of binary machine code.
pub const BINARY: &str = "minasec-bin";

/// A MINASEC-U program as read from a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The file's name as the user gave it.
    pub name: String,
    /// The name of the dialect in which the program is written.
    pub dialect: &'static str,
    /// The program memory. Words that are not in the file are 0 (`LD X00`), as in a cleared memory.
    pub words: [Word; WORDS],
    /// The line of each word that is in the file, by address; for binary machine code the address + 1.
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

    /// The program memory as bytes.
    #[must_use]
    pub fn bytes(&self) -> [u8; WORDS] {
        self.words.map(|word| word.0)
    }

    /// The number of words up to the last one that is not empty (0, that is `LD X00`). An empty program has 0.
    #[must_use]
    pub fn used(&self) -> usize {
        self.words.iter().rposition(|&word| word != Word::default()).map_or(0, |last| last + 1)
    }
}
