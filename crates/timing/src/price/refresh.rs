//! Refresh of inputs and outputs: its overhead, and what the user could state about points and base units.

use super::networks::{each_region, known_length};
use super::overhead::{OverheadTerm, charged};
use crate::table::{Evidence, MostPoints, Row, Table};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::{Facts, Part};
use scanbound_base::time::Picos;
use scanbound_ir::{Cell, Program, Region, Role};
use std::collections::BTreeSet;

/// Inputs or outputs for which the number of refreshed points is not stated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnstatedPoints {
    /// `input` or `output`.
    pub side: &'static str,
    /// The number of points that is charged: those that the program uses, as [`own_points`] counts them.
    pub taken: u32,
    /// The refresh time that was charged for the `taken` points.
    pub time: Picos,
    /// The refresh time of sixteen points alone: the most that sixteen more points can add.
    pub sixteen: Picos,
    /// The additional time of the refresh if the user stated a number of points but no base unit: the points may then
    /// be on several base units, and the slowest distribution is charged.
    pub begun: Picos,
    /// How the number of points was determined, as text for a report.
    pub why: String,
    /// The largest number of points that the CPU can have. `None` if the table does not give it.
    pub most: Option<MorePoints>,
}

/// The largest number of points that a CPU can have, and how much longer their refresh takes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MorePoints {
    /// The largest number of points that the CPU can have.
    pub points: u32,
    /// The time by which the refresh of `points` points is longer than that of the points charged.
    pub more: Picos,
    /// The evidence of the number of points.
    pub evidence: Evidence,
    /// The evidence of `more`: the weakest evidence of the number of points and of the table rows used.
    pub founded: Evidence,
    /// The source of the number of points, as in the table.
    pub source: String,
}

/// The additional time if all points that the CPU can have are refreshed, as far as the table gives their number.
#[must_use]
pub fn more_points(unstated: &[UnstatedPoints]) -> Picos {
    unstated.iter().filter_map(|points| points.most.as_ref()).map(|most| most.more).sum()
}

/// The refresh time that was charged and may not occur: that of points whose number is not stated; and where it is
/// stated but the base units are not, the difference between the slowest and the fastest base unit.
#[must_use]
pub fn uncertain_refresh(unstated: &[UnstatedPoints], bases: &[UnstatedBase]) -> Picos {
    let is_stated = |base: &&UnstatedBase| unstated.iter().all(|points| points.side != base.side);
    let bases = bases.iter().filter(is_stated).map(|base| base.saves);
    unstated.iter().map(|points| points.time).chain(bases).sum()
}

/// Inputs or outputs for which the kind of base unit is not stated, although it matters: the slowest one is charged,
/// and the table has a faster one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnstatedBase {
    /// `input` or `output`.
    pub side: &'static str,
    /// The name of the fastest base unit.
    pub least: String,
    /// The time by which the refresh on the fastest base unit is shorter than the charged one.
    pub saves: Picos,
}

/// The overhead for refreshing inputs and outputs, and what is not stated about them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Refresh {
    /// The overhead terms of the refresh.
    pub terms: Vec<OverheadTerm>,
    /// Inputs or outputs for which the number of points is not stated.
    pub points: Vec<UnstatedPoints>,
    /// Inputs or outputs for which the base units are not stated.
    pub bases: Vec<UnstatedBase>,
}

/// The table rows for the inputs or for the outputs: a time for each 8 or 16 points, and a time once in each scan.
struct PointRows<'a> {
    name: &'static str,
    table: &'a Table,
    /// Whether the points may be distributed over several base units in any way. This is so if their number is stated
    /// and the base units are not. If the points are counted by the addresses that the program names, they are in
    /// blocks of sixteen. A module occupies whole blocks, so each block is on one base unit.
    splits: bool,
    /// The number of points that the CPU can address. `None` if it is unknown.
    most: Option<u32>,
}

/// One table row that is charged for points.
struct ChargedRow<'a> {
    row: &'a Row,
    /// The number of points for which the row's time is. 0: any number.
    size: u32,
    /// How often the row is charged.
    times: u64,
    /// Whether the row is charged in addition to the slowest row, for points on a further base unit.
    besides: bool,
}

/// The numbers of points for which there are rows. 0 is a row that is charged once in each scan.
const SIZES: [u32; 3] = [8, 16, 0];

