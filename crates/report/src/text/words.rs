//! Headings, lists, numbers with their nouns, and places: what all sections of the text report say alike.

use super::style::BOLD;
use crate::columns::paint;
use crate::format::Extent;
use crate::wrap;
use scanbound_audit::Audit;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::location_text::short_file_name;
use unicode_width::UnicodeWidthStr;

pub(super) fn heading(text: &str, extent: Extent) -> String {
    let lines = wrap::lines(text, extent.width);
    let lines = lines.iter().map(|line| format!("{}\n", paint(BOLD, line)));
    format!("\n{}", lines.collect::<String>())
}

/// Entries under a heading, each with a mark; nothing if there are none.
pub(super) fn list(title: &str, entries: &[String], extent: Extent) -> String {
    if entries.is_empty() {
        return String::new();
    }
    let items = entries.iter().map(|entry| item(2, entry, extent));
    heading(title, extent) + &items.collect::<String>()
}

/// One entry, whose further lines stand a little to the right; nothing if it is empty.
pub(super) fn item(indent: usize, entry: &str, extent: Extent) -> String {
    if entry.is_empty() {
        return String::new();
    }
    let lines = wrap::lines(entry, extent.width.saturating_sub(indent + 2));
    let lines = lines.iter().enumerate().map(|(index, line)| {
        let more = if index == 0 { 0 } else { 2 };
        format!("{}{line}\n", " ".repeat(indent + more))
    });
    lines.collect()
}

/// How many entries are not shown.
pub(super) fn more(all: usize, shown: usize, one: &str, several: &str) -> String {
    match all.saturating_sub(shown) {
        0 => String::new(),
        rest => format!("  and {} (-v)\n", count(rest, one, several)),
    }
}

/// The first so many entries, and how many more there are.
pub(super) fn capped(entries: &[String], most: usize) -> Vec<String> {
    let mut shown: Vec<String> = entries.iter().take(most).cloned().collect();
    if entries.len() > most {
        shown.push(format!("and {} more", entries.len() - most));
    }
    shown
}

/// The entries apart by commas, behind a label and under each other where a line is full.
pub(super) fn wrapped(label: &str, entries: &[String], extent: Extent) -> String {
    let indent = label.width().min(extent.width / 3);
    let (mut text, mut used) = (label.to_owned(), label.width());
    for (index, entry) in entries.iter().enumerate() {
        let comma = if index + 1 < entries.len() { "," } else { "" };
        if index > 0 && used + 1 + entry.width() + comma.len() > extent.width {
            text += &format!("\n{}", " ".repeat(indent));
            used = indent;
        } else if index > 0 {
            text.push(' ');
            used += 1;
        }
        text += entry;
        text += comma;
        used += entry.width() + comma.len();
    }
    text + "\n"
}

pub(super) fn count(number: usize, one: &str, several: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { several })
}

pub(super) fn named(device: &str, comment: &str) -> String {
    if comment.is_empty() { device.to_owned() } else { format!("{device} {comment}") }
}

pub(crate) fn place(audit: &Audit, at: Location) -> String {
    let step = at.step.map_or(String::new(), |step| format!(" step {step}"));
    format!("{}:{}{step}", file(audit, at.file), at.line)
}

/// The file's name, as short as tells the files apart.
pub(crate) fn file(audit: &Audit, index: u32) -> &str {
    let all = audit.files.iter().map(String::as_str);
    audit.files.get(index as usize).map_or("", |name| short_file_name(name, all))
}

/// Microseconds to three places, rounded up.
pub(super) fn us(time: Picos) -> String {
    let nanos = time.0.div_ceil(1_000);
    format!("{}.{:03} us", nanos / 1_000, nanos % 1_000)
}

/// What was noticed of the input, each with its place.
pub(super) fn warnings(audit: &Audit) -> Vec<String> {
    audit
        .warnings
        .iter()
        .map(|one| {
            let line = one.line.map_or(String::new(), |line| format!(":{line}"));
            let place = match one.file.as_str() {
                "" => String::new(),
                file => format!("{file}{line}: "),
            };
            format!("{place}{}", one.message)
        })
        .collect()
}
