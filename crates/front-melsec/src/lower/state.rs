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

/// Stands for the target of a jump, call or loop until the target is known.
pub(super) const OPEN: usize = usize::MAX;

/// The lowering of a project to a program of `ir`. Each file of this module handles one type of instruction, and adds
/// its methods here. Methods that return `None` have reported an error, unless they say otherwise.
pub struct Lowering<'a> {
    pub(super) resolved: &'a Resolved<'a>,
    pub(super) structure: &'a Structure,
    pub(super) options: &'a DecodeOptions<'a>,
    pub(super) family: Family,
    pub(super) out: Builder,
    pub(super) faults: Vec<Faults<'a>>,
    /// The special relays and instructions of the project that change the meaning of other instructions.
    pub(super) modes: Modes,
    /// The instruction that is being lowered.
    pub(super) current: CurrentInstruction<'a>,
    /// The rung that is being lowered.
    pub(super) rung: RungState,
    /// The number of hidden bits that instructions use, and the instructions that act on edges.
    pub(super) edges: Edges,
    /// The regions that may be written through indirect addresses (`@D0`), if the facts state them. `None`: every
    /// device.
    pub(super) indirect: Option<Vec<Region>>,
    /// The targets of jumps, calls and loops.
    pub(super) targets: JumpTargets,
    /// The bit that holds the carry flag SM700, if the instruction before the contacts here is a shift or rotation that
    /// sets it.
    pub(super) carry: Option<Cell>,
    /// The bit that holds SM704, the result of the last block comparison (BKCMP), for real runs. `None` if the program
    /// does not read it, or if something else may change it.
    pub(super) block_result: Option<Cell>,
    /// The step ladder state that is being lowered. `None` outside of step ladder states.
    pub(super) state: Option<LadderState>,
}

impl Lowering<'_> {
    /// Reports an error at the current instruction; `part` is a slice of it or one of its words. Does nothing while
    /// errors are suppressed ([`CurrentInstruction::quiet`]).
    pub fn fault(&mut self, code: Code, part: &str, message: impl Into<String>, help: &str) {
        let Some(raw) = self.current.raw.filter(|_| !self.current.quiet) else { return };
        let file = &self.resolved.project.files[self.current.file];
        let found = raw.caret(file).at(part, code, &file.name, message, help).at_step(raw.step);
        self.faults[self.current.file].push(found);
    }

    /// Records an over-approximation at the instruction that will be added next, unless the same text is already
    /// recorded there.
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

    /// Adds an instruction to the program, and returns its index. Effects through indirect addresses are limited to the
    /// stated devices, the timing key gets the operand types, and the operation errors that were noted are recorded for
    /// it.
    pub fn add(&mut self, timing: Option<TimingKey>, effects: Vec<Effect>, step: Step) -> usize {
        let effects = self.limit_indirect(effects);
        let timing = timing.map(|key| self.with_operands(key));
        let at = self.out.add(timing, effects, step);
        let mut errors = std::mem::take(&mut self.current.errors);
        let error = if errors.len() > 1 { Some(Logic::Any(errors)) } else { errors.pop() };
        self.out.program.errors.extend(error.map(|error| (at, error)));
        at
    }

    /// Whether a block of this many words or bits, each read and written, can be modelled cell by cell within the limit
    /// for the whole program. False for a negative count.
    pub fn has_room(&self, count: i64) -> bool {
        usize::try_from(count).is_ok_and(|count| self.out.has_room(2 * count))
    }

    /// Whether the instruction has `count` operands; reports an error if not.
    pub fn takes(&mut self, raw: &RawInstruction, count: usize) -> bool {
        let file = &self.resolved.project.files[self.current.file];
        let fault = miscounted(raw, file, count);
        let fits = fault.is_none();
        fault.into_iter().for_each(|fault| self.faults[self.current.file].push(fault));
        fits
    }

    /// A new hidden bit that keeps its value from one execution to the next. Reports name it after the current
    /// instruction.
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
    /// The index of the instruction in [`Resolved::items`].
    pub item: usize,
    /// The instruction in the source; `None` before the first instruction of a file.
    pub raw: Option<&'a RawInstruction>,
    /// Whether errors are suppressed, because an operand is only tried out.
    pub quiet: bool,
    /// The conditions under which the instruction causes an operation error.
    pub errors: Vec<Logic>,
    /// What gets any value if the instruction overflows. `None` if nothing.
    pub on_overflow: Option<OverflowHavoc>,
    /// Each operand of the instruction parsed, or what is wrong with it.
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
    /// The number of results on the logic stack, that is, of blocks of contacts not yet connected; 0 outside a rung.
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
    /// The index of the instruction in the program.
    pub(super) at: usize,
    /// The hidden bit that holds the value of the device or condition at the last execution.
    pub(super) memory: Cell,
    /// Whether the instruction is a contact. Then its device may change several times in a scan.
    pub(super) is_contact: bool,
}

