//! Interrupt routines run at any moment: what they write the scan reads as any value, and they read any values.

use super::Pass;
use crate::program::{
    Approximated, Approximation, BitSource, Cell, ChoiceId, ChoiceKind, Program, Region, SourceMut,
    Step, WordSource, flow,
};
use std::collections::BTreeSet;

/// Reads of what may change at any moment become any values.
pub const PASS: Pass = Pass {
    name: "letting interrupts come at any moment",
    run: |program, _| {
        isolate(program);
        Ok(())
    },
};

/// Takes every read of a cell that an interrupt routine may write as any value, and every read within interrupt
/// routines too; the same of what else may change at any moment ([`Program::volatile`]).
fn isolate(program: &mut Program) {
    let inside = reachable(program);
    let mut regions: BTreeSet<Region> =
        inside.iter().flat_map(|&at| flow::written(program, at)).collect();
    regions.extend(&program.volatile);
    if inside.is_empty() && regions.is_empty() {
        return;
    }
    let changes = |first: Cell, count: u32| {
        (0..count).any(|n| regions.iter().any(|region| region.holds(first.plus(n))))
    };
    let mut choices = program.choices;
    let mut choice = || {
        choices += 1;
        ChoiceId(choices - 1)
    };
    // A loop's count is followed, so it must not change; other exact choices are worked out from no such cell.
    let kinds = &mut program.kinds;
    kinds.retain(|_, kind| match *kind {
        ChoiceKind::Iterations(WordSource::Cell(cell)) => !changes(cell, 1),
        ChoiceKind::Iterations(WordSource::Bits { first, count }) => !changes(first, count.into()),
        _ => true,
    });
    // An unsigned count may be as large as a word can say, whatever it is.
    let mut unsigned: BTreeSet<ChoiceId> = BTreeSet::new();
    for (&count, kind) in kinds.iter_mut() {
        if let ChoiceKind::Unsigned(word) = kind {
            unsigned.insert(count);
            let changed = match *word {
                WordSource::Cell(cell) => changes(cell, 1),
                WordSource::Bits { first, count } => changes(first, count.into()),
                WordSource::Const(_) | WordSource::Free(_) => false,
            };
            if changed {
                *word = WordSource::Free(choice());
            }
        }
    }
    program.volatile = regions.iter().copied().collect();
    for (at, instruction) in program.instructions.iter_mut().enumerate() {
        let all = inside.contains(&at);
        let count = match &instruction.step {
            Step::ForBegin { count, .. } => Some(*count),
            Step::Summary(summary) => summary.iterations.map(|(count, ..)| count),
            _ => None,
        };
        if let (true, Some(WordSource::Free(count))) = (all, count) {
            match unsigned.contains(&count) {
                true => _ = kinds.insert(count, ChoiceKind::Unsigned(WordSource::Free(choice()))),
                false => _ = kinds.remove(&count),
            }
        }
        let mut taken = false;
        instruction.each_read_mut(&mut |source| match source {
            SourceMut::Bit(source) => {
                if let BitSource::Cell(cell) | BitSource::WordBit(cell, _) = *source
                    && (all || changes(cell, 1))
                {
                    *source = BitSource::Free(choice());
                    taken = true;
                }
            }
            SourceMut::Word(source) => {
                let (first, count) = match *source {
                    WordSource::Cell(cell) => (cell, 1),
                    WordSource::Bits { first, count } => (first, u32::from(count)),
                    WordSource::Const(_) | WordSource::Free(_) => return,
                };
                if all || changes(first, count) {
                    *source = WordSource::Free(choice());
                    taken = true;
                }
            }
        });
        if taken && !all {
            let what = Approximated::Interrupted;
            program.approximations.push(Approximation { instruction: at, what });
        }
    }
    program.choices = choices;
    let entries: Vec<usize> = program.interrupts.iter().map(|one| one.entry).collect();
    entries.into_iter().for_each(|at| program.approximate(at, Approximated::ReadByInterrupt));
}

/// The instructions that interrupt routines may run, routines that they call included.
fn reachable(program: &Program) -> BTreeSet<usize> {
    let mut open: Vec<usize> = program.interrupts.iter().map(|interrupt| interrupt.entry).collect();
    let mut seen = BTreeSet::new();
    while let Some(at) = open.pop() {
        if at >= program.instructions.len() || !seen.insert(at) {
            continue;
        }
        match program.instructions[at].step {
            Step::Return | Step::End => continue,
            Step::Jump { target, .. } | Step::Call { target, .. } => open.push(target),
            _ => {}
        }
        open.push(at + 1);
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{AreaId, Interrupt, Join, Logic, testing};

    #[test]
    fn a_routine_that_writes_nothing_still_reads_any_value() {
        let cell = Cell { area: AreaId(0), index: 0 };
        let steps = [
            Step::End,
            Step::Logic { join: Join::Start, value: Logic::cell(cell) },
            Step::Act { fires: Logic::Condition },
            Step::Return,
        ];
        let mut program = testing::program(steps);
        let name = "I0".to_owned();
        program.interrupts.push(Interrupt { name, entry: 1, times: 1, stated: false });
        isolate(&mut program);
        let read = program.instructions[1].step.fires();
        assert_eq!(read, Some(&Logic::Bit(BitSource::Free(ChoiceId(0)))));
        assert_eq!((program.choices, program.approximations.len()), (1, 1));
    }
}
