//! The difference of two versions as CSV: a row a change, the longest first.

use crate::sheet::Sheet;
use scanbound_audit::difference::{Difference, Side};
use std::io::{self, Write};

const HEADS: [&str; 10] = [
    "kind", "delta_us", "old_file", "old_line", "old_us", "new_file", "new_line", "new_us",
    "old_text", "new_text",
];

/// Writes the changes, and what else changed the bound: the column `delta_us` adds up to the whole difference.
pub(crate) fn write(found: &Difference, out: &mut dyn Write) -> io::Result<()> {
    let mut sheet = Sheet::new(out)?;
    sheet.put(&HEADS)?;
    for one in &found.changes {
        let place = |side: &Option<Side>| match side {
            Some(side) => [side.file.clone(), side.at.line.to_string(), side.time.us_text()],
            None => [String::new(), String::new(), String::new()],
        };
        let text =
            |side: &Option<Side>| side.as_ref().map_or(String::new(), |side| side.text.clone());
        let head = [one.kind.name().to_owned(), microseconds(one.delta())];
        let texts = [text(&one.old), text(&one.new)];
        let fields = [&head[..], &place(&one.old), &place(&one.new), &texts];
        sheet.put(&fields.concat())?;
    }
    let mut last = vec!["besides".to_owned(), microseconds(found.besides)];
    last.resize(HEADS.len(), String::new());
    sheet.put(&last)?;
    sheet.finish()
}

/// Exact, with its sign where it is negative.
fn microseconds(delta: i128) -> String {
    let time = scanbound_base::time::Picos(u64::try_from(delta.unsigned_abs()).unwrap_or(u64::MAX));
    format!("{}{}", if delta < 0 { "-" } else { "" }, time.us_text())
}
