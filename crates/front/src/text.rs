//! Decodes source files, and rejects binary data.

use scanbound_base::code::Code;
use std::borrow::Cow;

use super::encoding;
use super::input::Input;
use scanbound_base::diagnostic::Diagnostic;

/// The number of bytes at the beginning of a file that are used to recognise it.
pub const BEGINNING: usize = 64 * 1024;

/// The text of the first [`BEGINNING`] bytes of a file; invalid bytes are replaced. `known_words` help to choose the
/// code page.
pub fn beginning<'a>(bytes: &'a [u8], known_words: &[&str]) -> Cow<'a, str> {
    encoding::beginning(bytes, BEGINNING, known_words)
}

/// As [`beginning`], but refuses binary data: more than 1 % of the characters are control characters other than tabs,
/// line ends, form feeds and the end-of-file mark.
///
/// # Errors
/// The file is binary.
pub fn checked_beginning<'a>(
    input: &'a Input,
    known_words: &[&str],
) -> Result<Cow<'a, str>, Diagnostic> {
    let text = beginning(&input.bytes, known_words);
    let stray = text.chars().filter(|&c| is_binary(c)).count();
    if stray > 0 && stray * 100 > text.chars().count() {
        let (message, help) = match input.bytes[..] {
            [0xD0, 0xCF, 0x11, 0xE0, ..] | [b'P', b'K', 3, 4, ..] => (
                "this is a tool's binary project file, not text",
                "open the project in the tool and export the programs as CSV",
            ),
            _ => {
                ("this is binary data, not text", "export the program from the tool as CSV or text")
            }
        };
        return Err(Diagnostic::file(Code::BinaryFile, &input.name, message, help));
    }
    Ok(text)
}

/// Whether the character occurs only in binary files.
fn is_binary(c: char) -> bool {
    c.is_control() && !matches!(c, '\t' | '\n' | '\r' | '\u{C}' | '\u{1A}')
}

/// The whole file as text. `known_words` help to choose the code page.
///
/// # Errors
/// No encoding fits the bytes.
pub fn decoded<'a>(input: &'a Input, known_words: &[&str]) -> Result<Cow<'a, str>, Diagnostic> {
    encoding::decode(&input.bytes, known_words).map_err(|fault| {
        let mut diagnostic = Diagnostic::file(
            Code::Encoding,
            &input.name,
            if fault.cut {
                format!("the file ends in the middle of a character ({})", fault.tried)
            } else {
                format!("the byte at offset {} is not valid in {}", fault.offset, fault.tried)
            },
            "export the file again: it is truncated, or its encoding was changed",
        );
        diagnostic.line = Some(fault.line);
        diagnostic
    })
}

/// Whether a text is markup (XML, HTML): it begins with `<`. Its content may look like an instruction list, but is not
/// one.
#[must_use]
pub fn is_markup(text: &str) -> bool {
    text.trim_start_matches('\u{feff}').trim_start().starts_with('<')
}

/// A file name without directory and (last) extension. A name that begins with its only dot (`.x`) has no extension.
pub fn stem(name: &str) -> &str {
    let base = name.rsplit(['/', '\\']).next().unwrap_or(name);
    match base.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem,
        _ => base,
    }
}

/// One warning for each file with device comments that is empty or blank.
pub fn empty_comment_files(comment_files: &[&Input]) -> Vec<Diagnostic> {
    let is_blank = |input: &&&Input| beginning(&input.bytes, &[]).trim().is_empty();
    let warnings = comment_files.iter().filter(is_blank).map(|input| {
        let help = "export the comments again, if any device has a comment";
        Diagnostic::file(Code::EmptyFile, &input.name, "the device comments are empty", help)
            .warning()
    });
    warnings.collect()
}
