//! Emits a MELSEC project, instruction by instruction, as a program without a dialect.

mod access;
mod application;
mod blocks;
mod compare;
mod control;
mod edges;
mod errors;
mod exact;
mod finish;
mod held;
mod masters;
mod meaning;
mod named;
mod now;
mod output;
mod overflow;
mod quirks;
mod ranges;
mod rungs;
mod scan_control;
mod shown;
mod units;

use super::frame::Frame;
use super::memory::{Family, area, areas, edge_memory, networks, power_up};
use super::operand::Operand;
use super::resolve::{Category, DecodeOptions, Item, Resolved, miscounted};
use super::source::RawInstruction;
use edges::Edges;
use finish::Routes;
use masters::State;
use now::Now;
use quirks::Quirks;
use rungs::Rung;
use scanbound_base::code::Code;
use scanbound_base::location::Location;
use scanbound_front::Faults;
use scanbound_front::builder::{Builder, always};
use scanbound_ir::{
    AccessedDevices, Approximated, Cell, Effect, Logic, Program, Region, SourceFile, Step,
    TimingKey, Units, Write,
};
use std::sync::Arc;

/// A target still to be found.
const OPEN: usize = usize::MAX;

/// A project while it is emitted: what it is made of, and in parts what is known so far. The files beside this one say
/// what each kind of instruction does, and change the parts that they own.
pub struct Emitter<'a> {
    resolved: &'a Resolved<'a>,
    frame: &'a Frame,
    options: &'a DecodeOptions<'a>,
    family: Family,
    out: Builder,
    faults: Vec<Faults<'a>>,
    /// What switches in the project change of instructions' meaning.
    quirks: Quirks,
    /// The instruction under way.
    now: Now<'a>,
    /// The rung under way.
    rung: Rung,
    /// Bits that remember something from one execution to the next.
    edges: Edges,
    /// What may be written through indirect addresses, if that is stated.
    indirect: Option<Vec<Region>>,
    /// Where control goes.
    routes: Routes,
    /// The open state of a step ladder.
    state: Option<State>,
}

impl<'a> Emitter<'a> {
    /// Before the first file. `faults` are those that the stages before have told.
    pub(super) fn new(
        resolved: &'a Resolved<'a>,
        frame: &'a Frame,
        options: &'a DecodeOptions<'a>,
        faults: Vec<Faults<'a>>,
    ) -> Self {
        let project = resolved.project;
        let cpu = project.files.iter().find_map(|file| file.cpu.clone());
        let program = Program {
            dialect: project.dialect.to_owned(),
            cpu,
            areas: areas(options.family),
            networks: networks(options.family),
            power_up: power_up(options.family),
            scan_control: scan_control::of_family(options.family),
            comments: shown::comments(&project.comments, options.family),
            ..Program::default()
        };
        let quirks = Quirks::of(&resolved.items, options.family);
        Emitter {
            resolved,
            frame,
            options,
            family: options.family,
            out: Builder::new(program),
            faults,
            indirect: ranges::indirect(options, quirks.switches_file_register),
            quirks,
            now: Now::default(),
            rung: Rung::default(),
            edges: Edges::default(),
            routes: Routes::default(),
            state: None,
        }
    }

    /// Emits a file.
    pub(super) fn file(&mut self, file: usize) {
        let resolved = self.resolved;
        let items = resolved.files[file].clone();
        let first = self.out.next();
        self.now = Now::of(file);
        self.rung = Rung::default();
        self.out.program.instructions.reserve(items.len());
        if let Some(end) = self.frame.rest(file) {
            self.rest(end);
        }
        for at in items {
            let item = &resolved.items[at];
            // What ends a state belongs to its end.
            self.now.begin(at, item);
            let raw = item.raw;
            let place = Location { file: file as u32, line: raw.line, step: raw.step };
            self.out.at(place, raw.text.clone(), shown::operands(raw, &item.operands));
            self.leave_state(self.frame.site(at).state);
            let first = self.out.next();
            self.instruction(item);
            self.note_scan_control(item, first);
            self.direct_inputs(item);
            // What follows so many faults is no program either.
            if self.faults[file].give_up() {
                return;
            }
        }
        self.check_rung();
        self.leave_state(None);
        self.now = Now::of(file);
        let last = self.out.next();
        match self.frame.on_standby(file) {
            true => self.out.program.standby.push(file),
            false => self.out.program.mains.push(first..last),
        }
        let raw = &resolved.project.files[file];
        self.out.program.files.push(SourceFile {
            name: raw.name.clone(),
            instructions: first..last,
            count: raw.instructions.len(),
        });
    }

    /// A program that need not run in every scan: it may go to its end at once. No line of the source says so: reports name
    /// the jump by what it stands for.
    fn rest(&mut self, end: usize) {
        let file = self.now.file;
        let place = Location { file: file as u32, line: 1, step: None };
        let text = format!("{} on standby", self.resolved.project.files[file].program);
        self.out.at(place, text.into(), Arc::default());
        self.approximate(
            "this program is called or stopped by instructions: it may run by itself in the scan or not",
        );
        let fires = self.free_bit();
        let at = self.add(None, Vec::new(), Step::Jump { fires, target: OPEN });
        self.routes.leads(at, end);
    }

