//! Routines that FCALL and its kin run with all coils off: there every instruction may act or be held off.

use super::Emitter;
use scanbound_ir::flow;
use scanbound_ir::{BitSource, ChoiceId, ChoiceKind, Instruction, Logic, Step, When, Write};
use std::collections::BTreeSet;

impl Emitter<'_> {
    /// Lets every instruction act or not in the routines of `calls_with_coils_off` and in those that these call.
    pub(super) fn hold_off(&mut self) {
        let mut open: Vec<usize> = self
            .routes
            .calls_with_coils_off
            .iter()
            .filter_map(|&at| match self.out.program.instructions[at].step {
                Step::Call { target, .. } => Some(target),
                _ => None,
            })
            .collect();
        let calls = flow::calls(&self.out.program);
        let (mut entries, mut inside) = (BTreeSet::new(), BTreeSet::new());
        while let Some(entry) = open.pop() {
            if !entries.insert(entry) {
                continue;
            }
            let Some(end) = flow::routine_end(&self.out.program, entry) else { continue };
            inside.extend(entry..=end);
            let within = calls.iter().filter(|(at, _)| (entry..=end).contains(at));
            open.extend(within.map(|&(_, target)| target));
        }
        for at in inside {
            let choice = self.choice();
            let_hold_off(&mut self.out.program.instructions[at], choice);
            // What an operation takes from the rung's condition is held off, too.
            for effect in &self.out.program.instructions[at].effects {
                if let (When::Always, Write::Havoc(_, own)) = (effect.when, &effect.write)
                    && let Some(ChoiceKind::Exact(_)) = self.out.program.kinds.get(own)
                {
                    self.out.program.kinds.remove(own);
                }
            }
        }
        for instruction in entries {
            let what = "this routine may run with its coils off: each of its instructions is taken to act or not";
            self.out.program.approximate(instruction, what);
        }
    }
}

/// Lets the choice hold an instruction off.
fn let_hold_off(instruction: &mut Instruction, choice: ChoiceId) {
    let may = Logic::Bit(BitSource::Free(choice));
    match &mut instruction.step {
        Step::Act { fires }
        | Step::Call { fires, .. }
        | Step::Stop { fires }
        | Step::MasterControlBegin { fires, .. } => put_behind(fires, &may),
        // Also one without a condition: where it is held off, what it would skip runs.
        Step::Jump { fires, .. } => {
            let taken = std::mem::replace(fires, Logic::Const(true));
            *fires = Logic::All(vec![taken, may.clone()]);
        }
        _ => {}
    }
    for effect in &mut instruction.effects {
        if let Write::Bit(_, value) = &mut effect.write {
            put_behind(value, &may);
        }
    }
}

/// Puts the rung's condition, wherever it is asked for, behind one more contact.
fn put_behind(logic: &mut Logic, may: &Logic) {
    match logic {
        Logic::Condition => *logic = Logic::All(vec![Logic::Condition, may.clone()]),
        Logic::Not(inner) => put_behind(inner, may),
        Logic::All(parts) | Logic::Any(parts) => {
            parts.iter_mut().for_each(|part| put_behind(part, may))
        }
        Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => {}
    }
}