/// A number of points on one kind of base unit. `None` if the base unit is not stated.
type Points<'a> = (Option<&'a str>, u32);

impl<'a> PointRows<'a> {
    /// The rows that give times for points, each with the number of points that its time is for (0: any number).
    fn rows(&self, base: Option<&str>) -> Vec<(u32, &'a Row)> {
        SIZES
            .into_iter()
            .flat_map(|size| self.rows_of(size, base).into_iter().map(move |row| (size, row)))
            .collect()
    }

    /// The rows whose time is for `size` points (0: any number). For a base unit: its own row, otherwise the general
    /// one. If the base units are not stated: the slowest row; for size 0 the rows of all base units, if their sum is
    /// more than the general row.
    fn rows_of(&self, size: u32, base: Option<&str>) -> Vec<&'a Row> {
        let plain = self.table.row(&self.row(size));
        let kind = format!("{}:", self.row(size));
        let is_own = |row: &&Row| row.name.to_ascii_lowercase().starts_with(&kind);
        let of_bases = || self.table.rows().iter().filter(is_own);
        let slowest = || of_bases().max_by_key(|row| row.on);
        let Some(base) = base else {
            // If the points are on several base units, the times that each base unit takes once in a scan add up.
            if size == 0
                && of_bases().map(|row| row.on).sum::<Picos>()
                    > plain.map_or(Picos::ZERO, |row| row.on)
            {
                return of_bases().collect();
            }
            // Among equal rows, take the general one: its name says what it is for.
            return slowest()
                .into_iter()
                .chain(plain)
                .max_by_key(|row| row.on)
                .into_iter()
                .collect();
        };
        let row_of_base = |size| self.table.row(&format!("{}:{base}", self.row(size)));
        // If a base unit has rows of its own, missing ones are not replaced by rows of another one.
        let is_known = SIZES.into_iter().any(|size| row_of_base(size).is_some());
        let others = || if is_known { None } else { slowest() };
        row_of_base(size).or(plain).or_else(others).into_iter().collect()
    }

    /// The table rows that are charged for this many points on a base unit (`None`: not stated), each with how often.
    /// Empty for 0 points.
    fn charges(&self, base: Option<&str>, points: u32) -> Vec<ChargedRow<'a>> {
        let mut charges = Vec::new();
        for (size, row) in self.rows(base).into_iter().filter(|_| points > 0) {
            let others = match base {
                None if self.splits && size > 0 => self.rows_of_further_bases(size, row, points),
                _ => Vec::new(),
            };
            let left = points - u32::try_from(others.len()).unwrap_or(0);
            charges.push(ChargedRow { row, size, times: times(size, left), besides: false });
            let others = others.into_iter();
            charges.extend(others.map(|row| ChargedRow { row, size, times: 1, besides: true }));
        }
        charges
    }

    /// The additional rows if the points are distributed over base units in the slowest way: one point on each of
    /// these, and all others charged by the slowest row. Each base unit rounds its number of points up. No other
    /// distribution takes longer, because beyond the first row of each base unit the slowest row is the most that
    /// further points can take. The CPU's addresses limit the total number of modules.
    fn rows_of_further_bases(&self, size: u32, slowest: &'a Row, points: u32) -> Vec<&'a Row> {
        let row_of_base = |base: &String| self.rows_of(size, Some(base)).into_iter().next();
        let mut rows: Vec<&Row> = self.bases().iter().filter_map(row_of_base).collect();
        rows.sort_by_key(|row| std::cmp::Reverse(row.on));
        // The slowest row is charged in any case. If it is the row of a base unit, that base unit is left out here.
        if rows.first().is_some_and(|row| row.on == slowest.on) {
            rows.remove(0);
        }
        let time = |row: &Row, times: u64| u128::from(row.on.0) * u128::from(times);
        let (mut best, mut longest, mut begun) = (0, time(slowest, times(size, points)), 0);
        for (others, left) in (1..=rows.len()).zip((1..points).rev()) {
            begun += time(rows[others - 1], 1);
            let sum = begun + time(slowest, times(size, left));
            let modules = others as u64 + times(size, left);
            let fit = self.most.is_none_or(|most| modules <= times(size, most.max(points)));
            if fit && sum > longest {
                (best, longest) = (others, sum);
            }
        }
        rows.truncate(best);
        rows
    }

    /// The name of the table row whose time is for `size` points, such as `@input16`.
    fn row(&self, size: u32) -> String {
        let size = if size == 0 { String::new() } else { size.to_string() };
        format!("@{}{size}", self.name)
    }

    /// The kinds of base units that the table distinguishes.
    fn bases(&self) -> BTreeSet<String> {
        let kinds = SIZES.map(|size| format!("{}:", self.row(size)));
        let names = self.table.rows().iter().map(|row| row.name.to_ascii_lowercase());
        names
            .filter_map(|name| {
                kinds.iter().find_map(|kind| Some(name.strip_prefix(kind)?.to_owned()))
            })
            .collect()
    }

    fn time(&self, all: &[Points<'_>]) -> Result<Picos, Vec<Diagnostic>> {
        let mut sum = Picos::ZERO;
        for &(base, points) in all {
            for charge in self.charges(base, points) {
                sum += charged(self.table, charge.row, charge.times)?;
            }
        }
        Ok(sum)
    }
}

/// The number of times that a row for `size` points is charged for `points` points.
fn times(size: u32, points: u32) -> u64 {
    match size {
        0 => u64::from(points > 0),
        size => u64::from(points.div_ceil(size)),
    }
}

/// The overhead terms of the refresh, and the facts about it that are not stated.
///
/// # Errors
/// Base units in the facts for which the table has no times; or a time that is too large.
pub fn refresh(
    program: &Program,
    table: &Table,
    facts: &Facts,
) -> Result<Refresh, Vec<Diagnostic>> {
    let sides = [
        ("input", Role::Input, facts.inputs, &table.most_inputs),
        ("output", Role::Output, facts.outputs, &table.most_outputs),
    ];
    check_bases(table, facts)?;
    let mut found = Refresh::default();
    for (at, (name, role, stated, most)) in sides.into_iter().enumerate() {
        let addresses = most.as_ref().map(|most| most.points);
        let side = PointRows { name, table, splits: stated.is_some(), most: addresses };
        if side.rows(None).is_empty() {
            continue;
        }
        let (points, origin) = match stated {
            Some(stated) => (stated, format!("{stated} {name} points, as stated")),
            None => own_points(program, name, role, most.as_ref()),
        };
        let base = facts.base.as_deref();
        let by_base = &facts.by_base[at];
        let taken: Vec<Points<'_>> = match by_base.is_empty() {
            true => vec![(base, points)],
            false => by_base.iter().map(|(base, &points)| (Some(base.as_str()), points)).collect(),
        };
        let time = side.time(&taken)?;
        if stated.is_none() {
            let most = most.as_ref().map(|most| -> Result<MorePoints, Vec<Diagnostic>> {
                let rows = side.rows(base);
                let founded = rows.iter().map(|(_, row)| row.evidence);
                Ok(MorePoints {
                    points: most.points,
                    more: side.time(&[(base, most.points)])?.checked_sub(time).unwrap_or_default(),
                    evidence: most.evidence,
                    founded: founded.fold(most.evidence, Evidence::min),
                    source: most.source.clone(),
                })
            });
            found.points.push(UnstatedPoints {
                side: name,
                taken: points,
                time,
                sixteen: side.time(&[(base, 16)])?,
                begun: {
                    let some = [(base, points.max(16))];
                    let split = PointRows { splits: true, most: None, ..side }.time(&some)?;
                    split.checked_sub(side.time(&some)?).unwrap_or_default()
                },
                why: origin.clone(),
                most: most.transpose()?,
            });
        }
        let mut saved = String::new();
        if base.is_none() && by_base.is_empty() {
            let mut least: Option<(Picos, String)> = None;
            for base in side.bases() {
                let on_base = side.time(&[(Some(&base), points)])?;
                if least.as_ref().is_none_or(|(known, _)| on_base < *known) {
                    least = Some((on_base, base));
                }
            }
            if let Some((on_base, least)) = least.filter(|(on_base, _)| *on_base < time) {
                let saves = time.checked_sub(on_base).unwrap_or_default();
                saved = format!(
                    ", the slowest base: the bound is {saves} lower with [io] base = \"{least}\""
                );
                found.bases.push(UnstatedBase { side: name, least, saves });
            }
        }
        for (base, points) in taken {
            for ChargedRow { row, size, times, besides } in side.charges(base, points) {
                let unit = row.on.us_text();
                let each = match size {
                    0 => "once a scan".to_owned(),
                    _ if besides => format!("per {size} points, on a further base"),
                    _ => format!("per {size} points"),
                };
                let origin = match (by_base.is_empty(), base) {
                    (false, Some(base)) => {
                        format!("{points} {name} points on the base {base} as stated")
                    }
                    (_, Some(base)) => format!("{origin}, on the base {base}"),
                    (_, None) => origin.clone(),
                };
                // The saving is reported only once.
                let saved = std::mem::take(&mut saved);
                let why = format!("{origin}: {times} x {unit} us {each}{saved}; {}", row.source);
                let time = charged(table, row, times)?;
                let name = format!("{name} refresh");
                found.terms.push(OverheadTerm { name, time, evidence: row.evidence, why });
            }
        }
    }
    Ok(found)
}

