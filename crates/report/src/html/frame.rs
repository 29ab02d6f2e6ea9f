//! The frame of all pages.

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
pub(super) const SCRIPT: &str = include_str!("page.js");

/// The text's columns.
pub(super) const WIDTH: usize = 110;

pub(super) fn framed(title: &str, body: &str) -> String {
    // What the project says comes last, so that nothing in it is filled.
    let page = PAGE.replace("{{style}}", STYLE);
    let (head, foot) = page.split_once("{{body}}").unwrap_or((&page, ""));
    let (start, rest) = head.split_once("{{title}}").unwrap_or((head, ""));
    [start, &escaped(title), rest, body, foot].concat()
}

pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
