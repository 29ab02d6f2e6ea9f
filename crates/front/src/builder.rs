//! Builds a program instruction by instruction. All fronts use it, whatever their dialect.

use std::sync::Arc;

use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::cell_budget::CellBudget;
use scanbound_ir::meaning::Meaning;
use scanbound_ir::timers::Expiry;
use scanbound_ir::{
    Approximated, BitSource, ChoiceId, ChoiceKind, Effect, Instruction, Interrupt, Logic,
    MissingRoutine, Operand, Program, Region, Step, TimingKey, When, WordSource, Write,
};

/// The time and the writes that the facts file states for a routine that is missing from the files.
pub struct StatedRoutine {
    /// The longest time of one call of the routine.
    pub time: Picos,
    /// All regions that the routine may write.
    pub writes: Vec<Region>,
}

/// A program under construction.
pub struct Builder {
    /// The program so far.
    pub program: Program,
    budget: CellBudget,
    place: Location,
    text: Arc<str>,
    operands: Arc<[Operand]>,
}

impl Builder {
    /// Starts from a program that has no instructions yet.
    pub fn new(program: Program) -> Self {
        Builder {
            program,
            budget: CellBudget::default(),
            place: Location { file: 0, line: 1, step: None },
            text: Arc::default(),
            operands: Arc::default(),
        }
    }

    /// Sets the source position, text and operands of the instructions that are added next.
    pub fn at(&mut self, place: Location, text: Arc<str>, operands: Arc<[Operand]>) {
        (self.place, self.text, self.operands) = (place, text, operands);
    }

    /// The source position of the instructions that are added next.
    pub fn place(&self) -> Location {
        self.place
    }

    /// The index of the next instruction to be added.
    pub fn next(&self) -> usize {
        self.program.instructions.len()
    }

    /// Adds an instruction and returns its index. Without `timing` it takes no time. If its effects list more cells
    /// than the program may list (see [`scanbound_ir::cell_budget`]), they become havocs of everything that they write,
    /// and the program lists this as an over-approximation.
    pub fn add(
        &mut self,
        timing: Option<TimingKey>,
        mut effects: Vec<Effect>,
        step: Step,
    ) -> usize {
        let choices = &mut self.program.choices;
        let fits = self.budget.effects(&mut effects, || {
            *choices += 1;
            ChoiceId(*choices - 1)
        });
        let at = self.next();
        self.program.instructions.push(Instruction {
            place: self.place,
            block: self.program.blocks.max(1),
            text: self.text.clone(),
            operands: self.operands.clone(),
            timing: timing.map(Box::new),
            effects,
            step,
        });
        if !fits {
            self.program.approximate(at, Approximated::BlocksTooLarge);
        }
        at
    }

    /// Adds an interrupt routine that begins at instruction `entry`. `stated` is the number of its runs in a scan that
    /// the user states; `None`: one run is charged.
    pub fn interrupt(&mut self, name: String, entry: usize, stated: Option<u32>) {
        let (times, stated) = (stated.unwrap_or(1), stated.is_some());
        self.program.interrupts.push(Interrupt { name, entry, times, stated });
    }

    /// Directs the call at instruction `call` to a substitute for a routine that is missing from the files. The
    /// substitute is added at the end of the program. If `known` is `None`, it takes no time and may write everything.
    pub fn call_absent(&mut self, call: usize, name: &str, known: Option<StatedRoutine>) {
        let entry = self.next();
        let stated = known.is_some();
        let StatedRoutine { time, writes } = known.unwrap_or_else(|| StatedRoutine {
            time: Picos::ZERO,
            writes: vec![Region::Everything],
        });
        let effects = writes.into_iter().map(|region| always(Write::Havoc(region, self.choice())));
        let effects = effects.collect();
        let own = &mut self.program.instructions[call];
        if let Step::Call { target, .. } = &mut own.step {
            *target = entry;
        }
        let (place, block) = (own.place, own.block);
        let part = |effects, step| Instruction {
            place,
            block,
            text: name.into(),
            operands: Arc::default(),
            timing: None,
            effects,
            step,
        };
        let parts = [part(effects, Step::Nothing), part(Vec::new(), Step::Return)];
        self.program.instructions.extend(parts);
        let what = "the routine is missing: any values are assumed for everything that the routine may write";
        self.program.approximate(entry, what);
        self.program.missing_routines.push(MissingRoutine {
            name: name.to_owned(),
            entry,
            time,
            stated,
            declared: false,
        });
    }

