//! Finds which operands an operation needs for wanted results: steering changes these operands.

use super::start_changes::Changes;
use super::steering::Conditions;
use scanbound_ir::meaning::{ChoiceKind, Meaning, Operation, OperationInput, Shape, Target};
use scanbound_ir::{BitTarget, Cell, ChoiceId, Number, Source, WordSource, WordTarget};
use scanbound_replay::{TracedOperation, operate};

/// Of operands with more words than this, only the word with the place of the wanted result is changed.
const FEW_WORDS: usize = 4;

/// A bit of an operand: the operand, the word and the bit.
type Place = (usize, usize, u8);

impl Conditions<'_> {
    /// Works out changes after which an operation writes these bits (mask and values) of a cell.
    pub(super) fn written(
        &self,
        event: usize,
        choice: ChoiceId,
        cell: Cell,
        wanted: (u16, u16),
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        let Some(ChoiceKind::Exact(meaning)) = self.program.kinds.get(&choice) else {
            return false;
        };
        let Some(done) = self.trace.operations.get(&(event, choice)) else { return false };
        let results = || meaning.outputs.iter().enumerate();
        let place = results().find_map(|(at, target)| {
            let first = done.to.get(at).copied().flatten();
            let (word, bit) = place_in(target, first, cell, wanted.0)?;
            Some(((at, word), bit))
        });
        match place {
            Some((at, None)) => self.result(event, choice, at, wanted, changes, steps),
            Some((at, Some((from, to)))) => {
                let bit = (1 << to, (wanted.1 >> from & 1) << to);
                self.result(event, choice, at, bit, changes, steps)
            }
            None => false,
        }
    }

    /// Works out changes after which these bits (mask and values) of a word of an operation's results have these
    /// values. `at` is the number of the result, and that of the word in it. For each wrong bit, an operand bit is
    /// found that changes it, and no other wanted bit.
    pub(super) fn result(
        &self,
        event: usize,
        choice: ChoiceId,
        at: (usize, usize),
        (mask, value): (u16, u16),
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        let Some(ChoiceKind::Exact(meaning)) = self.program.kinds.get(&choice) else {
            return false;
        };
        let Some(done) = self.trace.operations.get(&(event, choice)) else { return false };
        let mut inputs = done.inputs.clone();
        let now = |inputs: &[Vec<u16>]| -> Option<u16> {
            let results = operate(&meaning.operation, inputs)?;
            results.get(at.0)?.get(at.1).copied()
        };
        let Some(mut word) = now(&inputs) else { return false };
        while let Some(bit) = (0..16).find(|bit| (word ^ value) & mask & 1 << bit != 0) {
            let mut found = None;
            for place in operand_bits(meaning, &inputs, at.1) {
                if !super::steering::take(steps) {
                    return false;
                }
                let (operand, number, bit_there) = place;
                inputs[operand][number] ^= 1 << bit_there;
                if now(&inputs).is_some_and(|new| (new ^ word) & mask == 1 << bit) {
                    let on = inputs[operand][number] >> bit_there & 1 == 1;
                    let mut more = changes.clone();
                    if self.operand_bit(event, (meaning, done), place, on, &mut more, steps) {
                        found = Some(more);
                        break;
                    }
                }
                inputs[operand][number] ^= 1 << bit_there;
            }
            let (Some(more), Some(new)) = (found, now(&inputs)) else { return false };
            (*changes, word) = (more, new);
        }
        true
    }

    /// Works out changes after which a bit of an operand is on or off.
    fn operand_bit(
        &self,
        event: usize,
        (meaning, done): (&Meaning, &TracedOperation),
        (operand, word, bit): Place,
        on: bool,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        let bits = (1 << bit, u16::from(on) << bit);
        match &meaning.inputs[operand] {
            OperationInput::Words(sources) | OperationInput::Number(Number::Words(sources)) => {
                match sources.get(word) {
                    Some(&WordSource::Cell(cell)) => {
                        self.set(event, cell, bits.0, bits.1, changes, steps)
                    }
                    Some(&WordSource::Bits { first, count }) if bit < count => {
                        self.set(event, first.plus(bit.into()), 1, on.into(), changes, steps)
                    }
                    Some(&source @ WordSource::Free(choice)) => {
                        self.choice(event, choice, Source::Word(source), bits, changes, steps)
                    }
                    _ => false,
                }
            }
            OperationInput::Bits(sources) => sources
                .get(word)
                .is_some_and(|&source| bit == 0 && self.bit(event, source, on, changes, steps)),
            OperationInput::Truth(logic) => {
                bit == 0 && self.logic(event, logic, on, changes, steps)
            }
            OperationInput::Run(_, shape, _) => {
                let Some(first) = done.from.get(operand).copied().flatten() else { return false };
                let (word, on) = (word as u32, u16::from(on));
                match *shape {
                    Shape::Cells => {
                        self.set(event, first.plus(word), bits.0, bits.1, changes, steps)
                    }
                    Shape::WordBits(from) => {
                        let place = u32::from(from) + word;
                        let (cell, bit) = (first.plus(place / 16), place % 16);
                        self.set(event, cell, 1 << bit, on << bit, changes, steps)
                    }
                    Shape::Packed(_) => {
                        let cell = first.plus(16 * word + u32::from(bit));
                        self.set(event, cell, 1, on, changes, steps)
                    }
                }
            }
            OperationInput::Number(_) => false,
        }
    }
}

