//! Compares execution orders of a drawing: whether they can have different effects.

use super::super::resolver::Resolver;
use super::state::{Progress, Sheet};
use super::touched::{Cell, Touched};
use crate::tree::Statement;
use scanbound_base::code::Code;
use scanbound_iec::drawing::{ElementId, ElementKind};
use scanbound_iec::fault::Fault;
use std::collections::{BTreeMap, BTreeSet};

impl Resolver<'_> {
    /// For each cell with an address, a common representative of all cells that may overlap it.
    fn groups(&self, cells: &BTreeSet<Cell>) -> BTreeMap<Cell, Cell> {
        let located = || cells.iter().filter_map(|&cell| Some((cell, self.at(cell)?)));
        let mut sizes: BTreeMap<_, BTreeSet<(&str, bool)>> = BTreeMap::new();
        for (_, (area, size, _, is_plain)) in located() {
            sizes.entry(area).or_default().insert((size, is_plain));
        }
        let mut first = BTreeMap::new();
        let group = |(cell, (area, _, digits, _))| {
            // If the sizes of addresses differ, or a variable is larger than its address says, all cells of the area
            // may overlap.
            let is_apart = sizes.get(&area).is_some_and(|sizes| {
                sizes.len() == 1 && sizes.iter().all(|(_, is_plain)| *is_plain)
            });
            let key = (area, if is_apart { digits } else { "" });
            (cell, *first.entry(key).or_insert(cell))
        };
        located().map(group).collect()
    }

    /// Whether two orders can have different effects: they contain different statements, or two statements are swapped
    /// and one writes what the other reads or writes.
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
        // For each cell, the statements that access it: their positions in both orders, and whether they write it.
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

    /// Rejects conditions whose blocks affect each other if neither needs the other: generators choose the order
    /// themselves.
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

    /// Two of the given elements, or of the blocks that these need, whose order matters but is not fixed by their
    /// connections. `None` if there are none.
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
                // A contact's edge may be evaluated before the blocks in front of it.
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

    /// Whether the order of two accesses matters: one writes what the other reads.
    fn meet(&self, one: &Touched, other: &Touched) -> bool {
        self.may_change(one, other) || self.may_change(other, one)
    }

    /// Like [`Resolver::goals_are_apart`], for conditions in separate drawings, given the statements of each.
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

    /// Rejects a drawing whose effect depends on how generators sort elements into rows, where that is ambiguous.
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

/// The fault of conditions whose order of execution matters.
fn several_conditions(line: u32) -> Fault {
    let what = "a block of one drawn condition writes what a block of another one reads or writes: which of them comes first is not known";
    let help = "execute one of the blocks in an action, and use its output";
    Fault::new(line, what).code(Code::NotModelled).help(help)
}

impl Progress<'_> {
    /// The statements by element and running number within the element, with their positions and accesses.
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
