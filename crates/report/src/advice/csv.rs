//! Which statement lowers a bound most as CSV: a row a statement, the best first.

use crate::sheet::Sheet;
use scanbound_audit::advise::Advice;
use std::io::{self, Write};

const HEADS: [&str; 8] = ["upper_us", "gain_us", "kind", "table", "fact", "file", "line", "what"];

/// Writes the advice.
///
/// # Errors
/// Where what is written to takes no more.
pub fn write(advice: &Advice, out: &mut dyn Write) -> io::Result<()> {
    let mut sheet = Sheet::new(out)?;
    sheet.put(&HEADS)?;
    for one in &advice.found {
        let gain =
            advice.upper.and_then(|upper| upper.checked_sub(one.bound.upper)).unwrap_or_default();
        let first = one.statement.places.first().map(|(at, _)| at);
        let file = first.and_then(|at| advice.files.get(at.file as usize));
        sheet.put(&[
            one.bound.upper.us_text(),
            gain.us_text(),
            one.statement.kind.name().to_owned(),
            one.statement.table.to_owned(),
            one.statement.line.clone(),
            file.cloned().unwrap_or_default(),
            first.map_or(String::new(), |at| at.line.to_string()),
            one.statement.what.clone(),
        ])?;
    }
    sheet.finish()
}
