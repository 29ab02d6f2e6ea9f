//! Where the time goes: rows that add up to the bound.

use super::style::{BOLD, FAINT};
use super::words::{count, file, heading, item, place};
use crate::columns::{Cell, fitted, left, right};
use crate::format::{Detail, Extent};
use crate::wrap;
use scanbound_audit::breakdown::{By, Part, Piece};
use scanbound_audit::{Audit, Evidence, Share};
use scanbound_base::time::Picos;
use scanbound_base::time_text::{Scale, at_most};
use unicode_width::UnicodeWidthStr;

/// The table has at least so many rows where it is asked for.
const ASKED: usize = 40;

/// Where more of the bound is left open, its parts are not shown.
const MUCH_OPEN: Share = Share(250);

/// So many programs are named on the first screen.
const PROGRAMS: usize = 3;

/// A row before its time is rounded: the time, what of the program, and its text.
struct Row {
    time: Picos,
    what: String,
    text: String,
    /// What follows the text, and is not cut off.
    rest: String,
    is_code: bool,
}

impl Row {
    fn told(time: Picos, what: String, text: String) -> Row {
        Row { time, what, text, rest: String::new(), is_code: false }
    }
}

/// The programs and the rungs with the most time, and all others together. Where a search ended early and left much of
/// the bound open, its parts say nothing.
pub(super) fn largest(audit: &Audit, extent: Extent) -> String {
    let upper = at_most(audit.bound.upper);
    let left_open = audit.breakdown(By::Program).into_iter();
    let left_open = left_open.filter(|part| part.piece == Piece::Open);
    if audit.ended_early && left_open.map(|part| part.share(audit)).max() > Some(MUCH_OPEN) {
        let told = "audit tells where the time goes: the check ended before that was known";
        return format!("\n{}", item(2, told, extent));
    }
    let title = match audit.upper_with_all_points() > audit.bound.upper {
        true => format!("Where the time goes: {upper} with the points that the program names"),
        false => format!("Where the {upper} go"),
    };
    let mut text = heading(&title, extent);
    if audit.files.len() > 1 {
        text += &fitted(2, &[vec![left("programs"), left(programs(audit))]], extent.width);
    }
    text + &table(audit, By::Rung, extent.top, extent, true)
}

/// The bound shared out as it was asked for.
pub(super) fn asked(audit: &Audit, by: By, extent: Extent) -> String {
    let top = match extent.detail {
        Detail::Full => usize::MAX,
        _ => extent.top.max(ASKED),
    };
    let upper = at_most(audit.bound.upper);
    heading(&format!("Where the {upper} go, by {}", by.name()), extent)
        + &table(audit, by, top, extent, false)
}

fn programs(audit: &Audit) -> String {
    let parts = audit.breakdown(By::Program);
    let (programs, others): (Vec<&Part>, Vec<&Part>) =
        parts.iter().partition(|part| matches!(part.piece, Piece::Program(_)));
    let share =
        |parts: &[&Part]| Share::of(parts.iter().map(|part| part.time).sum(), audit.bound.upper);
    let worth = programs.iter().filter(|part| part.share(audit) > Share(0)).count();
    let shown = worth.min(PROGRAMS);
    let mut told: Vec<String> = programs[..shown]
        .iter()
        .map(|part| match part.piece {
            Piece::Program(index) => format!("{} {}", file(audit, index), part.share(audit)),
            _ => String::new(),
        })
        .collect();
    if let Some(rest) = programs.get(shown..).filter(|rest| !rest.is_empty()) {
        told.push(format!("{} more {}", rest.len(), share(rest)));
    }
    told.push(format!("outside programs {}", share(&others)));
    told.join(", ")
}

/// A row as it is shown: the time and the share as text, what of the program, and more about it.
pub(crate) struct PartRow {
    pub(crate) told: String,
    pub(crate) share: Share,
    pub(crate) what: String,
    pub(crate) text: String,
    /// What follows the text.
    pub(crate) rest: String,
    /// Whether the text is an instruction's.
    pub(crate) is_code: bool,
}

/// The parts with the most time, the others together, and what belongs to no part of the program: what is shown of
/// their times adds up to what is shown of the bound. In short, what each scan costs is one row.
pub(crate) fn shown(audit: &Audit, by: By, top: usize, is_short: bool) -> Vec<PartRow> {
    let rows = rows(audit, by, top, is_short);
    let times: Vec<Picos> = rows.iter().map(|row| row.time).collect();
    let told = Scale::of(audit.bound.upper).parts(&times);
    let shown = |(row, told): (Row, String)| PartRow {
        told,
        share: Share::of(row.time, audit.bound.upper),
        what: row.what,
        text: row.text,
        rest: row.rest,
        is_code: row.is_code,
    };
    rows.into_iter().zip(told).map(shown).collect()
}

