//! Routines that FCALL and its kin run with all coils off: there every instruction may act or be held off.

use super::Decoder;
use crate::program::flow;
use crate::program::{Approximation, BitSource, ChoiceId, Logic, Program, Step, Write};
use std::collections::BTreeSet;

impl Decoder<'_> {
    /// Frees what acts in the routines that the calls noted lead to.
    pub(super) fn hold_off(&mut self) {
        let mut open: Vec<usize> = self
            .held
            .iter()
            .filter_map(|&at| match self.program.instructions[at].step {
                Step::Call { target, .. } => Some(target),
                _ => None,
            })
            .collect();
        let calls = flow::calls(&self.program);
        let (mut entries, mut inside) = (BTreeSet::new(), BTreeSet::new());
        while let Some(entry) = open.pop() {
            if !entries.insert(entry) {
                continue;
            }
            let Some(end) = flow::extent(&self.program, entry) else { continue };
            inside.extend(entry..=end);
            let within = calls.iter().filter(|(at, _)| (entry..=end).contains(at));
            open.extend(within.map(|&(_, target)| target));
        }
        for at in inside {
            let choice = self.choice();
            free(&mut self.program, at, choice);
        }
        for instruction in entries {
            let what = "this routine may run with its coils off: each of its instructions is taken to act or not".to_owned();
            self.program.approximations.push(Approximation { instruction, what });
        }
    }
}

/// Lets the choice hold an instruction off.
fn free(program: &mut Program, at: usize, choice: ChoiceId) {
    let instruction = &mut program.instructions[at];
    let may = Logic::Bit(BitSource::Free(choice));
    match &mut instruction.step {
        Step::Act { fires }
        | Step::Call { fires, .. }
        | Step::Stop { fires }
        | Step::ZoneBegin { fires, .. } => held(fires, &may),
        // What is not skipped is reached as well.
        Step::Jump { fires, .. } => {
            let taken = std::mem::replace(fires, Logic::Const(true));
            *fires = Logic::All(vec![taken, may.clone()]);
        }
        _ => {}
    }
    for effect in &mut instruction.effects {
        if let Write::Bit(_, value) = &mut effect.write {
            held(value, &may);
        }
    }
}

/// Puts the condition, wherever it is asked for, behind one more contact.
fn held(logic: &mut Logic, may: &Logic) {
    match logic {
        Logic::Condition => *logic = Logic::All(vec![Logic::Condition, may.clone()]),
        Logic::Not(inner) => held(inner, may),
        Logic::All(parts) | Logic::Any(parts) => parts.iter_mut().for_each(|part| held(part, may)),
        Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => {}
    }
}
