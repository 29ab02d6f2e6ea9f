//! Names for users: devices with their comments, and the call contexts of an instruction.

use scanbound_base::location::Location;
use scanbound_ir::{BitTarget, Cell, Device, Frame, Instruction, Program, Role, Step, Write};
use scanbound_model::{Origin, Variable};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The names of devices, places and call contexts of a program as reports write them.
pub struct Names<'a> {
    program: &'a Program,
    /// The file names as they appear in places. Empty if there is only one file.
    files: Vec<&'a str>,
    /// For each hidden cell in which instructions remember a state, such as an edge's last condition: the index of the
    /// first instruction that writes it.
    memories: BTreeMap<Cell, usize>,
}

/// The operands of an instruction that have a comment, each as `D100 speed`: the operand as written, then its comment.
/// A bit without a comment uses that of its word.
#[must_use]
pub fn comments_in(program: &Program, instruction: &Instruction) -> Vec<String> {
    let comments = &program.comments;
    let mut seen = BTreeSet::new();
    let place_text = instruction.operands.iter().filter_map(|operand| {
        let own = [operand.device, Device { bit: None, ..operand.device }];
        let (device, comment) =
            own.into_iter().find_map(|device| Some((device, comments.get(&device)?)))?;
        let written = operand.source_text(&instruction.text);
        seen.insert(device).then(|| format!("{written} {comment}"))
    });
    place_text.collect()
}

