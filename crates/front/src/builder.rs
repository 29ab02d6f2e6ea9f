//! Puts a program together, instruction by instruction: what every front does alike, whatever its dialect means.

use std::sync::Arc;

use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::cell_budget::CellBudget;
use scanbound_ir::meaning::Meaning;
use scanbound_ir::timed::Expiry;
use scanbound_ir::{
    Absent, Approximated, BitSource, ChoiceId, ChoiceKind, Effect, Instruction, Interrupt, Logic,
    Operand, Program, Region, Step, TimingKey, When, WordSource, Write,
};

/// What is stated of a routine that is not there.
pub struct Known {
    /// The time that a call takes.
    pub time: Picos,
    /// All that it may write.
    pub writes: Vec<Region>,
}

/// A program while it is put together.
pub struct Builder {
    /// What has been added so far.
    pub program: Program,
    budget: CellBudget,
    place: Location,
    text: Arc<str>,
    operands: Arc<[Operand]>,
}

impl Builder {
    /// Goes on from a program without instructions.
    pub fn new(program: Program) -> Self {
        Builder {
            program,
            budget: CellBudget::default(),
            place: Location { file: 0, line: 1, step: None },
            text: Arc::default(),
            operands: Arc::default(),
        }
    }

    /// What is added from here on stands at this place of the source.
    pub fn at(&mut self, place: Location, text: Arc<str>, operands: Arc<[Operand]>) {
        (self.place, self.text, self.operands) = (place, text, operands);
    }

    /// The index that the next instruction gets.
    pub fn next(&self) -> usize {
        self.program.instructions.len()
    }

    /// Adds an instruction; its index. Where its effects are too many to be followed one by one, all that they write takes
    /// any value, which is listed.
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
            self.program.approximate(at, Approximated::NoRoom);
        }
        at
    }

    /// Adds an interrupt program that begins at an instruction. It is counted as often as is stated, else once.
    pub fn interrupt(&mut self, name: String, entry: usize, stated: Option<u32>) {
        let (times, stated) = (stated.unwrap_or(1), stated.is_some());
        self.program.interrupts.push(Interrupt { name, entry, times, stated });
    }

    /// Lets a call lead to a routine that is not there: to what stands in for it, behind all that was added. What is not
    /// stated to be written by it may be anything.
    pub fn call_absent(&mut self, call: usize, name: &str, known: Option<Known>) {
        let entry = self.next();
        let stated = known.is_some();
        let Known { time, writes } =
            known.unwrap_or_else(|| Known { time: Picos::ZERO, writes: vec![Region::Everything] });
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
        let what = "the routine is not there: what it may write takes any value";
        self.program.approximate(entry, what);
        self.program.absent.push(Absent {
            name: name.to_owned(),
            entry,
            time,
            stated,
            declared: false,
        });
    }

    /// Whether so many cells can still be followed one by one.
    pub fn has_room(&self, cells: usize) -> bool {
        self.budget.has_room(cells)
    }

    /// A new choice, of which nothing is known.
    pub fn choice(&mut self) -> ChoiceId {
        self.program.choices += 1;
        ChoiceId(self.program.choices - 1)
    }

    /// A choice that the outside makes.
    pub fn world(&mut self) -> ChoiceId {
        let choice = self.choice();
        self.program.kinds.insert(choice, ChoiceKind::World);
        choice
    }

    /// How many units of time one scan can take, as a word. Each timer has its own, so that none depends on another.
    pub fn scan_ticks(&mut self, unit: Picos, is_decimal: bool) -> ChoiceId {
        let choice = self.choice();
        self.program.kinds.insert(choice, ChoiceKind::ScanTicks { unit, is_decimal });
        choice
    }

    /// Says what decides the choices that tell whether a timer is over and how far it has run.
    pub fn expiry(&mut self, [over, elapsed]: [ChoiceId; 2], expiry: Expiry) {
        self.program.timekeeping.expiries.insert(over, expiry);
        self.program.timekeeping.elapsed.insert(elapsed, over);
    }

    /// A bit of any value.
    pub fn free_bit(&mut self) -> Logic {
        Logic::Bit(BitSource::Free(self.choice()))
    }

    /// A word of any value.
    pub fn free_word(&mut self) -> WordSource {
        WordSource::Free(self.choice())
    }

    /// The same, so that the bound follows it whatever it reads.
    pub fn followed(&mut self, choice: ChoiceId, meaning: Meaning) {
        self.program.followed.insert(choice);
        self.exactly(choice, meaning);
    }

    /// Says what gives a choice its value.
    pub fn exactly(&mut self, choice: ChoiceId, meaning: Meaning) {
        if self.budget.meaning(&meaning) {
            self.program.kinds.insert(choice, ChoiceKind::Exact(Box::new(meaning)));
        }
    }
}

/// An effect whenever the instruction is reached.
pub fn always(write: Write) -> Effect {
    Effect { when: When::Always, write }
}

/// An effect where the instruction fires.
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
        let (own, outside) = (builder.choice(), builder.world());
        assert_ne!(own, outside);
        let kinds = &builder.program.kinds;
        assert!(!kinds.contains_key(&own) && kinds[&outside] == ChoiceKind::World);
    }
}
