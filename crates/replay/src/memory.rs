//! The values of the cells between two consecutive scans.

use super::state::State;
use rustc_hash::FxHashMap;
use scanbound_ir::{Cell, Region};
use std::collections::BTreeSet;

/// A havocked region of at most this many cells is stored cell by cell.
const SMALL: u32 = 64;

/// The values of the cells, as far as they are known.
#[derive(Debug, Clone, Default)]
pub(super) struct Memory {
    /// Each cell's value and the mask of its unknown bits.
    cells: FxHashMap<Cell, (u16, u16)>,
    /// Havocked regions. Their cells are unknown, except those that `cells` contains.
    lost: BTreeSet<Region>,
}

/// The changes that a scan makes to the memory.
pub(super) struct ScanChanges {
    /// The regions that were havocked.
    lost: Vec<Region>,
    /// The cells that were read or written: the value and the mask of unknown bits of each.
    touched: Vec<(Cell, u16, u16)>,
}

impl ScanChanges {
    /// The changes of the memory that a scan made, from its final state.
    pub(super) fn of(state: &mut State<'_>) -> ScanChanges {
        let lost = state.lost();
        for &region in &lost {
            if let Region::Range { first, count } = region
                && count <= SMALL
            {
                (0..count).for_each(|n| _ = state.end_value(first.plus(n)));
            }
        }
        ScanChanges { lost, touched: state.accessed_cells() }
    }
}

impl Memory {
    /// Writes a value into a cell from outside the program.
    pub(super) fn set(&mut self, cell: Cell, value: u16) {
        self.cells.insert(cell, (value, 0));
    }

    /// The cell's value and the mask of its unknown bits. `None` if nothing has written it since power-up.
    pub(super) fn get(&self, cell: Cell) -> Option<(u16, u16)> {
        let is_lost =
            || self.lost.iter().any(|region| region.contains(cell)).then_some((0, u16::MAX));
        self.cells.get(&cell).copied().or_else(is_lost)
    }

    /// Applies the changes of a scan. Returns the cells that the scan read or wrote and that now differ from this
    /// memory, also those that it did not hold yet. Of a large havocked region, cells that the scan did not access are
    /// not returned.
    pub(super) fn apply(&mut self, changes: ScanChanges) -> Vec<Cell> {
        let is_new =
            |&&(cell, value, unknown): &&(Cell, u16, u16)| self.get(cell) != Some((value, unknown));
        let changed = changes.touched.iter().filter(is_new).map(|&(cell, ..)| cell).collect();
        for region in changes.lost {
            self.havoc(region);
        }
        let touched = changes.touched.into_iter();
        self.cells.extend(touched.map(|(cell, value, unknown)| (cell, (value, unknown))));
        changed
    }

    /// Makes all cells of a region unknown.
    fn havoc(&mut self, region: Region) {
        match region {
            Region::Range { first, count } if count <= SMALL => {
                self.cells.extend((0..count).map(|n| (first.plus(n), (0, u16::MAX))));
            }
            _ => {
                self.cells.retain(|cell, _| !region.contains(*cell));
                self.lost.insert(region);
            }
        }
    }
}
