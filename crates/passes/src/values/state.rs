//! What words may hold at one place of the scan, and what is known of the bits on which it hangs whether they are written.

use super::condition::{Condition, Happened, Known, Literal, Perhaps};
use super::limits::Limits;
use super::rungs::passed_over;
use super::slots::Slots;
use super::value::Value;
use rustc_hash::FxHashSet;
use scanbound_ir::Program;
use std::ops::Range;
use std::rc::Rc;

/// What is followed: the words that matter, and bits on which it hangs whether they are written.
pub struct Followed {
    pub words: Slots,
    pub bits: Slots,
    /// For the first instruction of each rung that changes none of them, the one behind it; 0 for all others.
    pub behind: Vec<usize>,
    /// How far what grows is let grow.
    pub limits: Limits,
}

impl Followed {
    /// These words and bits of a program.
    pub fn of(program: &Program, words: Slots, bits: Slots) -> Followed {
        let behind = passed_over(program, &words, &bits);
        let limits = Limits::of(program, &words);
        Followed { words, bits, behind, limits }
    }

    /// A state in which all may hold anything.
    pub fn anything(&self) -> State {
        self.holding(vec![Value::TOP; self.words.cells().len()])
    }

    /// A state in which the words hold these values.
    pub fn holding(&self, values: Vec<Value>) -> State {
        State::new(&values, self.bits.cells().len())
    }
}

/// So many slots are kept together: what does not change is shared between states.
const BLOCK: usize = 32;

/// What the words and bits hold.
#[derive(Debug, Clone)]
pub struct State {
    words: Vec<Rc<Block>>,
    /// Whether each word was written in this scan on every path here: a bit each, a block after the other.
    written: Vec<u32>,
    bits: Vec<Rc<[Bit; BLOCK]>>,
}

/// What some words hold.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Block {
    values: [Value; BLOCK],
    /// Which write each value comes from: what was found out about a value says nothing of another.
    stamps: [u32; BLOCK],
    /// What the last writes of each were that need not have happened.
    writes: [Option<Rc<Writes>>; BLOCK],
}

impl Block {
    /// Some words that may hold anything, all by one write.
    fn anything(stamp: u32) -> Block {
        Block {
            values: [Value::TOP; BLOCK],
            stamps: [stamp; BLOCK],
            writes: [const { None }; BLOCK],
        }
    }
}

/// Writes of a word that need not have happened.
#[derive(Debug, PartialEq, Eq)]
struct Writes {
    /// What it held before them.
    before: Value,
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

/// The blocks that slots lie in, each with the places in it.
fn blocks(slots: Range<usize>) -> impl Iterator<Item = (usize, Range<usize>)> {
    let Range { start, end } = slots;
    (start / BLOCK..end.div_ceil(BLOCK)).map(move |place| {
        let first = place * BLOCK;
        (place, start.max(first) - first..end.min(first + BLOCK) - first)
    })
}

/// So many writes of a word that need not have happened are remembered.
const MOST_WRITES: usize = 4;

impl State {
    /// What they hold when the scan starts, and so many bits anything.
    pub fn new(values: &[Value], bits: usize) -> State {
        let block = |some: &[Value]| {
            let mut block = Block::anything(0);
            block.values[..some.len()].copy_from_slice(some);
            Rc::new(block)
        };
        let free: Rc<[Bit; BLOCK]> = Rc::new(std::array::from_fn(|_| Bit::default()));
        State {
            words: values.chunks(BLOCK).map(block).collect(),
            written: vec![0; values.len().div_ceil(BLOCK)],
            bits: vec![free; bits.div_ceil(BLOCK)],
        }
    }

    pub fn value(&self, slot: usize) -> Value {
        self.words[slot / BLOCK].values[slot % BLOCK]
    }

    fn writes(&self, slot: usize) -> Option<&Rc<Writes>> {
        self.words[slot / BLOCK].writes[slot % BLOCK].as_ref()
    }

    /// The value where these are true.
    pub fn value_where(&self, slot: usize, holds: &[Literal]) -> Value {
        let all = self.value(slot);
        let Some(writes) = self.writes(slot) else { return all };
        let mut found: Option<Value> = None;
        let mut add = |value: Value| found = Some(found.map_or(value, |found| found.join(value)));
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
        self.written[slot / BLOCK] & 1 << (slot % BLOCK) != 0
    }

    /// Takes what is known of a value closer; it stays the same value.
    pub fn know(&mut self, slot: usize, value: Value) {
        if self.value(slot) != value {
            Rc::make_mut(&mut self.words[slot / BLOCK]).values[slot % BLOCK] = value;
        }
    }

    /// Takes the words closer to what holds with a condition. What was known before is put into `before`. False if it cannot
    /// hold here.
    pub fn assume(&mut self, condition: &Condition, before: &mut Vec<(usize, Value)>) -> bool {
        for known in condition.words() {
            if self.stamp(known.slot) != known.stamp {
                continue;
            }
            let value = self.value(known.slot);
            match value.meet(known.lies) {
                Some(closer) => {
                    before.push((known.slot, value));
                    self.know(known.slot, closer);
                }
                None => return false,
            }
        }
        true
    }

