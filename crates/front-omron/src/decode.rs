//! Decodes an OMRON project to a program of `ir`, and returns all errors at once.

use scanbound_base::code::Code;
use std::collections::{BTreeMap, BTreeSet};

use super::accessed;
use super::builder::OmronBuilder;
use super::catalog::{Amount, Extent, Role};
use super::extent;
use super::lower::{CallSite, Lowering};
use super::memory::Memory;
use super::operand::{Expected, Operand, Reader};
use super::resolve::{Item, resolve};
use super::source::{Family, RawFile, RawProgram, RawProject, Symbols, Task};
use super::structure::{Structure, structure};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Part;
use scanbound_base::time::Picos;
use scanbound_front::{Faults, Options, absent};
use scanbound_ir::{
    BitSource, Cell, Effect, Logic, Program, Region, SourceFile, StartRange, Step, When, Write,
    flow,
};

/// If the project has this many errors, further errors about stated ranges are not listed.
const MAX_FAULTS: usize = 100;

/// The largest number of instructions. The largest CPUs hold 400 K steps; a contact takes one step, most other
/// instructions two to seven.
const MAX_INSTRUCTIONS: usize = 300 * 1024;

/// Returns an error for a project that has more instructions than any CPU can hold.
fn too_many(project: &RawProject) -> Result<(), Vec<Diagnostic>> {
    let mut instructions = project.files.iter().flat_map(|file| {
        let own = file.programs.iter().flat_map(|program| &program.instructions);
        own.map(move |instruction| (file, instruction))
    });
    let Some((file, instruction)) = instructions.nth(MAX_INSTRUCTIONS) else { return Ok(()) };
    Err(vec![Diagnostic::line(
        Code::TooMany,
        &file.name,
        instruction.line,
        &*instruction.text,
        format!("the project has more than {MAX_INSTRUCTIONS} instructions"),
        "check the file: no CPU can hold so many instructions",
    )])
}

/// Lowers a project to a program of `ir`.
///
/// # Errors
/// The errors of the files and of the stated facts. For each program, at most 50 errors in names and operands are
/// listed, or else at most 50 in its control structure; errors found later are all listed. A project with more
/// instructions than any CPU can hold gives that error alone.
pub fn decode(project: &RawProject, options: &Options<'_>) -> Result<Program, Vec<Diagnostic>> {
    too_many(project)?;
    let memory = Memory { family: project.family };
    let mut decoder = Decoder {
        builder: OmronBuilder::new(memory, project.dialect),
        faults: Vec::new(),
        routines: BTreeMap::new(),
        calls: Vec::new(),
        tasks: Vec::new(),
        bodies: Vec::new(),
        switches: false,
        interrupted: Interrupted::default(),
        unmasked: false,
        shared: memory.family == Family::C
            && project.files.iter().map(|file| file.programs.len()).sum::<usize>() > 1,
        used: [BTreeMap::new(), BTreeMap::new()],
    };
    decoder.builder.fast = fast_timers(project, memory);
    for file in &project.files {
        decoder.file(file, options);
    }
    decoder.connect(project, options);
    decoder.ranges(project, options);
    super::loops::apply_stated_ranges(&mut decoder.builder);
    decoder.arrange(project, options);
    let Decoder { mut builder, mut faults, used: [read, written], .. } = decoder;
    builder.reset_counters();
    builder.widen_shared_counters();
    // A written word is an output. Other words are inputs, and so are words with a single bit that is read but not
    // written.
    let is_input = |(word, bits): &(&u32, &u16)| match written.get(word) {
        None => true,
        Some(written) => **bits & !written != 0,
    };
    let inputs = read.iter().filter(is_input).count();
    builder.out.program.networks = builder.memory.networks();
    builder.out.program.power_up = builder.memory.power_up();
    builder.out.program.scan_control.by_parameters = Some("minimum cycle time");
    builder.out.program.points = Some([inputs, written.len()].map(|words| 16 * words as u32));
    faults.append(&mut builder.faults);
    if !faults.is_empty() {
        faults.sort_by_key(|fault| (position(project, &fault.file), fault.line));
        return Err(faults);
    }
    let blocks = builder.out.program.instructions.iter().map(|one| one.block);
    builder.out.program.blocks = blocks.max().unwrap_or(0);
    builder.out.program.cpu = project.files.iter().find_map(|file| file.cpu.clone());
    builder.out.program.approximations.sort();
    builder.out.program.approximations.dedup();
    Ok(builder.out.program)
}

