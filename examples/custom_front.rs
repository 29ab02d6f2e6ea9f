//! A front for a dialect of one's own: a few lines that fill and drain a tank, read, priced and bounded.
#![allow(clippy::print_stdout)]

use scanbound::base::code::Code;
use scanbound::base::diagnostic::Diagnostic;
use scanbound::base::location::Location;
use scanbound::front::{Dialect, Front, Fronts, Input, Options, Project, Sniff, SourceOptions};
use scanbound::program::{
    AccessedDevices, Area, AreaId, AreaKind, BitTarget, Cell, Device, Effect, Instruction, Join,
    Logic, Operand, Program, Radix, Role, SourceFile, Step, TimingKey, Units, When, Write,
};
use std::error::Error;

/// `when IN1`, `unless IN1`: the lines below up to the next such run if the input is on, or off. `fill COIL2`: turns
/// an output on. Only the names of inputs and outputs are fixed, and what words are known is up to the timing table.
pub struct Toy;

static DIALECTS: [Dialect; 1] = [Dialect {
    name: "toy",
    what: "a toy's lines (when IN1, fill COIL2)",
    sniff: Sniff::Text(|text| text.starts_with("toy\n")),
}];

/// The fronts that read programs here.
static FRONTS: Fronts = Fronts(&[&Toy]);

impl Front for Toy {
    fn dialects(&self) -> &'static [Dialect] {
        &DIALECTS
    }

    fn is_comment_file(&self, _name: &str, beginning: &str) -> bool {
        beginning.starts_with("toy's names\n")
    }

    fn read(
        &self,
        dialect: &Dialect,
        programs: &[&Input],
        comment_files: &[&Input],
        _: SourceOptions,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        let files: Vec<File> = programs.iter().map(|input| file(input)).collect();
        let names = comment_files.iter().flat_map(|input| file(input).lines);
        let names = names.filter_map(|(_, device, name)| {
            let index = device.strip_prefix("IN")?.parse().ok()?;
            Some((Device { cell: Cell { area: AreaId(0), index }, bit: None }, name))
        });
        Ok(Box::new(ToyProject { dialect: dialect.name, names: names.collect(), files }))
    }
}

#[derive(Debug)]
struct ToyProject {
    dialect: &'static str,
    names: Vec<(Device, String)>,
    files: Vec<File>,
}

#[derive(Debug)]
struct File {
    name: String,
    /// Each line's number, its word and its operand.
    lines: Vec<(u32, String, String)>,
}

fn file(input: &Input) -> File {
    let text = String::from_utf8_lossy(&input.bytes);
    let lines = text.lines().zip(1..).skip(1).filter_map(|(line, number)| {
        let (word, operand) = line.split_once(' ')?;
        Some((number, word.to_owned(), operand.to_owned()))
    });
    File { name: input.name.clone(), lines: lines.collect() }
}

impl Project for ToyProject {
    fn cpu(&self) -> Option<&str> {
        None
    }

    fn decode(&self, options: &Options<'_>) -> Result<Program, Vec<Diagnostic>> {
        let area = |name, role| Area { role, ..Area::new(name, AreaKind::Bit, Radix::Decimal) };
        let mut program = Program {
            dialect: self.dialect.to_owned(),
            areas: vec![area("IN", Role::Input), area("COIL", Role::Output)],
            comments: self.names.iter().cloned().collect(),
            ..Program::default()
        };
        let mut faults = Vec::new();
        for (at, file) in self.files.iter().enumerate() {
            let first = program.instructions.len();
            for (line, word, operand) in &file.lines {
                let text = format!("{word} {operand}");
                let place = Location { file: at as u32, line: *line, step: None };
                match meaning(word, operand, options) {
                    Ok((cell, step, effects)) => {
                        program.blocks += u32::from(matches!(step, Step::Logic { .. }));
                        program.instructions.push(Instruction {
                            place,
                            block: program.blocks,
                            text: text.as_str().into(),
                            operands: [named(&text, cell)].into(),
                            timing: Some(Box::new(timing(word))),
                            effects,
                            step,
                        });
                    }
                    Err(what) => faults.push(Diagnostic::line(
                        Code::NotAnInstruction,
                        &file.name,
                        *line,
                        text,
                        what,
                        "write when, unless or a known word",
                    )),
                }
            }
            let all = first..program.instructions.len();
            program.mains.push(all.clone());
            let (name, count) = (file.name.clone(), all.len());
            program.files.push(SourceFile { name, instructions: all, count });
        }
        if faults.is_empty() { Ok(program) } else { Err(faults) }
    }
}

fn meaning(
    word: &str,
    operand: &str,
    options: &Options<'_>,
) -> Result<(Cell, Step, Vec<Effect>), String> {
    let cell = |letters: &str, area| {
        let index = operand.strip_prefix(letters).and_then(|digits| digits.parse().ok());
        let told = || format!("'{operand}' is no {letters} and a number");
        Ok::<Cell, String>(Cell { area: AreaId(area), index: index.ok_or_else(told)? })
    };
    let contact = |value| Step::Logic { join: Join::Start, value };
    match word {
        "when" => cell("IN", 0).map(|cell| (cell, contact(Logic::cell(cell)), Vec::new())),
        "unless" => cell("IN", 0).map(|cell| (cell, contact(Logic::cell(cell).not()), Vec::new())),
        word if (options.is_user_instruction)(word) => {
            let coil = cell("COIL", 1)?;
            let write = Write::Bit(BitTarget::Cell(coil), Logic::Const(true));
            let effect = Effect { when: When::Fired, write };
            Ok((coil, Step::Act { fires: Logic::Condition }, vec![effect]))
        }
        _ => Err(format!("'{word}' is no word of a toy")),
    }
}

/// The operand behind the word.
fn named(text: &str, cell: Cell) -> Operand {
    let start = text.find(' ').map_or(0, |blank| blank + 1);
    let device = Device { cell, bit: None };
    Operand { start: start as u32, end: text.len() as u32, device }
}

fn timing(word: &str) -> TimingKey {
    TimingKey {
        names: vec![word.to_owned()],
        class: "coil",
        units: Units::None,
        use_larger_time: false,
        optional: false,
        accessed: AccessedDevices::default(),
    }
}

/// The times of the dialect's instructions.
pub const TIMES: &str = "instruction,on_us,off_us\nwhen,1,\nunless,1,\nfill,50,2\ndrain,80,3\n@end,10,\n@input16,4,\n@output16,5,\n";

fn main() -> Result<(), Box<dyn Error>> {
    let report = scanbound::Analysis::new()
        .fronts(FRONTS)
        .file("fill.toy", "toy\nwhen IN1\nfill COIL2\n")
        .file("drain.toy", "toy\nunless IN1\ndrain COIL20\n")
        .table("toy.csv", TIMES)
        .run()?;
    // Filling and draining are mutually exclusive.
    assert!(report.is_exact());
    println!("bound: {}", report.upper());
    Ok(())
}
