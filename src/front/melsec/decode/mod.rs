//! Turns a MELSEC project, instruction by instruction, into a program without a dialect.

mod access;
mod application;
mod blocks;
mod compare;
mod control;
mod edges;
mod exact;
mod finish;
mod held;
mod meaning;
mod named;
mod output;
mod overflow;
mod ranges;
mod rungs;
mod shown;
#[cfg(test)]
mod tests;
mod units;
mod zones;

use super::device::{Family, Kind, area, areas, edge_memory, networks, power_up};
use super::operand::{self, Operand, parse, upper};
use super::source::{RawInstruction, RawProject};
use crate::base::code::Code;
use crate::base::diagnostic::Diagnostic;
use crate::base::facts::Facts;
use crate::base::location::Location;
use crate::front::Faults;
use crate::program::flow;
use crate::program::spelled::Spelled;
use crate::program::{
    Approximated, Cell, ChoiceId, Effect, Instruction, Interrupt, Logic, Program, Region,
    SourceFile, Step, TimingKey, Touched, Units, When, Write,
};
use ranges::Counts;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use zones::State;

/// What decoding needs to know besides the source.
pub struct DecodeOptions<'a> {
    /// The CPU family.
    pub family: Family,
    /// Whether the timing table has an instruction of the user's of this name.
    pub is_user_instruction: &'a dyn Fn(&str) -> bool,
    /// What the user states.
    pub facts: &'a Facts,
}

/// Decodes a project.
///
/// # Errors
/// All faults of all files.
pub fn decode(
    project: &RawProject,
    options: &DecodeOptions<'_>,
) -> Result<Program, Vec<Diagnostic>> {
    too_many(project, options.family)?;
    let mut overwritten = BTreeSet::new();
    loop {
        let mut decoder = Decoder::new(project, options, &overwritten);
        for file in 0..project.files.len() {
            decoder.file(file);
        }
        let (program, counts) = decoder.finish()?;
        // A stated range speaks of the scan's start. Where the program may write a word that it counts by,
        // the range is worth nothing there, and decoding begins again without it.
        let before = overwritten.len();
        overwritten.extend(
            counts
                .into_iter()
                .filter(|(_, cell)| flow::is_written(&program, *cell))
                .map(|(text, _)| text),
        );
        if overwritten.len() == before {
            return Ok(program);
        }
    }
}

/// Refuses a project of more instructions than any CPU of its family holds, at the first that is too many: each takes a
/// step or more.
fn too_many(project: &RawProject, family: Family) -> Result<(), Vec<Diagnostic>> {
    let most = family.most_steps();
    let files = project.files.iter();
    let mut all = files.flat_map(|file| file.instructions.iter().map(move |one| (file, one)));
    let Some((file, one)) = all.nth(most) else { return Ok(()) };
    let message = format!("the project has more than {most} instructions");
    let help = format!("no {} holds as many: check the file, and the CPU", family.series());
    let fault = Diagnostic::line(Code::TooMany, &file.name, one.line, &*one.text, message, help);
    Err(vec![fault.at_step(one.step)])
}

/// A target still to be found.
const OPEN: usize = usize::MAX;

/// A jump, call or loop whose target is not known yet.
struct Fixup {
    instruction: usize,
    label: u32,
    /// The file in which to look first, or the only one for calls by a file's name.
    file: usize,
    /// Only this file will do.
    only: bool,
}

/// Decoding of a project under way.
pub struct Decoder<'a> {
    project: &'a RawProject,
    options: &'a DecodeOptions<'a>,
    family: Family,
    program: Program,
    faults: Vec<Faults<'a>>,
    spelled: Spelled,
    switches_file_register: bool,
    /// FX, FX5: special relays that change what moves do: M8024 turns BMOV round, M8160 lets XCH swap bytes.
    turns_moves: bool,
    /// FX: with M8023 on, sums and differences of double words are of real numbers.
    sums_reals: bool,
    /// Q, L: with SM702 on, searches take their blocks for sorted ones.
    searches_by_halves: bool,
    /// FX, FX5: M8040, or IST, may keep a step ladder from moving on.
    states_may_stay: bool,
    /// FX: with M8164 on, FROM and TO move as many words as D8164 says.
    counts_elsewhere: bool,
    /// Files whose programs are called or stopped by their names.
    may_rest: Vec<bool>,

    file: usize,
    /// Nothing is a fault: something is only tried.
    quiet: bool,
    /// The instruction under way, an index into the file's.
    position: usize,
    raw: Option<&'a RawInstruction>,
    /// The rung under way: results on the stack, results saved, whether it has put anything out yet.
    depth: usize,
    saved: u32,
    has_output: bool,
    /// A rung was begun by a label or the like, which the next contact joins.
    block_open: bool,
    edges: u32,
    /// Instructions of the FX and FX5 that act at edges.
    edges_at: Vec<edges::Edge>,
    /// What the instruction under way loses if it overflows.
    lost: Option<overflow::Lost>,

    /// Words whose stated range does not hold where they count: the program may write them.
    overwritten: &'a BTreeSet<String>,
    /// Words that count and whose stated range was believed.
    counts: Counts,
    labels: Vec<BTreeMap<u32, usize>>,
    fixups: Vec<Fixup>,
    /// Calls that may run their routine with all its coils off.
    calls_with_coils_off: Vec<usize>,
    loops: Vec<usize>,
    /// Jumps to the next end of the main routine.
    ends: Vec<usize>,
    /// Open zones: level and the instruction that opened it.
    zones: Vec<(u32, usize)>,
    zone_of: Vec<Option<usize>>,
    interrupts: Vec<Interrupt>,
    /// The step ladder's open state: its relays, the jump over it, the instruction behind which it begins.
    state: Option<State>,
}

