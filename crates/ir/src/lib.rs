//! A PLC program as the analysis sees it: instructions over named cells, with exact meaning and no dialect.
//!
//! Dialects end here. A dialect turns its mnemonics into the few steps below; the symbolic execution
//! (`scan`) and the concrete interpreter (`replay`) both follow this page to the letter and share no code.
//!
//! # Meaning of one scan
//!
//! State: the cells (bits, 16-bit words), a stack of results, numbered save slots, a stack of open master control
//! regions. Every cell starts the scan with an arbitrary value that `ranges` and `invariants` allow. `mains` run in
//! order, each from its first to its last instruction; then every interrupt routine runs as often as it
//! states. For each instruction that is reached:
//!
//! 1. The *condition* is worked out: the top of the stack (true if the stack is empty), and, for the
//!    steps that act (all but `Logic`, the stack steps and `ForBegin`/`ForEnd`), every master control region's condition.
//! 2. The step's expressions (`value`, `fires`) are evaluated in the state before the instruction.
//!    `Logic::Condition` is the condition of 1.
//! 3. The instruction's effects are carried out in order, each seeing the effects before it;
//!    `When::Fired` effects only if `fires` was true (for `Logic` steps: only if `value` was true).
//! 4. The step itself is carried out: the stack changes, or control goes elsewhere.
//!
//! A `Logic` step fires if its `value` is true; a step with neither `fires` nor `value` fires whenever it is
//! reached. Stack, slots and master control regions are empty at the start of each main routine and of each run of an
//! interrupt routine; what is asked of an empty stack or slot is true. `End` in a called routine ends the main
//! routine all the same; in an interrupt's run, `End` and `Stop` end that run.
//!
//! An instruction that is reached costs its on-time if it fires, else its off-time. An instruction that is
//! not reached costs nothing. What a program cannot tell is a nondeterministic value, a *choice* for short: a
//! `Free` source has, in one call context (its [`Frame`]s of calls, loop iterations and interrupts), any one
//! value; two sources with the same id in the same context have the same value.
//!
//! That is what the upper bound is found on. Where a choice's value comes from on a PLC, [`meaning`] says.

mod approximation;
mod area;
pub mod cell_budget;
mod charts;
pub mod errors;
pub mod flow;
mod indexed;
pub mod ladder;
pub mod meaning;
pub mod place;
mod reads;
mod routines;
mod scan_control;
mod settled;
mod start;
mod statements;
pub mod tags;
mod task;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
pub mod timed;
mod timing;

pub use approximation::{Approximated, Approximation, Unfollowed};
pub use area::{Area, AreaKind, Device, Operand, Radix, Role};
pub use charts::Charts;
pub use indexed::{Indexed, Length};
pub use meaning::ChoiceKind;
pub use reads::{Source, SourceMut};
pub use routines::{Absent, Interrupt};
pub use scan_control::{ScanControl, Setting, Switch};
pub use settled::{Settled, Settling};
pub use start::{Apart, PowerUp, StartRange, TrustedRange, range_or_values};
pub use statements::{Body, Statement, Statements};
pub use tags::{Tag, Tags, Type};
pub use task::Task;
pub use timing::{Counted, TimingKey, Touched, Units};

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// Which area of memory, an index into `Program::areas`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AreaId(pub u16);

/// One cell of memory: a bit or a 16-bit word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Its area.
    pub area: AreaId,
    /// Its place there.
    pub index: u32,
}

impl Cell {
    /// The cell `n` places further on.
    #[must_use]
    pub fn plus(self, n: u32) -> Cell {
        Cell { area: self.area, index: self.index + n }
    }
}

/// A nondeterministic value: a place in the program whose value is not known. See the page's head.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChoiceId(pub u32);

/// Where a bit is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BitSource {
    /// A constant.
    Const(bool),
    /// A bit cell.
    Cell(Cell),
    /// Bit 0 (least) to 15 of a word cell.
    WordBit(Cell, u8),
    /// A nondeterministic value: bit 0 of the choice.
    Free(ChoiceId),
}

/// Where sixteen bits are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WordSource {
    /// A constant.
    Const(u16),
    /// A word cell.
    Cell(Cell),
    /// `count` (1 to 16) bit cells from `first` on, `first` the least; the bits above are 0.
    Bits {
        /// The least bit.
        first: Cell,
        /// How many.
        count: u8,
    },
    /// Any value.
    Free(ChoiceId),
}

/// Where a bit is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BitTarget {
    /// A bit cell.
    Cell(Cell),
    /// A bit of a word cell; the other bits stay.
    WordBit(Cell, u8),
}

