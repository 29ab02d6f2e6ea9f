//! Programs made by hand, for unit tests.

use super::{Effect, Instruction, Program, Step};
use scanbound_base::location::Location;

/// An instruction that is its step and nothing else: in rung 1 on line 1, without text, without a price.
pub fn instruction(step: Step) -> Instruction {
    Instruction {
        place: Location { file: 0, line: 1, step: None },
        block: 1,
        text: "".into(),
        operands: std::sync::Arc::default(),
        timing: None,
        effects: Vec::new(),
        step,
    }
}

/// The same with effects.
pub fn with_effects(step: Step, effects: Vec<Effect>) -> Instruction {
    Instruction { effects, ..instruction(step) }
}

/// A program of these steps, without areas and routines.
pub fn program(steps: impl IntoIterator<Item = Step>) -> Program {
    Program { instructions: steps.into_iter().map(instruction).collect(), ..Program::default() }
}
