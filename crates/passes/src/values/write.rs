//! Executes the effects of one instruction.

use super::condition::Condition;
use super::evaluate::{Evaluation, sign_extended};
use super::reach::Reach;
use super::slots::Slots;
use super::state::Kept;
use super::value::Value;
use rustc_hash::FxHashSet;
use scanbound_ir::flow;
use scanbound_ir::meaning::{ChoiceKind, Meaning, Operation, OperationInput, Target};
use scanbound_ir::{BitTarget, ChoiceId, Number, Region, WordSource, WordTarget, Write};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// A write of tracked words or bits, given by slots, that an effect does if it is executed.
pub enum To {
    /// The slot of a bit, and what is known if the bit is on and if it is off (`None`: nothing).
    Bit(usize, Option<[Condition; 2]>),
    /// The word in this slot gets this value, which may be that of a word at the start of the scan.
    Word { slot: usize, value: Value, origin: Origin },
    /// The words in these slots may get any value, or keep theirs.
    Words(Range<usize>),
    /// The bits in these slots may get any value, or keep theirs.
    Bits(Range<usize>),
}

/// Where the value of a write of a word comes from.
#[derive(Clone, Default)]
pub struct Origin {
    pub kept: Kept,
    /// The slot of the word of which it is a copy.
    pub copy_of: Option<usize>,
    /// Whether only a bit of the word is written, and others may still be what the word held.
    pub is_bit: bool,
}

/// What a scan writes to words, by slot.
#[derive(Clone, Default)]
pub struct Given {
    /// The words to which it gives values: not only zeros or single bits, and not only what they may have held when it
    /// started, limited or with some bits changed.
    pub words: BTreeSet<usize>,
    /// Those of them that are 0 in a number of which another word is not.
    pub beside: BTreeSet<usize>,
    /// The values given to each word that do not depend on what it held when the scan started.
    pub independent: BTreeMap<usize, Value>,
    /// The words to which values are given that are computed from what they held then.
    pub computed: BTreeSet<usize>,
}

impl Given {
    /// Records the writes of one effect. Words that are written together are one number, and so are their copies.
    pub fn note(&mut self, writes: &[To]) {
        let given = writes.iter().filter_map(|to| match to {
            To::Word { slot, value, origin }
                if !origin.is_bit && !origin.kept.may_be_value_of(*slot) =>
            {
                Some((*slot, *value, origin))
            }
            _ => None,
        });
        let given: Vec<(usize, Value, &Origin)> = given.collect();
        for &(slot, value, origin) in &given {
            if origin.kept.depends_on(slot) {
                self.computed.insert(slot);
            } else {
                let known = self.independent.entry(slot).or_insert(value);
                *known = known.join(value);
            }
        }
        let is_set = |value: &Value| *value != Value::constant(0);
        let is_number = |(_, value, origin): &(usize, Value, &Origin)| {
            is_set(value) || origin.copy_of.is_some_and(|from| self.beside.contains(&from))
        };
        if given.iter().any(is_number) {
            self.words.extend(given.iter().map(|(slot, ..)| *slot));
            let zeros = given.iter().filter(|(_, value, _)| !is_set(value));
            self.beside.extend(zeros.map(|(slot, ..)| *slot));
        }
    }

    /// Records that words may get any value.
    pub fn note_any(&mut self, slots: Range<usize>) {
        self.words.extend(slots.clone());
        self.independent.extend(slots.map(|slot| (slot, Value::TOP)));
    }
}

/// Evaluates one effect in an abstract state, and collects the writes that it does.
pub struct Writer<'a> {
    /// The state before the effect, in which expressions are evaluated; the effect's guard is true in it.
    pub evaluation: Evaluation<'a>,
    /// A result: the cells that each indexed write may reach, over all its executions so far (`None`: unknown).
    pub reaches: &'a mut BTreeMap<ChoiceId, Option<Reach>>,
    /// The value of `Logic::Condition` for the instruction: the rung's result, together with the conditions of the open
    /// master control regions where they matter. It does not say whether the instruction is reached or fires.
    pub condition: &'a Condition,
    /// The writes collected so far.
    pub writes: Vec<To>,
}

