//! What `--version` says: the program's version, and how old the times are that come with it.

use scanbound::timing::table::builtin;
use std::fmt::Write;
use std::sync::OnceLock;

/// The version, and each built-in timing table with the day of its last change.
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
