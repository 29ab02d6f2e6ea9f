//! The intermediate representation of a PLC program: instructions on named cells, with exact semantics and without
//! dialects.
//!
//! Each front translates its mnemonics into the few steps defined below. The symbolic execution (`scan`) and the
//! concrete interpreter (`replay`) both implement this definition exactly, and share no code.
//!
//! # Semantics of one scan
//!
//! State: the cells (bits and 16-bit words), a stack of results, numbered save slots, and a stack of open master
//! control regions. At the start of a scan each cell has any value that `stated_ranges` and `invariants` allow. The
//! routines in `mains` run in order, each from its first to its last instruction. Then every interrupt routine runs the
//! number of times that is stated for it. For each instruction that control reaches:
//!
//! 1. The *condition* is computed: the top of the stack (true if the stack is empty). For steps that act (all but
//!    `Logic`, the stack steps and `ForBegin`/`ForEnd`) the condition of every open master control region is combined
//!    with it by AND.
//! 2. The step's expressions (`value`, `fires`) are evaluated in the state before the instruction. `Logic::Condition`
//!    is the condition of point 1.
//! 3. The instruction's effects are executed in order; each sees the effects before it. `When::Fired` effects are
//!    executed only if `fires` was true (for `Logic` steps: only if `value` was true).
//! 4. The step itself is executed: the stack changes, or control is transferred.
//!
//! A `Logic` step fires if its `value` is true; a step with neither `fires` nor `value` fires whenever it is reached.
//! Stack, slots and master control regions are empty at the start of each main routine and of each run of an interrupt
//! routine. An empty stack or slot reads as true. `End` in a called routine ends the main routine too; in a run of an
//! interrupt routine, `End` and `Stop` end that run.
//!
//! An instruction that is reached costs its on-time if it fires, else its off-time. An instruction that is not
//! reached costs nothing. A value that the program does not determine is a nondeterministic value, a *choice* for
//! short: a `Free` source has any one value in each call context (the [`Frame`]s of calls, loop iterations and
//! interrupts). Two sources with the same id in the same context have the same value.
//!
//! The upper bound is computed with these semantics. The module [`meaning`] says where the value of a choice comes
//! from on a real PLC.

mod approximation;
mod area;
pub mod cell_budget;
mod charts;
pub mod errors;
pub mod flow;
mod indexed;
pub mod ladder;
pub mod location_text;
pub mod meaning;
mod reads;
mod region_set;
mod resolutions;
mod routines;
mod scan_control;
mod source;
mod start;
mod statements;
pub mod tags;
mod task;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
pub mod timers;
mod timing;
mod value;

pub use approximation::{Approximated, Approximation, SummaryReason};
pub use area::{Area, AreaKind, Device, Operand, Radix, Role};
pub use charts::Charts;
pub use indexed::{IndexedWrite, Length};
pub use meaning::ChoiceKind;
pub use region_set::RegionSet;
pub use resolutions::{Resolution, Resolutions};
pub use routines::{Interrupt, MissingRoutine};
pub use scan_control::{ScanControl, Setting, Switch};
pub use source::{Source, SourceMut};
pub use start::{ExclusiveBits, PowerUp, StartRange, TrustedRange, range_or_values};
pub use statements::{Body, Statement, Statements};
pub use tags::{Tag, Tags, Type};
pub use task::Task;
pub use timing::{AccessedDevices, Counted, TimingKey, Units};
pub use value::{
    AreaId, BitSource, BitTarget, Cell, ChoiceId, ChoiceKey, Compare, Frame, Logic, Number,
    NumberFormat, Region, Relation, WordSource, WordTarget,
};

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// A write to cells of the PLC's memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Write {
    /// Writes the value of an expression to a bit.
    Bit(BitTarget, Logic),
    /// Writes the words of a number to as many targets. All sources are read before any target is written.
    Words(Vec<WordTarget>, Number),
    /// Havoc: every cell of the region gets any value, given by the choice for each cell separately (a bit cell gets
    /// bit 0).
    Havoc(Region, ChoiceId),
}

