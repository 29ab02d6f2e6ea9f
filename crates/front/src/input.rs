//! A file as it was handed over.

/// A file, already read into memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// The name as the user gave it.
    pub name: String,
    /// The content.
    pub bytes: Vec<u8>,
}
