//! A front for a toy dialect, written here alone against the public trait: one place and one line of a registry are
//! all that a dialect takes, and everything behind `Program` serves it.

use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::code::Code;
use scanbound::base::diagnostic::Diagnostic;
use scanbound::base::facts::Facts;
use scanbound::base::location::Location;
use scanbound::base::time::Picos;
use scanbound::front::melsec::Melsec;
use scanbound::front::{Dialect, Front, Fronts, Input, Kind, Options, Project, Reading, Sniff};
use scanbound::program::{
    Area, AreaId, AreaKind, BitTarget, Cell, Device, Effect, Instruction, Join, Logic, Operand,
    Program, Radix, Role, SourceFile, Step, TimingKey, Touched, Units, When, Write,
};
use scanbound::timing::table::Table;

/// `when IN1`, `unless IN1`: the lines below up to the next such run if the input is on, or off. `fill COIL2`: turns
/// an output on. Only the names of inputs and outputs are fixed, and what words are known is up to the timing table.
struct Toy;

static DIALECTS: [Dialect; 1] = [Dialect {
    name: "toy",
    what: "a toy's lines (when IN1, fill COIL2)",
    sniff: Sniff::Text(|text| text.starts_with("toy\n")),
}];

/// The registry, with its line for the toy.
static FRONTS: Fronts = Fronts(&[&Melsec, &Toy]);

impl Front for Toy {
    fn dialects(&self) -> &'static [Dialect] {
        &DIALECTS
    }

    fn is_beside(&self, _name: &str, beginning: &str) -> bool {
        beginning.starts_with("toy's names\n")
    }

    fn read(
        &self,
        dialect: &Dialect,
        programs: &[&Input],
        beside: &[&Input],
        _reading: Reading,
    ) -> Result<Box<dyn Project>, Vec<Diagnostic>> {
        let files: Vec<File> = programs.iter().map(|input| file(input)).collect();
        let names = beside.iter().flat_map(|input| file(input).lines);
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
        dearer: false,
        optional: false,
        touched: Touched::default(),
    }
}

const ROWS: &str = "instruction,on_us,off_us\nwhen,1,\nunless,1,\nfill,50,2\ndrain,80,3\n@end,10,\n@input16,4,\n@output16,5,\n";

fn audited(files: &[(&str, &str)]) -> Result<Audit, Failure> {
    let table = Table::parse("toy.csv", ROWS.as_bytes()).expect("a table").table;
    let input = |(name, text): &(&str, &str)| Input {
        name: (*name).to_owned(),
        bytes: text.as_bytes().to_vec(),
    };
    let inputs: Vec<Input> = files.iter().map(input).collect();
    let facts = Facts::default();
    audit(&Request { fronts: FRONTS, table: Some(&table), ..Request::new(&inputs, &facts) })
}

#[test]
fn a_toys_longest_scan_is_found_and_shown_in_its_own_names() {
    let found = audited(&[
        ("fill.toy", "toy\nwhen IN1\nfill COIL2\n"),
        ("drain.toy", "toy\nunless IN1\ndrain COIL20\n"),
        ("names.txt", "toy's names\nIN1 tank is empty\n"),
    ]);
    let audit = found.expect("an audit");
    // Filling and draining exclude each other through IN1; 16 points come in and 32 go out.
    let us = |us: u64| Picos(us * 1_000_000);
    assert_eq!(audit.bound.upper, us(1 + 2 + 1 + 80 + 10 + 4 + 2 * 5));
    assert_eq!(audit.bound.lower, audit.bound.upper);
    assert_eq!((audit.dialect.as_str(), audit.instructions), ("toy", 4));
    let tie = &audit.groups[0].ties[0];
    assert_eq!((tie.device.as_str(), tie.comment.as_str()), ("IN1", "tank is empty"));
}

#[test]
fn a_toys_faults_are_told_with_their_lines() {
    let Err(Failure::Input(faults)) = audited(&[("a.toy", "toy\nwhen IN1\njump COIL2\nfill D\n")])
    else {
        panic!("a fault in each of two lines")
    };
    let told: Vec<_> = faults.iter().map(|fault| (fault.line, fault.message.as_str())).collect();
    assert_eq!(
        told,
        [(Some(3), "'jump' is no word of a toy"), (Some(4), "'D' is no COIL and a number"),]
    );
}

#[test]
fn a_toys_files_are_told_from_those_of_other_fronts() {
    let kind = |text: &str| {
        let input = Input { name: "a.txt".to_owned(), bytes: text.as_bytes().to_vec() };
        match FRONTS.detect(&input) {
            Ok(Kind::Program(dialect)) => Ok(dialect.name),
            Ok(Kind::Comments) => Ok("beside"),
            Err(fault) => Err(fault.code),
        }
    };
    assert_eq!(kind("toy\nwhen IN1\n"), Ok("toy"));
    assert_eq!(kind("toy's names\n"), Ok("beside"));
    assert_eq!(kind("LD X0\nOUT Y0\nEND\n"), Ok("melsec-list"));
    assert_eq!(
        kind("LD 00000\nOUT 00100\n"),
        Err(Code::UnknownDialect),
        "a front that is not listed"
    );
    let mixed = audited(&[("a.toy", "toy\nwhen IN1\n"), ("b.il", "LD X0\nOUT Y0\nEND\n")]);
    let Err(Failure::Input(faults)) = mixed else { panic!("two dialects") };
    assert_eq!(faults[0].code, Code::MixedDialects);
}
