//! Over-approximates interrupt routines, which may run at any moment: the scan reads any value from what they write,
//! and they read any values.

use super::pass::Pass;
use scanbound_ir::{
    Approximated, Approximation, BitSource, Cell, ChoiceId, ChoiceKind, Program, Region, Source,
    SourceMut, Step, WordSource, flow,
};
use std::collections::{BTreeMap, BTreeSet};

/// Replaces reads of cells that may change at any moment, and all reads within interrupt routines, by any values.
pub const PASS: Pass = Pass {
    name: "modelling interrupts",
    run: |program, _| {
        isolate(program);
        Ok(())
    },
};

/// Replaces every read of a cell that an interrupt routine may write, of another cell that may change at any moment
/// ([`Program::volatile`]), and every read within interrupt routines, by any value. Then all these cells are in
/// [`Program::volatile`].
fn isolate(program: &mut Program) {
    let inside = reachable(program);
    let mut unsteady: BTreeSet<Region> =
        inside.iter().flat_map(|&at| flow::written(program, at)).collect();
    unsteady.extend(program.volatile.iter().filter(|one| !program.delivered.contains(one)));
    let mut regions = unsteady.clone();
    regions.extend(&program.volatile);
    if inside.is_empty() && regions.is_empty() {
        return;
    }
    let changing = Changing { inside, regions, unsteady };
    let unsigned = changing.free_counts(program);
    changing.free_counts_inside(program, &unsigned);
    changing.free_reads(program);
    program.volatile = changing.regions.into_iter().collect();
    let entries: Vec<usize> = program.interrupt_entries();
    entries.into_iter().for_each(|at| program.approximate(at, Approximated::ReadByInterrupt));
}

/// The cells that may change at any moment, and the instructions that interrupt routines run.
struct Changing {
    /// The instructions that interrupt routines may execute. They may interrupt the scan anywhere, so they read any
    /// values.
    inside: BTreeSet<usize>,
    /// The regions that interrupt routines write, or that may change at any moment for another reason.
    regions: BTreeSet<Region>,
    /// Those of `regions` that may change within a scan whatever happens outside the program.
    unsteady: BTreeSet<Region>,
}

/// A new choice of which nothing is known.
fn fresh(choices: &mut u32) -> ChoiceId {
    *choices += 1;
    ChoiceId(*choices - 1)
}

impl Changing {
    fn holds(&self, cell: Cell) -> bool {
        self.regions.iter().any(|region| region.contains(cell))
    }

    fn holds_any(&self, word: WordSource) -> bool {
        match word {
            WordSource::Cell(cell) => self.holds(cell),
            WordSource::Bits { first, count } => {
                (0..u32::from(count)).any(|n| self.holds(first.plus(n)))
            }
            WordSource::Const(_) | WordSource::Free(_) => false,
        }
    }

    /// Replaces numbers of iterations that are computed from changing cells by any values. Returns the choices of
    /// unsigned numbers.
    fn free_counts(&self, program: &mut Program) -> BTreeSet<ChoiceId> {
        // A loop's count is followed, so its cell must not change. Other exact choices are not computed from changing
        // cells.
        let is_unchanging = |kind: &ChoiceKind| match *kind {
            ChoiceKind::Iterations(word) => !self.holds_any(word),
            _ => true,
        };
        program.kinds.retain(|_, kind| is_unchanging(kind));
        // An unsigned count may be as large as a word allows.
        let mut unsigned = BTreeSet::new();
        for (&count, kind) in &mut program.kinds {
            if let ChoiceKind::UnsignedIterations(word) = kind {
                unsigned.insert(count);
                if self.holds_any(*word) {
                    *word = WordSource::Free(fresh(&mut program.choices));
                }
            }
        }
        unsigned
    }

    /// Replaces the number of iterations of each loop within interrupt routines by any number; `unsigned` has the
    /// choices whose numbers are unsigned.
    fn free_counts_inside(&self, program: &mut Program, unsigned: &BTreeSet<ChoiceId>) {
        for &at in &self.inside {
            let count = match &program.instructions[at].step {
                Step::ForBegin { count, .. } => Some(*count),
                Step::Summary(summary) => summary.iterations.map(|(count, ..)| count),
                _ => None,
            };
            let Some(WordSource::Free(count)) = count else { continue };
            match unsigned.contains(&count) {
                true => {
                    let any = WordSource::Free(fresh(&mut program.choices));
                    program.kinds.insert(count, ChoiceKind::UnsignedIterations(any));
                }
                false => _ = program.kinds.remove(&count),
            }
        }
    }

    /// Replaces reads of changing cells, and all reads within interrupt routines, by any values, and records this for
    /// the scan's instructions.
    fn free_reads(&self, program: &mut Program) {
        let mut fresh = (&mut program.choices, &mut program.kinds);
        for (at, instruction) in program.instructions.iter_mut().enumerate() {
            let is_inside = self.inside.contains(&at);
            let mut taken = false;
            instruction
                .each_read_mut(&mut |source| taken |= self.frees(source, is_inside, &mut fresh));
            if taken && !is_inside {
                let what = Approximated::Interrupted;
                program.approximations.push(Approximation { instruction: at, what });
            }
        }
        for (at, error) in &mut program.errors {
            let is_inside = self.inside.contains(at);
            error.each_read_mut(&mut |source| _ = self.frees(source, is_inside, &mut fresh));
        }
    }

    /// Replaces a source that is a cell by any value if the cell may change at any moment, or if `all` is set. In a
    /// real run it keeps its value where nothing but the outside may change it. Returns whether it was replaced.
    fn frees(
        &self,
        source: SourceMut<'_>,
        all: bool,
        (choices, kinds): &mut (&mut u32, &mut BTreeMap<ChoiceId, ChoiceKind>),
    ) -> bool {
        let (choice, before) = match source {
            SourceMut::Bit(source) => {
                let (BitSource::Cell(cell) | BitSource::WordBit(cell, _)) = *source else {
                    return false;
                };
                if !all && !self.holds(cell) {
                    return false;
                }
                let choice = fresh(choices);
                (choice, Source::Bit(std::mem::replace(source, BitSource::Free(choice))))
            }
            SourceMut::Word(source) => {
                let is_memory = matches!(source, WordSource::Cell(_) | WordSource::Bits { .. });
                if !is_memory || !all && !self.holds_any(*source) {
                    return false;
                }
                let choice = fresh(choices);
                (choice, Source::Word(std::mem::replace(source, WordSource::Free(choice))))
            }
        };
        if !all && !self.is_unsteady(before) {
            kinds.insert(choice, ChoiceKind::StableExternal(before));
        }
        true
    }

    /// Whether a source may change within a scan whatever happens outside the program.
    fn is_unsteady(&self, source: Source) -> bool {
        let Some(Region::Range { first, count }) = source.region() else { return true };
        (0..count).any(|n| self.unsteady.iter().any(|region| region.contains(first.plus(n))))
    }
}

/// The instructions that interrupt routines may execute, including those of called routines.
fn reachable(program: &Program) -> BTreeSet<usize> {
    let mut open: Vec<usize> = program.interrupt_entries();
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
    use scanbound_ir::{AreaId, Interrupt, Join, Logic, testing};

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