/// Under which condition an effect of a reached instruction is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// The write happens whenever control reaches the instruction.
    Always,
    /// The write happens only if the instruction fires.
    Fired,
}

/// A write of an instruction, and when it happens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Effect {
    /// When the write happens.
    pub when: When,
    /// What is written.
    pub write: Write,
}

/// How a result is combined with the stack of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Join {
    /// Clears the stack and pushes: the first contact of a rung.
    Start,
    /// Pushes the value on the stack: a contact that begins a new branch.
    Load,
    /// ANDs the top of the stack with the value.
    And,
    /// ORs the top of the stack with the value.
    Or,
    /// Replaces the top of the stack by the value (pushes if the stack is empty).
    Replace,
}

/// What an instruction does besides its effects.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// A contact, or another instruction that combines a value with the stack of results. It fires if the value is
    /// true.
    Logic {
        /// How the value is combined with the stack.
        join: Join,
        /// The value that is combined with the stack.
        value: Logic,
    },
    /// Pops two results and pushes their conjunction.
    AndBlock,
    /// Pops two results and pushes their disjunction.
    OrBlock,
    /// Saves the top of the stack (true if it is empty) in a slot.
    Save(u32),
    /// Replaces the top of the stack by the slot's value (pushes if the stack is empty).
    Fetch(u32),
    /// A coil or an application instruction, which changes the state only by its effects.
    Act {
        /// The instruction fires, and costs its on-time, if this expression is true.
        fires: Logic,
    },
    /// If it fires, control jumps to a later instruction of the same routine: never into or out of a master control
    /// region, and never into a loop. A jump out of a loop ends the loop.
    Jump {
        /// The jump is taken if this expression is true.
        fires: Logic,
        /// The index of the instruction to which the step jumps.
        target: usize,
    },
    /// If it fires, calls the routine at `target`, which runs to a `Return`; then control continues here. The routine
    /// has a stack, slots and master control regions of its own, initially empty.
    Call {
        /// The routine is called if this expression is true.
        fires: Logic,
        /// The first instruction of the routine.
        target: usize,
    },
    /// Returns from a called routine. In a main routine or an interrupt routine itself, ends it.
    Return,
    /// Ends the main routine that is running, even from a routine that it called. In an interrupt routine, ends the run
    /// of this routine.
    End,
    /// If the instruction fires, the scan ends: the interrupt routines still run, but nothing else in any file. In an
    /// interrupt routine, ends only that run.
    Stop {
        /// The instruction ends the scan if this expression is true.
        fires: Logic,
    },
    /// An unbounded loop: control has returned to an earlier point and nothing that the loop tests has changed, or no
    /// end of the loop is known. A scan that reaches this has no bound. The analysis ends the scan there, as a
    /// [`Step::Stop`] that fires does.
    Unbounded {
        /// The first instruction of the loop; its last one is the instruction from which control came.
        from: usize,
        /// `true` if the loop certainly never ends; `false` if only the number of its iterations is unknown.
        certain: bool,
    },
    /// Executes the instructions up to its `ForEnd` as often as the count says. The count is read once, as a signed
    /// number (unsigned for [`ChoiceKind::UnsignedIterations`]), and limited to `least..=most`. `ForBegin` itself is
    /// reached once, its `ForEnd` once for each iteration.
    ForBegin {
        /// The word that gives the number of iterations.
        count: WordSource,
        /// The least number of iterations: a smaller count is raised to it.
        least: u32,
        /// The largest number of iterations: a larger count is lowered to it.
        most: u32,
        /// The index of the matching `ForEnd`.
        end: usize,
    },
    /// Ends an iteration of the loop that the matching `ForBegin` begins.
    ForEnd,
    /// Stands for a loop, a routine or a whole program that is not followed, because a number of iterations is unknown
    /// or there are too many executions. Every instruction listed is charged the given number of times at the larger of
    /// its two times; then the regions are havocked (with `choice`); then the first exit whose choice has bit 0 set is
    /// taken, or control continues after `end`. Stack and slots are empty afterwards.
    Summary(Box<Summary>),
    /// Opens a master control region. Until it is closed, its condition (whether this step fired) is part of the
    /// condition of every step that acts.
    MasterControlBegin {
        /// The nesting level of the master control region.
        level: u32,
        /// The condition of the region: while it is false, the region's instructions run with their conditions off.
        fires: Logic,
    },
    /// Closes every open master control region of this level or higher.
    MasterControlEnd {
        /// The nesting level of the region that ends.
        level: u32,
    },
    /// No operation: a label, a page break, NOP.
    Nothing,
}

