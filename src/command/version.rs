//! The text of `--version`: the program's version, and the dates of the built-in timing tables.

use scanbound::timing::table::builtin;
use std::fmt::Write;
use std::sync::OnceLock;

/// The version, and the date of the last change of each built-in timing table.
pub fn long() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let mut text =
            format!("{}\nbuilt-in timing tables, last changed:", env!("CARGO_PKG_VERSION"));
        for (name, date) in builtin::dates() {
            let _ = write!(text, "\n  {date}  {name}");
        }
        text
    })
}
