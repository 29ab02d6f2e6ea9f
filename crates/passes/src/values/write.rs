//! The effects of one instruction.

use super::condition::Condition;
use super::evaluate::Evaluation;
use super::reach::Reach;
use super::slots::Slots;
use super::value::Value;
use rustc_hash::FxHashSet;
use scanbound_ir::flow;
use scanbound_ir::meaning::{ChoiceKind, Target};
use scanbound_ir::{BitTarget, ChoiceId, Region, WordTarget, Write};
use std::collections::BTreeMap;
use std::ops::Range;

/// One write of what is followed.
pub enum To {
    /// A bit's slot, and what is known when it is on and when it is off.
    Bit(usize, Option<[Condition; 2]>),
    /// A word's slot and its value: it is written if the effect happens.
    Word { slot: usize, value: Value },
    /// Some words, perhaps: they may hold anything from here on.
    Words(Range<usize>),
    /// Some bits, perhaps.
    Bits(Range<usize>),
}

/// One effect being carried out.
pub struct Writer<'a> {
    /// In the state before it, where its guard holds.
    pub evaluation: Evaluation<'a>,
    /// What was found of indexed writes.
    pub reaches: &'a mut BTreeMap<ChoiceId, Option<Reach>>,
    /// The instruction's.
    pub condition: &'a Condition,
    /// What it writes.
    pub writes: Vec<To>,
}

impl Writer<'_> {
    /// Carries it out. `done` are the choices of which all effects are carried out.
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
                self.writes.push(To::Word { slot, value });
            }
            Write::Words(targets, number) => {
                let values = self.evaluation.number(number);
                self.put(targets, &values);
                flow::written_by(write).into_iter().for_each(|region| self.lose_bits(region));
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
            && let Some(results) = self.evaluation.operation(meaning)
        {
            // All effects with this choice are one writing.
            if done.insert(choice) {
                for (place, output) in meaning.outputs.iter().enumerate() {
                    let results = results.get(place).map_or(&[][..], Vec::as_slice);
                    match output {
                        Target::Words(targets) => self.put(targets, results),
                        // Bits are lost below.
                        Target::Bits(_) | Target::Run(..) | Target::Nowhere => {}
                    }
                }
            }
            self.lose_bits(region);
            return;
        }
        for region in self.reach(region, choice) {
            let words = self.words().within(region);
            self.writes.extend((!words.is_empty()).then_some(To::Words(words)));
            self.lose_bits(region);
        }
    }

    /// Takes bits as not known.
    fn lose_bits(&mut self, region: Region) {
        let bits = self.bits().within(region);
        self.writes.extend((!bits.is_empty()).then_some(To::Bits(bits)));
    }

    fn put(&mut self, targets: &[WordTarget], values: &[Value]) {
        for (place, target) in targets.iter().enumerate() {
            let WordTarget::Cell(cell) = target else { continue };
            if let Some(slot) = self.words().slot(*cell) {
                let value = values.get(place).copied().unwrap_or(Value::TOP);
                self.writes.push(To::Word { slot, value });
            }
        }
    }

    /// The cells that an indexed write may reach.
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
        found.stretches().into_iter().map(|ends| indexed.stretch(ends)).collect()
    }
}

/// Whether it is known where a result goes. A bit of a word is not followed: that word may hold anything.
fn is_followed(to: &Target) -> bool {
    match to {
        Target::Words(_) | Target::Nowhere => true,
        Target::Bits(bits) => bits.iter().all(|bit| !matches!(bit, BitTarget::WordBit(..))),
        Target::Run(..) => false,
    }
}
