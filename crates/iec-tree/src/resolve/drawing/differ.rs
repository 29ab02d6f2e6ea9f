//! Whether two orders of a drawing may do different things.

use super::super::resolver::Resolver;
use super::state::Progress;
use super::touched::{Cell, Touched};
use scanbound_iec::drawing::ElementId;
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
        if one.joins_all != other.joins_all || here.keys().ne(there.keys()) {
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
