//! What words may hold at one place of the scan, and what is known of the bits on which it hangs whether they are written.

use super::condition::{Condition, Happened, Known, Literal, Perhaps};
use super::ring::Ring;
use crate::program::{AreaId, Cell, Region};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

/// What is followed: the words that matter, and bits on which it hangs whether they are written.
pub struct Followed {
    pub words: Slots,
    pub bits: Slots,
}

impl Followed {
    /// A state in which all may hold anything.
    pub fn anything(&self) -> State {
        self.holding(vec![Ring::TOP; self.words.cells().len()])
    }

    /// A state in which the words hold these values.
    pub fn holding(&self, values: Vec<Ring>) -> State {
        State::new(&values, self.bits.cells().len())
    }
}

/// Some cells, each with a slot.
pub struct Slots {
    cells: Vec<Cell>,
    slots: FxHashMap<Cell, usize>,
    areas: BTreeMap<AreaId, Range<usize>>,
}

impl Slots {
    /// Slots for these cells, which are in order.
    pub fn of(cells: Vec<Cell>) -> Slots {
        let slots = cells.iter().enumerate().map(|(slot, cell)| (*cell, slot)).collect();
        let mut areas: BTreeMap<AreaId, Range<usize>> = BTreeMap::new();
        for (slot, cell) in cells.iter().enumerate() {
            areas.entry(cell.area).or_insert(slot..slot).end = slot + 1;
        }
        Slots { cells, slots, areas }
    }

    /// The cells.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The slot of a cell, if it has one.
    pub fn slot(&self, cell: Cell) -> Option<usize> {
        self.slots.get(&cell).copied()
    }

    /// The slots of all cells that lie in a region.
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

/// So many slots are kept together: what does not change is shared between states.
const BLOCK: usize = 32;

/// What the words and bits hold.
#[derive(Debug, Clone)]
pub struct State {
    words: Vec<Rc<Block>>,
    bits: Vec<Rc<[Bit; BLOCK]>>,
}

/// What some words hold.
#[derive(Debug, Clone)]
struct Block {
    values: [Ring; BLOCK],
    /// Which write each value comes from: what was found out about a value says nothing of another.
    stamps: [u32; BLOCK],
    /// Whether each was written in this scan on every path here: a bit each.
    written: u32,
    /// What the last writes of each were that need not have happened.
    writes: [Option<Rc<Writes>>; BLOCK],
}

/// Writes of a word that need not have happened.
#[derive(Debug, PartialEq, Eq)]
struct Writes {
    /// What it held before them.
    before: Ring,
    /// They, the last one first.
    perhaps: Vec<Perhaps>,
}

/// What is known of a bit.
#[derive(Debug, Clone, Default)]
struct Bit {
    /// Which write its value comes from.
    stamp: u32,
    /// When it is on, and when it is off.
    truth: Option<Rc<[Condition; 2]>>,
}

/// So many writes of a word that need not have happened are remembered.
const MOST_WRITES: usize = 4;

impl State {
    /// What they hold when the scan starts, and so many bits anything.
    pub fn new(values: &[Ring], bits: usize) -> State {
        let block = |some: &[Ring]| {
            let mut values = [Ring::TOP; BLOCK];
            values[..some.len()].copy_from_slice(some);
            Rc::new(Block {
                values,
                stamps: [0; BLOCK],
                written: 0,
                writes: [const { None }; BLOCK],
            })
        };
        let free: Rc<[Bit; BLOCK]> = Rc::new(std::array::from_fn(|_| Bit::default()));
        State {
            words: values.chunks(BLOCK).map(block).collect(),
            bits: vec![free; bits.div_ceil(BLOCK)],
        }
    }

    pub fn value(&self, slot: usize) -> Ring {
        self.words[slot / BLOCK].values[slot % BLOCK]
    }

    fn writes(&self, slot: usize) -> Option<&Rc<Writes>> {
        self.words[slot / BLOCK].writes[slot % BLOCK].as_ref()
    }

