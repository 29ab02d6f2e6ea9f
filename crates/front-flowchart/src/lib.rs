//! Flowchart PC: a main routine and up to 32 groups, written as flowcharts with tests, jumps and waits.
//!
//! The source is a Japanese teaching report about programming such a PC: its instruction table, its descriptions of
//! WAIT and timers, and its examples (docs/flowchart.md). There is no scan that runs every instruction once;
//! docs/flowchart.md defines what one pass is.

mod back_jumps;
pub mod decode;
pub mod interpret;
mod parse;
mod pass_starts;
mod source;
mod start_states;
mod structure;

pub use source::{Instruction, MAX_GROUPS, NAME, Op, Routine, Source};

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::numbering::{self, NumberedLine};
use scanbound_front::{
    Dialect, Front, Input, MachineOptions, Options, Project, Sniff, SourceOptions, decoded,
};
use scanbound_ir::Program;

/// The dialect, and how it is recognised.
static DIALECTS: [Dialect; 1] = [Dialect {
    name: NAME,
    what: "a list for a flowchart PC (LBL0: AND 1, CJP LBL1, WAIT, GJ)",
    sniff: Sniff::Text(parse::sniff),
}];

/// Reads programs for flowchart PCs: the implementation of [`Front`] for the dialect `flowchart`.
pub struct Flowchart;

/// The value of [`Flowchart`] that the list of all fronts contains.
pub const FRONT: Flowchart = Flowchart;

impl Front for Flowchart {
    fn dialects(&self) -> &'static [Dialect] {
        &DIALECTS
    }

    fn read(
        &self,
        _dialect: &Dialect,
        programs: &[&Input],
        _beside: &[&Input],
        _reading: SourceOptions,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        Ok(Box::new(read(programs)?))
    }
}

impl Project for Source {
    fn cpu(&self) -> Option<&str> {
        Some(CPU)
    }

    fn warnings(&self) -> Vec<Diagnostic> {
        self.warnings()
    }

    fn machine_options(&self) -> MachineOptions {
        MachineOptions { latched: true, ..MachineOptions::default() }
    }

    fn decode(&self, options: &Options<'_>) -> Result<Program, Vec<Diagnostic>> {
        Ok(decode::decode(self, options.facts.latched == Some(true)))
    }
}

/// The name of the CPU of every program in this dialect. The built-in timing table for flowchart PCs has it too.
pub const CPU: &str = "FLOWCHART-PC";

/// Reads the only file.
///
/// # Errors
/// The errors of the file, or that there is more than one file.
fn read(files: &[&Input]) -> Result<Source, Vec<Diagnostic>> {
    let Some((input, rest)) = files.split_first() else { return Err(Vec::new()) };
    if let Some(second) = rest.first() {
        return Err(vec![Diagnostic::file(
            Code::TwoPrograms,
            &second.name,
            format!("a flowchart PC runs one program, but {} is a second program", input.name),
            "give one file",
        )]);
    }
    let text = decoded(input, &[]).map_err(|fault| vec![fault])?;
    read_text(&input.name, &text)
}

/// Reads a program from the text of a file with the name `name`.
///
/// # Errors
/// The errors and warnings of the text, of each at most 50.
pub fn read_text(name: &str, text: &str) -> Result<Source, Vec<Diagnostic>> {
    let mut faults = scanbound_front::Faults::new(name);
    let list = parse::read(text, &mut faults);
    // Before a group, addresses may be skipped.
    numbering::check(numbered(&list), &mut faults);
    let source = structure::source(name, text, list, &mut faults);
    if faults.any_error() { Err(faults.into_diagnostics()) } else { Ok(source) }
}

/// The instructions with their addresses. Each instruction occupies one address, and a timer's time one more.
fn numbered(list: &[parse::Listed]) -> impl Iterator<Item = NumberedLine<'_>> {
    list.iter().enumerate().map(|(at, one)| {
        let is_head = one.word == parse::Mnemonic::Head;
        let before_head = list.get(at + 1).is_some_and(|next| next.word == parse::Mnemonic::Head);
        NumberedLine {
            line: one.line,
            address: one.step,
            takes: match one.word {
                // In some lists a label has the address of the instruction after it.
                parse::Mnemonic::Label => None,
                _ => Some(if one.time.is_some() { 2 } else { 1 }),
            },
            text: &one.text,
            restarts: is_head || before_head,
        }
    })
}

#[cfg(test)]
mod tests;