    /// Whether effects on this many more cells would be kept: they are few, or the program may still list so many
    /// cells.
    pub fn has_room(&self, cells: usize) -> bool {
        self.budget.has_room(cells)
    }

    /// A new choice (nondeterministic value) of which nothing is known: it may have any value.
    pub fn choice(&mut self) -> ChoiceId {
        self.program.choices += 1;
        ChoiceId(self.program.choices - 1)
    }

    /// A new choice that something outside the program determines, such as an input or a module.
    pub fn external_choice(&mut self) -> ChoiceId {
        let choice = self.choice();
        self.program.kinds.insert(choice, ChoiceKind::External);
        choice
    }

    /// A new choice for the number of ticks, each of length `unit`, that pass in one scan, as a word (in BCD if
    /// `is_decimal`). Each timer has its own choice, so that timers do not depend on each other. For `goes_on`, see
    /// [`ChoiceKind::ScanTicks`].
    pub fn scan_ticks(&mut self, unit: Picos, is_decimal: bool, goes_on: bool) -> ChoiceId {
        let choice = self.choice();
        self.program.kinds.insert(choice, ChoiceKind::ScanTicks { unit, is_decimal, goes_on });
        choice
    }

    /// Records the timer that determines two choices: whether it has timed out, and its present value.
    pub fn set_expiry(&mut self, [over, elapsed]: [ChoiceId; 2], expiry: Expiry) {
        self.program.timekeeping.expiries.insert(over, expiry);
        self.program.timekeeping.elapsed.insert(elapsed, over);
    }

    /// An expression for a bit that may have any value, from a new choice.
    pub fn free_bit(&mut self) -> Logic {
        Logic::Bit(BitSource::Free(self.choice()))
    }

    /// A word that may have any value, from a new choice.
    pub fn free_word(&mut self) -> WordSource {
        WordSource::Free(self.choice())
    }

    /// As [`Builder::define`]. In addition, the analysis always executes the operation, not only where its operands are
    /// known.
    pub fn define_followed(&mut self, choice: ChoiceId, meaning: Meaning) {
        self.program.always_followed.insert(choice);
        self.define(choice, meaning);
    }

    /// Records the operation and operands that compute the value of a choice. If the program would then list more cells
    /// than it may (see [`scanbound_ir::cell_budget`]), nothing is recorded, and the choice may have any value.
    pub fn define(&mut self, choice: ChoiceId, meaning: Meaning) {
        if self.budget.meaning(&meaning) {
            self.program.kinds.insert(choice, ChoiceKind::Exact(Box::new(meaning)));
        }
    }
}

/// An effect that happens whenever control reaches the instruction.
pub fn always(write: Write) -> Effect {
    Effect { when: When::Always, write }
}

/// An effect that happens only when the instruction fires.
pub fn fired(write: Write) -> Effect {
    Effect { when: When::Fired, write }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_ir::{AreaId, Cell, Number, WordTarget};

    #[test]
    fn what_cannot_be_followed_one_by_one_takes_any_value_and_is_listed() {
        let mut builder = Builder::new(Program::default());
        let block = |count: u32| {
            let cells = (0..count).map(|index| Cell { area: AreaId(0), index });
            let words = (0..count).map(|_| WordSource::Const(0));
            let targets = cells.map(WordTarget::Cell).collect();
            vec![fired(Write::Words(targets, Number::Words(words.collect())))]
        };
        assert_eq!(builder.add(None, block(100), Step::Nothing), 0);
        assert!(builder.program.approximations.is_empty());
        assert_eq!(builder.add(None, block(3_000_000), Step::Nothing), 1);
        assert_eq!(builder.program.approximations.len(), 1);
        let wide = &builder.program.instructions[1].effects;
        assert!(matches!(wide[..], [Effect { when: When::Fired, write: Write::Havoc(..) }]));
    }

    #[test]
    fn what_the_outside_decides_is_known_as_such() {
        let mut builder = Builder::new(Program::default());
        let (own, outside) = (builder.choice(), builder.external_choice());
        assert_ne!(own, outside);
        let kinds = &builder.program.kinds;
        assert!(!kinds.contains_key(&own) && kinds[&outside] == ChoiceKind::External);
    }
}
