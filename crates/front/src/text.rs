//! Source text: what bytes say in any encoding that a tool writes, and whether they are text at all.

use scanbound_base::code::Code;
use std::borrow::Cow;

use super::{Input, encoding};
use scanbound_base::diagnostic::Diagnostic;

/// The number of bytes at the beginning that tell what a file is.
pub const BEGINNING: usize = 64 * 1024;

/// The text of a file's beginning, faults replaced. `marks` are words that tell code pages apart.
pub fn beginning<'a>(bytes: &'a [u8], marks: &[&str]) -> Cow<'a, str> {
    encoding::beginning(bytes, BEGINNING, marks)
}

/// The same, of a file that is text.
///
/// # Errors
/// That it is binary data.
pub fn checked_beginning<'a>(input: &'a Input, marks: &[&str]) -> Result<Cow<'a, str>, Diagnostic> {
    let text = beginning(&input.bytes, marks);
    let stray = text.chars().filter(|&c| is_binary(c)).count();
    if stray > 0 && stray * 100 > text.chars().count() {
        let (message, help) = match input.bytes[..] {
            [0xD0, 0xCF, 0x11, 0xE0, ..] | [b'P', b'K', 3, 4, ..] => (
                "this is a tool's own file, no text",
                "open it in the tool and export its programs as CSV",
            ),
            _ => (
                "this is binary data, no text",
                "give the program as the tool exports it to CSV or text",
            ),
        };
        return Err(Diagnostic::file(Code::BinaryFile, &input.name, message, help));
    }
    Ok(text)
}

/// Whether no text has such a character.
fn is_binary(c: char) -> bool {
    c.is_control() && !matches!(c, '\t' | '\n' | '\r' | '\u{C}' | '\u{1A}')
}

/// The whole file as text. `marks` are words that files of its front hold, to tell code pages apart.
///
/// # Errors
/// Where no encoding explains the bytes.
pub fn decoded<'a>(input: &'a Input, marks: &[&str]) -> Result<Cow<'a, str>, Diagnostic> {
    encoding::decode(&input.bytes, marks).map_err(|fault| {
        let mut diagnostic = Diagnostic::file(
            Code::Encoding,
            &input.name,
            if fault.cut {
                format!("the file ends within a character of {}", fault.tried)
            } else {
                format!("the byte at offset {} is no text in {}", fault.offset, fault.tried)
            },
            "the file was cut off or its encoding changed on the way: export it again",
        );
        diagnostic.line = Some(fault.line);
        diagnostic
    })
}

/// Whether a text is markup: what stands in it may look like a list, and is none.
#[must_use]
pub fn is_markup(text: &str) -> bool {
    text.trim_start_matches('\u{feff}').trim_start().starts_with('<')
}

/// A file's name without directory and extension.
pub fn stem(name: &str) -> &str {
    let base = name.rsplit(['/', '\\']).next().unwrap_or(name);
    match base.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem,
        _ => base,
    }
}
