//! A file that the user gave, with its content.

/// A file, already read into memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// The path for messages: as the user gave it; for a file of a directory, the path of the directory with the file's
    /// name; `stdin` for standard input.
    pub name: String,
    /// The content of the file. [`Input::recode`] may have converted it to UTF-8.
    pub bytes: Vec<u8>,
}
