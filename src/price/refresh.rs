//! The refresh of inputs and outputs: what it is charged, and where nobody stated how many points there are.

use super::touched::Cells;
use super::{Evidence, OverheadTerm, charged};
use crate::diagnostic::Diagnostic;
use crate::facts::Facts;
use crate::program::{AreaId, Cell, Program};
use crate::table::{Row, Table};
use crate::time::Picos;

/// Points of one side of which nobody stated how many are refreshed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnstatedPoints {
    /// `input` or `output`.
    pub side: &'static str,
    /// How many were taken, as far as the program shows them.
    pub taken: u32,
    /// What their refresh was charged.
    pub time: Picos,
    /// What it would be charged for sixteen more at most.
    pub sixteen: Picos,
    /// How the number was found.
    pub why: String,
    /// All that the CPU can have, where the table says it.
    pub most: Option<MorePoints>,
}

/// The most points that a CPU can have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MorePoints {
    /// How many.
    pub points: u32,
    /// What the refresh of all of them takes beyond that of those taken.
    pub more: Picos,
    /// How well founded the number is.
    pub evidence: Evidence,
    /// How well founded the time is: the number and the rows that price it, the weakest of these.
    pub founded: Evidence,
    /// Where it comes from.
    pub source: String,
}

/// What all the points that the CPU can have take beyond those taken, as far as the table knows them.
#[must_use]
pub fn more_points(unstated: &[UnstatedPoints]) -> Picos {
    unstated.iter().filter_map(|points| points.most.as_ref()).map(|most| most.more).sum()
}

/// What the points were charged that were taken.
#[must_use]
pub fn points_taken(unstated: &[UnstatedPoints]) -> Picos {
    unstated.iter().map(|points| points.time).sum()
}

/// The terms of a scan for the refresh, and the sides whose points are not stated.
pub fn refresh(
    program: &Program,
    table: &Table,
    facts: &Facts,
) -> Result<(Vec<OverheadTerm>, Vec<UnstatedPoints>), Vec<Diagnostic>> {
    let sides = [
        ("input", "X", facts.inputs, &table.most_inputs),
        ("output", "Y", facts.outputs, &table.most_outputs),
    ];
    let (mut terms, mut unstated) = (Vec::new(), Vec::new());
    for (side, area, stated, most) in sides {
        let rows = [8u32, 16].map(|size| (size, table.row(&format!("@{side}{size}"))));
        let rows: Vec<(u32, &Row)> =
            rows.into_iter().filter_map(|(size, row)| Some((size, row?))).collect();
        if rows.is_empty() {
            continue;
        }
        let of = |points: u32| -> Result<Picos, Vec<Diagnostic>> {
            let times = |size: u32| u64::from(points.div_ceil(size));
            rows.iter().map(|&(size, row)| charged(table, row, times(size))).sum()
        };
        let (points, origin) = match stated {
            Some(stated) => (stated, format!("{stated} {side} points as stated")),
            None => points_seen(program, side, area),
        };
        if stated.is_none() {
            let most = most.as_ref().map(|most| -> Result<MorePoints, Vec<Diagnostic>> {
                Ok(MorePoints {
                    points: most.points,
                    more: of(most.points)?.checked_sub(of(points)?).unwrap_or_default(),
                    evidence: most.evidence,
                    founded: rows
                        .iter()
                        .map(|(_, row)| row.evidence)
                        .fold(most.evidence, Evidence::min),
                    source: most.source.clone(),
                })
            });
            unstated.push(UnstatedPoints {
                side,
                taken: points,
                time: of(points)?,
                sixteen: of(16)?,
                why: origin.clone(),
                most: most.transpose()?,
            });
        }
        for (size, row) in rows.iter().filter(|_| points > 0) {
            let count = u64::from(points.div_ceil(*size));
            let unit = row.on.us_text();
            let why = format!("{origin}: {count} x {unit} us a {size} points; {}", row.source);
            let time = charged(table, row, count)?;
            let name = format!("{side} refresh");
            terms.push(OverheadTerm { name, time, evidence: row.evidence, why });
        }
    }
    Ok((terms, unstated))
}

/// How many points the program is seen to use, and how that was found.
#[must_use]
pub fn points_seen(program: &Program, side: &str, area: &str) -> (u32, String) {
    let counted =
        program.points.map(|[inputs, outputs]| if side == "input" { inputs } else { outputs });
    match (counted, highest(program, area)) {
        (Some(points), _) => (
            points,
            format!("{points} {side} points in the words that the program uses as {side}s"),
        ),
        (None, None) => (0, format!("the program uses no {side}")),
        (None, Some(cell)) => {
            let points = cell.index.saturating_add(1).div_ceil(16).saturating_mul(16);
            let name = program.cell_name(cell);
            (points, format!("{points} {side} points, since {name} is the highest {side} used"))
        }
    }
}

/// The highest cell of an area that an instruction names.
fn highest(program: &Program, area_name: &str) -> Option<Cell> {
    let mine =
        |area: AreaId| program.areas[usize::from(area.0)].name.eq_ignore_ascii_case(area_name);
    program
        .instructions
        .iter()
        .flat_map(|instruction| Cells::of(instruction, 1).areas)
        .filter(|of| mine(of.area))
        .filter_map(|of| Some(Cell { area: of.area, index: of.highest? }))
        .max_by_key(|cell| cell.index)
}
