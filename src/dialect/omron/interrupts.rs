//! Makes what interrupt programs share with the others free: they may run between any two instructions.

use std::collections::BTreeSet;

use crate::program::{
    Approximation, BitSource, BitTarget, ChoiceId, Logic, Number, Program, Region, Step,
    WordSource, WordTarget, Write,
};

/// Frees every read of an interrupt program, and every read elsewhere of what an interrupt program writes.
pub(super) fn widen(program: &mut Program) {
    let within =
        reached(program, program.interrupts.iter().map(|interrupt| interrupt.entry).collect());
    let mut written: Vec<Region> = Vec::new();
    for &at in &within {
        for effect in &program.instructions[at].effects {
            regions(&effect.write, &mut written);
        }
    }
    written.sort_unstable();
    written.dedup();
    let mut free = Free { choices: program.choices, all: false, written, freed: false };
    let mut notes = Vec::new();
    for (at, instruction) in program.instructions.iter_mut().enumerate() {
        free.all = within.contains(&at);
        free.freed = false;
        match &mut instruction.step {
            Step::Logic { value, .. } => free.logic(value),
            Step::Act { fires }
            | Step::Jump { fires, .. }
            | Step::Call { fires, .. }
            | Step::Stop { fires }
            | Step::ZoneBegin { fires, .. } => free.logic(fires),
            Step::ForBegin { count, .. } => free.word(count),
            _ => {}
        }
        for effect in &mut instruction.effects {
            match &mut effect.write {
                Write::Bit(_, value) => free.logic(value),
                Write::Words(_, number) => free.number(number),
                Write::Forget(..) => {}
            }
        }
        if free.freed && !free.all {
            let what = "what an interrupt program may write meanwhile takes any value".to_owned();
            notes.push(Approximation { instruction: at, what });
        }
    }
    for interrupt in &program.interrupts {
        let what =
            "an interrupt program may run at any moment: what it reads takes any value".to_owned();
        notes.push(Approximation { instruction: interrupt.entry, what });
    }
    program.choices = free.choices;
    program.approximations.extend(notes);
}

/// Every instruction that can be reached from these.
fn reached(program: &Program, mut open: Vec<usize>) -> BTreeSet<usize> {
    let mut seen: BTreeSet<usize> = BTreeSet::new();
    while let Some(at) = open.pop() {
        if at >= program.instructions.len() || !seen.insert(at) {
            continue;
        }
        match &program.instructions[at].step {
            Step::Return | Step::End => continue,
            Step::Jump { target, .. } | Step::Call { target, .. } => open.push(*target),
            _ => {}
        }
        open.push(at + 1);
    }
    seen
}

fn regions(write: &Write, into: &mut Vec<Region>) {
    let mut word = |target: &WordTarget| match target {
        WordTarget::Cell(first) => into.push(Region::Range { first: *first, count: 1 }),
        WordTarget::Bits { first, count } => {
            into.push(Region::Range { first: *first, count: u32::from(*count) })
        }
        WordTarget::Discard => {}
    };
    match write {
        Write::Bit(BitTarget::Cell(first) | BitTarget::WordBit(first, _), _) => {
            into.push(Region::Range { first: *first, count: 1 });
        }
        Write::Words(targets, _) => targets.iter().for_each(&mut word),
        Write::Forget(region, _) => into.push(*region),
    }
}

struct Free {
    choices: u32,
    /// Whether all reads are free.
    all: bool,
    written: Vec<Region>,
    /// Whether a read was freed.
    freed: bool,
}

impl Free {
    fn new_choice(&mut self) -> ChoiceId {
        self.freed = true;
        self.choices += 1;
        ChoiceId(self.choices - 1)
    }

    fn logic(&mut self, logic: &mut Logic) {
        match logic {
            Logic::Condition | Logic::Const(_) => {}
            Logic::Bit(source) => {
                if let BitSource::Cell(cell) | BitSource::WordBit(cell, _) = *source
                    && (self.all || self.written.iter().any(|region| region.holds(cell)))
                {
                    *source = BitSource::Free(self.new_choice());
                }
            }
            Logic::Not(inner) => self.logic(inner),
            Logic::All(parts) | Logic::Any(parts) => {
                parts.iter_mut().for_each(|part| self.logic(part))
            }
            Logic::Compare(compare) => {
                self.number(&mut compare.left);
                self.number(&mut compare.right);
            }
        }
    }

    fn number(&mut self, number: &mut Number) {
        match number {
            Number::Words(words) => words.iter_mut().for_each(|word| self.word(word)),
            Number::Add(a, b)
            | Number::Sub(a, b)
            | Number::And(a, b)
            | Number::Or(a, b)
            | Number::Xor(a, b) => {
                self.number(a);
                self.number(b);
            }
        }
    }

    fn word(&mut self, word: &mut WordSource) {
        let (first, count) = match word {
            WordSource::Cell(cell) => (*cell, 1),
            WordSource::Bits { first, count } => (*first, u32::from(*count)),
            WordSource::Const(_) | WordSource::Free(_) => return,
        };
        let shared =
            (0..count).any(|n| self.written.iter().any(|region| region.holds(first.plus(n))));
        if self.all || shared {
            *word = WordSource::Free(self.new_choice());
        }
    }
}