impl BitTarget {
    /// The cell that holds it.
    #[must_use]
    pub fn cell(self) -> Cell {
        match self {
            BitTarget::Cell(cell) | BitTarget::WordBit(cell, _) => cell,
        }
    }

    /// Where it is read.
    #[must_use]
    pub fn source(self) -> BitSource {
        match self {
            BitTarget::Cell(cell) => BitSource::Cell(cell),
            BitTarget::WordBit(cell, bit) => BitSource::WordBit(cell, bit),
        }
    }
}

/// Where sixteen bits are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WordTarget {
    /// A word cell.
    Cell(Cell),
    /// The low `count` bits go to `count` (1 to 16) bit cells from `first` on.
    Bits {
        /// Where the least bit goes.
        first: Cell,
        /// How many.
        count: u8,
    },
    /// Nowhere that matters.
    Discard,
}

/// A number of one or more words, least word first. Both sides of an operation have equally many words,
/// results wrap around.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Number {
    /// The words themselves.
    Words(Vec<WordSource>),
    /// Sum.
    Add(Box<Number>, Box<Number>),
    /// Difference, left minus right.
    Sub(Box<Number>, Box<Number>),
    /// Bitwise and.
    And(Box<Number>, Box<Number>),
    /// Bitwise or.
    Or(Box<Number>, Box<Number>),
    /// Bitwise exclusive or.
    Xor(Box<Number>, Box<Number>),
}

/// How two numbers compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Relation {
    /// `=`
    Equal,
    /// `<>`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
}

/// As what numbers are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Reading {
    /// Two's complement of all words together.
    Signed,
    /// Unsigned of all words together.
    Unsigned,
    /// IEEE 754 single (two words). If either side is not a normal number or plain +0 (that is: -0, a
    /// denormal, an infinity, not a number), the comparison's result is bit 0 of the choice.
    Real(ChoiceId),
}

/// A comparison of two numbers of equally many words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Compare {
    /// The relation asked for.
    pub relation: Relation,
    /// Signed, unsigned or real.
    pub reading: Reading,
    /// Left side.
    pub left: Number,
    /// Right side.
    pub right: Number,
}

/// A truth value worked out from the state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Logic {
    /// The condition of this instruction.
    Condition,
    /// A constant.
    Const(bool),
    /// A bit.
    Bit(BitSource),
    /// Negation.
    Not(Box<Logic>),
    /// True if all are (true if none is given).
    All(Vec<Logic>),
    /// True if one is (false if none is given).
    Any(Vec<Logic>),
    /// A comparison.
    Compare(Box<Compare>),
}

impl Logic {
    /// The negation.
    #[must_use]
    #[allow(clippy::should_implement_trait)]
    pub fn not(self) -> Logic {
        Logic::Not(Box::new(self))
    }

    /// A bit cell.
    #[must_use]
    pub fn cell(cell: Cell) -> Logic {
        Logic::Bit(BitSource::Cell(cell))
    }
}

/// Some cells, for writes whose target or value is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Region {
    /// `count` cells from `first` on.
    Range {
        /// The first.
        first: Cell,
        /// How many.
        count: u32,
    },
    /// A whole area.
    Area(AreaId),
    /// Every cell of every area.
    Everything,
}

impl Region {
    /// Whether the region holds the cell.
    #[must_use]
    pub fn holds(self, cell: Cell) -> bool {
        match self {
            Region::Range { first, count } => {
                cell.area == first.area
                    && cell.index >= first.index
                    && cell.index - first.index < count
            }
            Region::Area(area) => cell.area == area,
            Region::Everything => true,
        }
    }

    /// What lies in this region of some stretches of cells of its area.
    #[must_use]
    pub fn parts(self, stretches: &[Region]) -> Vec<Region> {
        let Region::Range { first: own, count: most } = self else { return stretches.to_vec() };
        let part = |stretch: &Region| {
            let Region::Range { first, count } = *stretch else { return Some(self) };
            let end = |first: Cell, count: u32| u64::from(first.index) + u64::from(count);
            let end = end(own, most).min(end(first, count));
            let first = first.max(own);
            let count = u32::try_from(end.checked_sub(first.index.into())?).ok()?;
            (count > 0).then_some(Region::Range { first, count })
        };
        stretches.iter().filter_map(part).collect()
    }
}

/// A change of the state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Write {
    /// A bit takes a value.
    Bit(BitTarget, Logic),
    /// Words take a number's words; all are read before any is written. As many targets as words.
    Words(Vec<WordTarget>, Number),
    /// Every cell of the region takes any value: the choice, for each cell on its own (a bit cell takes
    /// bit 0).
    Havoc(Region, ChoiceId),
}

