//! The first screen: the answer, what it rests on, where the time goes, what to do next.

use super::next::next;
use super::parts;
use super::style::{BOLD, CARE};
use super::verdict::{self, answer, reasons};
use super::watchdog;
use super::words::{capped, count, file, item, warnings};
use crate::columns::{Cell, fitted, left};
use crate::format::{Detail, Extent};
use crate::response;
use scanbound_audit::verdict::Check;
use scanbound_audit::{Audit, Share, TaskUse};
use scanbound_base::budget::EarlyStop;
use scanbound_base::time_text::about;

/// So many rungs are shown however small the screen is.
const FEWEST: usize = 3;

/// The first screen. Rungs are left out where it would be higher than the page, all else stays.
pub(super) fn first(audit: &Audit, check: Option<&Check>, extent: Extent) -> String {
    let mut text = answer(audit, check).lines(extent.width);
    text += &reasons(check).iter().map(|reason| item(2, reason, extent)).collect::<String>();
    let mut rows = fact_rows(audit, check);
    let mut last = next(audit);
    if extent.detail == Detail::Short {
        rows.extend(warned(audit));
        let told = "-v the whole report, --by program|rung|instruction where the time goes";
        last.push(vec![left("more").styled(BOLD), left(told)]);
    }
    text += &fitted(2, &rows, extent.width);
    let last = fitted(2, &last, extent.width);
    let whole = |top: usize| parts::largest(audit, Extent { top, ..extent });
    let lines = |part: &str| part.lines().count();
    // A line is left for the prompt.
    let room = extent.height.saturating_sub(1 + lines(&text) + lines(&last));
    let over = lines(&whole(extent.top)).saturating_sub(room);
    let top = match extent.top {
        top if top > Extent::default().top => top,
        top => top.saturating_sub(over).max(FEWEST.min(top)),
    };
    text + &whole(top) + &last
}

/// The first warning, and how many more there are: all are told behind the first screen only.
fn warned(audit: &Audit) -> Option<Vec<Cell>> {
    let all = warnings(audit);
    let first = all.first()?;
    let more = match all.len() - 1 {
        0 => String::new(),
        more => format!(" (and {more} more: -v)"),
    };
    Some(vec![left("warning").styled(CARE), left(format!("{first}{more}"))])
}

/// Something about the answer.
pub(crate) struct Fact {
    pub(crate) label: &'static str,
    pub(crate) told: String,
    /// Whether it is to be seen.
    is_care: bool,
}

fn fact_rows(audit: &Audit, check: Option<&Check>) -> Vec<Vec<Cell>> {
    let row = |fact: Fact| {
        let label = left(fact.label);
        vec![if fact.is_care { label.styled(CARE) } else { label }, left(fact.told)]
    };
    facts(audit, check).into_iter().map(row).collect()
}

/// What the answer is about and what it rests on. What a check's answer says itself is not said twice.
pub(crate) fn facts(audit: &Audit, check: Option<&Check>) -> Vec<Fact> {
    let cpu = audit.cpu.as_ref().map_or(String::new(), |cpu| format!("{cpu}, "));
    let files: Vec<String> =
        (0..).take(audit.files.len()).map(|one| file(audit, one).to_owned()).collect();
    let fact = |label, told| Fact { label, told, is_care: false };
    let mut found = vec![fact(
        "program",
        format!(
            "{}: {}; {cpu}table {}",
            capped(&files, 2).join(", "),
            count(audit.instructions, "instruction", "instructions"),
            audit.table.name
        ),
    )];
    if !audit.standby.is_empty() {
        let own: Vec<String> =
            audit.standby.iter().map(|&one| file(audit, one as u32).to_owned()).collect();
        let told = format!(
            "{}: subroutines alone, which run where they are called",
            capped(&own, 2).join(", ")
        );
        found.push(fact("on call", told));
    }
    found.extend(audit.tasks.iter().enumerate().map(|(at, one)| fact("task", task(one, at == 0))));
    found.extend(watchdog::cycle(audit).map(|told| fact("cycle", told)));
    found.extend(watchdog::told(audit, check).map(|told| fact("watchdog", told)));
    let rests = rests(audit, check);
    if !rests.is_empty() {
        found.push(fact("rests on", rests.join(", ")));
    }
    found.extend(response::nominal(audit).map(|told| fact("nominal", told)));
    found.extend(audit.cuts.iter().map(|cut| Fact {
        label: "ended",
        told: format!(
            "by {} while {}: {}{}",
            cut.reason,
            cut.stage,
            cut.unfinished,
            left_open(audit, cut)
        ),
        is_care: true,
    }));
    if audit.ended_early {
        let told = "as soon as the limit was decided; audit looks for the longest scan";
        found.push(fact("ended", told.to_owned()));
    }
    found
}

/// How far the bound is from a scan, where the search was cut short.
fn left_open(audit: &Audit, cut: &EarlyStop) -> String {
    let above = audit.bound.upper.checked_sub(audit.possible()).unwrap_or_default();
    match cut.stage {
        "searching" => format!("; the bound is {} above the longest scan found", about(above)),
        _ => String::new(),
    }
}

/// A task of several: how it is called, its bound by itself, and how long it takes with those that interrupt it.
fn task(one: &TaskUse, is_this: bool) -> String {
    let is_this = if is_this { " (this scan)" } else { "" };
    let every = match one.interval {
        Some(interval) => format!("every {interval}"),
        None => "no interval".to_owned(),
    };
    let level = match one.priority {
        Some(level) if level < i64::MAX => format!("priority {level}"),
        Some(_) => "behind all others".to_owned(),
        None => "no priority".to_owned(),
    };
    let alone = match one.upper {
        Some(upper) => format!("at most {upper} by itself"),
        None => "nothing bounds it".to_owned(),
    };
    let by = match one.interrupted_by.as_slice() {
        [] => "nothing interrupts it".to_owned(),
        names => format!("interrupted by {}", names.join(", ")),
    };
    let waits = match one.waits_for.as_slice() {
        [] => String::new(),
        names => format!(", takes turns with {}", names.join(", ")),
    };
    let response = match &one.response {
        Ok(time) => {
            format!("worked out from bounds and intervals, it has ended {time} after it is due")
        }
        Err(why) => format!("when it has ended cannot be worked out: {why}"),
    };
    format!("{}{is_this}: {every}, {level}; {alone}; {by}{waits}; {response}", one.name)
}

/// What the bound rests on, the weightiest first.
fn rests(audit: &Audit, check: Option<&Check>) -> Vec<String> {
    let mut found = Vec::new();
    let assumed = audit.assumed_share();
    if assumed > Share(0) && !check.is_some_and(verdict::tells_assumed) {
        let most = if audit.is_settled() { "" } else { "at most " };
        found.push(format!("assumed times ({most}{assumed})"));
    }
    let counted =
        |number: usize, one: &str, several: &str| (number > 0).then(|| count(number, one, several));
    let counts = audit.unknowns.iter().filter(|one| one.counts().is_some()).count();
    found.extend(counted(counts, "count that nobody stated", "counts that nobody stated"));
    let indices = audit.unknowns.len() - counts;
    found.extend(counted(indices, "index that nobody stated", "indices that nobody stated"));
    let trusted = audit.assumptions.len();
    found.extend(counted(trusted, "trusted word", "trusted words"));
    found.extend(counted(audit.facts.len(), "stated fact", "stated facts"));
    found.extend(verdict::not_stated(audit).into_iter().map(|what| format!("{what} not stated")));
    found
}
