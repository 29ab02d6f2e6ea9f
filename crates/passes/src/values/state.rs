//! The abstract state at one program point: the possible values of words, and what is known about bits.

use super::condition::{Condition, ConditionalWrite, Literal, WasExecuted, WordFact};
use super::limits::WideningLimits;
use super::skippable::skippable;
use super::slots::Slots;
use super::value::Value;
use rustc_hash::FxHashSet;
use scanbound_ir::Program;
use std::collections::BTreeSet;
use std::ops::Range;
use std::rc::Rc;

/// The words and bits that the abstract interpretation tracks: words that affect counts, and bits that control their
/// writes.
pub struct Tracked {
    pub words: Slots,
    pub bits: Slots,
    /// For the first instruction of each rung that changes no tracked cell: the index of the next rung. 0 for all other
    /// instructions.
    pub behind: Vec<usize>,
    /// The numbers to which growing words are widened.
    pub limits: WideningLimits,
}

impl Tracked {
    /// Tracks these words and bits of a program, and finds the rungs that can be skipped and the limits for widening.
    pub fn of(program: &Program, words: Slots, bits: Slots) -> Tracked {
        let behind = skippable(program, &words, &bits);
        let limits = WideningLimits::of(program, &words);
        Tracked { words, bits, behind, limits }
    }

    /// The state in which every word and bit may have any value.
    pub fn anything(&self) -> State {
        self.holding(vec![Value::TOP; self.words.cells().len()])
    }

    /// The state in which the words, by slot, have these values, and nothing is known of bits.
    pub fn holding(&self, values: Vec<Value>) -> State {
        State::new(&values, self.bits.cells().len())
    }
}

/// The number of slots in a block. Copies of a state share its blocks until they change.
const BLOCK: usize = 32;

/// The abstract state at a point of the scan: the possible values of each tracked word, and what each tracked bit says
/// about words and other bits.
#[derive(Debug, Clone)]
pub struct State {
    words: Vec<Rc<Block>>,
    /// Whether each word was written in this scan on every path to this point: one bit for each word, one `u32` for
    /// each block.
    written: Vec<u32>,
    /// Whether each word was written on any path, in the same form.
    touched: Vec<u32>,
    bits: Vec<Rc<[Bit; BLOCK]>>,
}

/// What is known of the words in `BLOCK` successive slots.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Block {
    values: [Value; BLOCK],
    /// The stamp of the write that gave each value. Facts refer to a stamp, so they do not apply to later values.
    stamps: [u32; BLOCK],
    /// The recent conditional writes of each word; `None` if the last write was certain.
    writes: [Option<Rc<Writes>>; BLOCK],
    /// How each written word depends on the start of the scan.
    kept: [Kept; BLOCK],
}

/// How a word may depend on the values that words had at the start of the scan. Sets of slots are in ascending order;
/// `None` if they are empty.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Kept {
    /// The words of which it may hold such a value, perhaps limited or with some bits changed.
    perhaps: Option<Rc<[usize]>>,
    /// The words from whose values it may be computed in any way, with those in `perhaps`.
    from: Option<Rc<[usize]>>,
    /// The bits that may be those of a word in `perhaps`.
    bits: u16,
}

/// The slots that are in one of two sets.
fn united(one: &Option<Rc<[usize]>>, other: &Option<Rc<[usize]>>) -> Option<Rc<[usize]>> {
    match (one, other) {
        (None, some) | (some, None) => some.clone(),
        (Some(one), Some(other)) if one == other => Some(one.clone()),
        (Some(one), Some(other)) => {
            let all: BTreeSet<usize> = one.iter().chain(other.iter()).copied().collect();
            Some(all.into_iter().collect())
        }
    }
}

impl Kept {
    fn own(slot: usize) -> Kept {
        let own: Option<Rc<[usize]>> = Some(Rc::new([slot]));
        Kept { perhaps: own.clone(), from: own, bits: u16::MAX }
    }

    /// The same after a bit of the word was written.
    pub fn without_bit(self, bit: u8) -> Kept {
        match self.bits & !(1 << bit) {
            0 => Kept::default(),
            bits => Kept { bits, ..self },
        }
    }

    /// Whether the word may hold what the word in this slot held at the start of the scan, perhaps limited or with some
    /// bits changed.
    pub fn may_be_value_of(&self, slot: usize) -> bool {
        self.perhaps.as_ref().is_some_and(|slots| slots.contains(&slot))
    }