    /// The same with what holds where a condition does not.
    pub fn assume_not(&mut self, condition: &Condition) -> bool {
        for known in condition.words_off() {
            if self.stamp(known.slot) != known.stamp {
                continue;
            }
            match self.value(known.slot).meet(known.lies) {
                Some(closer) => self.know(known.slot, closer),
                None => return false,
            }
        }
        true
    }

    /// The value of a word where a condition does not hold; `None` if that cannot be.
    pub fn value_unless(&self, slot: usize, condition: &Condition) -> Option<Value> {
        let (mut value, stamp) = (self.value(slot), self.stamp(slot));
        if let Some(ways) = condition.ways_off(slot, stamp) {
            let on_way =
                |(holds, lies): (Vec<Literal>, Value)| self.value_where(slot, &holds).meet(lies);
            let all = ways.into_iter().filter_map(on_way).reduce(Value::join)?;
            value = value.meet(all)?;
        }
        let off = condition.words_off().iter();
        let off = off.filter(|known| known.slot == slot && known.stamp == stamp);
        off.map(|known| known.lies).try_fold(value, Value::meet)
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
    pub fn write(&mut self, slot: usize, value: Value, stamp: u32) {
        let (block, at) = (Rc::make_mut(&mut self.words[slot / BLOCK]), slot % BLOCK);
        block.values[at] = value;
        block.stamps[at] = stamp;
        block.writes[at] = None;
        self.written[slot / BLOCK] |= 1 << at;
    }

    /// Words may hold anything from here on; `stamp` is a new one.
    pub fn lose(&mut self, slots: Range<usize>, stamp: u32) {
        let all = std::cell::OnceCell::new();
        for (place, within) in blocks(slots) {
            let block = &mut self.words[place];
            if within == (0..BLOCK) {
                *block = Rc::clone(all.get_or_init(|| Rc::new(Block::anything(stamp))));
                continue;
            }
            let block = Rc::make_mut(block);
            for at in within {
                block.values[at] = Value::TOP;
                block.stamps[at] = stamp;
                block.writes[at] = None;
            }
        }
    }

    /// Writes a value perhaps; where that does not happen it stays one of `unwritten`. `stamp` is a new one.
    pub fn write_perhaps(&mut self, slot: usize, perhaps: Perhaps, unwritten: Value, stamp: u32) {
        let (block, at) = (Rc::make_mut(&mut self.words[slot / BLOCK]), slot % BLOCK);
        block.stamps[at] = stamp;
        let earlier = block.writes[at].take();
        let value = block.values[at];
        block.values[at] = unwritten.join(perhaps.value);
        if perhaps.when.is_none() && perhaps.value == Value::TOP {
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
                let opposite = if on { when_off } else { when_on };
                let [words, off] = [known, opposite].map(|truth| truth.words().to_vec());
                let found = Condition::of(literal, known.literals()).knowing(words.into_iter());
                found.denying(off.into_iter(), &[])
            }
            None => Condition::literal(literal),
        }
    }

    /// Writes a bit; nothing is known of it if `truth` is `None`. `stamp` is a new one.
    pub fn write_bit(&mut self, bit: usize, truth: Option<[Condition; 2]>, stamp: u32) {
        let block = Rc::make_mut(&mut self.bits[bit / BLOCK]);
        block[bit % BLOCK] = Bit { stamp, truth: truth.map(Rc::new) };
    }

    /// Nothing is known of bits from here on; `stamp` is a new one.
    pub fn lose_bits(&mut self, bits: Range<usize>, stamp: u32) {
        let all = std::cell::OnceCell::new();
        let lost = || Bit { stamp, truth: None };
        for (place, within) in blocks(bits) {
            let block = &mut self.bits[place];
            if within == (0..BLOCK) {
                let all = all.get_or_init(|| Rc::new(std::array::from_fn(|_| lost())));
                *block = Rc::clone(all);
            } else {
                Rc::make_mut(block)[within].fill(lost());
            }
        }
    }

    /// What they hold where two paths meet; `stamp` is a new one.
    pub fn meet(&mut self, other: &State, stamp: u32) {
        self.together(other, stamp, |_, here, there| here.join(there));
    }

    /// The same where that is done again and again.
    pub fn widen(&mut self, other: &State, stamp: u32, limits: &Limits, is_last: bool) {
        self.together(other, stamp, |slot, here, there| limits.widen(slot, here, there, is_last));
    }

    fn together(&mut self, other: &State, stamp: u32, how: impl Fn(usize, Value, Value) -> Value) {
        for (place, (here, there)) in self.words.iter_mut().zip(&other.words).enumerate() {
            if Rc::ptr_eq(here, there) {
                continue;
            }
            if **here == **there {
                continue;
            }
            let here = Rc::make_mut(here);
            for at in 0..BLOCK {
                if here.values[at] != there.values[at] {
                    let slot = place * BLOCK + at;
                    here.values[at] = how(slot, here.values[at], there.values[at]);
                }
                if here.stamps[at] != there.stamps[at] {
                    here.stamps[at] = stamp;
                    here.writes[at] = None;
                }
            }
        }
        for (here, there) in self.written.iter_mut().zip(&other.written) {
            *here &= there;
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
        self.written == other.written
            && self.words.iter().zip(&other.words).all(words)
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