fn rows(audit: &Audit, by: By, top: usize, is_short: bool) -> Vec<Row> {
    let parts = audit.breakdown(by);
    let of_program =
        |part: &&Part| !matches!(part.piece, Piece::EveryScan(_) | Piece::Open | Piece::Factor(_));
    let (own, besides): (Vec<&Part>, Vec<&Part>) = parts.iter().partition(of_program);
    let worth = own.iter().filter(|part| part.time > Picos::ZERO).count();
    let shown = worth.min(top);
    let mut rows: Vec<Row> = own[..shown].iter().map(|part| row(audit, part)).collect();
    let sum = |parts: &[&Part]| -> Picos { parts.iter().map(|part| part.time).sum() };
    let rest = &own[shown..];
    if !rest.is_empty() {
        let other = if shown == 0 { "" } else { "other " };
        let one = format!("{other}{}", by.name());
        let text = if worth <= shown { "nothing in that scan" } else { "" };
        let what = count(rest.len(), &one, &format!("{one}s"));
        rows.push(Row::told(sum(rest), what, text.to_owned()));
    }
    let (every, last): (Vec<&Part>, Vec<&Part>) =
        besides.into_iter().partition(|part| matches!(part.piece, Piece::EveryScan(_)));
    if is_short && every.len() > 1 {
        let names = every.iter().filter_map(|part| match &part.piece {
            Piece::EveryScan(name) => Some(name.as_str()),
            _ => None,
        });
        let text = names.collect::<Vec<_>>().join(", ");
        rows.push(Row::told(sum(&every), "every scan".to_owned(), text));
    } else {
        rows.extend(every.iter().map(|part| row(audit, part)));
    }
    rows.extend(last.iter().map(|part| row(audit, part)));
    rows
}

fn table(audit: &Audit, by: By, top: usize, extent: Extent, is_short: bool) -> String {
    let rows = shown(audit, by, top, is_short);
    let what = rows.iter().map(|row| row.what.width()).max().unwrap_or(0);
    let time = rows.iter().map(|row| row.told.width()).max().unwrap_or(0);
    // Two blanks in front and between, and the share.
    let room = extent.width.saturating_sub(2 + time + 2 + 7 + 2 + what + 2);
    let cells: Vec<Vec<Cell>> = rows
        .into_iter()
        .map(|row| {
            let room = room.saturating_sub(row.rest.width());
            let text = if is_short { wrap::cut(&row.text, room) } else { row.text };
            let text = text + &row.rest;
            let text = left(text).styled(if row.is_code { BOLD } else { FAINT });
            vec![right(row.told), right(row.share.to_string()), left(row.what), text]
        })
        .collect();
    fitted(2, &cells, if is_short { usize::MAX } else { extent.width })
}

fn row(audit: &Audit, part: &Part) -> Row {
    let assumed = |evidence| if evidence == Evidence::Assumed { " (assumed)" } else { "" };
    let (what, text) = match &part.piece {
        Piece::Program(index) => (file(audit, *index).to_owned(), instructions(part)),
        Piece::Routine(index, name) => {
            let file = file(audit, *index);
            match name {
                Some(name) => (format!("{file} {name}"), instructions(part)),
                None => (file.to_owned(), format!("main routine, {}", instructions(part))),
            }
        }
        Piece::Rung { at, instruction, .. } => {
            let others = match part.instructions {
                0 | 1 => String::new(),
                n => format!(" and {} more", n - 1),
            };
            return Row {
                time: part.time,
                what: place(audit, *at),
                text: instruction.to_string(),
                rest: others,
                is_code: true,
            };
        }
        Piece::Instruction(name) => {
            (name.to_string(), format!("{} in the program", part.instructions))
        }
        Piece::EveryScan(name) => {
            let term = audit.overhead.iter().find(|term| term.name == *name);
            let why = term.map_or(String::new(), |term| {
                let why = term.why.split(';').next().unwrap_or_default();
                format!("{why}{}", assumed(term.evidence))
            });
            (name.clone(), why)
        }
        Piece::Open => {
            // The bound above the longest scan that was found.
            let why = match audit.ended_early {
                true => "not needed to decide the limit",
                false => "unknown: more time may lower it",
            };
            ("left open".to_owned(), why.to_owned())
        }
        Piece::Factor(text) => {
            let evidence = audit.table.factor.as_ref().map(|one| one.evidence);
            (
                format!("factor {text}"),
                format!("on all of the above{}", evidence.map_or("", assumed)),
            )
        }
    };
    Row::told(part.time, what, text)
}

fn instructions(part: &Part) -> String {
    count(part.instructions, "instruction", "instructions")
}