    /// Whether the word may depend on what the word in this slot held at the start of the scan.
    pub fn depends_on(&self, slot: usize) -> bool {
        self.from.as_ref().is_some_and(|slots| slots.contains(&slot))
    }

    /// What is known of a value that is computed from it.
    pub fn computed(self) -> Kept {
        Kept { from: self.from, ..Kept::default() }
    }

    /// What is known if either applies, or of a word of which each bit is one of either, or made of both.
    pub fn join(&self, other: &Kept) -> Kept {
        let perhaps = united(&self.perhaps, &other.perhaps);
        let from = united(&self.from, &other.from);
        Kept { perhaps, from, bits: self.bits | other.bits }
    }
}

impl Block {
    /// A block of words with any values, all with one stamp.
    fn anything(stamp: u32) -> Block {
        Block {
            values: [Value::TOP; BLOCK],
            stamps: [stamp; BLOCK],
            writes: [const { None }; BLOCK],
            kept: [const { Kept { perhaps: None, from: None, bits: 0 } }; BLOCK],
        }
    }
}

/// The recent writes of a word that are executed only under a condition.
#[derive(Debug, PartialEq, Eq)]
struct Writes {
    /// The possible values before these writes.
    before: Value,
    /// The writes, latest first; at most [`MAX_WRITES`].
    perhaps: Vec<ConditionalWrite>,
}

/// What a tracked bit says about words and other bits. It is no set of values: the bit may be on or off.
#[derive(Debug, Clone, Default)]
struct Bit {
    /// The stamp of the bit's last write.
    stamp: u32,
    /// What is known if the bit is on, and what is known if it is off; `None`: nothing.
    truth: Option<Rc<[Condition; 2]>>,
}

/// The numbers of the blocks that contain these slots, each with the positions of these slots in the block.
fn blocks(slots: Range<usize>) -> impl Iterator<Item = (usize, Range<usize>)> {
    let Range { start, end } = slots;
    (start / BLOCK..end.div_ceil(BLOCK)).map(move |place| {
        let first = place * BLOCK;
        (place, start.max(first) - first..end.min(first + BLOCK) - first)
    })
}

/// The largest number of conditional writes of a word that are remembered one by one.
const MAX_WRITES: usize = 4;

