//! From an OMRON project to a program: every instruction with its exact or widened meaning, all faults at once.

use scanbound_base::code::Code;
use std::collections::{BTreeMap, BTreeSet};

use super::assembly::Assembly;
use super::catalog::{Amount, Extent, Role};
use super::emit::{CallSite, Emitter};
use super::extent;
use super::frame::{Frame, frame};
use super::memory::Memory;
use super::named;
use super::operand::{Operand, Reader, Want};
use super::resolve::{Item, resolve};
use super::source::{Family, RawFile, RawProgram, RawProject, Symbols, Task};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::facts::Part;
use scanbound_base::time::Picos;
use scanbound_front::{Faults, Options, absent};
use scanbound_ir::{
    BitSource, Cell, Effect, Logic, Program, Region, SourceFile, StartRange, Step, When, Write,
    flow,
};

/// Stated ranges with faults are told up to so many faults.
const MOST_FAULTS: usize = 100;

/// More instructions than this are refused: the largest CPUs hold 400 K steps, of which contacts take one and most else
/// two to seven.
const MOST: usize = 300 * 1024;

/// Refuses a project of more instructions than any CPU holds, at the first that is too many.
fn too_many(project: &RawProject) -> Result<(), Vec<Diagnostic>> {
    let mut instructions = project.files.iter().flat_map(|file| {
        let own = file.programs.iter().flat_map(|program| &program.instructions);
        own.map(move |instruction| (file, instruction))
    });
    let Some((file, instruction)) = instructions.nth(MOST) else { return Ok(()) };
    Err(vec![Diagnostic::line(
        Code::TooMany,
        &file.name,
        instruction.line,
        &*instruction.text,
        format!("the project has more than {MOST} instructions"),
        "no CPU holds as many: check the file",
    )])
}

/// Decodes a project.
///
/// # Errors
/// All faults of all files.
pub fn decode(project: &RawProject, options: &Options<'_>) -> Result<Program, Vec<Diagnostic>> {
    too_many(project)?;
    let memory = Memory { family: project.family };
    let mut decoder = Decoder {
        asm: Assembly::new(memory, project.dialect),
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
    decoder.asm.fast = fast_timers(project, memory);
    for file in &project.files {
        decoder.file(file, options);
    }
    decoder.connect(project, options);
    decoder.ranges(project, options);
    super::loops::settle(&mut decoder.asm);
    decoder.arrange(project, options);
    let Decoder { mut asm, mut faults, used: [read, written], .. } = decoder;
    // A word that is written serves outputs, another inputs; and so does one of which a bit is read that nothing writes.
    let is_input = |(word, bits): &(&u32, &u16)| match written.get(word) {
        None => true,
        Some(written) => **bits & !written != 0,
    };
    let inputs = read.iter().filter(is_input).count();
    asm.out.program.networks = asm.memory.networks();
    asm.out.program.power_up = asm.memory.power_up();
    asm.out.program.scan_control.by_parameters = Some("minimum cycle time");
    asm.out.program.points = Some([inputs, written.len()].map(|words| 16 * words as u32));
    faults.append(&mut asm.faults);
    if !faults.is_empty() {
        faults.sort_by_key(|fault| (position(project, &fault.file), fault.line));
        return Err(faults);
    }
    let blocks = asm.out.program.instructions.iter().map(|one| one.block);
    asm.out.program.blocks = blocks.max().unwrap_or(0);
    asm.out.program.cpu = project.files.iter().find_map(|file| file.cpu.clone());
    asm.out.program.approximations.sort();
    asm.out.program.approximations.dedup();
    Ok(asm.out.program)
}

/// Tasks that interrupts run and whose programs are not known.
const UNLISTED: &str = "unlisted tasks";
/// More words of inputs and outputs than this no CPU has.
const MOST_POINTS: u32 = 320;

/// Which subroutines interrupts may run, besides those that nothing calls.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Interrupted {
    /// Interrupts are let in.
    any: bool,
    /// A table in memory names the subroutines: it may be any.
    all: bool,
    /// These.
    numbers: BTreeSet<u32>,
}