/// The bits of the operands that may change word `at` of the results, the likeliest first.
fn operand_bits(meaning: &Meaning, inputs: &[Vec<u16>], at: usize) -> Vec<Place> {
    let mut found = Vec::new();
    for (operand, words) in inputs.iter().enumerate() {
        let likely = match meaning.operation {
            Operation::Split(bits) => at * usize::from(bits) / 16,
            _ => at % words.len().max(1),
        };
        let are_bits = matches!(
            meaning.inputs[operand],
            OperationInput::Bits(_) | OperationInput::Run(_, Shape::WordBits(_), _)
        );
        let mut places = vec![likely];
        if words.len() <= FEW_WORDS || are_bits {
            places.extend((0..words.len()).filter(|&word| word != likely));
        }
        let bits = if are_bits { 0..1 } else { 0..16 };
        found.extend(
            places.into_iter().flat_map(|word| bits.clone().map(move |bit| (operand, word, bit))),
        );
    }
    found.retain(|&(operand, word, _)| word < inputs[operand].len());
    found
}

/// Which word of a result goes to a cell of which the bits of `mask` are wanted. If the bits of the cell are not those
/// of the word: which bit of the cell is which one of the word. `first` is the first cell of a list at an address.
fn place_in(
    target: &Target,
    first: Option<Cell>,
    cell: Cell,
    mask: u16,
) -> Option<(usize, Option<(u8, u8)>)> {
    let single = || (mask.count_ones() == 1).then(|| mask.trailing_zeros() as u8);
    let beyond = |from: Cell, count: u32| {
        let offset = cell.index.checked_sub(from.index)?;
        (cell.area == from.area && offset < count).then_some(offset)
    };
    match target {
        Target::Words(targets) => {
            targets.iter().enumerate().find_map(|(word, target)| match *target {
                WordTarget::Cell(own) => (own == cell).then_some((word, None)),
                WordTarget::Bits { first, count } => {
                    let bit = beyond(first, count.into())? as u8;
                    Some((word, Some((0, bit))))
                }
                WordTarget::Discard => None,
            })
        }
        Target::Bits(targets) => {
            targets.iter().enumerate().find_map(|(word, target)| match *target {
                BitTarget::Cell(own) => (own == cell).then_some((word, Some((0, 0)))),
                BitTarget::WordBit(own, bit) => {
                    (own == cell && single() == Some(bit)).then_some((word, Some((bit, 0))))
                }
            })
        }
        Target::Run(_, shape) => {
            let offset = beyond(first?, u32::MAX)?;
            match *shape {
                Shape::Cells => Some((offset as usize, None)),
                Shape::WordBits(from) => {
                    let bit = single()?;
                    let word = (16 * offset + u32::from(bit)).checked_sub(from.into())?;
                    Some((word as usize, Some((bit, 0))))
                }
                Shape::Packed(_) => Some((offset as usize / 16, Some((0, (offset % 16) as u8)))),
            }
        }
        Target::Nowhere => None,
    }
}