impl Writer<'_> {
    /// Collects what a write does. `done` has the choices whose results were already written: all effects of an
    /// instruction with one choice are one write.
    pub fn write(&mut self, write: &Write, done: &mut FxHashSet<ChoiceId>) {
        match write {
            Write::Bit(BitTarget::Cell(cell), value) => {
                if let Some(slot) = self.bits().slot(*cell) {
                    let value = self.evaluation.logic(value, self.condition);
                    let off = value.negation();
                    self.writes.push(To::Bit(slot, Some([value, off])));
                }
            }
            Write::Bit(BitTarget::WordBit(cell, bit), value) => {
                let Some(slot) = self.words().slot(*cell) else { return };
                let value = self.evaluation.logic(value, self.condition);
                let before = self.evaluation.state.value(slot);
                let on = before.or(Value::constant(1 << bit), false);
                let off = before.and(Value::constant(!(1 << bit)));
                let value = match (value.surely, value.never) {
                    (true, _) => on,
                    (_, true) => off,
                    _ => on.join(off),
                };
                let before = self.evaluation.state.kept(slot);
                let kept = before.clone().without_bit(*bit);
                // The last of all bits makes the word the program's own.
                let is_bit = before == Kept::default() || kept != Kept::default();
                let origin = Origin { kept, copy_of: None, is_bit };
                self.writes.push(To::Word { slot, value, origin });
            }
            Write::Words(targets, number) => {
                let values = self.evaluation.number(number);
                self.write_words(targets, &values, &self.origins(number));
                flow::written_by(write).into_iter().for_each(|region| self.forget_bits(region));
            }
            Write::Havoc(region, choice) => self.havoc(*region, *choice, done),
        }
    }

    fn words(&self) -> &Slots {
        &self.evaluation.followed.words
    }

    fn bits(&self) -> &Slots {
        &self.evaluation.followed.bits
    }

    fn havoc(&mut self, region: Region, choice: ChoiceId, done: &mut FxHashSet<ChoiceId>) {
        let exact = match self.evaluation.program.kinds.get(&choice) {
            Some(ChoiceKind::Exact(meaning)) => Some(meaning),
            _ => None,
        };
        if let Some(meaning) = exact
            && meaning.outputs.iter().all(is_followed)
        {
            // All effects with one choice are one write.
            if done.insert(choice) {
                self.write_results(meaning);
            }
            self.forget_bits(region);
            return;
        }
        for region in self.reach(region, choice) {
            let words = self.words().within(region);
            self.writes.extend((!words.is_empty()).then_some(To::Words(words)));
            self.forget_bits(region);
        }
    }

    /// Collects the writes of an operation's results. If these are not known, they may be any values computed from its
    /// operands, and may also not be written. Bits are not written here.
    fn write_results(&mut self, meaning: &Meaning) {
        let all = computed(meaning.inputs.iter().flat_map(|input| self.input(input)));
        let results = self.evaluation.operation(meaning);
        for (place, output) in meaning.outputs.iter().enumerate() {
            let Target::Words(targets) = output else { continue };
            // The result may be this operand.
            let from = match meaning.operation {
                Operation::Copy => meaning.inputs.get(place),
                // The lower words are the same.
                Operation::Resize(_) | Operation::PutBit(_) => meaning.inputs.first(),
                Operation::Limit => meaning.inputs.get(2),
                _ => None,
            };
            let mut origins = from.map_or_else(Vec::new, |from| self.input(from));
            if meaning.operation != Operation::Copy {
                origins.iter_mut().for_each(|origin| {
                    origin.kept = origin.kept.join(&all.kept);
                    origin.copy_of = None;
                });
                origins.resize(targets.len().max(origins.len()), all.clone());
            }
            if results.is_none() {
                origins.resize(targets.len().max(origins.len()), Origin::default());
                for (origin, target) in origins.iter_mut().zip(targets) {
                    if let WordTarget::Cell(cell) = target {
                        let before = self.origins_of(&[WordSource::Cell(*cell)]);
                        origin.kept = origin.kept.join(&before[0].kept);
                    }
                    origin.copy_of = None;
                }
            }
            let known = results.as_ref().and_then(|all| all.get(place));
            self.write_words(targets, known.map_or(&[][..], Vec::as_slice), &origins);
        }
    }

    /// Collects that nothing is known any more about the tracked bits of a region.
    fn forget_bits(&mut self, region: Region) {
        let bits = self.bits().within(region);
        self.writes.extend((!bits.is_empty()).then_some(To::Bits(bits)));
    }

    /// Collects writes of words.
    fn write_words(&mut self, targets: &[WordTarget], values: &[Value], origins: &[Origin]) {
        for (place, target) in targets.iter().enumerate() {
            let WordTarget::Cell(cell) = target else { continue };
            if let Some(slot) = self.words().slot(*cell) {
                let value = values.get(place).copied().unwrap_or(Value::TOP);
                let origin = origins.get(place).cloned().unwrap_or_default();
                self.writes.push(To::Word { slot, value, origin });
            }
        }
    }

    /// Where each word of a number comes from.
    fn origins(&self, number: &Number) -> Vec<Origin> {
        if let Some(word) = sign_extended(number) {
            return self.origins_of(&[word]);
        }
        match number {
            Number::Words(words) => self.origins_of(words),
            Number::And(a, b) | Number::Or(a, b) | Number::Xor(a, b) => {
                let [mut a, mut b] = [a, b].map(|one| self.origins(one));
                let words = a.len().max(b.len());
                a.resize(words, Origin::default());
                b.resize(words, Origin::default());
                let both = |(a, b): (&Origin, &Origin)| Origin {
                    kept: a.kept.join(&b.kept),
                    ..Origin::default()
                };
                a.iter().zip(&b).map(both).collect()
            }
            // The result of a call is copied so.
            Number::Add(a, b) if b.words().all(|word| word == WordSource::Const(0)) => {
                self.origins(a)
            }
            Number::Add(a, b) | Number::Sub(a, b) => {
                let [a, b] = [a, b].map(|one| self.origins(one));
                let words = a.len().max(b.len());
                vec![computed(a.into_iter().chain(b)); words]
            }
        }
    }

    /// Where each word of an operand comes from; empty for bits and runs of cells.
    fn input(&self, input: &OperationInput) -> Vec<Origin> {
        match input {
            OperationInput::Words(words) => self.origins_of(words),
            OperationInput::Number(number) => self.origins(number),
            _ => Vec::new(),
        }
    }

    fn origins_of(&self, words: &[WordSource]) -> Vec<Origin> {
        let origin = |word: &WordSource| {
            let WordSource::Cell(cell) = word else { return Origin::default() };
            let copy_of = self.words().slot(*cell);
            let kept = copy_of.map(|slot| self.evaluation.state.kept(slot));
            Origin { kept: kept.unwrap_or_default(), copy_of, is_bit: false }
        };
        words.iter().map(origin).collect()
    }

    /// The regions that an indexed write may reach, which are also recorded; `region` itself if they are unknown.
    fn reach(&mut self, region: Region, choice: ChoiceId) -> Vec<Region> {
        let indexed = self.evaluation.program.indexed.get(&choice);
        let Some(indexed) = indexed.filter(|one| one.may_reach(region)) else {
            return vec![region];
        };
        let found = self.evaluation.reach(indexed);
        let known = self.reaches.entry(choice).or_insert(found);
        *known = match (*known, found) {
            (Some(known), Some(found)) => Some(known.join(found)),
            _ => None,
        };
        let Some(found) = found else { return vec![region] };
        found.stretches().into_iter().map(|ends| indexed.range(ends)).collect()
    }
}

/// Where a value comes from that is computed from all of these.
fn computed(all: impl Iterator<Item = Origin>) -> Origin {
    let kept = all.fold(Kept::default(), |all, one| all.join(&one.kept.computed()));
    Origin { kept, ..Origin::default() }
}

/// Whether a result with this target can be followed. Not with bits of words, which leave the word any value, and not
/// with a computed address.
fn is_followed(to: &Target) -> bool {
    match to {
        Target::Words(_) | Target::Nowhere => true,
        Target::Bits(bits) => bits.iter().all(|bit| !matches!(bit, BitTarget::WordBit(..))),
        Target::Run(..) => false,
    }
}