impl Interrupted {
    /// Looks at an instruction that may let interrupts in.
    fn look(&mut self, item: &Item<'_>, family: Family) {
        if family != Family::C {
            return;
        }
        match item.name.as_str() {
            // Inputs run 0 to 15, a scheduled interrupt 99.
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

/// The flags of the timers that the system counts on between instructions: all of 10 ms and less.
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
            let flag = raw.operands.first().map(|text| reader.read(text, Want::Completion("T")));
            match flag {
                Some(Ok(Operand::Flag(cell))) => _ = found.insert(cell),
                // Through an address that is not known: any timer.
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

/// A subroutine's body among the instructions, to find calls that come back to themselves.
struct Body {
    program: usize,
    number: u32,
    global: bool,
    range: std::ops::Range<usize>,
}

struct Decoder {
    asm: Assembly,
    faults: Vec<Diagnostic>,
    /// First instructions of subroutines by program, whether global, and number.
    routines: BTreeMap<(usize, bool, u32), usize>,
    /// Calls with their program and the fault to tell where there is no such subroutine.
    calls: Vec<(usize, CallSite, Diagnostic)>,
    /// Programs with their tasks: their instructions, the END.
    tasks: Vec<(Task, String, std::ops::Range<usize>, usize)>,
    bodies: Vec<Body>,
    switches: bool,
    /// Which subroutines interrupts may run that the program lets in (C series).
    interrupted: Interrupted,
    /// Whether the program lets interrupts in that run tasks (CS, CJ and CP).
    unmasked: bool,
    /// Whether programs call each other's subroutines: those of the C series do where there are several.
    shared: bool,
    /// Words of the input and output area that are read, and those that are written, with the bits that single bits name.
    used: [BTreeMap<u32, u16>; 2],
}

impl Decoder {
    fn file(&mut self, file: &RawFile, options: &Options<'_>) {
        let start = self.asm.next();
        let mut count = 0;
        self.asm.file = self.asm.out.program.files.len() as u32;
        self.asm.out.program.files.push(SourceFile {
            name: file.name.clone(),
            instructions: start..start,
            count: 0,
        });
        for program in &file.programs {
            count += program.instructions.len();
            self.program(file, program, options);
        }
        let end = self.asm.next();
        if let Some(source) = self.asm.out.program.files.last_mut() {
            (source.instructions, source.count) = (start..end, count);
        }
        for symbols in file.programs.iter().map(|program| &program.symbols).chain([&file.symbols]) {
            self.comments(symbols);
        }
    }

    /// Symbols are the names that people know addresses by.
    fn comments(&mut self, symbols: &Symbols) {
        let fast = BTreeSet::new();
        let reader = Reader { memory: self.asm.memory, symbols: [symbols, symbols], fast: &fast };
        for (name, symbol) in symbols {
            let want = if symbol.kind.to_ascii_uppercase().starts_with("BOOL") {
                Want::Bit
            } else {
                Want::Word
            };
            let read = reader.read(&symbol.address, want).ok();
            let Some(device) = read.as_ref().and_then(named::device) else { continue };
            let text = match symbol.comment.trim() {
                "" => name.clone(),
                comment => format!("{name}: {comment}"),
            };
            self.asm.out.program.comments.entry(device).or_insert(text);
        }
    }

    fn program(&mut self, file: &RawFile, program: &RawProgram, options: &Options<'_>) {
        let memory = self.asm.memory;
        let fast = self.asm.fast.clone();
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
            self.interrupted.look(item, memory.family);
            self.unmasked |=
                memory.family == Family::Cs && matches!(item.name.as_str(), "MSKS" | "CTBL");
        }
        let mut frame_faults = Faults::new(&file.name);
        let frame = frame(&items, memory.family, self.shared, &mut frame_faults);
        if items.is_empty() && complete {
            faults.push(Diagnostic::file(
                Code::EmptyProgram,
                &file.name,
                format!("the program {} has no instructions", program.name),
                "export the program again",
            ));
        }
        self.faults.extend(faults.into_diagnostics());
        // Without the instructions that are not understood, the frame may seem broken where it is not.
        if complete {
            self.faults.extend(frame_faults.into_diagnostics());
        }
        let start = self.asm.next();
        let fault_count = self.asm.faults.len();
        let gate = match program.task {
            Task::Cyclic(_) => {
                let choice = self.asm.choice();
                let fires = Logic::Bit(BitSource::Free(choice));
                if let Some(first) = items.first() {
                    self.asm.at(first);
                }
                Some(self.asm.push(Step::Jump { fires, target: 0 }, Vec::new(), None))
            }
            _ => None,
        };
        self.asm.rung();
        self.clear_flags();
        let mut emitter = Emitter::new(&mut self.asm, &items, &frame);
        let end = emitter.run();
        let (starts, calls) =
            (std::mem::take(&mut emitter.starts), std::mem::take(&mut emitter.calls));
        self.switches |= emitter.switches;
        if !complete {
            // Branches that do not add up may follow from what is missing.
            self.asm.faults.truncate(fault_count);
        }
        if let Some(gate) = gate
            && let Step::Jump { target, .. } = &mut self.asm.out.program.instructions[gate].step
        {
            *target = end;
        }
        self.note_extensions(&items, &starts);
        self.collect(&items, &frame, &starts, calls, file);
        self.tasks.push((program.task, program.name.clone(), start..self.asm.next(), end));
    }

    /// Notes by how much each WDT makes the cycle time monitor's time longer: by 10 ms for each unit of its operand on CS, CJ
    /// and CP. On the C series 100 ms are recalled, and not verified: no bound rests on them.
    fn note_extensions(&mut self, items: &[Item<'_>], starts: &[Option<usize>]) {
        const MS: u64 = 1_000_000_000;
        const MOST: u32 = 0x0F9F;
        let family = self.asm.memory.family;
        let program = &mut self.asm.out.program;
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
                    (unit.times(count.unwrap_or(0)), unit.times(count.unwrap_or(MOST.into())))
                }
            };
            program.scan_control.extensions.insert(at, times);
        }
    }

    /// Counts the words of the input and output area that an instruction names.
    fn count_points(&mut self, item: &Item<'_>) {
        let Some(row) = item.row else { return };
        let memory = self.asm.memory;
        let length = |amount| extent::length(memory, item, amount).unwrap_or(MOST_POINTS);
        let block = row.operands.iter().find_map(|slot| match slot.written_words() {
            Some(amount @ Amount::Counted { .. }) => Some(amount),
            _ => None,
        });
        for (slot, operand) in row.operands.iter().zip(&item.operands) {
            let (Operand::Word(cell) | Operand::Bit(cell, _)) = *operand else { continue };
            let (written, count) = match (slot.role, slot.extent) {
                // A block is read as long as it is written.
                (Role::Source, Extent::Words(Amount::Unknown)) => (0, block.map_or(1, length)),
                (Role::Source, Extent::Words(amount)) => (0, length(amount)),
                (
                    Role::Destination | Role::ReadWrite | Role::ReadWriteIfDevice,
                    Extent::Words(amount),
                ) => (1, length(amount)),
                (Role::Destination | Role::ReadWrite, _) => (1, 1),
                _ => (0, 1),
            };
            let words = (0..count.min(MOST_POINTS)).map(|n| cell.plus(n));
            // What reads a whole word may read what it wrote.
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

    /// The system clears the condition flags when a task begins.
    fn clear_flags(&mut self) {
        if self.asm.memory.family == Family::Cs && !self.tasks.is_empty() {
            let (first, count) = self.asm.memory.flags();
            let flags = Region::Range { first, count };
            let registers = self.asm.memory.registers().iter().copied().map(Region::Area);
            let effects = [flags].into_iter().chain(registers).map(|region| {
                let write = Write::Havoc(region, self.asm.choice());
                Effect { when: When::Always, write }
            });
            let effects = effects.collect();
            self.asm.push(Step::Nothing, effects, None);
        }
    }

    fn collect(
        &mut self,
        items: &[Item<'_>],
        frame: &Frame,
        starts: &[Option<usize>],
        calls: Vec<CallSite>,
        file: &RawFile,
    ) {
        let program = self.tasks.len();
        for routine in &frame.routines {
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
            let fault = Diagnostic::line(
                Code::NoSubroutine,
                &file.name,
                raw.line,
                scanbound_front::shown(&raw.text),
                format!("subroutine {} is not in the project", call.number),
                absent::help(
                    "give the file that holds it as well, correct the number",
                    &call.routine(),
                ),
            );
            self.calls.push((program, call, fault.at_step(raw.step)));
        }
    }

    /// Leads each call to its subroutine, and finds those that come back to themselves.
    fn connect(&mut self, project: &RawProject, options: &Options<'_>) {
        let shared = self.shared;
        let nothing = Symbols::new();
        let symbols = project.files.first().map_or(&nothing, |file| &file.symbols);
        let fast = BTreeSet::new();
        let memory = self.asm.memory;
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
                // Whatever it does leaves its condition flags behind.
                let (first, count) = memory.flags();
                let flags = [Region::Range { first, count }];
                let known = stated.map(|stated| absent::stated_routine(stated, written, &flags));
                self.asm.out.call_absent(call.at, &name, known);
                continue;
            };
            if let Step::Call { target, .. } = &mut self.asm.out.program.instructions[call.at].step
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
                    "subroutine {}{} comes to call itself",
                    if body.global { "G" } else { "" },
                    body.number
                );
                fault.help = "the PLC has no bound for this either: take the call out".to_owned();
                if body.program == self.calls[at].0 || body.global || shared {
                    self.faults.push(fault);
                }
            }
        }
    }

