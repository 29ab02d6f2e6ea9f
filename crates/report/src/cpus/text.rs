//! One program by every table of its family as text: the answer, and a row a table.

use crate::columns::{Cell, fitted, left, paint, right};
use crate::format::{Detail, Extent};
use crate::wrap;
use anstyle::{AnsiColor, Style};
use scanbound_audit::Share;
use scanbound_audit::cpus::{CpuComparison, CpuResult, CpuScanTime, Limit};
use scanbound_audit::verdict::{Check, Verdict};
use scanbound_base::time_text::at_most;

const BOLD: Style = Style::new().bold();
const GOOD: Style = AnsiColor::Green.on_default().bold();
const CARE: Style = AnsiColor::Yellow.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();

/// From so many thousandths on a share is told as so many times.
const MANY_TIMES: u64 = 10_000;
/// So many reasons are told, and instructions without a time.
const MAX_LISTED: usize = 5;

/// The choice. Has colour codes.
#[must_use]
pub fn render(choice: &CpuComparison, extent: Extent) -> String {
    let told = wrap::paragraph(0, &answer(choice), extent.width);
    let mut text = format!("{}\n\n", paint(BOLD, told.trim_end()));
    let mut rows = vec![heads(choice)];
    rows.extend(choice.candidates.iter().map(|one| row(choice, one)));
    text += &fitted(0, &rows, extent.width);
    let mut notes = notes(choice);
    let most = if extent.detail == Detail::Full { usize::MAX } else { MAX_LISTED };
    notes.extend(without_times(choice, most));
    notes.extend(reasons(choice, extent));
    if !notes.is_empty() {
        text.push('\n');
    }
    for note in &notes {
        let lines = wrap::lines(note, extent.width.saturating_sub(4)).join("\n    ");
        text += &format!("  {lines}\n");
    }
    text
}

/// The answer in a sentence.
#[must_use]
pub fn answer(choice: &CpuComparison) -> String {
    let Some(limit) = limit(choice) else {
        let found = choice.candidates.iter().filter(|one| one.outcome.is_ok()).count();
        return format!("The bound by {found} timing tables, the slowest CPU first.");
    };
    match choice.slowest() {
        Some(one) => {
            let bound = one.outcome.as_ref().ok().and_then(|found| found.all_points);
            format!(
                "{} is the slowest CPU that keeps to {limit}: no scan takes longer than {}.",
                name(one),
                bound.map_or(String::new(), at_most)
            )
        }
        None => format!("No CPU of these is proved to keep to {limit}."),
    }
}

/// What a limit is called.
fn limit(choice: &CpuComparison) -> Option<String> {
    let margin = match choice.condition.margin.is_none() {
        true => String::new(),
        false => format!(" with a margin of {}", choice.condition.margin),
    };
    Some(match choice.condition.limit? {
        Limit::Time(time) => at_most(time) + &margin,
        Limit::Watchdog => format!("its watchdog{margin}"),
    })
}

/// A table by a CPU that it is for.
fn name(one: &CpuResult) -> String {
    match one.cpu.as_ref().or(one.cpus.first()) {
        None => format!("table {}", one.table),
        Some(cpu) => format!("{cpu} (table {})", one.table),
    }
}

/// The CPUs of a table: one of them, and how many others.
fn cpus(one: &CpuResult) -> String {
    match (one.cpu.as_ref().or(one.cpus.first()), one.cpus.len()) {
        (None, _) => String::new(),
        (Some(cpu), 0 | 1) => cpu.clone(),
        (Some(cpu), count) => format!("{cpu} (+{})", count - 1),
    }
}

/// Whether what a limit is held against is more than the bound.
fn has_points(choice: &CpuComparison) -> bool {
    choice.condition.limit.is_some()
        && found(choice).any(|(_, found)| found.all_points != found.upper)
}

fn heads(choice: &CpuComparison) -> Vec<Cell> {
    let mut heads = vec![left(" "), left("table"), left("CPU (+ others)"), right("bound")];
    if has_points(choice) {
        heads.push(right("all points"));
    }
    if choice.condition.limit.is_some() {
        heads.push(right("of limit"));
    }
    heads.push(right("assumed"));
    if choice.condition.limit.is_some() {
        heads.push(left("verdict"));
    }
    heads.into_iter().map(|cell| cell.styled(BOLD)).collect()
}