/// When an effect happens, once its instruction is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// Whenever the instruction is reached.
    Always,
    /// Only if it fires.
    Fired,
}

/// A write and when it happens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Effect {
    /// When.
    pub when: When,
    /// What.
    pub write: Write,
}

/// How a result joins the stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Join {
    /// Empties the stack and pushes: the first contact of a rung.
    Start,
    /// Pushes: a contact that begins a further branch.
    Load,
    /// Top of the stack becomes top and value.
    And,
    /// Top of the stack becomes top or value.
    Or,
    /// Top of the stack becomes the value (pushes if the stack is empty).
    Replace,
}

/// What an instruction does besides its effects.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// A contact, or a change of the result.
    Logic {
        /// How it joins the stack.
        join: Join,
        /// Its value.
        value: Logic,
    },
    /// Pops two, pushes their conjunction.
    AndBlock,
    /// Pops two, pushes their disjunction.
    OrBlock,
    /// Saves the top of the stack (true if it is empty) in a slot.
    Save(u32),
    /// The top of the stack becomes the slot's value (pushes if the stack is empty).
    Fetch(u32),
    /// A coil or an application instruction: all it does stands in the effects.
    Act {
        /// When it counts as on.
        fires: Logic,
    },
    /// Goes to a later instruction of the same routine if it fires. Never into or out of a master control region, never
    /// into a loop; out of a loop ends that loop.
    Jump {
        /// When.
        fires: Logic,
        /// The instruction gone to.
        target: usize,
    },
    /// Runs from `target` to a `Return` if it fires, then goes on. The called routine has its own stack,
    /// slots and master control regions, empty at first.
    Call {
        /// When.
        fires: Logic,
        /// First instruction of the routine.
        target: usize,
    },
    /// Ends the routine that was called, or the interrupt routine.
    Return,
    /// Ends the main routine of this file.
    End,
    /// If it fires, the scan ends here; nothing further is reached, in no file (but interrupt routines).
    Stop {
        /// When.
        fires: Logic,
    },
    /// A loop without a bound: control has come round to where it was, and nothing that the loop asks for has changed, or
    /// nothing is known that ends it. A scan that gets here has no bound. It is followed no further, as if it ended.
    Unbounded {
        /// Where the loop begins; it ends where control came from.
        from: usize,
        /// Whether it goes on for ever; else only no count of its turns is known.
        certain: bool,
    },
    /// Runs the instructions up to its `ForEnd` so many times: the count as a signed number, but at
    /// least `least` and at most `most`. Read once. `ForBegin` itself is reached once, its `ForEnd` once an iteration.
    ForBegin {
        /// The count.
        count: WordSource,
        /// Fewer iterations are not made.
        least: u32,
        /// More iterations are not made.
        most: u32,
        /// The matching `ForEnd`.
        end: usize,
    },
    /// Ends an iteration.
    ForEnd,
    /// A loop of which no sensible number of iterations is known, summarised: every instruction listed is
    /// charged so often at its dearer time, then the regions are havocked (under `choice`), then each exit whose
    /// choice's bit 0 is true is taken (the first such), else control goes behind `end`. No result is left on the
    /// stack or in a slot.
    Summary(Box<Summary>),
    /// Opens a master control region: until it ends, its condition (whether this fired) holds off what stands in it.
    MasterControlBegin {
        /// Its nesting level.
        level: u32,
        /// Its condition.
        fires: Logic,
    },
    /// Closes every open master control region of this level or a higher one.
    MasterControlEnd {
        /// The level.
        level: u32,
    },
    /// Nothing: a label, a page break, no operation.
    Nothing,
}

/// What is summarised. It stands apart: few steps are one, and all are as large as the largest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Summary {
    /// The matching `ForEnd`; what stands between is not run.
    pub end: usize,
    /// Instruction and how often it is charged.
    pub charges: Vec<(usize, u64)>,
    /// What the loop may have written.
    pub havocs: Vec<Region>,
    /// The choice of the values.
    pub choice: ChoiceId,
    /// Exits other than its end.
    pub exits: Vec<(ChoiceId, Exit)>,
    /// For a loop, what its `ForBegin` said: the count, the least and the most iterations. A real run goes by these.
    pub iterations: Option<(WordSource, u32, u32)>,
}

/// An exit of what is summarised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// To a later instruction of the same routine, as a jump.
    To(usize),
    /// As `Step::Return`.
    Return,
    /// As `Step::End`.
    End,
    /// As a `Step::Stop` that fires.
    Stop,
}