impl State {
    /// A state with these values of words and nothing known of `bits` bits.
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
            touched: vec![0; values.len().div_ceil(BLOCK)],
            bits: vec![free; bits.div_ceil(BLOCK)],
        }
    }

    pub fn value(&self, slot: usize) -> Value {
        self.words[slot / BLOCK].values[slot % BLOCK]
    }

    fn writes(&self, slot: usize) -> Option<&Rc<Writes>> {
        self.words[slot / BLOCK].writes[slot % BLOCK].as_ref()
    }

    /// The possible values of a word if these literals are true: those of its conditional writes that may then have
    /// been executed.
    pub fn value_where(&self, slot: usize, holds: &[Literal]) -> Value {
        let all = self.value(slot);
        let Some(writes) = self.writes(slot) else { return all };
        let mut found: Option<Value> = None;
        let mut add = |value: Value| found = Some(found.map_or(value, |found| found.join(value)));
        let mut done = false;
        for write in &writes.perhaps {
            match write.happened(holds) {
                WasExecuted::No => continue,
                WasExecuted::ConditionalWrite => add(write.value),
                WasExecuted::Yes => {
                    add(write.value);
                    done = true;
                    break;
                }
            }
        }
        if !done {
            add(writes.before);
        }
        // Both results are valid, so use their intersection.
        found.map_or(all, |found| found.closer(all))
    }

    pub fn stamp(&self, slot: usize) -> u32 {
        self.words[slot / BLOCK].stamps[slot % BLOCK]
    }

    /// Whether the word was written in this scan on every path to this point, and not only with the value that it had
    /// at the start, perhaps limited: a parameter that is passed by reference is copied to the block and back.
    pub fn has_new_value(&self, slot: usize) -> bool {
        !self.kept(slot).may_be_value_of(slot)
    }

    /// How this word may depend on what words held at the start of the scan.
    pub fn kept(&self, slot: usize) -> Kept {
        let (place, at) = (slot / BLOCK, slot % BLOCK);
        let bit = |of: &[u32]| of[place] & 1 << at != 0;
        let kept = &self.words[place].kept[at];
        match (bit(&self.touched), bit(&self.written)) {
            (false, _) => Kept::own(slot),
            (true, true) => kept.clone(),
            (true, false) => kept.join(&Kept::own(slot)),
        }
    }

    /// Replaces what is known of a word by `value`, without a new stamp: the word was not written.
    pub fn restrict(&mut self, slot: usize, value: Value) {
        if self.value(slot) != value {
            Rc::make_mut(&mut self.words[slot / BLOCK]).values[slot % BLOCK] = value;
        }
    }

    /// Restricts words to what is known if the condition is true. The previous values of restricted words are appended
    /// to `before`, so that the caller can restore them. `false` if the condition cannot be true here.
    pub fn assume(&mut self, condition: &Condition, before: &mut Vec<(usize, Value)>) -> bool {
        for known in condition.words() {
            if self.stamp(known.slot) != known.stamp {
                continue;
            }
            let value = self.value(known.slot);
            match value.meet(known.value) {
                Some(closer) => {
                    before.push((known.slot, value));
                    self.restrict(known.slot, closer);
                }
                None => return false,
            }
        }
        true
    }

    /// Restricts words to what is known if the condition is false. `false` if the condition cannot be false here.
    pub fn assume_not(&mut self, condition: &Condition) -> bool {
        for known in condition.words_off() {
            if self.stamp(known.slot) != known.stamp {
                continue;
            }
            match self.value(known.slot).meet(known.value) {
                Some(closer) => self.restrict(known.slot, closer),
                None => return false,
            }
        }
        true
    }

    /// The possible values of a word if a condition is false; `None` if it cannot be false here.
    pub fn value_unless(&self, slot: usize, condition: &Condition) -> Option<Value> {
        let (mut value, stamp) = (self.value(slot), self.stamp(slot));
        if let Some(ways) = condition.cases_if_false(slot, stamp) {
            let on_way =
                |(holds, lies): (Vec<Literal>, Value)| self.value_where(slot, &holds).meet(lies);
            let all = ways.into_iter().filter_map(on_way).reduce(Value::join)?;
            value = value.meet(all)?;
        }
        let off = condition.words_off().iter();
        let off = off.filter(|known| known.slot == slot && known.stamp == stamp);
        off.map(|known| known.value).try_fold(value, Value::meet)
    }

    /// Restricts the values of all words to what follows if these literals are true.
    pub fn restrict_where(&mut self, holds: &[Literal]) {
        if holds.is_empty() {
            return;
        }
        for slot in 0..self.words.len() * BLOCK {
            if self.writes(slot).is_some() {
                self.restrict(slot, self.value_where(slot, holds));
            }
        }
    }

    /// Writes a value to a word for certain; `stamp` must be new.
    pub fn write(&mut self, slot: usize, value: Value, kept: Kept, stamp: u32) {
        let (block, at) = (Rc::make_mut(&mut self.words[slot / BLOCK]), slot % BLOCK);
        block.values[at] = value;
        block.stamps[at] = stamp;
        block.writes[at] = None;
        block.kept[at] = kept;
        self.touched[slot / BLOCK] |= 1 << at;
        self.written[slot / BLOCK] |= 1 << at;
    }

    /// Sets words to any value, because they may have been written; `stamp` must be new.
    pub fn forget(&mut self, slots: Range<usize>, stamp: u32) {
        let all = std::cell::OnceCell::new();
        for (place, within) in blocks(slots) {
            let block = &mut self.words[place];
            for at in within.clone() {
                self.touched[place] |= 1 << at;
            }
            let is_kept = |one: &Kept| *one != Kept::default();
            if within == (0..BLOCK) && !block.kept.iter().any(is_kept) {
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

    /// As [`State::write`], for a value that the word gets only under a condition; otherwise it has a value of
    /// `unwritten`.
    pub fn write_perhaps(
        &mut self,
        slot: usize,
        perhaps: ConditionalWrite,
        unwritten: Value,
        kept: &Kept,
        stamp: u32,
    ) {
        let either = self.kept(slot).join(kept);
        let (block, at) = (Rc::make_mut(&mut self.words[slot / BLOCK]), slot % BLOCK);
        self.touched[slot / BLOCK] |= 1 << at;
        block.stamps[at] = stamp;
        block.kept[at] = either;
        let earlier = block.writes[at].take();
        let value = block.values[at];
        block.values[at] = unwritten.join(perhaps.value);
        if perhaps.when.is_none() && perhaps.value == Value::TOP {
            // The word may have any value in either case.
            return;
        }
        let (before, mut others) = match earlier {
            Some(writes) if writes.perhaps.len() < MAX_WRITES => {
                (writes.before, writes.perhaps.clone())
            }
            _ => (value, Vec::new()),
        };
        others.insert(0, perhaps);
        block.writes[at] = Some(Rc::new(Writes { before, perhaps: others }));
    }

    /// The condition that a bit is on (with `on` false, that it is off), with what is known if it is true and if it is
    /// false.
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
                let found = Condition::of(literal, known.literals()).with_facts(words.into_iter());
                found.with_facts_if_false(off.into_iter(), &[])
            }
            None => Condition::literal(literal),
        }
    }

    /// Writes a bit. `truth` is what is known if the bit is on, and if it is off; `None`: nothing. `stamp` must be new.
    pub fn write_bit(&mut self, bit: usize, truth: Option<[Condition; 2]>, stamp: u32) {
        let block = Rc::make_mut(&mut self.bits[bit / BLOCK]);
        block[bit % BLOCK] = Bit { stamp, truth: truth.map(Rc::new) };
    }

    /// Forgets everything about bits; `stamp` must be new.
    pub fn forget_bits(&mut self, bits: Range<usize>, stamp: u32) {
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

    /// Joins the state with that of a second path; `stamp` must be new.
    pub fn meet(&mut self, other: &State, stamp: u32) {
        self.together(other, stamp, |_, here, there| here.join(there));
    }

    /// Joins the state with that of one more iteration or scan, and widens values that grow; `stamp` must be new.
    pub fn widen(&mut self, other: &State, stamp: u32, limits: &WideningLimits, is_last: bool) {
        self.together(other, stamp, |slot, here, there| limits.widen(slot, here, there, is_last));
    }

    fn together(&mut self, other: &State, stamp: u32, how: impl Fn(usize, Value, Value) -> Value) {
        for place in 0..self.words.len() {
            let there = &other.words[place];
            if Rc::ptr_eq(&self.words[place], there) || *self.words[place] == **there {
                continue;
            }
            let slots = place * BLOCK..(place + 1) * BLOCK;
            let kept: Vec<Kept> =
                slots.map(|slot| self.kept(slot).join(&other.kept(slot))).collect();
            let here = Rc::make_mut(&mut self.words[place]);
            for (at, kept) in kept.into_iter().enumerate() {
                here.kept[at] = kept;
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
        for (here, there) in self.touched.iter_mut().zip(&other.touched) {
            *here |= there;
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

    /// Whether this state allows everything that the other allows, by a quick test: the words must have equal values.
    /// `false` may be wrong, `true` is certain.
    pub fn covers(&self, other: &State) -> bool {
        let words = |(here, there): (&Rc<Block>, &Rc<Block>)| {
            Rc::ptr_eq(here, there)
                || (here.values == there.values
                    && here.kept == there.kept
                    && (0..BLOCK)
                        .all(|at| here.writes[at].is_none() || here.stamps[at] == there.stamps[at]))
        };
        // Facts about a bit may refer to words, each with the stamp of its write.
        let holds_there = |known: &WordFact| {
            self.stamp(known.slot) != known.stamp || other.stamp(known.slot) == known.stamp
        };
        // Different stamps of a bit matter only if a fact refers to that stamp.
        let mut named: Option<FxHashSet<(usize, u32)>> = None;
        let mut bit = |place: usize, here: &Bit, there: &Bit| match &here.truth {
            None if here.stamp == there.stamp => true,
            None => {
                let named = named.get_or_insert_with(|| self.stamps_in_facts());
                !named.contains(&(place, here.stamp))
            }
            Some(truth) => {
                here.stamp == there.stamp
                    && truth.iter().all(|known| known.words().iter().all(holds_there))
            }
        };
        self.written == other.written
            && self.touched == other.touched
            && self.words.iter().zip(&other.words).all(words)
            && self
                .bits
                .iter()
                .flat_map(|block| block.iter())
                .zip(other.bits.iter().flat_map(|block| block.iter()))
                .enumerate()
                .all(|(place, (here, there))| bit(place, here, there))
    }

    /// The bits, with their stamps, to which facts about words and other bits refer.
    fn stamps_in_facts(&self) -> FxHashSet<(usize, u32)> {
        let writes = self.words.iter().flat_map(|block| block.writes.iter().flatten());
        let perhaps = writes.flat_map(|writes| &writes.perhaps);
        let of_words = perhaps.filter_map(|one| one.when.as_deref()).flatten();
        let truths = self.bits.iter().flat_map(|block| block.iter());
        let truths = truths.filter_map(|bit| bit.truth.as_deref()).flatten();
        let of_bits = truths.flat_map(Condition::literals);
        of_words.chain(of_bits).filter_map(|one| Some((one.bit?, one.stamp))).collect()
    }
}