impl<'a> Decoder<'a> {
    fn new(
        project: &'a RawProject,
        options: &'a DecodeOptions<'a>,
        overwritten: &'a BTreeSet<String>,
    ) -> Self {
        let cpu = project.files.iter().find_map(|file| file.cpu.clone());
        let program = Program {
            dialect: project.dialect.to_owned(),
            cpu,
            areas: areas(options.family),
            networks: networks(options.family),
            power_up: power_up(options.family),
            comments: shown::comments(&project.comments, options.family),
            ..Program::default()
        };
        let is_switch = |raw: &RawInstruction| {
            ["RSET", "RSETP", "QDRSET", "QDRSETP"]
                .iter()
                .any(|name| raw.mnemonic.eq_ignore_ascii_case(name))
        };
        Decoder {
            project,
            options,
            family: options.family,
            program,
            faults: project.files.iter().map(|file| Faults::new(&file.name)).collect(),
            spelled: Spelled::default(),
            switches_file_register: project
                .files
                .iter()
                .flat_map(|file| &file.instructions)
                .any(is_switch),
            turns_moves: matches!(options.family, Family::Fx | Family::Fx5)
                && touches(project, options.family, &[8024, 8160]),
            sums_reals: options.family == Family::Fx && touches(project, options.family, &[8023]),
            searches_by_halves: touches(project, options.family, &[702]),
            states_may_stay: matches!(options.family, Family::Fx | Family::Fx5)
                && (touches(project, options.family, &[8040]) || has(project, "IST")),
            counts_elsewhere: options.family == Family::Fx
                && touches(project, options.family, &[8164]),
            may_rest: may_rest(project),
            file: 0,
            quiet: false,
            position: 0,
            raw: None,
            depth: 0,
            saved: 0,
            has_output: true,
            block_open: false,
            edges: 0,
            edges_at: Vec::new(),
            lost: None,
            overwritten,
            counts: Vec::new(),
            labels: vec![BTreeMap::new(); project.files.len()],
            fixups: Vec::new(),
            calls_with_coils_off: Vec::new(),
            loops: Vec::new(),
            ends: Vec::new(),
            zones: Vec::new(),
            zone_of: Vec::new(),
            interrupts: Vec::new(),
            state: None,
        }
    }

    fn file(&mut self, file: usize) {
        self.file = file;
        let first = self.program.instructions.len();
        (self.depth, self.saved, self.has_output, self.block_open) = (0, 0, true, false);
        let raw_file = &self.project.files[file];
        self.program.instructions.reserve(raw_file.instructions.len());
        self.zone_of.reserve(raw_file.instructions.len());
        if self.may_rest[file] {
            self.rest();
        }
        for (position, raw) in raw_file.instructions.iter().enumerate() {
            (self.position, self.raw) = (position, Some(raw));
            self.instruction(raw);
            self.direct_inputs(raw);
            // What follows so many faults is no program either.
            if self.faults[file].give_up() {
                return;
            }
        }
        self.raw = raw_file.instructions.last();
        self.end_of_file();
        self.raw = None;
        let last = self.program.instructions.len();
        self.program.mains.push(first..last);
        self.program.files.push(SourceFile {
            name: raw_file.name.clone(),
            instructions: first..last,
            count: raw_file.instructions.len(),
        });
    }

    /// A program that need not run in every scan.
    fn rest(&mut self) {
        self.approximate(
            "this program is called or stopped by instructions: it may run by itself in the scan or not",
        );
        let fires = self.free_bit();
        let at = self.add(None, Vec::new(), Step::Jump { fires, target: OPEN });
        self.ends.push(at);
    }

