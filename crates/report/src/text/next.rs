//! What to do next, the most useful first.

use super::style::BOLD;
use super::words::place;
use crate::columns::{Cell, left};
use scanbound_audit::{Audit, Doubt, Share, UnstatedPoints};
use scanbound_base::time_text::about;

/// So many steps are told.
const MAX_NEXT_STEPS: usize = 2;

/// More than this rests on assumed times before it is worth a word.
const MUCH: Share = Share(200);

/// Rows to be read behind "next".
pub(super) fn next(audit: &Audit) -> Vec<Vec<Cell>> {
    let label = |index: usize| left(if index == 0 { "next" } else { "" }).styled(BOLD);
    let steps = steps(audit).into_iter().take(MAX_NEXT_STEPS).enumerate();
    steps.map(|(at, step)| vec![label(at), left(step)]).collect()
}

/// All steps.
pub(crate) fn steps(audit: &Audit) -> Vec<String> {
    let mut found = Vec::new();
    let facts = format!("scanbound facts {}", audit.named);
    let facts = facts.trim_end();
    // What hides the counts comes first in the order of what is known then; the largest count is what lowers the bound.
    let first = audit.unknowns.first().filter(|first| first.counts().is_none());
    let counts = audit.unknowns.iter().filter_map(|one| Some((one.counts()?.cost, one)));
    let largest = counts.rev().max_by_key(|(cost, _)| *cost).map(|(_, one)| one);
    for first in largest.into_iter().chain(first) {
        let at = place(audit, first.places[0].0);
        found.push(match first.counts() {
            Some(counts) => format!(
                "state what {} is at most ({at}), up to {} of the bound depend on it: {facts}",
                first.word,
                about(counts.cost)
            ),
            None => format!(
                "state {} ({at}): what is written there may be anywhere: {facts}",
                first.word
            ),
        });
    }
    if !audit.cuts.is_empty() {
        found.push("give it more time: --time-limit 10min".to_owned());
    }
    for doubt in audit.all_doubts() {
        found.extend(match doubt {
            Doubt::Networks { .. } => Some(
                "state what network refresh takes: [network] refresh = \"1.5ms\" (--facts)"
                    .to_owned(),
            ),
            Doubt::Bodiless { names, .. } => names.first().map(|name| {
                format!("give the code of {name}, or state its time: [calls] \"{name}\" (--facts)")
            }),
            Doubt::Interrupts { name, .. } => {
                let option = match name.contains(' ') {
                    true => format!("'{name}=2'"),
                    false => format!("{name}=2"),
                };
                Some(format!("state how often {name} interrupts a scan: --interrupts {option}"))
            }
            _ => None,
        });
    }
    // No fewer than the program is seen to use.
    let side = |points: &UnstatedPoints| format!("{}s = {}", points.side, points.taken);
    let sides: Vec<String> = audit.points.iter().map(side).collect();
    if !sides.is_empty() {
        found.push(format!("state the I/O points: [io] {} or more (--facts)", sides.join(", ")));
    }
    if audit.assumed_share() >= MUCH {
        let first = audit.table.assumed.iter().find(|one| one.count > 0);
        found.extend(first.map(|one| {
            let name = one.name.split(' ').next().unwrap_or_default();
            format!("replace assumed times, {name} first: --time {name}=1.5us, or --table FILE")
        }));
    }
    found
}