    /// The value where these are true.
    pub fn value_where(&self, slot: usize, holds: &[Literal]) -> Ring {
        let all = self.value(slot);
        let Some(writes) = self.writes(slot) else { return all };
        let mut found: Option<Ring> = None;
        let mut add = |value: Ring| found = Some(found.map_or(value, |found| found.join(value)));
        let mut done = false;
        for write in &writes.perhaps {
            match write.happened(holds) {
                Happened::No => continue,
                Happened::Perhaps => add(write.value),
                Happened::Yes => {
                    add(write.value);
                    done = true;
                    break;
                }
            }
        }
        if !done {
            add(writes.before);
        }
        // Both are true of it.
        found.map_or(all, |found| found.closer(all))
    }

    pub fn stamp(&self, slot: usize) -> u32 {
        self.words[slot / BLOCK].stamps[slot % BLOCK]
    }

    pub fn is_written(&self, slot: usize) -> bool {
        self.words[slot / BLOCK].written & 1 << (slot % BLOCK) != 0
    }

    /// Takes what is known of a value closer; it stays the same value.
    pub fn know(&mut self, slot: usize, value: Ring) {
        if self.value(slot) != value {
            Rc::make_mut(&mut self.words[slot / BLOCK]).values[slot % BLOCK] = value;
        }
    }

    /// Takes the words closer to what holds with a condition. What was known before is put into `before`. False if it cannot
    /// hold here.
    pub fn assume(&mut self, condition: &Condition, before: &mut Vec<(usize, Ring)>) -> bool {
        for known in condition.words() {
            if self.stamp(known.slot) != known.stamp {
                continue;
            }
            let value = self.value(known.slot);
            match value.within(known.signed, known.low, known.high) {
                Some(closer) => {
                    before.push((known.slot, value));
                    self.know(known.slot, closer);
                }
                None => return false,
            }
        }
        true
    }

    /// Takes all values closer to what they are where these are true.
    pub fn know_where(&mut self, holds: &[Literal]) {
        if holds.is_empty() {
            return;
        }
        for slot in 0..self.words.len() * BLOCK {
            if self.writes(slot).is_some() {
                self.know(slot, self.value_where(slot, holds));
            }
        }
    }

    /// Writes a value; `stamp` is a new one.
    pub fn write(&mut self, slot: usize, value: Ring, stamp: u32) {
        let (block, at) = (Rc::make_mut(&mut self.words[slot / BLOCK]), slot % BLOCK);
        block.values[at] = value;
        block.stamps[at] = stamp;
        block.written |= 1 << at;
        block.writes[at] = None;
    }

    /// Writes a value perhaps; `stamp` is a new one.
    pub fn write_perhaps(&mut self, slot: usize, perhaps: Perhaps, stamp: u32) {
        let (block, at) = (Rc::make_mut(&mut self.words[slot / BLOCK]), slot % BLOCK);
        block.stamps[at] = stamp;
        let earlier = block.writes[at].take();
        let value = block.values[at];
        block.values[at] = value.join(perhaps.value);
        if perhaps.when.is_none() && perhaps.value == Ring::TOP {
            // From here on it is anything, whatever came before.
            return;
        }
        let (before, mut others) = match earlier {
            Some(writes) if writes.perhaps.len() < MOST_WRITES => {
                (writes.before, writes.perhaps.clone())
            }
            _ => (value, Vec::new()),
        };
        others.insert(0, perhaps);
        block.writes[at] = Some(Rc::new(Writes { before, perhaps: others }));
    }

    /// The literal that a bit is on, and what is known when it is on or off.
    pub fn bit(&self, bit: usize, on: bool) -> Condition {
        let Bit { stamp, truth } = &self.bits[bit / BLOCK][bit % BLOCK];
        let literal = Literal { bit: Some(bit), stamp: *stamp, on };
        match truth {
            Some(truth) => {
                let [when_on, when_off] = &**truth;
                let known = if on { when_on } else { when_off };
                if known.surely || known.never {
                    return Condition::constant(known.surely);
                }
                let words = known.words().to_vec();
                Condition::of(literal, known.literals()).knowing(words.into_iter())
            }
            None => Condition::literal(literal),
        }
    }

