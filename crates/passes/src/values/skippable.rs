//! Finds rungs that change nothing relevant, so that the abstract interpretation can skip them.

use super::slots::Slots;
use rustc_hash::FxHashSet;
use scanbound_ir::{Effect, Instruction, Join, Program, Step, Write, flow};

/// For the first instruction of each rung that the analysis can skip: the index of the next rung. 0 for all other
/// instructions.
pub fn skippable(program: &Program, words: &Slots, bits: &Slots) -> Vec<usize> {
    let instructions = &program.instructions;
    let entries = entries(program);
    let saved_slots = slots_kept(instructions);
    let changes_nothing = |at: usize| {
        continues(program, &saved_slots, at)
            && flow::written(program, at)
                .into_iter()
                .all(|region| words.within(region).is_empty() && bits.within(region).is_empty())
    };
    let mut behind = vec![0; instructions.len()];
    let mut from = 0;
    while from < instructions.len() {
        let mut to = from + 1;
        if starts(&instructions[from]) && changes_nothing(from) {
            while to < instructions.len()
                && !starts(&instructions[to])
                && !entries.contains(&to)
                && changes_nothing(to)
            {
                to += 1;
            }
            if needs_no_result(&instructions[to..]) {
                behind[from] = to;
            }
        }
        from = to;
    }
    behind
}

fn starts(instruction: &Instruction) -> bool {
    matches!(instruction.step, Step::Logic { join: Join::Start, .. })
}

/// The targets of jumps and calls, the first instructions of main and interrupt routines, and the instructions after
/// main routines: to these, control may come from elsewhere than the previous instruction. Loops are not included,
/// because their first and last instructions are never skipped.
fn entries(program: &Program) -> FxHashSet<usize> {
    let targets = program.instructions.iter().filter_map(|one| match &one.step {
        Step::Jump { target, .. } | Step::Call { target, .. } => Some(*target),
        _ => None,
    });
    let mains = program.mains.iter().flat_map(|main| [main.start, main.end]);
    let interrupts = program.interrupts.iter().map(|interrupt| interrupt.entry);
    targets.chain(mains).chain(interrupts).collect()
}

/// The save slots that some rung reads although it did not save anything in them before.
fn slots_kept(instructions: &[Instruction]) -> FxHashSet<u32> {
    let (mut own, mut saved_slots) = (FxHashSet::default(), FxHashSet::default());
    for instruction in instructions {
        match &instruction.step {
            Step::Logic { join: Join::Start, .. } => own.clear(),
            Step::Save(slot) => {
                own.insert(*slot);
            }
            Step::Fetch(slot) if !own.contains(slot) => {
                saved_slots.insert(*slot);
            }
            _ => {}
        }
    }
    saved_slots
}

/// Whether an instruction always continues with the next one, and gives no count or index and saves no result that
/// another rung reads. Its writes are not examined.
fn continues(program: &Program, saved_slots: &FxHashSet<u32>, at: usize) -> bool {
    let instruction = &program.instructions[at];
    let goes_on = match &instruction.step {
        Step::Logic { .. } | Step::AndBlock | Step::OrBlock | Step::Fetch(_) | Step::Act { .. } => {
            true
        }
        Step::Save(slot) => !saved_slots.contains(slot),
        _ => false,
    };
    let is_indexed = |effect: &Effect| match &effect.write {
        Write::Havoc(_, choice) => program.indexed.contains_key(choice),
        _ => false,
    };
    goes_on && instruction.counted().is_none() && !instruction.effects.iter().any(is_indexed)
}

/// Whether these instructions, which follow a rung, do not read its result, up to the next rung or the routine's end.
fn needs_no_result(instructions: &[Instruction]) -> bool {
    for instruction in instructions {
        match &instruction.step {
            Step::Logic { join: Join::Start, .. } | Step::Return | Step::End => return true,
            Step::Nothing | Step::ForBegin { .. } | Step::ForEnd => {
                if !instruction.effects.is_empty() {
                    return false;
                }
            }
            _ => return false,
        }
    }
    true
}
