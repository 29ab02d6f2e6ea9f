//! What of a project is read and what stands in the way of a bound as CSV: a row a finding and place.

use crate::sheet::Sheet;
use scanbound_audit::doctor::Diagnosis;
use std::io::{self, Write};

/// Writes the findings.
///
/// # Errors
/// Where what is written to takes no more.
pub fn write(found: &Diagnosis, out: &mut dyn Write) -> io::Result<()> {
    let mut sheet = Sheet::new(out)?;
    sheet.put(&["section", "code", "file", "line", "message", "help"])?;
    for one in &found.findings {
        let code = one.code.map_or("", |code| code.name());
        let mut put = |file: &str, line: Option<u32>| {
            let line = line.map_or(String::new(), |line| line.to_string());
            sheet.put(&[one.section.name(), code, file, &line, &one.message, &one.help])
        };
        if one.places.is_empty() {
            put("", None)?;
        }
        for (file, line) in &one.places {
            put(file, *line)?;
        }
    }
    sheet.finish()
}
