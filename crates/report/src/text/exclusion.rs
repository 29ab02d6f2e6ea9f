//! Which rungs cannot run together with the longest scan, and why; the groups with their rungs.

use super::style::{BOLD, CARE, FAINT, GOOD};
use super::words::{capped, count, heading, more, named, place, us, wrapped};
use crate::columns::{Cell, fitted, left, right};
use crate::format::{Detail, Extent};
use scanbound_audit::{Audit, Exclusion, Fate, GroupUse, RungUse};
use scanbound_base::time::Picos;
use scanbound_base::time_text::at_most;

/// So many rungs are told unless all are asked for.
const MAX_RUNGS: usize = 6;
/// Through more devices than this nothing is told.
const MAX_DEVICES: usize = 4;

/// The rungs that cost less than they could, those that would add most first.
pub(super) fn excluded(audit: &Audit, extent: Extent) -> String {
    let rungs = audit.groups.iter().flat_map(|group| &group.rungs);
    let spared = |rung: &RungUse| audit.bare(rung.naive.checked_sub(rung.cost).unwrap_or_default());
    let mut told: Vec<(Picos, &RungUse, &Exclusion)> = rungs
        .filter_map(|rung| Some((spared(rung), rung, rung.exclusion.as_ref()?)))
        .filter(|(spared, ..)| *spared > Picos::ZERO)
        .collect();
    told.sort_by_key(|(spared, rung, _)| (std::cmp::Reverse(*spared), rung.block));
    let shown = if extent.detail == Detail::Full { told.len() } else { extent.top.min(MAX_RUNGS) };
    if told.is_empty() || shown == 0 {
        return String::new();
    }
    let rows: Vec<Vec<Cell>> = told
        .iter()
        .take(shown)
        .map(|(spared, rung, why)| {
            vec![
                right(at_most(*spared)),
                left(place(audit, rung.at)),
                left(format!("{}: {}", rung.instruction, reason(audit, rung, why))),
            ]
        })
        .collect();
    heading("What can not run in the same scan, and so is not in the bound", extent)
        + &fitted(2, &rows, extent.width)
        + &more(told.len(), shown, "such rung", "such rungs")
}

fn reason(audit: &Audit, rung: &RungUse, why: &Exclusion) -> String {
    let through = match why.devices.len() {
        // So many tell nothing.
        1..=MAX_DEVICES => format!(" through {}", why.devices.join(", ")),
        _ => String::new(),
    };
    match why.blocks.as_slice() {
        [] => format!("never costs more{through}"),
        [one] if *one == rung.block => format!("not all of it in one scan{through}"),
        blocks => {
            let names: Vec<String> = blocks.iter().map(|&block| named_rung(audit, block)).collect();
            format!("excluded by {}{through}", capped(&names, 4).join(", "))
        }
    }
}

/// A rung by the place of its slowest instruction, or by its number.
fn named_rung(audit: &Audit, block: u32) -> String {
    let rungs = audit.groups.iter().flat_map(|group| &group.rungs);
    let found = rungs.into_iter().find(|rung| rung.block == block);
    found.map_or_else(
        || format!("rung {block}"),
        |rung| format!("rung {block} ({})", place(audit, rung.at)),
    )
}

/// A group's rungs, the longest first.
pub(super) fn group(audit: &Audit, group: &GroupUse, extent: Extent) -> String {
    let exact = if group.exact() {
        String::from("exact")
    } else {
        format!("at least {}", us(audit.bare(group.lower)))
    };
    let title = format!(
        "Group {}: at most {}, {exact}; {}",
        group.id,
        us(audit.bare(group.upper)),
        count(group.blocks.len(), "rung", "rungs")
    );
    let ties: Vec<String> = group.ties.iter().map(|tie| named(&tie.device, &tie.comment)).collect();
    let rows: Vec<Vec<Cell>> =
        group.rungs.iter().take(extent.top).map(|rung| self::rung(audit, rung)).collect();
    heading(&title, extent)
        + &wrapped("  tied by ", &capped(&ties, 10), extent)
        + &fitted(2, &rows, extent.width)
        + &more(group.rungs.len(), extent.top, "cheaper rung", "cheaper rungs")
}

fn rung(audit: &Audit, rung: &RungUse) -> Vec<Cell> {
    let (fate, style) = match rung.fate {
        Fate::Runs if rung.is_charged_off => ("off", GOOD),
        Fate::Runs => ("runs", GOOD),
        Fate::Partly => ("partly", CARE),
        Fate::Excluded => ("excluded", FAINT),
    };
    let (cost, naive) = (us(audit.bare(rung.cost)), us(audit.bare(rung.naive)));
    let time = match rung.fate {
        Fate::Runs => cost,
        Fate::Excluded if rung.cost == Picos::ZERO => format!("0 of {naive}"),
        Fate::Partly | Fate::Excluded => format!("{cost} of {naive}"),
    };
    let mut what = rung.instruction.to_string();
    if rung.others > 0 {
        what += &format!(" and {} more", rung.others);
    }
    let reason = rung.exclusion.as_ref().map(|why| reason(audit, rung, why));
    let off = "does not run: this is its time when off";
    let off = Some(off.to_owned()).filter(|_| rung.is_charged_off);
    let comments = Some(rung.comments.join(", ")).filter(|text| !text.is_empty());
    let notes: Vec<String> = [comments, off, reason].into_iter().flatten().collect();
    let notes = notes.join("; ");
    vec![
        left(fate).styled(style),
        right(time),
        left(format!("rung {}", rung.block)),
        left(place(audit, rung.at)),
        left(if notes.is_empty() { what } else { format!("{what}  {notes}") }).styled(BOLD),
    ]
}
