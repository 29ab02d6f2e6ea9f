//! What the cells hold between two scans that follow each other.

use super::FreeValues;
use super::state::State;
use rustc_hash::FxHashMap;
use scanbound_ir::{Cell, Region};
use std::collections::BTreeSet;

/// A region of so many cells at most that took any value is kept cell by cell.
const SMALL: u32 = 64;

/// The values of cells.
#[derive(Debug, Clone, Default)]
pub(super) struct Memory {
    /// Each cell's value, and which of its bits are not known.
    cells: FxHashMap<Cell, (u16, u16)>,
    /// Regions of which nothing is known but what stands in `cells`.
    lost: BTreeSet<Region>,
}

/// What a scan leaves.
pub(super) struct Left {
    /// The regions that took any value.
    lost: Vec<Region>,
    /// The cells that it touched, with their values and which of their bits are not known.
    touched: Vec<(Cell, u16, u16)>,
}

impl Left {
    /// What it leaves in this state.
    pub(super) fn by<F: FreeValues>(state: &mut State<'_, F>) -> Left {
        let lost = state.lost();
        for &region in &lost {
            if let Region::Range { first, count } = region
                && count <= SMALL
            {
                (0..count).for_each(|n| _ = state.after(first.plus(n)));
            }
        }
        Left { lost, touched: state.touched() }
    }
}

impl Memory {
    /// Sets a cell from outside.
    pub(super) fn set(&mut self, cell: Cell, value: u16) {
        self.cells.insert(cell, (value, 0));
    }

    /// What a cell holds, and which of its bits are not known; `None` if nothing has changed it yet.
    pub(super) fn get(&self, cell: Cell) -> Option<(u16, u16)> {
        let is_lost = || self.lost.iter().any(|region| region.holds(cell)).then_some((0, u16::MAX));
        self.cells.get(&cell).copied().or_else(is_lost)
    }

    /// Takes over what a scan leaves; the cells that it changed.
    pub(super) fn take(&mut self, left: Left) -> Vec<Cell> {
        let is_new =
            |&&(cell, value, unknown): &&(Cell, u16, u16)| self.get(cell) != Some((value, unknown));
        let changed = left.touched.iter().filter(is_new).map(|&(cell, ..)| cell).collect();
        for region in left.lost {
            self.lose(region);
        }
        let touched = left.touched.into_iter();
        self.cells.extend(touched.map(|(cell, value, unknown)| (cell, (value, unknown))));
        changed
    }

    /// Nothing is known of a region any more.
    fn lose(&mut self, region: Region) {
        match region {
            Region::Range { first, count } if count <= SMALL => {
                self.cells.extend((0..count).map(|n| (first.plus(n), (0, u16::MAX))));
            }
            _ => {
                self.cells.retain(|cell, _| !region.holds(*cell));
                self.lost.insert(region);
            }
        }
    }
}
