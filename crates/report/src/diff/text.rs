//! The difference of two versions as text for people: the bound before and after, and what each change costs.

use crate::columns::{Cell, fitted, left, paint, right};
use crate::format::{Detail, Extent};
use crate::wrap;
use anstyle::{AnsiColor, Style};
use scanbound_audit::difference::{Change, ChangeKind, Difference};
use scanbound_base::time::Picos;
use scanbound_base::time_text::{about, at_most};

const BOLD: Style = Style::new().bold();
const MORE: Style = AnsiColor::Red.on_default();
const LESS: Style = AnsiColor::Green.on_default();

/// The difference. Has colour codes.
#[must_use]
pub fn render(found: &Difference, extent: Extent) -> String {
    let mut text = wrap::paragraph(0, &answer(found), extent.width);
    text = format!("{}\n", paint(BOLD, text.trim_end()));
    if found.is_doubtful {
        let told = "what is not stated may make the bounds too low: scanbound audit says what";
        text += &wrap::paragraph(2, told, extent.width);
    }
    let top = if extent.detail == Detail::Full { usize::MAX } else { extent.top };
    let differing =
        found.changes.iter().filter(|one| one.kind != ChangeKind::Moved || one.delta() != 0);
    let mut rows: Vec<Vec<Cell>> = differing.clone().take(top).map(row).collect();
    let rest: Vec<&Change> = differing.skip(top).collect();
    let besides = |delta: i128, what: String| vec![amount(delta), left(what)];
    if !rest.is_empty() {
        let delta = rest.iter().map(|one| one.delta()).sum();
        rows.push(besides(delta, format!("{} other changes (-v)", rest.len())));
    }
    if found.besides != 0 {
        let what =
            "outside rungs: END processing and the like, the factor, what the search left open";
        rows.push(besides(found.besides, what.to_owned()));
    }
    if !rows.is_empty() {
        text += &format!(
            "\n{}\n{}",
            paint(BOLD, "What changes the bound"),
            fitted(2, &rows, extent.width)
        );
    }
    text += &wrap::paragraph(2, &counts(found), extent.width);
    text
}

/// The two bounds and how far they are apart, in a sentence.
#[must_use]
pub fn answer(found: &Difference) -> String {
    let (old, new) = (at_most(found.old), at_most(found.new));
    let bound = match found.delta() {
        0 => format!("The bound stays at {new}."),
        delta => format!(
            "The bound {} from {old} to {new}: {} ({}).",
            if delta > 0 { "rises" } else { "falls" },
            signed(delta),
            percent(found.thousandths())
        ),
    };
    match found.is_endless {
        true => format!("A scan of the new version may never end. Of scans that end: {bound}"),
        false => bound,
    }
}

/// A difference with its sign.
pub(crate) fn signed(delta: i128) -> String {
    let time = Picos(u64::try_from(delta.unsigned_abs()).unwrap_or(u64::MAX));
    match delta.signum() {
        0 => "0".to_owned(),
        1 => format!("+{}", about(time)),
        _ => format!("-{}", about(time)),
    }
}

fn percent(thousandths: i128) -> String {
    let sign = if thousandths < 0 { "-" } else { "+" };
    let (whole, part) = (thousandths.abs() / 10, thousandths.abs() % 10);
    format!("{sign}{whole}.{part} %")
}

fn amount(delta: i128) -> Cell {
    let style = match delta.signum() {
        0 => Style::new(),
        1 => MORE,
        _ => LESS,
    };
    right(signed(delta)).styled(style)
}

fn row(one: &Change) -> Vec<Cell> {
    vec![amount(one.delta()), left(format!("{}, {}", place(one), words(one)))]
}

/// Where it stands: in the new version, else where it stood.
pub(crate) fn place(one: &Change) -> String {
    let name = |file: &str| file.rsplit(['/', '\\']).next().unwrap_or(file).to_owned();
    let side = one.new.as_ref().or(one.old.as_ref());
    side.map_or(String::new(), |side| {
        let step = side.at.step.map_or(String::new(), |step| format!(" step {step}"));
        format!("{}:{}{step}", name(&side.file), side.at.line)
    })
}

/// What became of it, with what differs between its two texts.
pub(crate) fn words(one: &Change) -> String {
    let text = |side: &Option<scanbound_audit::difference::Side>| {
        side.as_ref().map_or(String::new(), |side| side.text.clone())
    };
    let (old, new) = (text(&one.old), text(&one.new));
    match one.kind {
        ChangeKind::Added => format!("added: {new}"),
        ChangeKind::Removed => format!("removed: {old}"),
        ChangeKind::Moved => format!("moved here: {new}"),
        ChangeKind::Same => format!("unchanged, but runs otherwise in the longest scan: {new}"),
        ChangeKind::Changed => {
            let (before, after): (Vec<&str>, Vec<&str>) =
                (old.split(" / ").collect(), new.split(" / ").collect());
            let head = before.iter().zip(&after).take_while(|(a, b)| a == b).count();
            let most = before.len().min(after.len()) - head;
            let tails = before.iter().rev().zip(after.iter().rev());
            let tail = tails.take_while(|(a, b)| a == b).count().min(most);
            let middle = |parts: &[&str]| match &parts[head..parts.len() - tail] {
                [] => "nothing".to_owned(),
                parts => parts.join(" / "),
            };
            format!("changed: {} became {}", middle(&before), middle(&after))
        }
    }
}

/// How many rungs of each kind there are.
pub(crate) fn counts(found: &Difference) -> String {
    let of = |kind| found.changes.iter().filter(|one| one.kind == kind).count();
    format!(
        "rungs: {} changed, {} added, {} removed, {} moved, {} the same",
        of(ChangeKind::Changed),
        of(ChangeKind::Added),
        of(ChangeKind::Removed),
        of(ChangeKind::Moved),
        of(ChangeKind::Same) + found.unchanged
    )
}
