//! An audit as one page for a browser, without a network: the bound and its parts, what to do, and all rungs drawn as
//! ladder with the longest scan lit.
//!
//! The page holds data and draws it itself, a rung when it comes into view: so it stays small where a project is large.

mod data;
mod frame;
mod tables;

use super::format::{Detail, Extent, Format};
use super::{json, text};
use frame::{SCRIPT, WIDTH, escaped, framed};
use scanbound_audit::Audit;
use scanbound_audit::verdict::Check;
use std::io::{self, Write};

/// A page for a browser.
pub const FORMAT: Format = Format {
    name: "html",
    about: "One page for a browser, with the ladder drawn",
    suffixes: &["html", "htm"],
    draws: true,
    escapes: false,
    audit: write,
    compare: |found, out| out.write_all(tables::comparison(found).as_bytes()),
    diff: |found, _, out| out.write_all(tables::difference(found).as_bytes()),
    checks: || Box::<tables::All>::default(),
    tells_faults: false,
};

fn write(audit: &Audit, check: Option<&Check>, _: Extent, out: &mut dyn Write) -> io::Result<()> {
    let extent =
        Extent { detail: Detail::Usual, width: WIDTH, height: usize::MAX, ..Extent::default() };
    let plain = |text: &str| anstream::adapter::strip_str(text).to_string();
    let data = format!(
        "{{\"version\":{},\"answer\":{},\"text\":{},\"report\":{},\"ladder\":{}}}",
        serde_json::to_string(env!("CARGO_PKG_VERSION"))?,
        serde_json::to_string(&plain(&text::answer(audit, check, extent)))?,
        serde_json::to_string(&plain(&text::render(audit, check, extent)))?,
        json::without_charges(audit, check)?,
        serde_json::to_string(&data::ladder(audit))?,
    );
    // Nothing in it ends the element that holds it.
    let data = data.replace('<', "\\u003c");
    let body = format!(
        "<main id=\"page\"></main>\n<noscript><pre>{}</pre></noscript>\n<script type=\"application/json\" id=\"data\">{data}</script>\n<script>{SCRIPT}</script>",
        escaped(&plain(&text::render(audit, check, extent)))
    );
    write!(out, "{}", framed(&title(audit), &body))
}

fn title(audit: &Audit) -> String {
    let name = |file: &String| file.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
    let first = audit.files.first().map(name).unwrap_or_default();
    match audit.files.len() {
        0 | 1 => first,
        n => format!("{first} and {} more", n - 1),
    }
}
