//! Which statement lowers a bound most as text: the answer, and a statement after the other with the bound that it
//! gives.

use crate::columns::{fitted, left, paint, right};
use crate::format::{Detail, Extent};
use crate::wrap;
use anstyle::Style;
use scanbound_audit::Share;
use scanbound_audit::advise::{Advice, Measured};
use scanbound_base::location::Location;
use scanbound_base::time_text::at_most;
use scanbound_ir::location_text::short_file_name;

const BOLD: Style = Style::new().bold();

/// So many places of one statement are told.
const MAX_PLACES: usize = 3;

/// The advice. Has colour codes.
#[must_use]
pub fn render(advice: &Advice, extent: Extent) -> String {
    let told = wrap::paragraph(0, &answer(advice), extent.width);
    let mut text = format!("{}\n", paint(BOLD, told.trim_end()));
    let is_full = extent.detail == Detail::Full;
    let shown = if is_full { advice.found.len() } else { extent.top };
    for one in advice.found.iter().take(shown) {
        text += &format!("\n{}", statement(advice, one, extent));
    }
    let mut notes = Vec::new();
    if advice.found.len() > shown {
        notes.push(format!("and {} that lower it less (-v)", advice.found.len() - shown));
    }
    if advice.useless > 0 {
        let (others, lower) = match (advice.found.is_empty(), advice.useless) {
            (_, 1) => ("one other statement was", "lowers"),
            (false, _) => ("other statements were", "lower"),
            (true, _) => ("statements were", "lower"),
        };
        let count =
            if advice.useless == 1 { String::new() } else { format!("{} ", advice.useless) };
        notes.push(format!("{count}{others} asked about and {lower} it by less than 0.1 % alone"));
    }
    if advice.untried > 0 {
        notes.push(format!(
            "for want of time {} more could not be asked about: --budget",
            advice.untried
        ));
    }
    if !advice.found.is_empty() {
        notes.push("state what is true, and ask again: what is worth nothing alone may be worth much then (scanbound advise --facts)".to_owned());
    }
    if !notes.is_empty() {
        text.push('\n');
    }
    for note in notes {
        let lines = wrap::lines(&note, extent.width.saturating_sub(4)).join("\n    ");
        text += &format!("  {lines}\n");
    }
    text
}

/// The answer in a sentence.
#[must_use]
pub fn answer(advice: &Advice) -> String {
    let Some(upper) = advice.upper else {
        return "Nothing bounds the scan, whatever is stated: a loop in it may never end (scanbound audit).".to_owned();
    };
    let now = format!("The bound is {}", at_most(upper));
    match advice.found.first() {
        None if advice.untried > 0 => {
            format!("{now}; nothing that was asked about in the time allowed lowers that.")
        }
        None => format!("{now}; no single statement that was asked about lowers that."),
        Some(best) => format!(
            "{now}. One statement more makes it {} at best; each bound here is that of an audit with the line.",
            at_most(best.bound.upper)
        ),
    }
}

fn statement(advice: &Advice, one: &Measured, extent: Extent) -> String {
    let upper = advice.upper.unwrap_or(one.bound.upper);
    let gain = upper.checked_sub(one.bound.upper).unwrap_or_default();
    let line = match extent.detail {
        Detail::Full => one.statement.line.clone(),
        _ => wrap::cut(&one.statement.line, extent.width.saturating_sub(36)),
    };
    let cut = match one.bound.cut {
        true => "; the time limit ended that audit: a longer --time-limit may find less",
        false => "",
    };
    let row = vec![
        right(at_most(one.bound.upper)).styled(BOLD),
        right(format!("-{}", Share::of(gain, upper))),
        left(format!("[{}] {line}", one.statement.table)),
    ];
    let mut text = fitted(2, &[row], extent.width);
    text += &wrap::paragraph(6, &(one.statement.what.clone() + cut), extent.width);
    let rows: Vec<_> = one
        .statement
        .places
        .iter()
        .take(MAX_PLACES)
        .map(|(at, instruction)| vec![left(place(advice, *at)), left(&**instruction)])
        .collect();
    text += &fitted(6, &rows, extent.width);
    if one.statement.places.len() > MAX_PLACES {
        text += &format!("      and {} more places\n", one.statement.places.len() - MAX_PLACES);
    }
    text
}

fn place(advice: &Advice, at: Location) -> String {
    let file = advice
        .files
        .get(at.file as usize)
        .map_or("", |name| short_file_name(name, advice.files.iter().map(String::as_str)));
    let step = at.step.map_or(String::new(), |step| format!(" step {step}"));
    format!("{file}:{}{step}", at.line)
}