    /// What is read as `DX` is then found in `X` as well.
    fn direct_inputs(&mut self, item: &Item<'_>) {
        let is_direct = |operand: &Result<Operand, String>| matches!(operand, Ok(Operand::Device(device)) if device.name == "DX");
        if !item.operands.iter().any(is_direct) {
            return;
        }
        self.approximate("a direct input refreshes X: any X is taken as any value");
        let choice = self.choice();
        let lost = always(Write::Havoc(Region::Area(area("X")), choice));
        self.add(None, vec![lost], Step::Nothing);
    }

    /// Emits one instruction; each kind has its file.
    fn instruction(&mut self, item: &Item<'_>) {
        let (name, raw) = (&*item.name, item.raw);
        match &item.category {
            &Category::Contact { join, rising, negated } => {
                self.contact(name, raw, join, rising, negated);
            }
            &Category::Comparison { join, sort, relation } => {
                self.comparison(name, raw, join, sort, relation);
            }
            &Category::ProgramCheck(join) => self.program_check(name, raw, join),
            Category::Block => self.block(name, raw),
            Category::Branch => self.branch(name, raw),
            Category::Result => self.result(name, raw),
            &Category::Control(control) => self.control(item, control),
            Category::Coil => self.coil(name, raw),
            Category::Listed(found) => self.listed(name, raw, found),
            Category::User => self.user(raw),
            Category::Unknown { is_output: true } => _ = self.output_here(name),
            Category::Unknown { is_output: false } => {}
        }
    }

    /// Notes a fault at the instruction under way; `part` is a slice of it or a word of it.
    pub fn fault(&mut self, code: Code, part: &str, message: impl Into<String>, help: &str) {
        let Some(raw) = self.now.raw.filter(|_| !self.now.quiet) else { return };
        let file = &self.resolved.project.files[self.now.file];
        let found = raw.caret(file).at(part, code, &file.name, message, help).at_step(raw.step);
        self.faults[self.now.file].push(found);
    }

    /// Lists what is taken wider than it is at the instruction about to be added.
    pub fn approximate(&mut self, what: impl Into<Approximated>) {
        let what = what.into();
        let instruction = self.out.next();
        let known = self
            .out
            .program
            .approximations
            .iter()
            .rev()
            .take_while(|a| a.instruction == instruction);
        if known.into_iter().all(|a| a.what != what) {
            self.out.program.approximate(instruction, what);
        }
    }

    /// Adds an instruction; its index.
    pub fn add(&mut self, timing: Option<TimingKey>, effects: Vec<Effect>, step: Step) -> usize {
        let effects = self.pointed(effects);
        let timing = timing.map(|key| self.with_operands(key));
        let at = self.out.add(timing, effects, step);
        let mut errors = std::mem::take(&mut self.now.errors);
        let error = if errors.len() > 1 { Some(Logic::Any(errors)) } else { errors.pop() };
        self.out.program.errors.extend(error.map(|error| (at, error)));
        at
    }

    /// Whether a block of so many words or bits, each read and written, can still be followed.
    pub fn has_room(&self, count: i64) -> bool {
        usize::try_from(count).is_ok_and(|count| self.out.has_room(2 * count))
    }

    /// Checks the number of operands.
    pub fn takes(&mut self, raw: &RawInstruction, count: usize) -> bool {
        let file = &self.resolved.project.files[self.now.file];
        let fault = miscounted(raw, file, count);
        let fits = fault.is_none();
        fault.into_iter().for_each(|fault| self.faults[self.now.file].push(fault));
        fits
    }

    /// A hidden bit that remembers something from one execution to the next.
    pub fn memory(&mut self) -> Cell {
        let cell = edge_memory(self.edges.count);
        self.edges.count += 1;
        if let Some(raw) = self.now.raw {
            let files = if self.resolved.project.files.len() > 1 {
                format!("{}:", self.resolved.project.files[self.now.file].program)
            } else {
                String::new()
            };
            self.out
                .program
                .names
                .insert(cell, format!("last scan of `{}` ({files}{})", raw.text, raw.line));
        }
        cell
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
    let touched = AccessedDevices::default();
    TimingKey { names, class, units, use_larger_time: dearer, optional: false, accessed: touched }
}

/// How a control instruction is priced: by its name alone.
pub fn key(mnemonic: &str, class: &'static str) -> TimingKey {
    // What always fires has one time: the dearer.
    let dearer = matches!(class, "nothing" | "loop")
        || matches!(mnemonic, "RET" | "RETSTL" | "SRET" | "IRET" | "MCR" | "JMP");
    timing(mnemonic, false, None, class, Units::None, dearer)
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
