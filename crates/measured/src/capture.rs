//! Reads scan times from files of logic analysers, oscilloscopes and PLCs: columns of times, pulses, captured signals.

use super::signal::fault;
use super::{Measurements, delimited, dump};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::{FileKind, Input};
use scanbound_fronts::detect;

pub use super::signal::{Edge, Selection, Threshold};

/// Reads a file.
///
/// # Errors
/// Why it contains no scan times, or all faults of its rows, up to a limit.
pub fn read(
    name: &str,
    bytes: &[u8],
    selection: &Selection<'_>,
) -> Result<Measurements, Vec<Diagnostic>> {
    let start = bytes.iter().position(|byte| !byte.is_ascii_whitespace());
    let Some(start) = start else {
        return Err(vec![fault(name, "the file is empty", "capture some scans first")]);
    };
    let found = if bytes[start] == b'$' {
        dump::read(name, bytes, selection)
    } else {
        delimited::read(name, bytes, selection)
    };
    found.map_err(|faults| {
        let file = Input { name: name.to_owned(), bytes: bytes.to_vec() };
        match detect(&file) {
            Ok(FileKind::Program(dialect)) => {
                let message =
                    format!("this is a program ({}), not a file of measurements", dialect.name);
                let help = "the last file on the command line must be the measurements";
                vec![Diagnostic::file(Code::Capture, name, message, help)]
            }
            _ => faults,
        }
    })
}
