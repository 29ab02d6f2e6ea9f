//! What the words that matter may hold at one place of the scan.

use super::ring::Ring;
use crate::program::{AreaId, Cell, Region};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::ops::Range;

/// The words that matter, each with a slot.
pub struct Slots {
    cells: Vec<Cell>,
    slots: FxHashMap<Cell, usize>,
    areas: BTreeMap<AreaId, Range<usize>>,
}

impl Slots {
    /// Slots for these words, which are in order.
    pub fn of(cells: Vec<Cell>) -> Slots {
        let slots = cells.iter().enumerate().map(|(slot, cell)| (*cell, slot)).collect();
        let mut areas: BTreeMap<AreaId, Range<usize>> = BTreeMap::new();
        for (slot, cell) in cells.iter().enumerate() {
            areas.entry(cell.area).or_insert(slot..slot).end = slot + 1;
        }
        Slots { cells, slots, areas }
    }

    /// The words.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The slot of a word that matters.
    pub fn slot(&self, cell: Cell) -> Option<usize> {
        self.slots.get(&cell).copied()
    }

    /// The slots of all words that lie in a region.
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

/// What they hold.
#[derive(Debug, Clone)]
pub struct State {
    values: Vec<Ring>,
    /// Which write each value comes from: what was found out about a value says nothing of another.
    stamps: Vec<u32>,
    /// Whether each was written in this scan on every way here.
    written: Vec<bool>,
}

impl State {
    /// What they hold when the scan starts.
    pub fn new(values: Vec<Ring>) -> State {
        State { stamps: vec![0; values.len()], written: vec![false; values.len()], values }
    }

    pub fn value(&self, slot: usize) -> Ring {
        self.values[slot]
    }

    pub fn stamp(&self, slot: usize) -> u32 {
        self.stamps[slot]
    }

    pub fn is_written(&self, slot: usize) -> bool {
        self.written[slot]
    }

    /// Takes what is known of a value closer; it stays the same value.
    pub fn know(&mut self, slot: usize, value: Ring) {
        self.values[slot] = value;
    }

    /// Writes a value, surely or perhaps; `stamp` is a new one.
    pub fn write(&mut self, slot: usize, value: Ring, surely: bool, stamp: u32) {
        self.values[slot] = if surely { value } else { self.values[slot].join(value) };
        self.stamps[slot] = stamp;
        self.written[slot] |= surely;
    }

    /// What they hold where two ways meet; `stamp` is a new one.
    pub fn meet(&mut self, other: &State, stamp: u32) {
        self.together(other, stamp, Ring::join);
    }

    /// The same where that is done again and again.
    pub fn widen(&mut self, other: &State, stamp: u32) {
        self.together(other, stamp, Ring::widen);
    }

    fn together(&mut self, other: &State, stamp: u32, how: fn(Ring, Ring) -> Ring) {
        for slot in 0..self.values.len() {
            self.values[slot] = how(self.values[slot], other.values[slot]);
            if self.stamps[slot] != other.stamps[slot] {
                self.stamps[slot] = stamp;
            }
            self.written[slot] &= other.written[slot];
        }
    }

    /// Whether they hold the same, whatever wrote it.
    pub fn equals(&self, other: &State) -> bool {
        self.values == other.values && self.written == other.written
    }
}