/// What [`Step::Summary`] charges and writes in place of a loop, a routine or a whole program that is not followed.
/// Boxed in [`Step`], because it is large and rare.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Summary {
    /// The last instruction that the summary stands for: of a loop, its `ForEnd`; otherwise the summary itself. Control
    /// continues after it if no exit is taken.
    pub end: usize,
    /// The instructions that are charged, each with the number of times that it is charged at the larger of its two
    /// times.
    pub charges: Vec<(usize, u64)>,
    /// The regions that are havocked: everything that the loop, routine or program may write.
    pub havocs: Vec<Region>,
    /// The choice whose values are written to these regions.
    pub choice: ChoiceId,
    /// The exits besides the normal end of the loop, each with the choice that decides whether it is taken.
    pub exits: Vec<(ChoiceId, Exit)>,
    /// For a loop: the word with the number of iterations, and the smallest and largest number. Real runs use these to
    /// execute the loop. `None` for a routine or a whole program, at which a real run stops.
    pub iterations: Option<(WordSource, u32, u32)>,
}

/// An exit from a summarised loop or routine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// Jumps to a later instruction of the same routine.
    To(usize),
    /// To the caller of the routine, like `Step::Return`.
    Return,
    /// To the end of the main routine, like `Step::End`.
    End,
    /// To the end of the scan, like a `Step::Stop` that fires.
    Stop,
    /// Into an unbounded loop, like the `Step::Unbounded` with this index.
    Unbounded(usize),
}

impl Step {
    /// Whether the conditions of the open master control regions are part of the step's condition. If not, the
    /// condition is the top of the stack alone.
    #[must_use]
    pub fn depends_on_master_control(&self) -> bool {
        match self {
            Step::Logic { .. }
            | Step::AndBlock
            | Step::OrBlock
            | Step::Save(_)
            | Step::Fetch(_)
            | Step::ForBegin { .. }
            | Step::ForEnd => false,
            Step::Act { .. }
            | Step::Jump { .. }
            | Step::Call { .. }
            | Step::Return
            | Step::End
            | Step::Unbounded { .. }
            | Step::Stop { .. }
            | Step::Summary(_)
            | Step::MasterControlBegin { .. }
            | Step::MasterControlEnd { .. }
            | Step::Nothing => true,
        }
    }

    /// The expression that says whether the step fires: the value of a contact, else the field `fires`. `None` if the
    /// step fires whenever it is reached.
    #[must_use]
    pub fn fires(&self) -> Option<&Logic> {
        match self {
            Step::Logic { value, .. } => Some(value),
            Step::Act { fires }
            | Step::Jump { fires, .. }
            | Step::Call { fires, .. }
            | Step::Stop { fires }
            | Step::MasterControlBegin { fires, .. } => Some(fires),
            Step::AndBlock
            | Step::OrBlock
            | Step::Save(_)
            | Step::Fetch(_)
            | Step::Return
            | Step::End
            | Step::Unbounded { .. }
            | Step::ForBegin { .. }
            | Step::ForEnd
            | Step::Summary(_)
            | Step::MasterControlEnd { .. }
            | Step::Nothing => None,
        }
    }
}