/// The name for interrupt tasks whose programs are missing.
const UNLISTED: &str = "unlisted tasks";
/// The largest number of input and output words of any CPU.
const MAX_POINTS: u32 = 320;

/// The subroutines that the instructions INT, STIM and CTBL (C series) let interrupts run. Where one of these
/// instructions occurs, interrupts may also run each subroutine that nothing calls, even if it is not listed here.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Interrupted {
    /// Whether the program has an instruction that lets interrupts run subroutines.
    any: bool,
    /// Whether interrupts may run any subroutine, because a table in memory selects it.
    all: bool,
    /// The numbers of the subroutines that interrupts may run.
    numbers: BTreeSet<u32>,
}

impl Interrupted {
    /// Records what an instruction enables, if it enables interrupts.
    fn note_interrupts(&mut self, item: &Item<'_>, family: Family) {
        if family != Family::C {
            return;
        }
        match item.name.as_str() {
            // Input interrupts run subroutines 0 to 15, a scheduled interrupt runs 99.
            "INT" => self.numbers.extend((0..16).chain([99])),
            "STIM" => match item.operands.get(2).and_then(|operand| operand.count(family)) {
                Some(number) => self.numbers.extend([number]),
                None => self.all = true,
            },
            "CTBL" => self.all = true,
            _ => return,
        }
        self.any = true;
    }

    fn may_run(&self, number: u32) -> bool {
        self.all || self.numbers.contains(&number)
    }
}

/// The completion flags of timers that may time out between instructions: of all timers with a time base of 10 ms or
/// less. If one of these is at an unknown address, the flags of all timers.
fn fast_timers(project: &RawProject, memory: Memory) -> BTreeSet<Cell> {
    let none = BTreeSet::new();
    let mut found = BTreeSet::new();
    for (file, program) in project
        .files
        .iter()
        .flat_map(|file| file.programs.iter().map(move |program| (file, program)))
    {
        let reader = Reader { memory, symbols: [&program.symbols, &file.symbols], fast: &none };
        for raw in program.instructions.iter().filter(|raw| super::timers::is_fast(raw)) {
            let flag =
                raw.operands.first().map(|text| reader.read(text, Expected::Completion("T")));
            match flag {
                Some(Ok(Operand::Flag(cell))) => _ = found.insert(cell),
                // At an unknown address: any timer.
                Some(Ok(_)) => found.extend(memory.timers()),
                _ => {}
            }
        }
    }
    found
}

fn position(project: &RawProject, file: &str) -> usize {
    project.files.iter().position(|other| other.name == file).unwrap_or(usize::MAX)
}

/// A subroutine, with the range of its lowered instructions: to find recursive calls and those that interrupts may run.
struct Body {
    program: usize,
    number: u32,
    global: bool,
    range: std::ops::Range<usize>,
}

struct Decoder {
    builder: OmronBuilder,
    faults: Vec<Diagnostic>,
    /// The first instruction of each subroutine, by program, by whether it is global, and by number.
    routines: BTreeMap<(usize, bool, u32), usize>,
    /// The calls, each with its program, and with the error for the case that the subroutine is missing.
    calls: Vec<(usize, CallSite, Diagnostic)>,
    /// The lowered programs: task, name, range of instructions, and the index of END.
    tasks: Vec<(Task, String, std::ops::Range<usize>, usize)>,
    bodies: Vec<Body>,
    switches: bool,
    /// The subroutines that interrupts may run (C series).
    interrupted: Interrupted,
    /// Whether the program enables interrupts that run tasks (CS, CJ and CP).
    unmasked: bool,
    /// Whether programs call subroutines of each other, as several programs of the C series do.
    shared: bool,
    /// Input and output words by their numbers: first those that the program reads, then those that it writes. Each has
    /// a mask of the bits that are used; a read of a whole word adds no bits to it.
    used: [BTreeMap<u32, u16>; 2],
}