impl<'a> Names<'a> {
    /// Prepares names of devices and places for a program, with the comments of its devices.
    pub fn new(program: &'a Program) -> Names<'a> {
        let mut memories = BTreeMap::new();
        for (index, instruction) in program.instructions.iter().enumerate() {
            for effect in &instruction.effects {
                if let Write::Bit(BitTarget::Cell(cell), _) = effect.write
                    && program.area(cell.area).role == Role::Internal
                {
                    memories.entry(cell).or_insert(index);
                }
            }
        }
        let files = match program.files.len() {
            0 | 1 => Vec::new(),
            _ => program.files.iter().map(|file| program.short_name(file)).collect(),
        };
        Names { program, files, memories }
    }

    /// The name of a free variable in reports. For a choice in a loop, it includes the number of the iteration.
    pub fn free(&self, variable: &Variable) -> String {
        match &variable.origin {
            Origin::Start(cell) => self.cell(*cell),
            Origin::Choice(key) => {
                let iterations = key.frames.iter().filter_map(|&frame| self.iteration(frame));
                iterations
                    .fold(variable.name.clone(), |name, iteration| format!("{name}, {iteration}"))
            }
            Origin::Havocked { .. } => variable.name.clone(),
        }
    }

    /// A place as `file:line`. As `Program::location_text`, but the file names are cached: there are many executions
    /// and few files.
    fn place_text(&self, at: Location) -> String {
        match self.files.get(at.file as usize) {
            Some(file) => format!("{file}:{}", at.line),
            None => self.program.location_text(at),
        }
    }

    fn cell(&self, cell: Cell) -> String {
        let Some(&index) = self.memories.get(&cell) else { return self.program.cell_name(cell) };
        let at = &self.program.instructions[index];
        format!("remembered state of `{}` in {}", at.text, self.place_text(at.place))
    }

    fn iteration(&self, frame: Frame) -> Option<String> {
        match self.program.instructions[frame.at].step {
            Step::Call { .. } => None,
            Step::ForBegin { .. } => Some(format!("iteration {}", frame.iteration + 1)),
            _ => Some(format!("run {}", frame.iteration + 1)),
        }
    }

    /// The comment of the device of a free variable. Empty if there is none.
    pub fn comment(&self, variable: &Variable) -> String {
        cell_of(variable).map(|cell| self.comment_of(cell)).unwrap_or_default()
    }

    /// The comment of a cell. Empty if there is none.
    pub fn comment_of(&self, cell: Cell) -> String {
        self.program.comments.get(&Device { cell, bit: None }).cloned().unwrap_or_default()
    }

    /// As [`comments_in`], for an instruction of this program.
    pub fn comments_in(&self, instruction: &Instruction) -> Vec<String> {
        comments_in(self.program, instruction)
    }

    /// The name of the device for which a free variable stands. For a choice without a cell: the name of the variable.
    pub fn device(&self, variable: &Variable) -> String {
        cell_of(variable).map_or_else(|| variable.name.clone(), |cell| self.cell(cell))
    }

    /// The call context of an instruction: calls, loop iterations and interrupts, outermost first.
    pub fn context(&self, frames: &[Frame]) -> Vec<String> {
        frames.iter().map(|frame| self.frame(*frame)).collect()
    }

    /// The label of the innermost called routine, or the name of the interrupt. `None` in the main program.
    pub fn routine(&self, frames: &[Frame]) -> Option<Arc<str>> {
        frames.iter().rev().find_map(|frame| {
            let interrupt = self.program.interrupts.iter().find(|one| one.entry == frame.at);
            match (&self.program.instructions[frame.at].step, interrupt) {
                (Step::Call { target, .. }, _) => {
                    Some(self.program.instructions[*target].text.clone())
                }
                (_, Some(interrupt)) => Some(interrupt.name.as_str().into()),
                _ => None,
            }
        })
    }

    fn frame(&self, frame: Frame) -> String {
        let interrupt = self.program.interrupts.iter().find(|one| one.entry == frame.at);
        let at = &self.program.instructions[frame.at];
        match (&at.step, interrupt) {
            (Step::Call { .. }, _) => format!("{} in {}", at.text, self.place_text(at.place)),
            (Step::ForBegin { .. }, _) => {
                let place = self.place_text(at.place);
                format!("{} in {place}, iteration {}", at.text, frame.iteration + 1)
            }
            (_, Some(interrupt)) => format!("{}, run {}", interrupt.name, frame.iteration + 1),
            _ => format!("{} in {}", at.text, self.place_text(at.place)),
        }
    }
}

/// The cell for which a free variable stands. `None` for a choice that belongs to no cell.
fn cell_of(variable: &Variable) -> Option<Cell> {
    match &variable.origin {
        Origin::Start(cell) | Origin::Havocked { cell, .. } => Some(*cell),
        Origin::Choice(key) => key.cell,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_base::facts::Facts;
    use scanbound_front::{Input, Options};
    use scanbound_fronts::read;

    #[test]
    fn comments_are_those_of_the_devices_that_operands_name() {
        let list = "LD X00A\nMOV K4X0A D100Z2\nMOV ZR5 D100\nOUT T1 K5\nOUT D7.F\nEND\n";
        let names =
            "Device Name,Comment\nX00A,start\nD100,step\nZR5,recipe\nT1,delay\nD7,flags\nD2, \n";
        let input = |name: &str, text: &str| Input {
            name: name.to_owned(),
            bytes: text.as_bytes().to_vec(),
        };
        let inputs = [input("a.il", list), input("COMMENT.csv", names)];
        let project = read(&inputs, None).expect("readable");
        let facts = Facts::default();
        let program = project.decode(&Options::new(&facts)).expect("a program");
        let names = Names::new(&program);
        let place_text = |text: &str| {
            let of = program.instructions.iter().find(|one| &*one.text == text);
            names.comments_in(of.expect("an instruction")).join(", ")
        };
        assert_eq!(place_text("LD X00A"), "X00A start");
        assert_eq!(place_text("MOV K4X0A D100Z2"), "K4X0A start, D100Z2 step");
        assert_eq!(place_text("MOV ZR5 D100"), "ZR5 recipe, D100 step");
        assert_eq!(place_text("OUT T1 K5"), "T1 delay");
        assert_eq!(place_text("OUT D7.F"), "D7.F flags");
    }
}