impl Step {
    /// Whether master control regions that are off hold it off.
    #[must_use]
    pub fn acts(&self) -> bool {
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

    /// What decides whether the step fires; `None` if it fires whenever it is reached.
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

/// One instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instruction {
    /// Where it stands.
    pub place: Location,
    /// Its rung, from 1 through all files.
    pub block: u32,
    /// As the source has it, operands apart by one blank. The parts of an instruction share it.
    pub text: Arc<str>,
    /// The operands that name devices, in the order of the text. The parts of an instruction share them.
    pub operands: Arc<[Operand]>,
    /// How it is priced; `None` for a part of an instruction that is priced elsewhere.
    pub timing: Option<Box<TimingKey>>,
    /// What it changes.
    pub effects: Vec<Effect>,
    /// What it does.
    pub step: Step,
}

impl Instruction {
    /// The words that say how many units it handles.
    #[must_use]
    pub fn counted(&self) -> Option<&Counted> {
        self.timing.as_ref()?.counted()
    }
}

/// One source file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceFile {
    /// Its name as the user gave it.
    pub name: String,
    /// Its instructions, a range of `Program::instructions`.
    pub instructions: std::ops::Range<usize>,
    /// How many instructions the source has (an instruction may take more than one of ours).
    pub count: usize,
}

/// A whole project: its files' programs run one after another in each scan.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Program {
    /// The dialect's name, for the report.
    pub dialect: String,
    /// The CPU that the source names, if it does.
    pub cpu: Option<String>,
    /// The files.
    pub files: Vec<SourceFile>,
    /// The places among these of files of subroutines alone, which do not run by themselves.
    pub standby: Vec<usize>,
    /// The memory areas.
    pub areas: Vec<Area>,
    /// All instructions of all files.
    pub instructions: Vec<Instruction>,
    /// The main routines, ranges of instructions, in the order in which they run.
    pub mains: Vec<std::ops::Range<usize>>,
    /// The interrupt routines.
    pub interrupts: Vec<Interrupt>,
    /// The tasks that the project has by name, the one whose scan this is first; the others are interrupts of the same names.
    pub tasks: Vec<Task>,
    /// The `ForBegin`s of loops of which nothing says how many iterations they make. They are summarised, however few
    /// instructions they have.
    pub uncounted: BTreeSet<usize>,
    /// Instructions at which fewer iterations or units are counted than their words could say, as `passes::values` found.
    pub narrowed: BTreeSet<usize>,
    /// Instructions that may be an operation error, and when they are: worked out in the state before the instruction, where
    /// it fires or is a contact. The CPU does not go on from one, so no such scan is a lower bound; upper bounds have such scans, too.
    pub errors: BTreeMap<usize, Logic>,
    /// The routines that are not there, one for each call.
    pub absent: Vec<Absent>,
    /// Units without a body that are called, and of which nothing is stated: they were taken to do nothing.
    pub bodiless: Vec<(String, Location)>,
    /// How many rungs there are.
    pub blocks: u32,
    /// How many nondeterministic values there are: ids are below this.
    pub choices: u32,
    /// What is known of nondeterministic values; of one that is not named here nothing is.
    pub kinds: BTreeMap<ChoiceId, ChoiceKind>,
    /// Exact choices that the bound follows whatever they read; others only where that is known.
    pub followed: BTreeSet<ChoiceId>,
    /// What registers of the CPU some choices read, which it sets by itself: their area and number.
    pub registers: BTreeMap<ChoiceId, (String, u32)>,
    /// What an emulated CPU's timers and counters do.
    pub timekeeping: timed::Timekeeping,
    /// For choices with which a whole area is havocked since an index says where to write: which cells that can be.
    pub indexed: BTreeMap<ChoiceId, Indexed>,
    /// How the CPU comes up.
    pub power_up: PowerUp,
    /// What it does to the time that a scan may take.
    pub scan_control: ScanControl,
    /// What may change at any moment: a read of it gives any value (`passes::interrupts`), and no exact choice is worked
    /// out from it.
    pub volatile: Vec<Region>,
    /// What is over-approximated.
    pub approximations: Vec<Approximation>,
    /// Names of cells that have none of their own, such as what an instruction remembers.
    pub names: BTreeMap<Cell, String>,
    /// Data that is not flat, and what its cells are called.
    pub tags: Tags,
    /// What people call devices.
    pub comments: BTreeMap<Device, String>,
    /// How many words each scan runs, one a clock, on a machine that works so.
    pub clocked: Option<u64>,
    /// The shortest timer, where a timer that a scan starts is taken not to run out in it.
    pub shortest_timer: Option<Picos>,
    /// Whether a scan is best told by its path from place to place.
    pub shows_path: bool,
    /// Input points and output points that the program uses, where its dialect counted them.
    pub points: Option<[u32; 2]>,
    /// Cells that a network or a special unit refreshes where one is fitted, and what they are, in words.
    pub networks: Vec<(Region, String)>,
    /// Cells that others than the program write between scans, as the user states, or as modules deliver later what an
    /// instruction asked for.
    pub external: Vec<Region>,
    /// Cells that nobody but the program writes, as the user states; what is also in `external` is not.
    pub internal: Vec<Region>,
    /// The first instruction that reaches into a network's station by itself, an index into `instructions`.
    pub direct_links: Option<usize>,
    /// Ranges the user stated.
    pub ranges: Vec<StartRange>,
    /// Words with a stated range into which the program writes, and nothing outside of that range, if a scan starts as stated.
    pub kept: BTreeSet<Cell>,
    /// Ranges that the program keeps to, where it is trusted with its words; constraints on the scan's start like those that
    /// are stated.
    pub trusted: Vec<TrustedRange>,
    /// Bits that the program keeps apart, where it is trusted with them; `invariants` say the same.
    pub apart: Vec<Apart>,
    /// What the user stated of the count at an instruction, wherever it is executed: the iterations of a loop, signed, or the
    /// units that [`Counted`] words say, unsigned. The least and the largest.
    pub counts: BTreeMap<usize, (i64, i64)>,
    /// What holds in the state in which every scan starts; no choice and no condition occurs in it.
    pub invariants: Vec<Logic>,
    /// Those of them that the user stated: each that two bits are not on together.
    pub exclusive: Range<usize>,
    /// What charts among its routines tell.
    pub charts: Charts,
    /// The statements that the instructions came from.
    pub statements: Statements,
}

