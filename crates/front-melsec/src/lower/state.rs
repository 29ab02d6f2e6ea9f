//! The state of the lowering, and what all its files use.

use super::modes::Modes;
use crate::catalog::unpulsed;
use crate::memory::{Family, edge_memory};
use crate::operand::{Operand, parse};
use crate::resolve::{DecodeOptions, Item, Resolved, miscounted};
use crate::source::RawInstruction;
use crate::structure::Structure;
use scanbound_base::code::Code;
use scanbound_front::Faults;
use scanbound_front::builder::Builder;
use scanbound_ir::{
    AccessedDevices, Approximated, Cell, Effect, Logic, Region, Step, TimingKey, Units,
};
use std::collections::BTreeMap;

/// Stands for a target that is not resolved yet.
pub(super) const OPEN: usize = usize::MAX;

/// The lowering of a project. Each file of this module handles one type of instruction, and adds its methods here.
pub struct Lowering<'a> {
    pub(super) resolved: &'a Resolved<'a>,
    pub(super) structure: &'a Structure,
    pub(super) options: &'a DecodeOptions<'a>,
    pub(super) family: Family,
    pub(super) out: Builder,
    pub(super) faults: Vec<Faults<'a>>,
    /// The special relays in use that change the meaning of other instructions.
    pub(super) modes: Modes,
    /// The instruction that is being lowered.
    pub(super) current: CurrentInstruction<'a>,
    /// The rung that is being lowered.
    pub(super) rung: RungState,
    /// The hidden bits that remember conditions for edges.
    pub(super) edges: Edges,
    /// The regions that may be written through indirect addresses, if stated.
    pub(super) indirect: Option<Vec<Region>>,
    /// Jump and call targets.
    pub(super) targets: JumpTargets,
    /// The open state of a step ladder.
    pub(super) state: Option<LadderState>,
}

impl Lowering<'_> {
    /// Reports an error at the current instruction; `part` is a slice of it or one of its words.
    pub fn fault(&mut self, code: Code, part: &str, message: impl Into<String>, help: &str) {
        let Some(raw) = self.current.raw.filter(|_| !self.current.quiet) else { return };
        let file = &self.resolved.project.files[self.current.file];
        let found = raw.caret(file).at(part, code, &file.name, message, help).at_step(raw.step);
        self.faults[self.current.file].push(found);
    }

    /// Records an over-approximation at the instruction that will be added next.
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
        let effects = self.limit_indirect(effects);
        let timing = timing.map(|key| self.with_operands(key));
        let at = self.out.add(timing, effects, step);
        let mut errors = std::mem::take(&mut self.current.errors);
        let error = if errors.len() > 1 { Some(Logic::Any(errors)) } else { errors.pop() };
        self.out.program.errors.extend(error.map(|error| (at, error)));
        at
    }

    /// Whether the cell budget has room for a block of this many words or bits, each read and written.
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

    /// Parses an operand's text. Nearly always it is one of the current instruction's operands, which are parsed
    /// already.
    pub(super) fn parsed(&self, text: &str) -> Result<Operand, String> {
        let own = self.current.raw.map_or(&[][..], |raw| &raw.operands);
        match own.iter().position(|own| own == text) {
            Some(at) => self.current.operands[at].clone(),
            None => parse(text, self.family),
        }
    }
}

/// The instruction that is being lowered.
#[derive(Default)]
pub(super) struct CurrentInstruction<'a> {
    /// The index of the file that contains the instruction.
    pub file: usize,
    /// The index of the instruction among all items.
    pub item: usize,
    /// The instruction in the source; `None` before the first instruction of a file.
    pub raw: Option<&'a RawInstruction>,
    /// Whether errors are suppressed, because an operand is only tried out.
    pub quiet: bool,
    /// The conditions under which the instruction causes an operation error.
    pub errors: Vec<Logic>,
    /// What the instruction havocs if it overflows.
    pub on_overflow: Option<OverflowHavoc>,
    /// The parsed operands of the instruction, or why one is invalid.
    pub operands: &'a [Result<Operand, String>],
}

impl<'a> CurrentInstruction<'a> {
    /// The state before the first instruction of a file.
    pub fn of(file: usize) -> CurrentInstruction<'a> {
        CurrentInstruction { file, ..CurrentInstruction::default() }
    }

    /// Moves to the next item of the file.
    pub fn begin(&mut self, at: usize, item: &'a Item<'_>) {
        (self.item, self.raw, self.operands) = (at, Some(item.raw), &item.operands);
        self.errors.clear();
    }
}

