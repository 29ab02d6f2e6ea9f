//! A sorted list of cells; the slot of a cell is its index in the list.

use rustc_hash::FxHashMap;
use scanbound_ir::{AreaId, Cell, Region};
use std::collections::BTreeMap;
use std::ops::Range;

/// Tracked cells in ascending order. The slot of a cell, its index in this order, is its number in abstract states.
pub struct Slots {
    cells: Vec<Cell>,
    slots: FxHashMap<Cell, usize>,
    areas: BTreeMap<AreaId, Range<usize>>,
}

impl Slots {
    /// Assigns slots to these cells, which must be in ascending order.
    pub fn of(cells: Vec<Cell>) -> Slots {
        let slots = cells.iter().enumerate().map(|(slot, cell)| (*cell, slot)).collect();
        let mut areas: BTreeMap<AreaId, Range<usize>> = BTreeMap::new();
        for (slot, cell) in cells.iter().enumerate() {
            areas.entry(cell.area).or_insert(slot..slot).end = slot + 1;
        }
        Slots { cells, slots, areas }
    }

    /// The cells in ascending order; the index of a cell is its slot.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The slot of a cell, if it is in the list.
    pub fn slot(&self, cell: Cell) -> Option<usize> {
        self.slots.get(&cell).copied()
    }

    /// The slots of all listed cells in a region, which follow each other.
    pub fn within(&self, region: Region) -> Range<usize> {
        match region {
            Region::Everything => 0..self.cells.len(),
            Region::Area(area) => self.areas.get(&area).cloned().unwrap_or(0..0),
            Region::Range { first, count } => {
                let Some(all) = self.areas.get(&first.area).cloned() else { return 0..0 };
                let own = &self.cells[all.clone()];
                let end = u64::from(first.index) + u64::from(count);
                let from = own.partition_point(|cell| cell.index < first.index);
                let to = own.partition_point(|cell| u64::from(cell.index) < end);
                all.start + from..all.start + to
            }
        }
    }
}