impl Program {
    /// Lists what is over-approximated at an instruction. Many are for the same reason, whose text they share.
    pub fn approximate(&mut self, instruction: usize, what: impl Into<Approximated>) {
        let what = what.into();
        let alike = self.approximations.iter().rev().take(4).find(|one| one.what == what);
        let what = alike.map_or(what, |one| one.what.clone());
        self.approximations.push(Approximation { instruction, what });
    }

    /// A fault at an instruction, with its place and its text.
    #[must_use]
    pub fn fault(
        &self,
        at: &Instruction,
        code: Code,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Diagnostic {
        let Location { file, line, step } = at.place;
        // Programs made by hand may have no files.
        let file = self.files.get(file as usize).map_or("", |file| file.name.as_str());
        Diagnostic::line(code, file, line, &*at.text, message, help).at_step(step)
    }

    /// The area in which a cell lies.
    #[must_use]
    pub fn area(&self, id: AreaId) -> &Area {
        &self.areas[usize::from(id.0)]
    }

    /// A bit's name: its cell's, or that of its word and its number there (`M5`, `D100.A`).
    #[must_use]
    pub fn bit_name(&self, bit: BitTarget) -> String {
        match bit {
            BitTarget::Cell(cell) => self.cell_name(cell),
            BitTarget::WordBit(cell, bit) => format!("{}.{bit:X}", self.cell_name(cell)),
        }
    }

    /// The cell's name as users write it (`X1F`, `D100`).
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

/// One iteration of a loop, one call, or one run of an interrupt on the path to an instruction. Frames together are its
/// call context.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Frame {
    /// The `Call` or `ForBegin`, or the entry of an interrupt routine.
    pub at: usize,
    /// The loop's iteration or the interrupt's occurrence, from 0; 0 for a call.
    pub iteration: u32,
}

/// What a choice was made for: the frames, the choice, and the cell where a region was havocked.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChoiceKey {
    /// Outermost first; empty in the main routine outside loops.
    pub frames: Vec<Frame>,
    /// Which.
    pub choice: ChoiceId,
    /// The cell, for `Write::Havoc` and `Step::Summary`'s havocked regions.
    pub cell: Option<Cell>,
}

/// One scan, told by everything in it that is free. What is missing is 0.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Witness {
    /// Values at the start of the scan; bits are 0 or 1.
    pub start: BTreeMap<Cell, u16>,
    /// The choices.
    pub choices: BTreeMap<ChoiceKey, u16>,
    /// What the analysis settled that found the scan.
    pub settled: Arc<Settled>,
}