    /// What is read as `DX` is then found in `X` as well.
    fn direct_inputs(&mut self, raw: &RawInstruction) {
        // Hardly any program has one.
        let may_be =
            |text: &String| text.as_bytes().windows(2).any(|two| two.eq_ignore_ascii_case(b"DX"));
        if !raw.operands.iter().any(may_be) {
            return;
        }
        let is_direct = |text: &String| matches!(parse(text, self.family), Ok(Operand::Device(device)) if device.name == "DX");
        if !raw.operands.iter().any(is_direct) {
            return;
        }
        self.approximate("a direct input refreshes X: any X is taken as any value");
        let choice = self.choice();
        let lost = always(Write::Havoc(Region::Area(area("X")), choice));
        self.add(None, vec![lost], Step::Nothing);
    }

    /// Decodes one instruction; each kind has its file.
    fn instruction(&mut self, raw: &RawInstruction) {
        let upper = upper(&raw.mnemonic);
        let known = self.rung(&upper, raw)
            || self.comparison(&upper, raw)
            || self.control(&upper, raw)
            || self.output(&upper, raw);
        if !known {
            self.application(&upper, raw);
        }
    }

    /// Notes a fault at the instruction under way; `part` is a slice of it or a word of it.
    pub fn fault(&mut self, code: Code, part: &str, message: impl Into<String>, help: &str) {
        let Some(raw) = self.raw.filter(|_| !self.quiet) else { return };
        let file = &self.project.files[self.file];
        let found = raw.pointer(file).at(part, code, &file.name, message, help).at_step(raw.step);
        self.faults[self.file].push(found);
    }

    /// Lists what is taken wider than it is at the instruction about to be added.
    pub fn approximate(&mut self, what: impl Into<Approximated>) {
        let what = what.into();
        let instruction = self.program.instructions.len();
        let known =
            self.program.approximations.iter().rev().take_while(|a| a.instruction == instruction);
        if known.into_iter().all(|a| a.what != what) {
            self.program.approximate(instruction, what);
        }
    }

    /// Adds an instruction; its index.
    pub fn add(&mut self, timing: Option<TimingKey>, effects: Vec<Effect>, step: Step) -> usize {
        let mut effects = effects;
        let choices = &mut self.program.choices;
        let fits = self.spelled.effects(&mut effects, || {
            *choices += 1;
            ChoiceId(*choices - 1)
        });
        if !fits {
            self.approximate(Approximated::NoRoom);
        }
        let index = self.program.instructions.len();
        let raw = self.raw;
        let timing = timing.map(|key| self.with_operands(key));
        self.zone_of.push(self.zones.last().map(|&(_, opened)| opened));
        let text = raw.map_or_else(Arc::default, |raw| raw.text.clone());
        let operands = match (self.program.instructions.last(), raw) {
            (Some(last), _) if Arc::ptr_eq(&last.text, &text) => last.operands.clone(),
            (_, Some(raw)) => shown::operands(raw, self.family),
            (_, None) => Arc::default(),
        };
        self.program.instructions.push(Instruction {
            place: Location {
                file: self.file as u32,
                line: raw.map_or(1, |raw| raw.line),
                step: raw.and_then(|raw| raw.step),
            },
            block: self.program.blocks.max(1),
            text,
            operands,
            timing: timing.map(Box::new),
            effects,
            step,
        });
        index
    }

    /// Whether a block of so many words or bits, each read and written, can still be followed.
    pub fn has_room(&self, count: i64) -> bool {
        usize::try_from(count).is_ok_and(|count| self.spelled.has_room(2 * count))
    }

    /// Checks the number of operands.
    pub fn takes(&mut self, raw: &RawInstruction, count: usize) -> bool {
        let found = raw.operands.len();
        if found == count {
            return true;
        }
        let message = format!("`{}` takes {}, here are {found}", raw.mnemonic, operands(count));
        let part = raw.operands.get(count).map_or(raw.mnemonic.as_str(), String::as_str);
        self.fault(
            Code::OperandCount,
            part,
            message,
            "compare the line with the instruction's description",
        );
        false
    }

    /// A hidden bit that remembers something from one execution to the next.
    pub fn memory(&mut self) -> Cell {
        let cell = edge_memory(self.edges);
        self.edges += 1;
        if let Some(raw) = self.raw {
            let files = if self.project.files.len() > 1 {
                format!("{}:", self.project.files[self.file].program)
            } else {
                String::new()
            };
            self.program
                .names
                .insert(cell, format!("last scan of `{}` ({files}{})", raw.text, raw.line));
        }
        cell
    }
}

