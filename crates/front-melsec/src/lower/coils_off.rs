//! Routines that FCALL and similar instructions may run with all coils off: each instruction in them may act or not.

use super::state::Lowering;
use scanbound_ir::flow;
use scanbound_ir::{BitSource, ChoiceId, ChoiceKind, Instruction, Logic, Step, When, Write};
use std::collections::BTreeSet;

impl Lowering<'_> {
    /// Makes each instruction optional in the routines that `calls_with_coils_off` call, directly or through further
    /// calls.
    pub(super) fn allow_coils_off(&mut self) {
        let mut open: Vec<usize> = self
            .targets
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
            make_optional(&mut self.out.program.instructions[at], choice);
            // An operation that reads the rung's condition reads it as possibly false.
            for effect in &self.out.program.instructions[at].effects {
                if let (When::Always, Write::Havoc(_, own)) = (effect.when, &effect.write)
                    && let Some(ChoiceKind::Exact(_)) = self.out.program.kinds.get(own)
                {
                    self.out.program.kinds.remove(own);
                }
            }
        }
        for instruction in entries {
            let what = "the condition of the call may be off when this routine runs: each instruction of the routine may or may not act";
            self.out.program.approximate(instruction, what);
        }
    }
}

/// Changes an instruction so that it acts only if `choice` is true.
fn make_optional(instruction: &mut Instruction, choice: ChoiceId) {
    let may = Logic::Bit(BitSource::Free(choice));
    match &mut instruction.step {
        Step::Act { fires }
        | Step::Call { fires, .. }
        | Step::Stop { fires }
        | Step::MasterControlBegin { fires, .. } => add_series_contact(fires, &may),
        // A jump without a condition is optional too: if it is held off, the skipped instructions run.
        Step::Jump { fires, .. } => {
            let taken = std::mem::replace(fires, Logic::Const(true));
            *fires = Logic::All(vec![taken, may.clone()]);
        }
        _ => {}
    }
    for effect in &mut instruction.effects {
        if let Write::Bit(_, value) = &mut effect.write {
            add_series_contact(value, &may);
        }
    }
}

/// Adds `may` as one more series contact to the rung's condition, wherever the condition is read.
fn add_series_contact(logic: &mut Logic, may: &Logic) {
    match logic {
        Logic::Condition => *logic = Logic::All(vec![Logic::Condition, may.clone()]),
        Logic::Not(inner) => add_series_contact(inner, may),
        Logic::All(parts) | Logic::Any(parts) => {
            parts.iter_mut().for_each(|part| add_series_contact(part, may))
        }
        Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => {}
    }
}