/// An instruction, or a part of one, in the order of execution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instruction {
    /// The position of the instruction in the source.
    pub place: Location,
    /// The number of its rung, counted from 1 through all files.
    pub block: u32,
    /// The source text, with one blank between operands. The parts of an instruction share it.
    pub text: Arc<str>,
    /// The operands that name devices, in text order. The parts of an instruction share them.
    pub operands: Arc<[Operand]>,
    /// How to find the instruction's time; `None` for a part of an instruction whose time is charged at a different
    /// part.
    pub timing: Option<Box<TimingKey>>,
    /// The instruction's writes, in the order in which they happen.
    pub effects: Vec<Effect>,
    /// What the instruction does besides its writes.
    pub step: Step,
}

impl Instruction {
    /// The words from which the instruction's number of units is read. `None` if no words give it: the instruction has
    /// no units, a constant number of them, or an unknown number up to a limit.
    #[must_use]
    pub fn counted(&self) -> Option<&Counted> {
        self.timing.as_ref()?.counted()
    }
}

/// A source file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceFile {
    /// The name of the file as the user gave it.
    pub name: String,
    /// The instructions of the file, a range of `Program::instructions`.
    pub instructions: std::ops::Range<usize>,
    /// The number of instructions in the source. One source instruction may become several here.
    pub count: usize,
}

