//! Works conditions and values that steering wants in a run back to changes of the run's start.

use super::start_changes::Changes;
use super::steering::{Condition, Conditions, Node};
use scanbound_ir::meaning::{ChoiceKind, Meaning, Operation, OperationInput, Shape, Target};
use scanbound_ir::{
    BitSource, BitTarget, Cell, ChoiceId, Compare, Logic, Number, NumberFormat, Relation, Source,
    When, WordSource, WordTarget, Write,
};
use scanbound_replay::{TracedOperation, TracedRead, operate};

/// Of operands with more words than this, only the word with the place of the wanted result is changed.
const FEW_WORDS: usize = 4;

/// A bit of an operand: the operand, the word and the bit.
type Place = (usize, usize, u8);

impl Conditions<'_> {
    pub(super) fn fires(
        &self,
        event: usize,
        on: bool,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        let at = self.run.replay.events[event].instruction;
        match self.program.instructions[at].step.fires() {
            Some(logic) => self.logic(event, logic, on, changes, steps),
            None => on,
        }
    }

    pub(super) fn solve(
        &self,
        node: Node,
        on: bool,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        if !take(steps) {
            return false;
        }
        let (condition, value) = self.nodes[node];
        match condition {
            Condition::Always => on,
            Condition::Fired(event) => {
                let is_known = !self.run.replay.events[event].is_uncertain;
                value == on && is_known || self.fires(event, on, changes, steps)
            }
            Condition::And(a, b) | Condition::Or(a, b) => {
                let is_and = matches!(condition, Condition::And(..));
                if is_and == on {
                    return self.solve(a, on, changes, steps) && self.solve(b, on, changes, steps);
                }
                // The nearer part first: it is the more specific one.
                [b, a].into_iter().any(|part| {
                    let mut more = changes.clone();
                    let done = self.solve(part, on, &mut more, steps);
                    if done {
                        *changes = more;
                    }
                    done
                })
            }
        }
    }

    /// As [`Self::solve`], for an expression of an event's instruction.
    pub(super) fn logic(
        &self,
        event: usize,
        logic: &Logic,
        on: bool,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        if !take(steps) {
            return false;
        }
        match logic {
            Logic::Condition => {
                let node = self.of_events.get(event).copied().unwrap_or(self.end);
                self.solve(node, on, changes, steps)
            }
            Logic::Const(value) => *value == on,
            Logic::Not(inner) => self.logic(event, inner, !on, changes, steps),
            Logic::All(parts) | Logic::Any(parts) => {
                if matches!(logic, Logic::All(_)) == on {
                    return parts.iter().all(|part| self.logic(event, part, on, changes, steps));
                }
                parts.iter().any(|part| {
                    let mut more = changes.clone();
                    let done = self.logic(event, part, on, &mut more, steps);
                    if done {
                        *changes = more;
                    }
                    done
                })
            }
            Logic::Bit(source) => self.bit(event, *source, on, changes, steps),
            Logic::Compare(compare) => self.compare(event, compare, on, changes, steps),
        }
    }

    pub(super) fn read(&self, event: usize, source: Source) -> Option<&TracedRead> {
        self.trace.reads.get(event)?.iter().find(|read| read.source == source)
    }

    fn bit(
        &self,
        event: usize,
        source: BitSource,
        on: bool,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        match source {
            BitSource::Const(value) => value == on,
            BitSource::Cell(cell) => self.set(event, cell, 1, on.into(), changes, steps),
            BitSource::WordBit(cell, bit) => {
                self.set(event, cell, 1 << bit, u16::from(on) << bit, changes, steps)
            }
            BitSource::Free(choice) => {
                self.choice(event, choice, Source::Bit(source), (1, on.into()), changes, steps)
            }
        }
    }

    pub(super) fn word(
        &self,
        event: usize,
        source: WordSource,
        value: u16,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        match source {
            WordSource::Const(constant) => constant == value,
            WordSource::Cell(cell) => self.set(event, cell, u16::MAX, value, changes, steps),
            WordSource::Bits { first, count } => {
                (count >= 16 || value >> count == 0)
                    && (0..count).all(|n| {
                        let bit = first.plus(u32::from(n));
                        self.set(event, bit, 1, value >> n & 1, changes, steps)
                    })
            }
            WordSource::Free(choice) => {
                let wanted = (u16::MAX, value);
                self.choice(event, choice, Source::Word(source), wanted, changes, steps)
            }
        }
    }

    /// Works out changes after which these bits (mask and values) of a choice, read as `source`, have these values.
    fn choice(
        &self,
        event: usize,
        choice: ChoiceId,
        source: Source,
        (mask, value): (u16, u16),
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        match self.program.kinds.get(&choice) {
            Some(&ChoiceKind::StableExternal(Source::Word(word))) => match word {
                WordSource::Cell(cell) => self.set(event, cell, mask, value, changes, steps),
                word => mask == u16::MAX && self.word(event, word, value, changes, steps),
            },
            Some(&ChoiceKind::StableExternal(Source::Bit(bit))) => {
                self.bit(event, bit, value & 1 == 1, changes, steps)
            }
            Some(ChoiceKind::Exact(_)) => {
                self.result(event, choice, (0, 0), (mask, value), changes, steps)
            }
            _ => match self.read(event, source) {
                Some(TracedRead { outside: Some(key), .. }) => {
                    changes.set_outside(key, mask, value)
                }
                _ => false,
            },
        }
    }

    /// The value that an expression of plain words had. `None` for other expressions.
    fn number(&self, event: usize, number: &Number) -> Option<(Vec<WordSource>, i64)> {
        let Number::Words(words) = number else { return None };
        let mut value = 0_i64;
        for &word in words.iter().rev() {
            let one = match word {
                WordSource::Const(value) => value,
                _ => self.read(event, Source::Word(word))?.value,
            };
            value = value << 16 | i64::from(one);
        }
        (words.len() <= 2).then(|| (words.clone(), value))
    }

    fn compare(
        &self,
        event: usize,
        compare: &Compare,
        on: bool,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        let signed = match compare.format {
            NumberFormat::Signed => true,
            NumberFormat::Unsigned => false,
            NumberFormat::Real(_) => return false,
        };
        let (Some((left, a)), Some((right, b))) =
            (self.number(event, &compare.left), self.number(event, &compare.right))
        else {
            return false;
        };
        let bits = 16 * left.len();
        let read = |value: i64| {
            if signed && value >> (bits - 1) & 1 == 1 { value - (1 << bits) } else { value }
        };
        let (a, b) = (read(a), read(b));
        let (least, most) =
            if signed { (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) } else { (0, (1 << bits) - 1) };
        let relation = if on { compare.relation } else { compare.relation.negated() };
        if relation.holds(a, b) {
            return true;
        }
        let sides = [(&left, relation, b), (&right, relation.mirrored(), a)];
        sides.into_iter().any(|(side, relation, other)| {
            let value = match relation {
                Relation::Equal | Relation::LessOrEqual | Relation::GreaterOrEqual => other,
                Relation::NotEqual if other == most => other - 1,
                Relation::NotEqual | Relation::Greater => other + 1,
                Relation::Less => other - 1,
            };
            if !(least..=most).contains(&value) {
                return false;
            }
            let mut more = changes.clone();
            let done = side.iter().enumerate().all(|(n, &word)| {
                self.word(event, word, (value >> (16 * n)) as u16, &mut more, steps)
            });
            if done {
                *changes = more;
            }
            done
        })
    }

    /// Works out changes after which these bits of the cell have these values when an event reads it.
    fn set(
        &self,
        event: usize,
        cell: Cell,
        mask: u16,
        value: u16,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        if !take(steps) {
            return false;
        }
        let Some(writer) = self.trace.last_write(cell, event) else {
            return changes.set(cell, mask, value);
        };
        if let Some(key) = self.trace.delivered.get(&cell) {
            return changes.set_outside(key, mask, value);
        }
        let wrote = &self.run.replay.events[writer];
        let instruction = &self.program.instructions[wrote.instruction];
        let mut more = changes.clone();
        for effect in &instruction.effects {
            let done = match &effect.write {
                Write::Bit(target, logic) => {
                    let (bit, own) = match *target {
                        BitTarget::Cell(own) => (1, own),
                        BitTarget::WordBit(own, bit) => (1 << bit, own),
                    };
                    own == cell
                        && mask & !bit == 0
                        && self.logic(writer, logic, value & mask != 0, &mut more, steps)
                        && (effect.when == When::Always || wrote.fired)
                }
                Write::Words(targets, Number::Words(sources)) => {
                    let place =
                        targets.iter().zip(sources).find_map(|(target, &source)| match *target {
                            WordTarget::Cell(own) => (own == cell).then_some((source, None)),
                            WordTarget::Bits { first, count } => (0..count)
                                .find(|&n| first.plus(u32::from(n)) == cell)
                                .map(|n| (source, Some(n))),
                            WordTarget::Discard => None,
                        });
                    match place {
                        Some((WordSource::Const(constant), None)) => (constant ^ value) & mask == 0,
                        Some((WordSource::Cell(source), None)) => {
                            self.set(writer, source, mask, value, &mut more, steps)
                        }
                        Some((WordSource::Cell(source), Some(n))) => {
                            self.set(writer, source, 1 << n, (value & 1) << n, &mut more, steps)
                        }
                        Some((WordSource::Bits { first, count }, Some(n))) if n < count => {
                            self.set(writer, first.plus(n.into()), 1, value & 1, &mut more, steps)
                        }
                        Some((WordSource::Bits { first, count }, None))
                            if mask.count_ones() == 1 && mask.trailing_zeros() < count.into() =>
                        {
                            let bit = first.plus(mask.trailing_zeros());
                            let on = u16::from(value & mask != 0);
                            self.set(writer, bit, 1, on, &mut more, steps)
                        }
                        Some((source @ WordSource::Free(choice), None)) => {
                            let (source, wanted) = (Source::Word(source), (mask, value));
                            self.choice(writer, choice, source, wanted, &mut more, steps)
                        }
                        _ => false,
                    }
                }
                Write::Havoc(_, choice) => {
                    wrote.fired
                        && self.written(writer, *choice, cell, (mask, value), &mut more, steps)
                }
                _ => false,
            };
            if done {
                *changes = more;
                return true;
            }
            more = changes.clone();
        }
        // Or the cell is not written there, and has the value before.
        let is_always = instruction.effects.iter().any(|effect| effect.when == When::Always);
        if is_always || !self.fires(writer, false, &mut more, steps) {
            return false;
        }
        let done = self.set(writer, cell, mask, value, &mut more, steps);
        if done {
            *changes = more;
        }
        done
    }

    /// The operation that an event executed for this choice, and what it read.
    fn operation(&self, event: usize, choice: ChoiceId) -> Option<(&Meaning, &TracedOperation)> {
        let Some(ChoiceKind::Exact(meaning)) = self.program.kinds.get(&choice) else { return None };
        Some((meaning, self.trace.operations.get(&(event, choice))?))
    }

    /// Works out changes after which an operation writes these bits (mask and values) of a cell.
    fn written(
        &self,
        event: usize,
        choice: ChoiceId,
        cell: Cell,
        wanted: (u16, u16),
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        let Some((meaning, done)) = self.operation(event, choice) else { return false };
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
    fn result(
        &self,
        event: usize,
        choice: ChoiceId,
        at: (usize, usize),
        (mask, value): (u16, u16),
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        let Some((meaning, done)) = self.operation(event, choice) else { return false };
        let mut inputs = done.inputs.clone();
        let now = |inputs: &[Vec<u16>]| -> Option<u16> {
            let results = operate(&meaning.operation, inputs)?;
            results.get(at.0)?.get(at.1).copied()
        };
        let Some(mut word) = now(&inputs) else { return false };
        while let Some(bit) = (0..16).find(|bit| (word ^ value) & mask & 1 << bit != 0) {
            let mut found = None;
            for place in operand_bits(meaning, &inputs, at.1) {
                if !take(steps) {
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

/// Counts a step. Returns false if there are none left.
fn take(steps: &mut usize) -> bool {
    match steps.checked_sub(1) {
        Some(left) => {
            *steps = left;
            true
        }
        None => false,
    }
}
