//! Lowers a MELSEC project, instruction by instruction, to a program of `ir`.

mod access;
mod accessed;
mod application;
mod blocks;
mod choices;
mod coils_off;
mod compare;
mod control;
mod current;
mod edges;
mod errors;
mod finish;
mod labels;
mod meaning;
mod modes;
mod output;
mod overflow;
mod ranges;
mod regions;
mod rungs;
mod scan_control;
mod units;

use super::memory::{Family, area, areas, edge_memory, networks, power_up};
use super::operand::Operand;
use super::resolve::{Category, DecodeOptions, Item, Resolved, miscounted};
use super::source::RawInstruction;
use super::structure::Structure;
use current::CurrentInstruction;
use edges::Edges;
use finish::JumpTargets;
use modes::Modes;
use regions::LadderState;
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

/// The placeholder for a target that is not resolved yet.
const OPEN: usize = usize::MAX;

/// The lowering of a project. Each file of this module handles one type of instruction, and adds its methods here.
pub struct Lowering<'a> {
    resolved: &'a Resolved<'a>,
    structure: &'a Structure,
    options: &'a DecodeOptions<'a>,
    family: Family,
    out: Builder,
    faults: Vec<Faults<'a>>,
    /// The special relays in use that change the meaning of instructions.
    modes: Modes,
    /// The instruction that is being lowered.
    current: CurrentInstruction<'a>,
    /// The rung that is being lowered.
    rung: Rung,
    /// The hidden bits for edges.
    edges: Edges,
    /// The regions that may be written through indirect addresses, if stated.
    indirect: Option<Vec<Region>>,
    /// Jump and call targets.
    targets: JumpTargets,
    /// The open state of a step ladder.
    state: Option<LadderState>,
}