fn row(choice: &CpuComparison, one: &CpuResult) -> Vec<Cell> {
    let limited = choice.condition.limit.is_some();
    let is_chosen = choice.slowest().is_some_and(|chosen| chosen.table == one.table);
    let mark = match (is_chosen, one.is_own) {
        (true, true) => left(">*").styled(GOOD),
        (true, false) => left(">").styled(GOOD),
        (false, true) => left(" *"),
        (false, false) => left(" "),
    };
    let style = if is_chosen { BOLD } else { Style::new() };
    let mut cells = vec![mark, left(&one.table).styled(style), left(cpus(one))];
    let time = |time: Option<_>| right(time.map_or("endless".to_owned(), at_most));
    let points = has_points(choice);
    match &one.outcome {
        Ok(found) => {
            cells.push(time(found.upper));
            cells.extend(points.then(|| time(found.all_points)));
            let share = found.check.as_ref().map_or("-".to_owned(), of_limit);
            cells.extend(limited.then(|| right(share)));
            cells.push(right(found.assumed.to_string()));
            cells.extend(limited.then(|| verdict(found)));
        }
        Err(_) => {
            cells.push(right("none"));
            let dashes = usize::from(points) + usize::from(limited) + 1;
            cells.extend((0..dashes).map(|_| right("-")));
            cells.extend(limited.then(|| left("no bound").styled(BAD)));
        }
    }
    cells
}

fn of_limit(check: &Check) -> String {
    let share = Share::of(check.upper, check.limit);
    match share.0 {
        thousandths if thousandths >= MANY_TIMES => format!("{} times", thousandths / 1000),
        _ => share.to_string(),
    }
}

fn verdict(found: &CpuScanTime) -> Cell {
    match found.check.as_ref().map(|check| &check.verdict) {
        None => left("no watchdog"),
        Some(Verdict::Proved) => left("proved").styled(GOOD),
        Some(Verdict::Refuted) => left("refuted").styled(BAD),
        Some(Verdict::Undecided(_)) => left("undecided").styled(CARE),
    }
}

fn found(choice: &CpuComparison) -> impl Iterator<Item = (&CpuResult, &CpuScanTime)> {
    choice.candidates.iter().filter_map(|one| Some((one, one.outcome.as_ref().ok()?)))
}

/// What the marks and columns mean.
fn notes(choice: &CpuComparison) -> Vec<String> {
    let mut notes = Vec::new();
    if choice.slowest().is_some() {
        notes.push("> the slowest CPU that keeps to the limit".to_owned());
    }
    if choice.candidates.iter().any(|one| one.is_own) {
        notes.push("* the program's own CPU".to_owned());
    }
    if has_points(choice) {
        notes.push("all points: the bound with all I/O points that the CPU can have. It is not stated how many are fitted ([io] in --facts), so the limit is held against this".to_owned());
    }
    if !choice.condition.margin.is_none() {
        notes.push(format!("of limit, verdict: with the margin of {}", choice.condition.margin));
    }
    if found(choice).next().is_some() {
        let told =
            "assumed: how much of the bound rests on times that nobody has published or measured";
        notes.push(told.to_owned());
    }
    if found(choice).any(|(_, found)| found.is_cut) {
        notes.push("the time limit ended the search by some tables: a longer --time-limit may lower their bounds".to_owned());
    }
    notes
}

/// What has no time in which table.
fn without_times(choice: &CpuComparison, most: usize) -> Vec<String> {
    let refused =
        choice.candidates.iter().filter_map(|one| Some((one, one.outcome.as_ref().err()?)));
    let told = |(one, faults): (&CpuResult, &Vec<_>)| {
        let mut messages: Vec<&str> = Vec::new();
        for fault in faults {
            let fault: &scanbound_base::diagnostic::Diagnostic = fault;
            if !messages.contains(&fault.message.as_str()) {
                messages.push(&fault.message);
            }
        }
        let more = messages.len().saturating_sub(most);
        messages.truncate(most);
        let more = if more > 0 { format!("; and {more} more (-v)") } else { String::new() };
        format!("{}: {}{more}", one.table, messages.join("; "))
    };
    refused.map(told).collect()
}

/// Why the fastest CPU that is undecided is so, or all of them.
fn reasons(choice: &CpuComparison, extent: Extent) -> Vec<String> {
    let undecided = found(choice).filter_map(|(one, found)| match &found.check.as_ref()?.verdict {
        Verdict::Undecided(reasons) => Some((one, reasons)),
        Verdict::Proved | Verdict::Refuted => None,
    });
    let most = if extent.detail == Detail::Full { usize::MAX } else { 1 };
    let is_open = choice.slowest().is_none() || extent.detail == Detail::Full;
    let told = undecided.collect::<Vec<_>>().into_iter().rev().filter(|_| is_open).take(most);
    let told = told.map(|(one, reasons)| {
        let reasons: Vec<String> = reasons.iter().map(ToString::to_string).collect();
        format!("{} is undecided: {}", one.table, reasons.join("; "))
    });
    told.collect()
}
