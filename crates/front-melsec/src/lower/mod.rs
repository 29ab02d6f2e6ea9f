//! Lowers a MELSEC project, instruction by instruction, to a program of `ir`.

mod access;
mod accessed;
mod application;
mod blocks;
mod choices;
mod coils_off;
mod compare;
mod control;
mod devices;
mod edges;
mod errors;
mod finish;
mod indirect;
mod labels;
mod meaning;
mod modes;
mod named;
mod output;
mod overflow;
mod ranges;
mod regions;
mod rungs;
mod scan_control;
mod state;
mod units;
mod written;

use super::memory::{area, areas, networks, power_up};
use super::operand::Operand;
use super::resolve::{Category, DecodeOptions, Item, Resolved};
use super::structure::Structure;
use modes::Modes;
use scanbound_base::location::Location;
use scanbound_front::Faults;
use scanbound_front::builder::{Builder, always};
use scanbound_ir::{BitSource, ChoiceKind, Logic, Program, Region, SourceFile, Step, Write};
pub(super) use state::Lowering;
use state::{CurrentInstruction, Edges, JumpTargets, OPEN, RungState};
use std::sync::Arc;

impl<'a> Lowering<'a> {
    /// Starts the lowering. `faults` are the errors that earlier stages found, one entry for each file.
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
        let written_by_others = |relays: &[u32]| {
            let is_one = |text: &String| {
                let is_in = |relay: String| ranges::has_special(text, &relay, options.family);
                relays.iter().any(|relay| is_in(format!("M{relay}")) || is_in(format!("SM{relay}")))
            };
            ranges::others_write(structure, options, is_one)
        };
        let modes = Modes::of(&resolved.items, options.family, written_by_others);
        let mut lowering = Lowering {
            resolved,
            structure,
            options,
            family: options.family,
            out: Builder::new(program),
            faults,
            indirect: ranges::indirect(options, modes.switches_file_register),
            modes,
            current: CurrentInstruction::default(),
            rung: RungState::default(),
            edges: Edges::default(),
            targets: JumpTargets::default(),
            carry: None,
            block_result: None,
            state: None,
        };
        if lowering.modes.reads_block_result {
            let cell = lowering.memory();
            lowering.out.program.names.insert(cell, "SM704".to_owned());
            lowering.block_result = Some(cell);
        }
        lowering.modes.index_is_open = lowering.writes_other_indices();
        // Others may write an index register as a special register, which has no cell of its own.
        let external = options.facts.external.iter();
        let external = external.filter_map(|text| ranges::written(text, options.family, false));
        lowering.note_devices();
        let indices = external.flatten().filter(|region| matches!(region, Region::Area(_)));
        lowering.out.program.external.extend(indices);
        lowering
    }

    pub(super) fn file(&mut self, file: usize) {
        let resolved = self.resolved;
        let items = resolved.files[file].clone();
        let first = self.out.next();
        self.current = CurrentInstruction::of(file);
        self.rung = RungState::default();
        self.carry = None;
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
            "instructions call, start or stop this program: the bound covers scans in which the program runs and scans in which it does not",
        );
        // A program that other programs call may have the type standby: a real run's CPU calls it, and it does not run
        // by itself. If instructions start and stop programs, it is unknown.
        let runs_itself = self.choice();
        if !self.resolved.starts_programs() {
            self.out.program.kinds.insert(runs_itself, ChoiceKind::Parameter);
        }
        let fires = Logic::Bit(BitSource::Free(runs_itself)).not();
        let at = self.add(None, Vec::new(), Step::Jump { fires, target: OPEN });
        self.targets.add_jump(at, end);
    }

    /// After an instruction with a direct input (`DX`), lets every `X` have any value, because a direct input also
    /// refreshes `X`.
    fn direct_inputs(&mut self, item: &Item<'_>) {
        let is_direct = |operand: &Result<Operand, String>| matches!(operand, Ok(Operand::Device(device)) if device.name == "DX");
        if !item.operands.iter().any(is_direct) {
            return;
        }
        self.approximate(
            "a direct input (DX) refreshes X while the scan runs: every X may have any value",
        );
        let choice = self.choice();
        let lost = always(Write::Havoc(Region::Area(area("X")), choice));
        self.add(None, vec![lost], Step::Nothing);
    }

    fn instruction(&mut self, item: &Item<'_>) {
        let (name, raw) = (&*item.name, item.raw);
        let is_contact = matches!(
            item.category,
            Category::Contact { .. }
                | Category::Comparison { .. }
                | Category::Block
                | Category::Branch
                | Category::Result
        );
        self.carry = self.carry.filter(|_| is_contact);
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
            Category::Listed(found) => self.application(name, raw, found),
            Category::User => self.user(raw),
            Category::Unknown { is_output: true } => _ = self.output_here(name),
            Category::Unknown { is_output: false } => {}
        }
    }
}
