//! Whether two orders of a drawing may do different things.

use super::super::resolver::Resolver;
use super::state::{Progress, Sheet};
use super::touched::{Cell, Touched};
use crate::tree::Statement;
use scanbound_base::code::Code;
use scanbound_iec::drawing::{ElementId, ElementKind};
use scanbound_iec::fault::Fault;
use std::collections::{BTreeMap, BTreeSet};

impl Resolver<'_> {
    /// One of all cells that overlap, for each of these that has an address.
    fn groups(&self, cells: &BTreeSet<Cell>) -> BTreeMap<Cell, Cell> {
        let located = || cells.iter().filter_map(|&cell| Some((cell, self.at(cell)?)));
        let mut sizes: BTreeMap<_, BTreeSet<(&str, bool)>> = BTreeMap::new();
        for (_, (area, size, _, is_plain)) in located() {
            sizes.entry(area).or_default().insert((size, is_plain));
        }
        let mut first = BTreeMap::new();
        let group = |(cell, (area, _, digits, _))| {
            // Where sizes differ, or something is larger than its address says, each may overlap with all others.
            let is_apart = sizes.get(&area).is_some_and(|sizes| {
                sizes.len() == 1 && sizes.iter().all(|(_, is_plain)| *is_plain)
            });
            let key = (area, if is_apart { digits } else { "" });
            (cell, *first.entry(key).or_insert(cell))
        };
        located().map(group).collect()
    }

    /// Whether two orders may do different things: two statements come the other way round, and one writes what the
    /// other one touches.
    pub(super) fn differ(&self, one: &Progress<'_>, other: &Progress<'_>) -> bool {
        let (here, there) = (one.by_place(), other.by_place());
        if one.differs_in_itself != other.differs_in_itself || here.keys().ne(there.keys()) {
            return true;
        }
        let all = || here.values().chain(there.values()).map(|(_, touched)| *touched);
        let reads = |cell: Cell| all().any(|own| own.reads.contains(&cell));
        let (through_any, through_shared) = (reads(Cell::All), reads(Cell::Shared));
        let cells = all().flat_map(|own| own.reads.iter().chain(&own.writes)).copied().collect();
        let groups = self.groups(&cells);
        // By cell, the statements that touch it: their places in both orders, and whether they write it.
        let mut by_cell: BTreeMap<Cell, Vec<(usize, usize, bool)>> = BTreeMap::new();
        for ((here, own), (there, also)) in here.values().zip(there.values()) {
            let mut cells = BTreeMap::from([(Cell::All, false)]);
            for (touched, writes) in [
                (&own.reads, false),
                (&also.reads, false),
                (&own.writes, true),
                (&also.writes, true),
            ] {
                for &cell in touched {
                    if self.is_shared(cell) {
                        *cells.entry(Cell::Shared).or_insert(false) |= writes && through_shared;
                    }
                    *cells.entry(Cell::All).or_insert(false) |= writes && through_any;
                    let cell = groups.get(&cell).copied().unwrap_or(cell);
                    if (cell, writes) != (Cell::All, false) {
                        *cells.entry(cell).or_insert(false) |= writes;
                    }
                }
            }
            for (cell, writes) in cells {
                by_cell.entry(cell).or_default().push((*here, *there, writes));
            }
        }
        by_cell.into_values().any(|touching| {
            let writers = || touching.iter().filter(|(.., writes)| *writes);
            writers().any(|(here, there, _)| {
                touching.iter().any(|(own, also, _)| (own < here) != (also < there))
            })
        })
    }

    /// Refuses conditions whose blocks do something else where others of them come first: generators have an order of
    /// their own.
    pub(super) fn goals_are_apart(
        &self,
        sheet: &Sheet<'_>,
        known: &Progress<'_>,
    ) -> Result<(), Fault> {
        let owners = known.all.iter().map(|one| one.owner).collect();
        match self.unclear_order(sheet, known, owners) {
            Some((one, _)) => Err(several_conditions(sheet.drawing.element(one).line)),
            None => Ok(()),
        }
    }

    /// Two of these elements or of the blocks that they ask for of which neither is executed for the other, and it
    /// matters which of them comes first.
    fn unclear_order(
        &self,
        sheet: &Sheet<'_>,
        known: &Progress<'_>,
        mut open: Vec<ElementId>,
    ) -> Option<(ElementId, ElementId)> {
        let mut touched: BTreeMap<ElementId, Vec<&Touched>> = BTreeMap::new();
        known.all.iter().for_each(|one| touched.entry(one.owner).or_default().push(&one.touched));
        let mut before: BTreeMap<ElementId, BTreeSet<ElementId>> = BTreeMap::new();
        while let Some(id) = open.pop() {
            before.entry(id).or_insert_with(|| {
                // The edge of a contact may be looked at before the blocks that lead to it.
                let blocks = match sheet.drawing.element(id).kind {
                    ElementKind::Contact => BTreeSet::new(),
                    _ => sheet.blocks_before(id),
                };
                open.extend(&blocks);
                blocks
            });
        }
        let meets = |one: &ElementId, other: &ElementId| {
            let is_fixed = before[one].contains(other) != before[other].contains(one);
            let all = |id| touched.get(id).into_iter().flatten();
            !is_fixed && all(one).any(|one| all(other).any(|other| self.meet(one, other)))
        };
        let mut pairs = before
            .keys()
            .flat_map(|one| before.range(one..).skip(1).map(move |(two, _)| (one, two)));
        pairs.find(|(one, other)| meets(one, other)).map(|(one, other)| (*one, *other))
    }

    /// Whether it matters which of two comes first.
    fn meet(&self, one: &Touched, other: &Touched) -> bool {
        self.may_change(one, other) || self.may_change(other, one)
    }

    /// The same of conditions in drawings of their own, by what is executed for them.
    pub(in super::super) fn drawings_are_apart(
        &self,
        all: &[Vec<Statement>],
        line: u32,
    ) -> Result<(), Fault> {
        let touched: Vec<Touched> = all.iter().map(|one| self.touched(one)).collect();
        let mut pairs = touched
            .iter()
            .enumerate()
            .flat_map(|(at, one)| touched[..at].iter().map(move |two| (one, two)));
        match pairs.any(|(one, other)| self.meet(one, other)) {
            true => Err(several_conditions(line)),
            false => Ok(()),
        }
    }

    /// Refuses a drawing in which it matters how generators sort elements whose rows are not clear.
    pub(super) fn rows_are_clear(
        &self,
        sheet: &Sheet<'_>,
        known: &Progress<'_>,
    ) -> Result<(), Fault> {
        let mut rows = sheet.unclear_rows().into_iter();
        let Some((one, other)) = rows.find_map(|own| self.unclear_order(sheet, known, own)) else {
            return Ok(());
        };
        let (one, other) = (sheet.drawing.element(one), sheet.drawing.element(other));
        let what = format!(
            "whether it comes before {} is not clear: older generators sort by rows of ten units, and these are not apart",
            other.called()
        );
        let help = "move elements until their rows are ten units apart, or number them";
        Err(one.fault(&what).code(Code::NotModelled).help(help))
    }
}

/// The fault of conditions whose order matters.
fn several_conditions(line: u32) -> Fault {
    let what = "a block that a condition is drawn with writes what one of another condition reads or writes: which of them comes first is not known";
    let help = "execute one of the blocks in an action, and use what it puts out";
    Fault::new(line, what).code(Code::NotModelled).help(help)
}

impl Progress<'_> {
    /// Its statements by their elements and their numbers among those of these, with their places and what they touch.
    fn by_place(&self) -> BTreeMap<(ElementId, usize), (usize, &Touched)> {
        let mut counts: BTreeMap<ElementId, usize> = BTreeMap::new();
        let mut found = BTreeMap::new();
        for (at, one) in self.all.iter().enumerate() {
            let count = counts.entry(one.owner).or_insert(0);
            found.insert((one.owner, *count), (at, &one.touched));
            *count += 1;
        }
        found
    }
}