/// A project. The programs of its files run one after another in each scan.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Program {
    /// The name of the dialect, for reports.
    pub dialect: String,
    /// The CPU that the source names, if any.
    pub cpu: Option<String>,
    /// The source files.
    pub files: Vec<SourceFile>,
    /// Indices into `files` of the files that contain only subroutines and do not run by themselves.
    pub standby: Vec<usize>,
    /// The memory areas. An [`AreaId`] is an index into this list.
    pub areas: Vec<Area>,
    /// The instructions of all files, then those that stand for missing routines, and for routines and programs that
    /// are not followed.
    pub instructions: Vec<Instruction>,
    /// The main routines, ranges of instructions, in execution order.
    pub mains: Vec<std::ops::Range<usize>>,
    /// The interrupt routines.
    pub interrupts: Vec<Interrupt>,
    /// The named tasks of the project. The first is the task whose scan is bounded; the others are also interrupts with
    /// the same names.
    pub tasks: Vec<Task>,
    /// The `ForBegin`s of loops for which neither the front nor the user gives a number of iterations. `passes::loops`
    /// summarises them ([`Step::Summary`]), however small they are. If `passes::values` then finds a smaller limit,
    /// they are followed.
    pub loops_without_count: BTreeSet<usize>,
    /// Instructions whose iterations or units have a smaller upper limit than their words could hold, as
    /// `passes::values` found.
    pub limited_counts: BTreeSet<usize>,
    /// By instruction: the condition under which it causes an operation error. It is evaluated in the state before the
    /// instruction, and counts only if the instruction fires or is a contact. The CPU stops at such an error, so a scan
    /// with one is not a lower bound. The upper bound includes such scans.
    pub errors: BTreeMap<usize, Logic>,
    /// For areas whose number of devices is a parameter: how many each PLC has that can run the program. A real run may
    /// use more; it then says how many ([`meaning::AddressRange::chosen`]).
    pub certain_devices: BTreeMap<AreaId, u32>,
    /// Code that is missing or in a language that cannot be read: one entry for each instruction that stands for such
    /// code, as for each call of a missing routine.
    pub missing_routines: Vec<MissingRoutine>,
    /// Functions and function blocks that are called but have no body and no stated facts. The analysis assumes that
    /// they do nothing.
    pub without_body: Vec<(String, Location)>,
    /// The interval at which the task whose scan is bounded runs. `None` if it is not cyclic, or unknown.
    pub interval: Option<Picos>,
    /// The number of rungs in all files.
    pub blocks: u32,
    /// The number of choices; every `ChoiceId` is below it.
    pub choices: u32,
    /// Where the values of choices come from. Nothing is known of a choice without an entry.
    pub kinds: BTreeMap<ChoiceId, ChoiceKind>,
    /// Choices of the kind [`ChoiceKind::Exact`] whose operation the analysis always executes. It executes the
    /// operations of other choices only where their operands are known.
    pub always_followed: BTreeSet<ChoiceId>,
    /// Choices that read registers which the CPU itself sets: the name of the register's area, and its number.
    pub registers: BTreeMap<ChoiceId, (String, u32)>,
    /// Timers and counters, for emulated CPUs and runs of successive scans.
    pub timekeeping: timers::Timekeeping,
    /// For choices that havoc more cells than the instruction writes, because an index selects the cells or a word
    /// gives their number: what is known of the cells that it may write.
    pub indexed: BTreeMap<ChoiceId, IndexedWrite>,
    /// What is known of the memory after power-up.
    pub power_up: PowerUp,
    /// How the program changes the limits of its scan time.
    pub scan_control: ScanControl,
    /// Cells that may change at any moment, because an interrupt routine or another writer changes them: every read
    /// gives any value (`passes::interrupts`). No operation ([`ChoiceKind::Exact`]) that reads them is computed.
    pub volatile: Vec<Region>,
    /// The part of `volatile` that something outside the program writes, such as results that a module delivers later.
    /// In a real run, nothing is written to it from outside within the scan.
    pub delivered: Vec<Region>,
    /// All places where the program is over-approximated.
    pub approximations: Vec<Approximation>,
    /// The names of cells that are not devices, such as the memory of an edge instruction.
    pub names: BTreeMap<Cell, String>,
    /// Structured data, and the names of its cells.
    pub tags: Tags,
    /// The comments of devices.
    pub comments: BTreeMap<Device, String>,
    /// For a machine that executes one word at each clock: the number of words in each scan. `None` for other machines.
    pub words_per_scan: Option<u64>,
    /// The shortest set value of a timer, if the analysis assumes that a timer does not time out in the scan that
    /// starts it. Otherwise `None`.
    pub shortest_timer: Option<Picos>,
    /// Whether reports show a scan as a path from place to place, as for flowcharts and charts.
    pub shows_path: bool,
    /// The number of input points and output points that the program uses, if the dialect counts them.
    pub points: Option<[u32; 2]>,
    /// Cells that a network or a special unit refreshes if one is fitted, with a description.
    pub networks: Vec<(Region, String)>,
    /// Cells that something other than the program writes between scans, as the user states, or because a module
    /// delivers later what an instruction requested.
    pub external: Vec<Region>,
    /// Cells that only the program writes, as the user states. Cells that are also in `external` are not included.
    pub internal: Vec<Region>,
    /// The first instruction that accesses a network station directly, an index into `instructions`. `None` if there is
    /// none.
    pub first_direct_access: Option<usize>,
    /// Ranges of values at the start of every scan: those that the user stated, then those of `trusted_ranges`.
    pub stated_ranges: Vec<StartRange>,
    /// Words with a stated range for which this is proved: in every scan that starts within the stated ranges, the
    /// program writes only values within the range.
    pub proved_ranges: BTreeSet<Cell>,
    /// Ranges that the program itself ensures, if trusted. `stated_ranges` contains the same ranges.
    pub trusted_ranges: Vec<TrustedRange>,
    /// Bits that the program itself keeps mutually exclusive, if trusted. `invariants` contains the same statements.
    pub mutually_exclusive: Vec<ExclusiveBits>,
    /// By instruction: the least and the largest count that the user stated, valid for each execution. The count is the
    /// iterations of a loop (signed), or the units that [`Counted`] words give (unsigned).
    pub stated_counts: BTreeMap<usize, (i64, i64)>,
    /// Statements that hold in the start state of every scan. They contain no choices and no `Logic::Condition`.
    pub invariants: Vec<Logic>,
    /// The part of `invariants` (a range of its indices) that the user stated; each says that two bits are not on
    /// together.
    pub stated_exclusions: Range<usize>,
    /// What is known from sequential function charts among the routines.
    pub charts: Charts,
    /// The source statements from which the instructions were generated.
    pub statements: Statements,
    /// What some controllers do in another way than the standard has it, by the number of [`ChoiceKind::Reading`]. What
    /// the user states of the controller is not included.
    pub readings: Vec<String>,
}