    /// Writes a bit; nothing is known of it if `truth` is `None`. `stamp` is a new one.
    pub fn write_bit(&mut self, bit: usize, truth: Option<[Condition; 2]>, stamp: u32) {
        let block = Rc::make_mut(&mut self.bits[bit / BLOCK]);
        block[bit % BLOCK] = Bit { stamp, truth: truth.map(Rc::new) };
    }

    /// What they hold where two paths meet; `stamp` is a new one.
    pub fn meet(&mut self, other: &State, stamp: u32) {
        self.together(other, stamp, Ring::join);
    }

    /// The same where that is done again and again.
    pub fn widen(&mut self, other: &State, stamp: u32) {
        self.together(other, stamp, Ring::widen);
    }

    fn together(&mut self, other: &State, stamp: u32, how: fn(Ring, Ring) -> Ring) {
        for (here, there) in self.words.iter_mut().zip(&other.words) {
            if Rc::ptr_eq(here, there) {
                continue;
            }
            let here = Rc::make_mut(here);
            for at in 0..BLOCK {
                here.values[at] = how(here.values[at], there.values[at]);
                if here.stamps[at] != there.stamps[at] {
                    here.stamps[at] = stamp;
                    here.writes[at] = None;
                }
            }
            here.written &= there.written;
        }
        for (here, there) in self.bits.iter_mut().zip(&other.bits) {
            if Rc::ptr_eq(here, there) {
                continue;
            }
            let here = Rc::make_mut(here);
            for (bit, there) in here.iter_mut().zip(&**there) {
                if bit.stamp != there.stamp {
                    *bit = Bit { stamp, truth: None };
                }
            }
        }
    }

    /// Whether all that can come of the other state can come of this one, and no more is known of this one.
    pub fn covers(&self, other: &State) -> bool {
        let words = |(here, there): (&Rc<Block>, &Rc<Block>)| {
            Rc::ptr_eq(here, there)
                || (here.values == there.values
                    && here.written == there.written
                    && (0..BLOCK)
                        .all(|at| here.writes[at].is_none() || here.stamps[at] == there.stamps[at]))
        };
        // What is known of a bit may speak of words, each by the write that it comes from.
        let holds_there = |known: &Known| {
            self.stamp(known.slot) != known.stamp || other.stamp(known.slot) == known.stamp
        };
        // Another write of a bit is the same only if nothing that is known hangs on which it is.
        let mut named: Option<FxHashSet<(usize, u32)>> = None;
        let mut bit = |place: usize, here: &Bit, there: &Bit| match &here.truth {
            None if here.stamp == there.stamp => true,
            None => {
                let named = named.get_or_insert_with(|| self.named());
                !named.contains(&(place, here.stamp))
            }
            Some(truth) => {
                here.stamp == there.stamp
                    && truth.iter().all(|known| known.words().iter().all(holds_there))
            }
        };
        self.words.iter().zip(&other.words).all(words)
            && self
                .bits
                .iter()
                .flat_map(|block| block.iter())
                .zip(other.bits.iter().flat_map(|block| block.iter()))
                .enumerate()
                .all(|(place, (here, there))| bit(place, here, there))
    }

    /// The bits, each by a write of it, on which it hangs what is known of words and other bits.
    fn named(&self) -> FxHashSet<(usize, u32)> {
        let writes = self.words.iter().flat_map(|block| block.writes.iter().flatten());
        let perhaps = writes.flat_map(|writes| &writes.perhaps);
        let of_words = perhaps.filter_map(|one| one.when.as_deref()).flatten();
        let truths = self.bits.iter().flat_map(|block| block.iter());
        let truths = truths.filter_map(|bit| bit.truth.as_deref()).flatten();
        let of_bits = truths.flat_map(Condition::literals);
        of_words.chain(of_bits).filter_map(|one| Some((one.bit?, one.stamp))).collect()
    }
}