impl Decoder {
    fn file(&mut self, file: &RawFile, options: &Options<'_>) {
        let start = self.builder.next();
        let mut count = 0;
        self.builder.file = self.builder.out.program.files.len() as u32;
        self.builder.out.program.files.push(SourceFile {
            name: file.name.clone(),
            instructions: start..start,
            count: 0,
        });
        for program in &file.programs {
            count += program.instructions.len();
            self.program(file, program, options);
        }
        let end = self.builder.next();
        if let Some(source) = self.builder.out.program.files.last_mut() {
            (source.instructions, source.count) = (start..end, count);
        }
        for symbols in file.programs.iter().map(|program| &program.symbols).chain([&file.symbols]) {
            self.comments(symbols);
        }
    }

    /// Records the comment of each symbol, or its name, as the comment of the device at its address.
    fn comments(&mut self, symbols: &Symbols) {
        let fast = BTreeSet::new();
        let reader =
            Reader { memory: self.builder.memory, symbols: [symbols, symbols], fast: &fast };
        for (name, symbol) in symbols {
            let want = if symbol.kind.to_ascii_uppercase().starts_with("BOOL") {
                Expected::Bit
            } else {
                Expected::Word
            };
            let read = reader.read(&symbol.address, want).ok();
            let Some(device) = read.as_ref().and_then(accessed::device) else { continue };
            let text = match symbol.comment.trim() {
                "" => name.clone(),
                comment => format!("{name}: {comment}"),
            };
            self.builder.out.program.comments.entry(device).or_insert(text);
        }
    }

    fn program(&mut self, file: &RawFile, program: &RawProgram, options: &Options<'_>) {
        let memory = self.builder.memory;
        let fast = self.builder.fast.clone();
        let reader = Reader { memory, symbols: [&program.symbols, &file.symbols], fast: &fast };
        let mut faults = Faults::new(&file.name);
        let items: Vec<Item<'_>> = program
            .instructions
            .iter()
            .filter_map(|raw| {
                resolve(raw, &reader, options.is_user_instruction, &file.source, &mut faults)
            })
            .collect();
        let complete = !faults.any_error();
        for item in &items {
            self.count_points(item);
            self.interrupted.note_interrupts(item, memory.family);
            self.unmasked |=
                memory.family == Family::Cs && matches!(item.name.as_str(), "MSKS" | "CTBL");
        }
        let mut frame_faults = Faults::new(&file.name);
        let structure = structure(&items, memory.family, self.shared, &mut frame_faults);
        if items.is_empty() && complete {
            faults.push(Diagnostic::file(
                Code::EmptyProgram,
                &file.name,
                format!("the program {} has no instructions", program.name),
                "export the program again",
            ));
        }
        self.faults.extend(faults.into_diagnostics());
        // If instructions could not be resolved, errors of the structure may only follow from that.
        if complete {
            self.faults.extend(frame_faults.into_diagnostics());
        }
        let start = self.builder.next();
        let fault_count = self.builder.faults.len();
        let gate = match program.task {
            Task::Cyclic(_) => {
                let choice = self.builder.choice();
                let fires = Logic::Bit(BitSource::Free(choice));
                if let Some(first) = items.first() {
                    self.builder.at(first);
                }
                Some(self.builder.push(Step::Jump { fires, target: 0 }, Vec::new(), None))
            }
            _ => None,
        };
        self.builder.rung();
        self.clear_flags();
        let mut emitter = Lowering::new(&mut self.builder, &items, &structure);
        let end = emitter.run();
        let (starts, calls) =
            (std::mem::take(&mut emitter.starts), std::mem::take(&mut emitter.calls));
        self.switches |= emitter.switches;
        if !complete {
            // If instructions are missing, errors about branches may only follow from that.
            self.builder.faults.truncate(fault_count);
        }
        if let Some(gate) = gate
            && let Step::Jump { target, .. } = &mut self.builder.out.program.instructions[gate].step
        {
            *target = end;
        }
        self.note_scan_control(&items, &starts);
        self.collect(&items, &structure, &starts, calls, file);
        self.tasks.push((program.task, program.name.clone(), start..self.builder.next(), end));
    }