impl Program {
    /// Records that an instruction is over-approximated. If one of the last four entries has the same reason, they
    /// share its text.
    pub fn approximate(&mut self, instruction: usize, what: impl Into<Approximated>) {
        let what = what.into();
        let alike = self.approximations.iter().rev().take(4).find(|one| one.what == what);
        let what = alike.map_or(what, |one| one.what.clone());
        self.approximations.push(Approximation { instruction, what });
    }

    /// An error message about an instruction, with its file, line, step number and text.
    #[must_use]
    pub fn fault(
        &self,
        at: &Instruction,
        code: Code,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Diagnostic {
        let Location { file, line, step } = at.place;
        // Programs built by tests may have no files.
        let file = self.files.get(file as usize).map_or("", |file| file.name.as_str());
        Diagnostic::line(code, file, line, &*at.text, message, help).at_step(step)
    }

    /// The area with this id.
    #[must_use]
    pub fn area(&self, id: AreaId) -> &Area {
        &self.areas[usize::from(id.0)]
    }

    /// The name of a bit: the cell's name, or the word's name with the bit number in hexadecimal (`M5`, `D100.A`).
    #[must_use]
    pub fn bit_name(&self, bit: BitTarget) -> String {
        match bit {
            BitTarget::Cell(cell) => self.cell_name(cell),
            BitTarget::WordBit(cell, bit) => format!("{}.{bit:X}", self.cell_name(cell)),
        }
    }

    /// The cell's name as users write it: from `names` or `tags` if they contain the cell, otherwise the area's name
    /// and the index (`X1F`, `D100`).
    #[must_use]
    pub fn cell_name(&self, cell: Cell) -> String {
        if let Some(name) = self.names.get(&cell) {
            return name.clone();
        }
        if let Some(name) = self.tags.name(cell) {
            return name;
        }
        let area = self.area(cell.area);
        match area.radix {
            Radix::Decimal => format!("{}{}", area.name, cell.index),
            Radix::Hexadecimal => format!("{}{:X}", area.name, cell.index),
            Radix::Octal => format!("{}{:o}", area.name, cell.index),
        }
    }
}

impl Program {
    /// The first instructions of the interrupt routines.
    pub fn interrupt_entries<C: FromIterator<usize>>(&self) -> C {
        self.interrupts.iter().map(|interrupt| interrupt.entry).collect()
    }

    /// The interrupt routines for which the user states no rate. Tasks whose priority is too low to interrupt the scan
    /// are omitted.
    pub fn unstated_interrupts(&self) -> impl Iterator<Item = &Interrupt> {
        let is_task = |one: &Interrupt| self.tasks.iter().find(|task| task.name == one.name);
        let comes = move |one: &&Interrupt| {
            is_task(one).zip(self.tasks.first()).is_none_or(|(task, own)| task.interrupts(own))
        };
        self.interrupts.iter().filter(|one| !one.stated).filter(comes)
    }
}

/// One scan of the model, given by its start values and the values of its choices. A value that is missing here is 0.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Witness {
    /// The cells' values at the start of the scan; a bit is 0 or 1.
    pub start: BTreeMap<Cell, u16>,
    /// The values of the choices that the scan reads.
    pub choices: BTreeMap<ChoiceKey, u16>,
    /// The choices whose values the analysis computed when it found the scan. A replay must compute the same ones.
    pub resolutions: Arc<Resolutions>,
}
