//! Records for spreadsheets.

use csv::Writer;
use std::borrow::Cow;
use std::io;

/// What tells spreadsheets that a file is UTF-8.
const MARK: &[u8] = "\u{FEFF}".as_bytes();

/// Records for spreadsheets.
pub(crate) struct Sheet<'a>(Writer<&'a mut dyn io::Write>);

impl<'a> Sheet<'a> {
    pub(crate) fn new(out: &'a mut dyn io::Write) -> io::Result<Sheet<'a>> {
        out.write_all(MARK)?;
        Ok(Sheet(Writer::from_writer(out)))
    }

    pub(crate) fn put<T: AsRef<str>>(&mut self, fields: &[T]) -> io::Result<()> {
        let record = fields.iter().map(|field| harmless(field.as_ref()));
        self.0.write_record(record.map(Cow::into_owned)).map_err(fault)
    }
}

impl Sheet<'_> {
    /// The last of it.
    pub(crate) fn finish(mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// The fault as it was met: where the reader has gone away, that must still be seen.
fn fault(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// The text so that no spreadsheet takes it for a formula, as `= D0 K1` or `@end` would be.
fn harmless(text: &str) -> Cow<'_, str> {
    let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r'])
        && !text.strip_prefix('-').is_some_and(is_number);
    if is_formula { Cow::Owned(format!("'{text}")) } else { Cow::Borrowed(text) }
}

#[cfg(test)]
mod tests {
    #[test]
    fn no_cell_is_taken_for_a_formula() {
        for text in ["= D0 K1", "+ K1 D0", "-P D0 D1", "@end"] {
            assert_eq!(super::harmless(text), format!("'{text}"));
        }
        for text in ["LD= D0 K1", "-1.5"] {
            assert_eq!(super::harmless(text), text);
        }
    }
}