impl<'a> Lowering<'a> {
    /// Starts the lowering. `faults` are the errors of the stages before.
    pub(super) fn new(
        resolved: &'a Resolved<'a>,
        structure: &'a Structure,
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
            comments: labels::comments(&project.comments, options.family),
            ..Program::default()
        };
        let modes = Modes::of(&resolved.items, options.family);
        Lowering {
            resolved,
            structure,
            options,
            family: options.family,
            out: Builder::new(program),
            faults,
            indirect: ranges::indirect(options, modes.switches_file_register),
            modes,
            current: CurrentInstruction::default(),
            rung: Rung::default(),
            edges: Edges::default(),
            targets: JumpTargets::default(),
            state: None,
        }
    }

    /// Lowers one file.
    pub(super) fn file(&mut self, file: usize) {
        let resolved = self.resolved;
        let items = resolved.files[file].clone();
        let first = self.out.next();
        self.current = CurrentInstruction::of(file);
        self.rung = Rung::default();
        self.out.program.instructions.reserve(items.len());
        if let Some(end) = self.structure.skip_target(file) {
            self.lower_skip(end);
        }
        for at in items {
            let item = &resolved.items[at];
            // The instruction that ends a state is still part of it.
            self.current.begin(at, item);
            let raw = item.raw;
            let place = Location { file: file as u32, line: raw.line, step: raw.step };
            self.out.at(place, raw.text.clone(), labels::operands(raw, &item.operands));
            self.leave_state(self.structure.site(at).state);
            let first = self.out.next();
            self.instruction(item);
            self.note_scan_control(item, first);
            self.direct_inputs(item);
            // After this many errors, the file is not a program.
            if self.faults[file].give_up() {
                return;
            }
        }
        self.check_rung();
        self.leave_state(None);
        self.current = CurrentInstruction::of(file);
        let last = self.out.next();
        match self.structure.on_standby(file) {
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

    /// Emits the jump by which a program that need not run in every scan may skip to its end. No source line says this,
    /// so reports show a description of the jump.
    fn lower_skip(&mut self, end: usize) {
        let file = self.current.file;
        let place = Location { file: file as u32, line: 1, step: None };
        let text = format!("{} on standby", self.resolved.project.files[file].program);
        self.out.at(place, text.into(), Arc::default());
        self.approximate(
            "instructions call or stop this program: it may or may not run in this scan",
        );
        let fires = self.free_bit();
        let at = self.add(None, Vec::new(), Step::Jump { fires, target: OPEN });
        self.targets.add_jump(at, end);
    }

    /// A read of `DX` refreshes `X`, too.
    fn direct_inputs(&mut self, item: &Item<'_>) {
        let is_direct = |operand: &Result<Operand, String>| matches!(operand, Ok(Operand::Device(device)) if device.name == "DX");
        if !item.operands.iter().any(is_direct) {
            return;
        }
        self.approximate("a direct input refreshes X: any X may have any value");
        let choice = self.choice();
        let lost = always(Write::Havoc(Region::Area(area("X")), choice));
        self.add(None, vec![lost], Step::Nothing);
    }

    /// Lowers one instruction.
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

    /// Reports an error at the current instruction; `part` is a slice of it or one of its words.
    pub fn fault(&mut self, code: Code, part: &str, message: impl Into<String>, help: &str) {
        let Some(raw) = self.current.raw.filter(|_| !self.current.quiet) else { return };
        let file = &self.resolved.project.files[self.current.file];
        let found = raw.caret(file).at(part, code, &file.name, message, help).at_step(raw.step);
        self.faults[self.current.file].push(found);
    }

    /// Lists an over-approximation at the instruction to be added next.
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

    /// Adds an instruction and returns its index.
    pub fn add(&mut self, timing: Option<TimingKey>, effects: Vec<Effect>, step: Step) -> usize {
        let effects = self.pointed(effects);
        let timing = timing.map(|key| self.with_operands(key));
        let at = self.out.add(timing, effects, step);
        let mut errors = std::mem::take(&mut self.current.errors);
        let error = if errors.len() > 1 { Some(Logic::Any(errors)) } else { errors.pop() };
        self.out.program.errors.extend(error.map(|error| (at, error)));
        at
    }

    /// Whether the cell budget allows a block of this many words or bits, each read and written.
    pub fn has_room(&self, count: i64) -> bool {
        usize::try_from(count).is_ok_and(|count| self.out.has_room(2 * count))
    }

    /// Checks the number of operands, and reports an error if it is wrong.
    pub fn takes(&mut self, raw: &RawInstruction, count: usize) -> bool {
        let file = &self.resolved.project.files[self.current.file];
        let fault = miscounted(raw, file, count);
        let fits = fault.is_none();
        fault.into_iter().for_each(|fault| self.faults[self.current.file].push(fault));
        fits
    }

    /// A new hidden bit that keeps its value from one execution to the next.
    pub fn memory(&mut self) -> Cell {
        let cell = edge_memory(self.edges.count);
        self.edges.count += 1;
        if let Some(raw) = self.current.raw {
            let files = if self.resolved.project.files.len() > 1 {
                format!("{}:", self.resolved.project.files[self.current.file].program)
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

/// The key for an instruction's time: its name with the letters of its device, its name, and for a pulse form the name without
/// the suffix. The operand types are added when the instruction is added.
pub fn timing(
    mnemonic: &str,
    pulsed: bool,
    letters: Option<&str>,
    class: &'static str,
    units: Units,
    use_larger_time: bool,
) -> TimingKey {
    let mut names = Vec::with_capacity(2);
    let base = if pulsed { super::catalog::unpulsed(mnemonic) } else { None };
    for name in [Some(mnemonic.to_owned()), base].into_iter().flatten() {
        names.extend(letters.map(|letters| [&name, ":", letters].concat()));
        names.push(name);
    }
    let touched = AccessedDevices::default();
    TimingKey { names, class, units, use_larger_time, optional: false, accessed: touched }
}

/// The key of a control instruction: its name only.
pub fn key(mnemonic: &str, class: &'static str) -> TimingKey {
    // These always fire, so the table may give two times; the larger one counts.
    let use_larger_time = matches!(class, "nothing" | "loop")
        || matches!(mnemonic, "RET" | "RETSTL" | "SRET" | "IRET" | "MCR" | "JMP");
    timing(mnemonic, false, None, class, Units::None, use_larger_time)
}

/// The rising or falling edge of a value, compared with a remembered one.
pub fn edge(rising: bool, value: Logic, memory: Cell) -> Logic {
    let before = Logic::cell(memory);
    if rising {
        Logic::All(vec![value, before.not()])
    } else {
        Logic::All(vec![value.not(), before])
    }
}