/// The state of the rung that is being lowered.
pub(super) struct RungState {
    /// The number of results on the logic stack.
    pub depth: usize,
    /// The number of results saved by MPS and not yet taken by MPP.
    pub saved: u32,
    /// Whether the rung has an output yet.
    pub has_output: bool,
    /// Whether a label or a similar instruction began the rung, so that the next contact belongs to it.
    pub open: bool,
}

impl Default for RungState {
    /// The state between two rungs.
    fn default() -> RungState {
        RungState { depth: 0, saved: 0, has_output: true, open: false }
    }
}

/// An instruction that acts on an edge.
pub(super) struct EdgeInstruction {
    /// The index of the instruction.
    pub(super) at: usize,
    /// The hidden bit that holds the value at the last execution.
    pub(super) memory: Cell,
    /// Whether the instruction is a contact. Then its device may change several times in a scan.
    pub(super) is_contact: bool,
}

/// The hidden bits for edges, and the instructions that need special treatment.
#[derive(Default)]
pub(super) struct Edges {
    /// The number of hidden bits so far.
    pub count: u32,
    /// The edge instructions of the FX and FX5, which need special treatment.
    pub at: Vec<EdgeInstruction>,
    /// For each relay whose edge only one pulse contact detects, its pulse contacts.
    pub single: BTreeMap<Cell, Vec<usize>>,
}

/// Jump targets: the instruction index of each item, and the instructions that lead to it.
#[derive(Default)]
pub(super) struct JumpTargets {
    pub(super) stands: BTreeMap<usize, usize>,
    pub(super) leads: Vec<(usize, usize)>,
    /// The calls of missing routines, with their names.
    pub(super) absent: Vec<(usize, String)>,
    /// The calls that may run the called routine with all coils off.
    pub(super) calls_with_coils_off: Vec<usize>,
}

impl JumpTargets {
    /// Records that an item begins at this instruction.
    pub(super) fn define_target(&mut self, item: usize, at: usize) {
        self.stands.insert(item, at);
    }

    /// Records that instruction `at` jumps to `item` or calls it.
    pub(super) fn add_jump(&mut self, at: usize, item: usize) {
        self.leads.push((at, item));
    }
}

/// The open state of a step ladder (STL).
pub(super) struct LadderState {
    /// The item of the STL instruction that begins the state.
    pub(super) item: usize,
    /// The step relays that must all be on for the state to be active.
    pub(super) relays: Vec<Cell>,
    /// The instruction that jumps over the state if it is not active.
    pub(super) jump: usize,
}

/// Regions that get any value after an instruction if a bit says that the instruction overflowed.
pub(super) struct OverflowHavoc {
    pub(super) overflow: Cell,
    pub(super) regions: Vec<Region>,
}

/// The key for an instruction's time: its name with the letters of its device, its name, and for a pulse form the name
/// without the suffix. The operand types are added when the instruction is added.
pub fn timing(
    mnemonic: &str,
    pulsed: bool,
    letters: Option<&str>,
    class: &'static str,
    units: Units,
    use_larger_time: bool,
) -> TimingKey {
    let mut names = Vec::with_capacity(2);
    let base = if pulsed { unpulsed(mnemonic) } else { None };
    for name in [Some(mnemonic.to_owned()), base].into_iter().flatten() {
        names.extend(letters.map(|letters| [&name, ":", letters].concat()));
        names.push(name);
    }
    let touched = AccessedDevices::default();
    TimingKey { names, class, units, use_larger_time, optional: false, accessed: touched }
}

/// The timing key of a control instruction, which consists only of its name.
pub fn key(mnemonic: &str, class: &'static str) -> TimingKey {
    // These always fire, so the table may give two times; the larger one counts.
    let use_larger_time = matches!(class, "nothing" | "loop")
        || matches!(mnemonic, "RET" | "RETSTL" | "SRET" | "IRET" | "MCR" | "JMP");
    timing(mnemonic, false, None, class, Units::None, use_larger_time)
}

/// The rising or falling edge of a value: compares it with the value that `memory` holds.
pub fn edge(rising: bool, value: Logic, memory: Cell) -> Logic {
    let before = Logic::cell(memory);
    if rising {
        Logic::All(vec![value, before.not()])
    } else {
        Logic::All(vec![value.not(), before])
    }
}