/// The number of hidden bits, and the instructions whose hidden bits are changed at the end of the lowering.
#[derive(Default)]
pub(super) struct Edges {
    /// The number of hidden bits of the program so far.
    pub count: u32,
    /// The edge instructions of the FX and FX5, for `widen_edges`. Empty for other families.
    pub at: Vec<EdgeInstruction>,
    /// For each relay whose edge only one pulse contact detects (FX, M2800 to M3071): the instructions that are its
    /// pulse contacts.
    pub single: BTreeMap<Cell, Vec<usize>>,
}

/// The instruction at which each target begins, and the instructions that lead to the targets.
#[derive(Default)]
pub(super) struct JumpTargets {
    /// For each item that may be a target: the instruction at which it begins.
    pub(super) stands: BTreeMap<usize, usize>,
    /// Each jump, call and loop start (an instruction), with the item that it leads to.
    pub(super) leads: Vec<(usize, usize)>,
    /// The calls of missing routines (instructions), with the routines' names.
    pub(super) absent: Vec<(usize, String)>,
    /// The calls (instructions) that may run the called routine with all coils off.
    pub(super) calls_with_coils_off: Vec<usize>,
}

impl JumpTargets {
    /// Records that an item, to which jumps may lead, begins at instruction `at`.
    pub(super) fn define_target(&mut self, item: usize, at: usize) {
        self.stands.insert(item, at);
    }

    /// Records that instruction `at` leads to `item`: it jumps there, calls it, or begins a loop that ends there.
    pub(super) fn add_jump(&mut self, at: usize, item: usize) {
        self.leads.push((at, item));
    }
}

/// The step ladder state (STL) that is being lowered.
pub(super) struct LadderState {
    /// The item of the STL instruction that begins the state.
    pub(super) item: usize,
    /// The step relays that must all be on for the state to be active.
    pub(super) relays: Vec<Cell>,
    /// The instruction that jumps over the state if it is not active.
    pub(super) jump: usize,
}

/// The regions that get any value after an instruction if the bit `overflow` says that the instruction overflowed.
pub(super) struct OverflowHavoc {
    pub(super) overflow: Cell,
    pub(super) regions: Vec<Region>,
}

/// The key for an instruction's time, with the names of the table rows in the order in which they are tried: the
/// mnemonic with the letters of its device, the mnemonic, and for a pulse form the same two without the suffix P. The
/// operand types are added when the instruction is added.
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

/// The timing key of a control instruction: its time is looked up by the mnemonic alone, then by `class`. For an
/// instruction that always acts, the larger of the two times counts.
pub fn key(mnemonic: &str, class: &'static str) -> TimingKey {
    // These always fire, so the table may give two times; the larger one counts.
    let use_larger_time = matches!(class, "nothing" | "loop")
        || matches!(mnemonic, "RET" | "RETSTL" | "SRET" | "IRET" | "MCR" | "JMP");
    timing(mnemonic, false, None, class, Units::None, use_larger_time)
}

/// The condition that is true at the rising or falling edge of a value: the value differs in this direction from the
/// one that `memory` holds.
pub fn edge(rising: bool, value: Logic, memory: Cell) -> Logic {
    let before = Logic::cell(memory);
    if rising {
        Logic::All(vec![value, before.not()])
    } else {
        Logic::All(vec![value.not(), before])
    }
}