    /// Records by how much each WDT extends the cycle time monitoring time: 10 ms for each unit of its operand on CS,
    /// CJ and CP. The value for the C series (100 ms) is unverified, so no bound uses it. Also records whether an
    /// instruction may let interrupts wait.
    fn note_scan_control(&mut self, items: &[Item<'_>], starts: &[Option<usize>]) {
        const MS: u64 = 1_000_000_000;
        const MAX_UNITS: u32 = 0x0F9F;
        let family = self.builder.memory.family;
        let program = &mut self.builder.out.program;
        program.scan_control.holds_interrupts |=
            items.iter().any(|item| matches!(&*item.name, "DI" | "MSKS" | "INT"));
        for (item, &start) in items.iter().zip(starts).filter(|(item, _)| item.name == "WDT") {
            let Some(start) = start else { continue };
            let priced = program.instructions[start..].iter().position(|one| one.timing.is_some());
            let Some(at) = priced.map(|offset| start + offset) else { continue };
            let count = item.operands.first().and_then(|operand| operand.count(family));
            let count = count.map(u64::from);
            let times = match family {
                Family::C => (Picos::ZERO, Picos(100 * MS).times(count.unwrap_or(99))),
                _ => {
                    let unit = Picos(10 * MS);
                    (unit.times(count.unwrap_or(0)), unit.times(count.unwrap_or(MAX_UNITS.into())))
                }
            };
            program.scan_control.extensions.insert(at, times);
        }
    }

    /// Records the input and output words that an instruction accesses.
    fn count_points(&mut self, item: &Item<'_>) {
        let Some(row) = item.row else { return };
        let memory = self.builder.memory;
        let length = |amount| extent::length(memory, item, amount).unwrap_or(MAX_POINTS);
        let block = row.operands.iter().find_map(|slot| match slot.written_words() {
            Some(amount @ Amount::Counted { .. }) => Some(amount),
            _ => None,
        });
        for (slot, operand) in row.operands.iter().zip(&item.operands) {
            let (Operand::Word(cell) | Operand::Bit(cell, _)) = *operand else { continue };
            let (written, count) = match (slot.role, slot.extent) {
                // A block that is copied has the same length as its destination.
                (Role::Source, Extent::Words(Amount::Unknown)) => (0, block.map_or(1, length)),
                (Role::Source, Extent::Words(amount)) => (0, length(amount)),
                (
                    Role::Destination | Role::ReadWrite | Role::ReadWriteIfDevice,
                    Extent::Words(amount),
                ) => (1, length(amount)),
                (Role::Destination | Role::ReadWrite, _) => (1, 1),
                _ => (0, 1),
            };
            let words = (0..count.min(MAX_POINTS)).map(|n| cell.plus(n));
            // A read of a whole word may read bits that the program wrote.
            let bits = match *operand {
                Operand::Bit(_, bit) if count == 1 => 1 << bit,
                _ if written == 1 => u16::MAX,
                _ => 0,
            };
            for cell in words.filter(|cell| memory.is_point(*cell)) {
                *self.used[written].entry(cell.index).or_default() |= bits;
            }
        }
    }

    /// On CS, CJ and CP, adds before each program but the first that the condition flags, the index registers and the
    /// data registers may have any value, because the system changes them when a task begins.
    fn clear_flags(&mut self) {
        if self.builder.memory.family == Family::Cs && !self.tasks.is_empty() {
            let (first, count) = self.builder.memory.flags();
            let flags = Region::Range { first, count };
            let registers = self.builder.memory.registers().iter().copied().map(Region::Area);
            let effects = [flags].into_iter().chain(registers).map(|region| {
                let write = Write::Havoc(region, self.builder.choice());
                Effect { when: When::Always, write }
            });
            let effects = effects.collect();
            self.builder.push(Step::Nothing, effects, None);
        }
    }

    fn collect(
        &mut self,
        items: &[Item<'_>],
        structure: &Structure,
        starts: &[Option<usize>],
        calls: Vec<CallSite>,
        file: &RawFile,
    ) {
        let program = self.tasks.len();
        for routine in &structure.routines {
            let (Some(first), Some(last)) = (starts[routine.begin], starts[routine.end]) else {
                continue;
            };
            self.routines.insert((program, routine.global, routine.number), first);
            self.bodies.push(Body {
                program,
                number: routine.number,
                global: routine.global,
                range: first..last + 1,
            });
        }
        for call in calls {
            let raw = items[call.item].raw;
            // SBS of the CS series reaches only subroutines of its own program.
            let (place, first) = match self.builder.memory.family {
                Family::Cs if !call.global => {
                    ("this program", "give the whole program, correct the subroutine number")
                }
                _ => (
                    "the project",
                    "give the file that contains the subroutine too, correct the subroutine number",
                ),
            };
            let fault = Diagnostic::line(
                Code::NoSubroutine,
                &file.name,
                raw.line,
                scanbound_front::shown(&raw.text),
                format!("subroutine {} does not exist in {place}", call.number),
                absent::help(first, &call.routine()),
            );
            self.calls.push((program, call, fault.at_step(raw.step)));
        }
    }

    /// Connects each call with its subroutine, or with a substitute if the subroutine is missing, and reports recursive
    /// calls.
    fn connect(&mut self, project: &RawProject, options: &Options<'_>) {
        let shared = self.shared;
        let nothing = Symbols::new();
        let symbols = project.files.first().map_or(&nothing, |file| &file.symbols);
        let fast = BTreeSet::new();
        let memory = self.builder.memory;
        let reader = Reader { memory, symbols: [symbols, &nothing], fast: &fast };
        let written = |text: &str| written(&reader, text);
        self.faults.extend(absent::faults(options.facts, written));
        let mut graph: BTreeSet<(usize, usize)> = BTreeSet::new();
        let mut entries: Vec<(usize, usize, usize)> = Vec::new();
        for (program, call, fault) in &self.calls {
            let own = self.routines.get(&(*program, call.global, call.number));
            let others = self.routines.iter().filter(|((_, global, number), _)| {
                *number == call.number && *global == call.global
            });
            let found = own.or_else(|| {
                others.map(|(_, first)| first).next().filter(|_| shared || call.global)
            });
            let Some(&first) = found else {
                let name = call.routine();
                let stated = options.facts.calls.get(&name);
                if stated.is_none() && !options.absent_calls_take_no_time {
                    self.faults.push(fault.clone());
                    continue;
                }
                // A missing routine may change the condition flags.
                let (first, count) = memory.flags();
                let flags = [Region::Range { first, count }];
                let known = stated.map(|stated| absent::stated_routine(stated, written, &flags));
                self.builder.out.call_absent(call.at, &name, known);
                continue;
            };
            if let Step::Call { target, .. } =
                &mut self.builder.out.program.instructions[call.at].step
            {
                *target = first;
            }
            let caller = self.bodies.iter().position(|body| body.range.contains(&call.at));
            let callee = self.bodies.iter().position(|body| body.range.start == first);
            if let (Some(caller), Some(callee)) = (caller, callee) {
                graph.insert((caller, callee));
                entries.push((
                    caller,
                    callee,
                    self.calls.iter().position(|(_, other, _)| other.at == call.at).unwrap_or(0),
                ));
            }
        }
        for (caller, callee, at) in entries {
            if reaches(&graph, callee, caller) {
                let body = &self.bodies[callee];
                let mut fault = self.calls[at].2.clone();
                fault.code = Code::Recursion;
                fault.message = format!(
                    "subroutine {}{} calls itself, directly or through other subroutines",
                    if body.global { "G" } else { "" },
                    body.number
                );
                fault.help =
                    "remove the call: a recursive call can repeat without limit".to_owned();
                if body.program == self.calls[at].0 || body.global || shared {
                    self.faults.push(fault);
                }
            }
        }
    }

    /// Makes main routines of the programs that run in each scan, ordered by task number, and interrupt routines of
    /// those of interrupt tasks. A list of mnemonics is an interrupt routine if the facts state runs for its name.
    fn arrange(&mut self, project: &RawProject, options: &Options<'_>) {
        let mut tasks = std::mem::take(&mut self.tasks);
        tasks.sort_by_key(|(task, ..)| match task {
            Task::Each => (0, 0),
            Task::Cyclic(number) => (1, *number),
            Task::Interrupt(number) => (2, *number),
        });
        let cyclic = tasks.iter().filter(|(task, ..)| matches!(task, Task::Cyclic(_))).count();
        for (task, name, range, end) in tasks {
            // A list does not say when its program runs. If the facts state an interrupt of its name, it is an
            // interrupt program.
            if let (Task::Each, stated @ Some(_)) = (task, options.facts.interrupt(&name)) {
                self.builder.out.interrupt(name, range.start, stated);
                continue;
            }
            let Task::Interrupt(number) = task else {
                let gated = matches!(task, Task::Cyclic(_));
                self.add_task_switch(range.start, gated && (cyclic > 1 || self.switches), gated);
                self.builder.out.program.mains.push(range.start..end + 1);
                continue;
            };
            let label = format!("task {number}");
            let stated = [label.as_str(), name.as_str()]
                .into_iter()
                .find_map(|label| options.facts.interrupt(label));
            self.builder.out.interrupt(label, range.start, stated);
        }
        if self.builder.out.program.mains.is_empty() && self.faults.is_empty() {
            let name = project.files.first().map_or("", |file| &file.name);
            self.faults.push(Diagnostic::file(
                Code::NoProgram,
                name,
                "no program runs in every scan",
                "give the programs of the cyclic tasks too: the given programs run only as interrupt tasks, or are stated under [interrupts]",
            ));
        }
        self.uncalled(options);
        self.unlisted(options);
    }

    /// If tasks can be interrupted but the project has no interrupt program, adds an interrupt routine without
    /// instructions for the missing ones. Mnemonics lists do not show them.
    fn unlisted(&mut self, options: &Options<'_>) {
        if !self.unmasked || !self.builder.out.program.interrupts.is_empty() {
            return;
        }
        let stated = options.facts.interrupt(UNLISTED);
        if let Some(times) = stated.filter(|&times| times > 0) {
            let message = format!(
                "{times} runs of {UNLISTED} in a scan are stated, but no given file contains an interrupt program"
            );
            let help = "give the program files, and state the runs by file name, such as [interrupts] task2 = 1";
            self.faults.push(Diagnostic::file(Code::NoInterrupt, "", message, help));
        }
        let entry = self.builder.push(Step::Return, Vec::new(), None);
        self.builder.out.interrupt(UNLISTED.to_owned(), entry, stated);
        self.builder.approximate(
            "interrupts are enabled, but the interrupt programs are not among the files: the bound does not include their instructions",
        );
    }

    /// Makes interrupt routines of the subroutines that nothing calls or that interrupts may run, if interrupts are
    /// enabled (C series).
    fn uncalled(&mut self, options: &Options<'_>) {
        if self.interrupted == Interrupted::default() {
            return;
        }
        let calls = flow::calls(&self.builder.out.program);
        let called: BTreeSet<usize> = calls.into_iter().map(|(_, routine)| routine).collect();
        let runs = |body: &&Body| {
            !called.contains(&body.range.start) || self.interrupted.may_run(body.number)
        };
        for body in self.bodies.iter().filter(runs) {
            let name = format!("SBN {:02}", body.number);
            let stated = options.facts.interrupt(&name);
            self.builder.out.interrupt(name, body.range.start, stated);
        }
    }

    /// Completes the jump over a task's program, which only a cyclic task has (`gated`). If the task may be off, the
    /// jump may or may not jump; otherwise it never jumps.
    fn add_task_switch(&mut self, at: usize, may_be_off: bool, gated: bool) {
        if !gated {
            return;
        }
        if may_be_off {
            self.builder.out.program.approximate(at, "the task of this program may be off: the bound covers scans with the program and without it");
        } else if let Step::Jump { fires, .. } = &mut self.builder.out.program.instructions[at].step
        {
            *fires = Logic::Const(false);
        }
    }

    /// Adds the stated ranges of words as constraints on the scan's start. Reports errors in them, unless the project
    /// already has 100 errors.
    fn ranges(&mut self, project: &RawProject, options: &Options<'_>) {
        let nothing = Symbols::new();
        let symbols = project.files.first().map_or(&nothing, |file| &file.symbols);
        let fast = BTreeSet::new();
        let reader =
            Reader { memory: self.builder.memory, symbols: [symbols, &nothing], fast: &fast };
        for (device, &(low, high)) in &options.facts.ranges {
            match reader.read(device, Expected::Word) {
                _ if self.faults.len() >= MAX_FAULTS => break,
                Ok(Operand::Word(_)) if (0x8000..0x1_0000).contains(&high) => self.faults.push(options.facts.fault(
                    ["ranges", device],
                    Part::Value,
                    Code::Fact,
                    format!("the range of '{device}' ends at {high}, above 32767, the largest signed word"),
                    "state a range that ends at most at 32767 (a signed word), or above 65535 (a double word)",
                )),
                Ok(Operand::Word(cell)) => {
                    let wide = low < -0x8000 || high > 0x7FFF;
                    let cells: Vec<Cell> = (0..1 + u32::from(wide)).map(|n| cell.plus(n)).collect();
                    self.builder.out.program.stated_ranges.push(StartRange {
                        cells,
                        low,
                        high,
                        values: Vec::new(),
                    });
                }
                _ => self.faults.push(options.facts.fault(
                    ["ranges", device],
                    Part::Key,
                    Code::Fact,
                    format!("'{device}' has a stated range, but is not a word whose range can be stated"),
                    "write the word as in the program, such as D100 or \"DM 0100\"",
                )),
            }
        }
    }
}

/// The cells that a device or device range of the facts file covers. `None` if the text is neither.
fn written(reader: &Reader<'_>, text: &str) -> Option<Vec<Region>> {
    let ends = |want| {
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        let cell = |text| match reader.read(text, want).ok()? {
            Operand::Word(cell) | Operand::Bit(cell, _) | Operand::Flag(cell) => Some(cell),
            _ => None,
        };
        let (first, last): (Cell, Cell) = (cell(first)?, cell(last)?);
        (first.area == last.area && first.index <= last.index)
            .then(|| Region::Range { first, count: last.index - first.index + 1 })
    };
    let is_flag = |text: &str| matches!(reader.read(text, Expected::Bit), Ok(Operand::Flag(_)));
    let first = text.split('-').next().unwrap_or(text);
    match (ends(Expected::Word), ends(Expected::Bit)) {
        // A timer or counter has a current value and a flag.
        (Some(words), Some(bits)) if is_flag(first) => Some(vec![words, bits]),
        (Some(region), _) | (None, Some(region)) => Some(vec![region]),
        (None, None) => None,
    }
}

fn reaches(graph: &BTreeSet<(usize, usize)>, from: usize, to: usize) -> bool {
    let (mut seen, mut open) = (BTreeSet::from([from]), vec![from]);
    while let Some(at) = open.pop() {
        if at == to {
            return true;
        }
        let next = graph.iter().filter(|(caller, _)| *caller == at).map(|(_, callee)| *callee);
        open.extend(next.filter(|callee| seen.insert(*callee)));
    }
    false
}
