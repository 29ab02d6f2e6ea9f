//! What of a project is read and what stands in the way of a bound, as text.

use crate::columns::{Cell, fitted, left, paint, right};
use crate::format::{Detail, Extent};
use crate::wrap;
use anstyle::{AnsiColor, Style};
use scanbound_audit::doctor::{Diagnosis, ExaminedFile, ExaminedKind, Finding, Section};

const BOLD: Style = Style::new().bold();
const GOOD: Style = AnsiColor::Green.on_default().bold();
const CARE: Style = AnsiColor::Yellow.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();

/// So many findings of a part are shown, and places of one.
const MAX_SHOWN: usize = 12;
const MAX_PLACES: usize = 3;

/// The diagnosis. Has colour codes.
#[must_use]
pub fn render(found: &Diagnosis, extent: Extent) -> String {
    let style = if found.is_sound() { GOOD } else { BAD };
    let told = wrap::paragraph(0, &answer(found), extent.width);
    let mut text = format!("{}\n", paint(style, told.trim_end()));
    text += &format!("\n{}\n", paint(BOLD, "Read"));
    let rows: Vec<Vec<Cell>> = found.files.iter().map(file).collect();
    text += &fitted(2, &rows, extent.width);
    if let Some(table) = &found.table {
        let cpu = found.cpu.as_ref().map_or(String::new(), |cpu| format!("{cpu}, "));
        text += &format!("  {cpu}table {table}\n");
    }
    let most = if extent.detail == Detail::Full { usize::MAX } else { MAX_SHOWN };
    for section in Section::ALL {
        let own: Vec<&Finding> =
            found.findings.iter().filter(|one| one.section == section).collect();
        if own.is_empty() {
            continue;
        }
        let style = if section.is_grave() { BAD } else { CARE };
        text += &format!("\n{}\n", paint(style, title(section)));
        for one in own.iter().take(most) {
            text += &finding(one, extent);
        }
        if own.len() > most {
            text += &format!("  and {} more (-v)\n", own.len() - most);
        }
    }
    text += &format!("\n{}\n", paint(BOLD, "Next"));
    for step in next(found) {
        let lines = wrap::lines(&step, extent.width.saturating_sub(4)).join("\n    ");
        text += &format!("  {lines}\n");
    }
    text
}

/// The answer in a sentence.
#[must_use]
pub fn answer(found: &Diagnosis) -> String {
    let grave = found.findings.iter().filter(|one| one.section.is_grave()).count();
    let others = found.findings.len() - grave;
    match (grave, others) {
        (0, 0) => "Nothing stands in the way of a bound.".to_owned(),
        (0, 1) => "Nothing stands in the way of a bound; one thing is worth a look.".to_owned(),
        (0, n) => format!("Nothing stands in the way of a bound; {n} things are worth a look."),
        (1, _) => "One thing stands in the way of a bound.".to_owned(),
        (n, _) => format!("{n} things stand in the way of a bound."),
    }
}

fn title(section: Section) -> &'static str {
    match section {
        Section::Refused => "Refused: cannot be read or followed",
        Section::Unknown => "Unknown instructions",
        Section::Missing => "Routines and labels that are not there",
        Section::NoTime => "Without a time in the table",
        Section::Stated => "Stated wrongly: facts, options, tables",
        Section::NotStated => "Not stated: the bound may be too low without",
        Section::LeftOut => "Left out: not in the bound",
        Section::Noticed => "Noticed",
    }
}

fn file(seen: &ExaminedFile) -> Vec<Cell> {
    let (what, style) = match seen.what {
        ExaminedKind::Program(dialect) => (dialect, Style::new()),
        ExaminedKind::Comments => ("names and comments of devices", Style::new()),
        ExaminedKind::Refused => ("refused", BAD),
    };
    let count = seen.instructions.map_or(String::new(), |count| format!("{count} instructions"));
    let what = match seen.standby {
        true => format!("{what}; subroutines alone, which run where they are called"),
        false => what.to_owned(),
    };
    vec![left(&seen.name), right(count), left(what).styled(style)]
}

fn finding(one: &Finding, extent: Extent) -> String {
    let place = |(file, line): &(String, Option<u32>)| match line {
        Some(line) => format!("{file}:{line}"),
        None => file.clone(),
    };
    let places: Vec<String> = one.places.iter().take(MAX_PLACES).map(place).collect();
    let mut head = places.join(", ");
    if one.places.len() > MAX_PLACES {
        head += &format!(" and {} more places", one.places.len() - MAX_PLACES);
    }
    if !head.is_empty() {
        head += ": ";
    }
    let code = one.code.map_or(String::new(), |code| format!(" [{code}]"));
    let room = extent.width.saturating_sub(4);
    let lines = wrap::lines(&format!("{head}{}{code}", one.message), room).join("\n    ");
    let mut text = format!("  {lines}\n");
    if !one.text.trim().is_empty() && one.places.len() == 1 {
        text +=
            &format!("      | {}\n", wrap::cut(one.text.trim(), extent.width.saturating_sub(8)));
    }
    if !one.help.is_empty() {
        text += &wrap::paragraph(6, &format!("do: {}", one.help), extent.width);
    }
    text
}

/// What to do next.
fn next(found: &Diagnosis) -> Vec<String> {
    let has = |section| found.findings.iter().any(|one| one.section == section);
    let mut steps = Vec::new();
    if has(Section::Refused) {
        steps.push("export the refused files again, mend them, or leave them out with --ignore if they are not part of the scan".to_owned());
    }
    if has(Section::Unknown) || has(Section::NoTime) {
        steps.push("give what has no time one: --time NAME=12.5us, or a table of your own with these rows (docs/timing-tables.md)".to_owned());
    }
    if has(Section::Missing) {
        steps.push(
            "name the files in which the missing routines stand, or state what they take: scanbound facts writes the lines"
                .to_owned(),
        );
    }
    if has(Section::Stated) {
        steps.push("mend what is stated wrongly".to_owned());
    }
    if has(Section::LeftOut) {
        steps.push("look whether what was left out belongs to the scan: then name it".to_owned());
    }
    if has(Section::NotStated) {
        steps.push("state what is not stated: scanbound facts writes a file to fill in".to_owned());
    }
    steps.push(
        match found.is_sound() {
            true => "scanbound audit: the bound",
            false => "then scanbound doctor again; scanbound explain CODE tells more of a code in brackets",
        }
        .to_owned(),
    );
    steps
}
