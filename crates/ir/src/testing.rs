//! Programs built by hand for unit tests.

use super::{Effect, Instruction, Program, Step};
use scanbound_base::location::Location;

/// An instruction with only a step: in rung 1 on line 1, without text and without a time.
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

/// An instruction with a step and effects: in rung 1 on line 1, without text and without a time.
pub fn with_effects(step: Step, effects: Vec<Effect>) -> Instruction {
    Instruction { effects, ..instruction(step) }
}

/// A program of these steps, without areas and routines.
pub fn program(steps: impl IntoIterator<Item = Step>) -> Program {
    Program { instructions: steps.into_iter().map(instruction).collect(), ..Program::default() }
}