/// Refuses base units in the facts for which the table has no times.
fn check_bases(table: &Table, facts: &Facts) -> Result<(), Vec<Diagnostic>> {
    let sides =
        ["input", "output"].map(|name| PointRows { name, table, splits: false, most: None });
    let known: BTreeSet<String> = sides.iter().flat_map(PointRows::bases).collect();
    let names = known.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
    let fault = |key: &str, part: Part, base: &str| {
        let message = format!("the table {} has no times for the base '{base}'", table.name);
        let help = match known.is_empty() {
            true => {
                "the times in this table are the same for all base units: name no base unit under [io] in the facts file"
                    .to_owned()
            }
            false => format!("it has {names}"),
        };
        facts.fault(["io", key], part, Code::NoBase, message, &help)
    };
    let mut faults = Vec::new();
    faults.extend(
        facts
            .base
            .iter()
            .filter(|base| !known.contains(*base))
            .map(|base| fault("base", Part::Value, base)),
    );
    for (side, bases) in ["inputs", "outputs"].into_iter().zip(&facts.by_base) {
        let wrong = bases.keys().filter(|base| !known.contains(*base)).take(MAX_LISTED);
        faults.extend(wrong.map(|base| fault(&format!("{side}.{base}"), Part::Key, base)));
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The largest number of wrong base units of a side that are reported.
const MAX_LISTED: usize = 100;

/// The number of points that is charged if the user states none, and how it was determined. It is the number that the
/// front counted, otherwise the number up to the highest input or output that the program names, rounded up to a
/// multiple of 16. It is never more than the CPU can have: points above that belong to a network.
#[must_use]
pub fn own_points(
    program: &Program,
    side: &str,
    role: Role,
    most: Option<&MostPoints>,
) -> (u32, String) {
    let most = most.map(|most| most.points);
    let counted = program.points.map(|[inputs, outputs]| match side {
        "input" => inputs,
        _ => outputs,
    });
    if let Some(seen) = counted {
        let counted = most.map_or(seen, |most| seen.min(most));
        let why = format!("{counted} {side} points in the words that the program uses as {side}s");
        return (counted, why);
    }
    let Some(highest) = highest(program, role, most) else {
        return (0, format!("0 {side} points, since the program uses no {side}"));
    };
    let points = highest.cell.index.saturating_add(1).div_ceil(16).saturating_mul(16);
    let counted = most.map_or(points, |most| points.min(most));
    let name = program.cell_name(highest.cell);
    let which = match most.filter(|_| highest.beyond) {
        Some(most) => format!("among the CPU's own {most}"),
        None => "used".to_owned(),
    };
    (counted, format!("{counted} {side} points, since {name} is the highest {side} {which}"))
}

/// The highest input or output below a limit that instructions name, and whether they name any above the limit.
struct Highest {
    cell: Cell,
    beyond: bool,
}

fn highest(program: &Program, role: Role, below: Option<u32>) -> Option<Highest> {
    let (mut last, mut beyond): (Option<Cell>, bool) = (None, false);
    for instruction in &program.instructions {
        each_region(instruction, &mut |region| {
            let Region::Range { first, count } = region else { return };
            if count == 0 || program.area(first.area).role != role {
                return;
            }
            let end = first.index.saturating_add(known_length(count));
            beyond |= below.is_some_and(|below| end > below);
            let end = below.map_or(end, |below| end.min(below));
            if first.index < end {
                let cell = Cell { index: end - 1, ..first };
                last = Some(last.filter(|known| known.index >= cell.index).unwrap_or(cell));
            }
        });
    }
    Some(Highest { cell: last?, beyond })
}
