//! A file as it was handed over.

/// A file, already read into memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// The name of the file as the user gave it.
    pub name: String,
    /// The bytes of the file.
    pub bytes: Vec<u8>,
}