/// Whether the program names one of these special relays of the FX (`M8023`) or FX5 (`SM8023`), alone, among digits or
/// the devices that ZRST clears, or may by an index.
fn touches(project: &RawProject, family: Family, relays: &[u32]) -> bool {
    let instructions = project.files.iter().flat_map(|file| &file.instructions);
    let touched = |first: u32, last: u32| relays.iter().any(|relay| (first..=last).contains(relay));
    let in_name = |text: &String| match parse(text, family) {
        Ok(Operand::Device(device)) if matches!(device.name, "M" | "SM") => match device.place {
            operand::Place::At(_, relay) => touched(relay, relay),
            operand::Place::Digits(_, first, digits) => {
                // Blocks begin with them.
                touched(first, first + 4 * u32::from(digits) - 1)
                    || (first >= FIRST_SPECIAL && touched(first, u32::MAX))
            }
            operand::Place::Indexed(Kind::VolatileBit, _)
            | operand::Place::IndexedDigits(Kind::VolatileBit, _) => true,
            _ => false,
        },
        _ => false,
    };
    let number = |text: &String| match parse(text, family) {
        Ok(Operand::Device(operand::Device { place: operand::Place::At(_, at), .. })) => Some(at),
        _ => None,
    };
    let mut instructions = instructions;
    instructions.any(|raw| {
        let between = match &raw.operands[..] {
            [first, last] if upper(&raw.mnemonic).starts_with("ZRST") => {
                number(first).zip(number(last)).is_some_and(|(from, to)| touched(from, to))
            }
            _ => false,
        };
        between || raw.operands.iter().any(in_name)
    })
}

/// Whether the program has such an instruction.
fn has(project: &RawProject, mnemonic: &str) -> bool {
    let mut instructions = project.files.iter().flat_map(|file| &file.instructions);
    instructions.any(|raw| raw.mnemonic.eq_ignore_ascii_case(mnemonic))
}

/// From here on the FX's relays are special ones.
const FIRST_SPECIAL: u32 = 8000;

/// Which files' programs need not run in every scan: those that are called by name are commonly on standby, and
/// those that are stopped rest. An operand that is no name may be any of them.
fn may_rest(project: &RawProject) -> Vec<bool> {
    let mut rests = vec![false; project.files.len()];
    for raw in project.files.iter().flat_map(|file| &file.instructions) {
        let mnemonic = upper(&raw.mnemonic);
        let names = ["ECALL", "EFCALL", "PSTOP", "POFF", "PSCAN", "PLOW"];
        let is_named =
            |name: &&str| mnemonic.strip_prefix(*name).is_some_and(|p| ["", "P"].contains(&p));
        if !names.iter().any(is_named) {
            continue;
        }
        let text = raw.operands.first().map_or("", String::as_str).trim_matches('"');
        let stem = text.split('.').next().unwrap_or(text);
        let named = project.files.iter().position(|f| f.program.eq_ignore_ascii_case(stem));
        match named {
            Some(file) => rests[file] = true,
            None => rests.fill(true),
        }
    }
    rests
}

/// `1 operand`, `3 operands`.
fn operands(count: usize) -> String {
    match count {
        0 => "no operand".to_owned(),
        1 => "1 operand".to_owned(),
        n => format!("{n} operands"),
    }
}

/// How an instruction is priced: by its name with the letters of its device, by its name, then, where it acts on the
/// rising edge, the same without the pulse suffix. The kinds of its operands are added with the instruction.
pub fn timing(
    mnemonic: &str,
    pulsed: bool,
    letters: Option<&str>,
    class: &'static str,
    units: Units,
    dearer: bool,
) -> TimingKey {
    let mut names = Vec::with_capacity(2);
    let base = if pulsed { super::catalog::unpulsed(mnemonic) } else { None };
    for name in [Some(mnemonic.to_owned()), base].into_iter().flatten() {
        names.extend(letters.map(|letters| [&name, ":", letters].concat()));
        names.push(name);
    }
    let touched = Touched::default();
    TimingKey { names, class, units, dearer, optional: false, touched }
}

/// How a control instruction is priced: by its name alone.
pub fn key(mnemonic: &str, class: &'static str) -> TimingKey {
    // What always fires has one time: the dearer.
    let dearer = matches!(class, "nothing" | "loop")
        || matches!(mnemonic, "RET" | "RETSTL" | "SRET" | "IRET" | "MCR" | "JMP");
    timing(mnemonic, false, None, class, Units::None, dearer)
}

/// An effect whenever the instruction is reached.
pub fn always(write: Write) -> Effect {
    Effect { when: When::Always, write }
}

/// An effect where the instruction fires.
pub fn fired(write: Write) -> Effect {
    Effect { when: When::Fired, write }
}

/// Rising (or falling) edge of a value against a remembered one.
pub fn edge(rising: bool, value: Logic, memory: Cell) -> Logic {
    let before = Logic::cell(memory);
    if rising {
        Logic::All(vec![value, before.not()])
    } else {
        Logic::All(vec![value.not(), before])
    }
}