    /// The order in which the programs run.
    fn arrange(&mut self, project: &RawProject, options: &Options<'_>) {
        let mut tasks = std::mem::take(&mut self.tasks);
        tasks.sort_by_key(|(task, ..)| match task {
            Task::Each => (0, 0),
            Task::Cyclic(number) => (1, *number),
            Task::Interrupt(number) => (2, *number),
        });
        let cyclic = tasks.iter().filter(|(task, ..)| matches!(task, Task::Cyclic(_))).count();
        for (task, name, range, end) in tasks {
            // A list does not say when its program runs: that it is an interrupt's is stated by its name.
            if let (Task::Each, stated @ Some(_)) = (task, options.facts.interrupt(&name)) {
                self.asm.out.interrupt(name, range.start, stated);
                continue;
            }
            let Task::Interrupt(number) = task else {
                let gated = matches!(task, Task::Cyclic(_));
                self.gate(range.start, gated && (cyclic > 1 || self.switches), gated);
                self.asm.out.program.mains.push(range.start..end + 1);
                continue;
            };
            let label = format!("task {number}");
            let stated = [label.as_str(), name.as_str()]
                .into_iter()
                .find_map(|label| options.facts.interrupt(label));
            self.asm.out.interrupt(label, range.start, stated);
        }
        if self.asm.out.program.mains.is_empty() && self.faults.is_empty() {
            let name = project.files.first().map_or("", |file| &file.name);
            self.faults.push(Diagnostic::file(
                Code::NoProgram,
                name,
                "no program runs in each scan",
                "the project has interrupt tasks only: give its cyclic tasks",
            ));
        }
        self.uncalled(options);
        self.unlisted(options);
    }

