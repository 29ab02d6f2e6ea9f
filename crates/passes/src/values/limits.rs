//! Limits for widening: a word that keeps growing is first extended to the numbers with which the program compares it,
//! then to any constant of the program, then to the least or largest number.

use super::slots::Slots;
use super::value::{Growth, Value};
use scanbound_ir::meaning::{ChoiceKind, OperationInput};
use scanbound_ir::{Compare, Logic, Number, Program, Step, WordSource, Write};
use std::collections::{BTreeMap, BTreeSet};

/// The numbers to which growing words are widened, in ascending order.
pub struct WideningLimits {
    /// For each tracked word, by its slot: the constants with which the word is compared, and their neighbours.
    by_slot: BTreeMap<usize, Vec<i64>>,
    /// All constants of the program, as signed numbers, and the neighbours of those in comparisons.
    all: Vec<i64>,
}

impl WideningLimits {
    /// Collects the constants of a program; `words` are the tracked words.
    pub fn of(program: &Program, words: &Slots) -> WideningLimits {
        let mut found = Collected { words, by_slot: BTreeMap::new(), all: BTreeSet::new() };
        for instruction in &program.instructions {
            if let Some(fires) = instruction.step.fires() {
                found.logic(fires);
            }
            if let Step::ForBegin { count, .. } = instruction.step {
                found.word(count);
            }
            for effect in &instruction.effects {
                match &effect.write {
                    Write::Words(_, number) => found.number(number),
                    Write::Bit(_, logic) => found.logic(logic),
                    Write::Havoc(_, choice) => {
                        let Some(ChoiceKind::Exact(meaning)) = program.kinds.get(choice) else {
                            continue;
                        };
                        for input in &meaning.inputs {
                            match input {
                                OperationInput::Words(words) => {
                                    words.iter().for_each(|word| found.word(*word))
                                }
                                OperationInput::Number(number) => found.number(number),
                                OperationInput::Bits(_)
                                | OperationInput::Truth(_)
                                | OperationInput::Run(..) => {}
                            }
                        }
                    }
                }
            }
        }
        let in_order = |all: BTreeSet<i64>| all.into_iter().collect::<Vec<i64>>();
        let by_slot = found.by_slot.into_iter().map(|(slot, all)| (slot, in_order(all))).collect();
        WideningLimits { by_slot, all: in_order(found.all) }
    }

    /// Joins two values of the word in this slot, and widens the result to the next limit; with `is_last`, to the
    /// smallest or largest number.
    pub fn widen(&self, slot: usize, here: Value, there: Value, is_last: bool) -> Value {
        if is_last {
            return here.widen(there, Growth::Ends);
        }
        let (_, high) = here.join(there).signed();
        let is_enough = |by_slot: &&Vec<i64>| by_slot.last().is_some_and(|&last| high <= last);
        let by_slot = self.by_slot.get(&slot).filter(is_enough);
        here.widen(there, Growth::To(by_slot.unwrap_or(&self.all)))
    }
}

struct Collected<'a> {
    words: &'a Slots,
    by_slot: BTreeMap<usize, BTreeSet<i64>>,
    all: BTreeSet<i64>,
}

impl Collected<'_> {
    fn word(&mut self, word: WordSource) {
        if let WordSource::Const(value) = word {
            self.all.insert(value.cast_signed().into());
        }
    }

    fn number(&mut self, number: &Number) {
        number.words().for_each(|word| self.word(word));
    }

    fn logic(&mut self, logic: &Logic) {
        match logic {
            Logic::Compare(compare) => self.compare(compare),
            Logic::Not(inner) => self.logic(inner),
            Logic::All(parts) | Logic::Any(parts) => parts.iter().for_each(|part| self.logic(part)),
            Logic::Condition | Logic::Const(_) | Logic::Bit(_) => {}
        }
    }

    fn compare(&mut self, compare: &Compare) {
        for (one, other) in [(&compare.left, &compare.right), (&compare.right, &compare.left)] {
            let (Number::Words(one), Number::Words(other)) = (one, other) else { continue };
            let ([WordSource::Const(value)], [other]) = (&one[..], &other[..]) else { continue };
            let value = i64::from(value.cast_signed());
            let near = [value - 1, value, value + 1];
            self.all.extend(near);
            if let WordSource::Cell(cell) = other
                && let Some(slot) = self.words.slot(*cell)
            {
                self.by_slot.entry(slot).or_default().extend(near);
            }
        }
    }
}
