//! Interrupt routines run at any moment: what they write is unknown to the scan, and all they read is unknown to them.

use super::flow;
use crate::program::{
    Approximation, BitSource, ChoiceId, Logic, Number, Program, Region, Step, WordSource, Write,
};
use std::collections::BTreeSet;

/// Takes every read of a cell that an interrupt routine may write as any value, and every read within
/// interrupt routines too.
///
/// `volatile` is what else may change at any moment.
pub fn isolate(program: &mut Program, volatile: &[Region]) {
    let inside = reachable(program);
    let mut regions: BTreeSet<Region> =
        inside.iter().flat_map(|&at| flow::written(program, at)).collect();
    regions.extend(volatile);
    if regions.is_empty() {
        return;
    }
    let mut choices = program.choices;
    for at in 0..program.instructions.len() {
        let all = inside.contains(&at);
        let mut taken = false;
        let mut free = |changes: bool| -> Option<ChoiceId> {
            (all || changes).then(|| {
                taken = true;
                choices += 1;
                ChoiceId(choices - 1)
            })
        };
        let mut hide = Hide { regions: &regions, free: &mut free };
        let instruction = &mut program.instructions[at];
        for effect in &mut instruction.effects {
            match &mut effect.write {
                Write::Bit(_, value) => hide.logic(value),
                Write::Words(_, number) => hide.number(number),
                Write::Forget(..) => {}
            }
        }
        match &mut instruction.step {
            Step::Logic { value, .. } => hide.logic(value),
            Step::Act { fires }
            | Step::Jump { fires, .. }
            | Step::Call { fires, .. }
            | Step::Stop { fires }
            | Step::ZoneBegin { fires, .. } => hide.logic(fires),
            Step::ForBegin { count, .. } => hide.word(count),
            _ => {}
        }
        if taken && !all {
            let what = "an interrupt may write what is read here: taken as any value".to_owned();
            program.approximations.push(Approximation { instruction: at, what });
        }
    }
    program.choices = choices;
    let entries: Vec<usize> = program.interrupts.iter().map(|interrupt| interrupt.entry).collect();
    program.approximations.extend(entries.into_iter().map(|instruction| {
        Approximation {
            instruction,
            what: "an interrupt may come at any moment: all that it reads is taken as any value"
                .to_owned(),
        }
    }));
}

/// The instructions that interrupt routines run, routines that they call included.
fn reachable(program: &Program) -> BTreeSet<usize> {
    let mut open: Vec<usize> = program.interrupts.iter().map(|interrupt| interrupt.entry).collect();
    let mut inside = BTreeSet::new();
    let mut seen = BTreeSet::new();
    while let Some(entry) = open.pop() {
        if !seen.insert(entry) {
            continue;
        }
        let last = flow::extent(program, entry).unwrap_or(program.instructions.len() - 1);
        for at in entry..=last {
            inside.insert(at);
            if let Step::Call { target, .. } = program.instructions[at].step {
                open.push(target);
            }
        }
    }
    inside
}

/// Replaces reads by choices.
struct Hide<'a> {
    regions: &'a BTreeSet<Region>,
    free: &'a mut dyn FnMut(bool) -> Option<ChoiceId>,
}

impl Hide<'_> {
    fn changes(&self, cell: crate::program::Cell, count: u32) -> bool {
        (0..count).any(|n| self.regions.iter().any(|region| region.holds(cell.plus(n))))
    }

    fn logic(&mut self, logic: &mut Logic) {
        match logic {
            Logic::Condition | Logic::Const(_) => {}
            Logic::Bit(source) => {
                let changes = match source {
                    BitSource::Cell(cell) | BitSource::WordBit(cell, _) => self.changes(*cell, 1),
                    BitSource::Const(_) | BitSource::Free(_) => return,
                };
                if let Some(choice) = (self.free)(changes) {
                    *source = BitSource::Free(choice);
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
            Number::Words(sources) => sources.iter_mut().for_each(|source| self.word(source)),
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

    fn word(&mut self, source: &mut WordSource) {
        let changes = match *source {
            WordSource::Cell(cell) => self.changes(cell, 1),
            WordSource::Bits { first, count } => self.changes(first, u32::from(count)),
            WordSource::Const(_) | WordSource::Free(_) => return,
        };
        if let Some(choice) = (self.free)(changes) {
            *source = WordSource::Free(choice);
        }
    }
}