    /// Interrupts that are let in run tasks, of which a list of mnemonics shows nothing.
    fn unlisted(&mut self, options: &Options<'_>) {
        if !self.unmasked || !self.asm.out.program.interrupts.is_empty() {
            return;
        }
        let stated = options.facts.interrupt(UNLISTED);
        if let Some(times) = stated.filter(|&times| times > 0) {
            let message =
                format!("{times} runs of {UNLISTED} are stated, whose programs are not known");
            let help = "give their programs, and state each by its file's name, such as [interrupts] task2 = 1";
            self.faults.push(Diagnostic::file(Code::NoInterrupt, "", message, help));
        }
        let entry = self.asm.push(Step::Return, Vec::new(), None);
        self.asm.out.interrupt(UNLISTED.to_owned(), entry, stated);
        self.asm.note("interrupts are let in, and the programs that they run are not among these");
    }

    /// Where interrupts are let in, subroutines that nothing calls are their routines.
    fn uncalled(&mut self, options: &Options<'_>) {
        if self.interrupted == Interrupted::default() {
            return;
        }
        let calls = flow::calls(&self.asm.out.program);
        let called: BTreeSet<usize> = calls.into_iter().map(|(_, routine)| routine).collect();
        let runs = |body: &&Body| {
            !called.contains(&body.range.start) || self.interrupted.may_run(body.number)
        };
        for body in self.bodies.iter().filter(runs) {
            let name = format!("SBN {:02}", body.number);
            let stated = options.facts.interrupt(&name);
            self.asm.out.interrupt(name, body.range.start, stated);
        }
    }

    /// A task may be off where the project can switch it; otherwise its gate is always open.
    fn gate(&mut self, at: usize, may_be_off: bool, gated: bool) {
        if !gated {
            return;
        }
        if may_be_off {
            self.asm.out.program.approximate(at, "the task may be off");
        } else if let Step::Jump { fires, .. } = &mut self.asm.out.program.instructions[at].step {
            *fires = Logic::Const(false);
        }
    }

    /// The user's ranges of words at the scan's start.
    fn ranges(&mut self, project: &RawProject, options: &Options<'_>) {
        let nothing = Symbols::new();
        let symbols = project.files.first().map_or(&nothing, |file| &file.symbols);
        let fast = BTreeSet::new();
        let reader = Reader { memory: self.asm.memory, symbols: [symbols, &nothing], fast: &fast };
        for (device, &(low, high)) in &options.facts.ranges {
            match reader.read(device, Want::Word) {
                _ if self.faults.len() >= MOST_FAULTS => break,
                Ok(Operand::Word(_)) if (0x8000..0x1_0000).contains(&high) => self.faults.push(options.facts.fault(
                    ["ranges", device],
                    Part::Value,
                    Code::Fact,
                    format!("the range of '{device}' reaches to {high}, past a signed word's 32767"),
                    "ranges are of signed words, or of double words from 65536 on: state a smaller one",
                )),
                Ok(Operand::Word(cell)) => {
                    let wide = low < -0x8000 || high > 0x7FFF;
                    let cells: Vec<Cell> = (0..1 + u32::from(wide)).map(|n| cell.plus(n)).collect();
                    self.asm.out.program.stated_ranges.push(StartRange {
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
                    format!("a range is stated for '{device}', which is no word"),
                    "write the word as in the program, such as D100 or \"DM 0100\"",
                )),
            }
        }
    }
}

/// What may be read and written of the devices that a text names: one, or all from the first to the last.
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
    let is_flag = |text: &str| matches!(reader.read(text, Want::Bit), Ok(Operand::Flag(_)));
    let first = text.split('-').next().unwrap_or(text);
    match (ends(Want::Word), ends(Want::Bit)) {
        // A timer's or counter's present value and its flag.
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
