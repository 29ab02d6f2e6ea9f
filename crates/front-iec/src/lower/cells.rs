//! Sets of cells, and the effects of code as such sets.

use scanbound_ir::{Cell, Region};
use std::collections::BTreeSet;

/// Ranges of cells, as first cell and count. They may overlap.
pub(super) type Cells = BTreeSet<(Cell, u32)>;

/// The effects of code: the cells that it reads and writes.
#[derive(Debug, Clone, Default)]
pub(super) struct Effects {
    pub(super) reads: Cells,
    pub(super) writes: Cells,
    /// Whether it may read or write anything, since it is not fully known.
    pub(super) anything: bool,
}

impl Effects {
    /// Whether this code writes a cell that the other code reads or writes, or may do so because one of them is not
    /// fully known.
    pub(super) fn changes(&self, other: &Effects) -> bool {
        let meets = |one: &Cells, two: &Cells| one.iter().any(|own| meet(own, two));
        let is_idle =
            |one: &Effects| !one.anything && one.reads.is_empty() && one.writes.is_empty();
        (self.anything && !is_idle(other))
            || (other.anything && !self.writes.is_empty())
            || meets(&self.writes, &other.reads)
            || meets(&self.writes, &other.writes)
    }

    /// Whether both access a common cell, be it only for reading.
    pub(super) fn meets(&self, other: &Effects) -> bool {
        self.changes(other)
            || other.changes(self)
            || self.reads.iter().any(|own| meet(own, &other.reads))
    }

    pub(super) fn join(&mut self, other: &Effects) {
        self.reads.extend(&other.reads);
        self.writes.extend(&other.writes);
        self.anything |= other.anything;
    }

    /// Keeps only the regions for which `lasts` is true.
    pub(super) fn lasting(mut self, lasts: impl Fn(Region) -> bool) -> Effects {
        let lasts = |&(first, count): &(Cell, u32)| lasts(Region::Range { first, count });
        self.reads.retain(lasts);
        self.writes.retain(lasts);
        self
    }
}

/// Whether a range overlaps any range of a set.
fn meet(one: &(Cell, u32), others: &Cells) -> bool {
    let (first, count) = *one;
    let end = (first.plus(count), 0);
    // Ranges may contain each other, so not only the last one before `end` can reach this one.
    others
        .range(..end)
        .rev()
        .take_while(|(own, _)| own.area == first.area)
        .any(|(own, many)| own.index < first.index + count && first.index < own.index + many)
}

pub(super) fn add(found: &mut Cells, regions: Vec<Region>) {
    for region in regions {
        if let Region::Range { first, count } = region {
            found.insert((first, count));
        }
    }
}

/// Whether a region contains all cells of another one.
pub(super) fn encloses(region: Region, other: Region) -> bool {
    match other {
        Region::Range { first, count } => {
            count == 0 || region.contains(first) && region.contains(first.plus(count - 1))
        }
        Region::Area(_) | Region::Everything => region == other,
    }
}
