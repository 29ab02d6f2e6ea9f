//! Lowers a flowchart program: one pass becomes a scan with forward jumps and calls.
//!
//! Each position of a routine at the start of a pass is a bit, and so is whether a group runs. Each routine begins with
//! jumps to its position. A group clears its position when it jumps there, and sets the next one when its turn ends. A
//! jump back in the main routine ends the pass. A group is unrolled: it has one copy for each jump back that its turn
//! can make, so that all its jumps lead forward. A turn with more jumps back repeats without end ([`Step::Unbounded`]).
//!
//! An input may have any value at each test, unless the user states an input image: then it has one value during the
//! pass. The state of a timer is one bit, which says that it was started in an earlier pass, so that it may have timed
//! out. CNR TIM may reset it, or stop it and keep its remaining time (the document says this about a timer that is
//! reused before it times out, 3.2.1 (1)). Both are possible, so afterwards the timer may time out even in the pass
//! that restarts it.

use super::back_jumps::{MAX_BACK_JUMPS, jumps_back};
use super::pass_starts::{Reset, pass_starts};
use super::source::{self, NAME, Op, Routine, Source};
use super::start_states::{RoutinePositions, StartState, invariants};
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::timers::Expiry;
use scanbound_ir::{
    AccessedDevices, Area, AreaId, AreaKind, BitSource, BitTarget, Cell, ChoiceId, ChoiceKind,
    Device, Effect, Instruction, Join, Logic, Operand, PowerUp, Program, Radix, Region, Role,
    SourceFile, Step, TimingKey, Units, When, WordSource, Write,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The area of the inputs.
const INPUTS: AreaId = AreaId(0);
/// The area of the outputs.
const OUTPUTS: AreaId = AreaId(1);
/// The area of the timers that were started in an earlier pass.
const TIMERS: AreaId = AreaId(2);
/// The area of the bits, one for each group, that say that the group continues at its head.
const HEADS: AreaId = AreaId(3);
/// The area of the bits, one for each label, that say that the main routine continues at the label.
const BACK: AreaId = AreaId(4);
/// The area of the bits that say whether a group runs.
const RUNS: AreaId = AreaId(5);
/// The area of the timers that were started in this pass.
const STARTED: AreaId = AreaId(6);
/// The number of the first area of bits that say that a routine continues at a WAIT; each routine has one such area.
const WAITS: u16 = 7;
/// The largest number of instructions in the copies that unrolling adds to the first copy of a group.
const MAX_UNROLLED: usize = 100_000;

/// A tenth of a second, in picoseconds.
const TENTH: u64 = 100_000_000_000;

/// Lowers a source: one scan is one pass. `latched`: inputs are read once in a pass, not at each test.
#[must_use]
pub fn decode(source: &Source, latched: bool) -> Program {
    let area = |name: String| Area::new(name, AreaKind::Bit, Radix::Decimal);
    let fixed = ["IN", "OUT", "TIM", "Head of GN", "Main at LBL", "Run of GN", "Started TIM"];
    let mut fixed = fixed.map(|name| area(name.to_owned()));
    fixed[usize::from(INPUTS.0)].role = Role::Input;
    fixed[usize::from(OUTPUTS.0)].role = Role::Output;
    fixed[usize::from(STARTED.0)].role = Role::Internal;
    let waits = source.routines.iter().map(|routine| area(format!("{} in line ", name(routine))));
    let outputs = source.outputs();
    let comments = source.comments.iter().map(|(&bit, comment)| {
        let area = if outputs.contains(&bit) { OUTPUTS } else { INPUTS };
        (Device { cell: Cell { area, index: bit }, bit: None }, comment.clone())
    });
    let blocks = blocks(source);
    let areas: Vec<Area> = fixed.into_iter().chain(waits).collect();
    let cleared = (0..areas.len()).filter_map(|at| u16::try_from(at).ok());
    let power_up = PowerUp {
        inputs: vec![Region::Area(INPUTS)],
        cleared: cleared.map(|at| Region::Area(AreaId(at))).collect(),
        ..PowerUp::default()
    };
    let program = Program {
        power_up,
        dialect: NAME.to_owned(),
        shows_path: true,
        shortest_timer: source.shortest_timer().map(|tenths| Picos(TENTH).times(u64::from(tenths))),
        areas,
        blocks: blocks.last().copied().unwrap_or(0),
        comments: comments.collect(),
        ..Program::default()
    };
    let (calls, reported) = (Vec::new(), BTreeSet::new());
    let timers = timers(source);
    let mut layout =
        Lowering { source, latched, outputs, blocks, timers, program, calls, reported };
    for (index, routine) in source.routines.iter().enumerate() {
        layout.routine(index, routine);
    }
    layout.invariant();
    layout.finish()
}

/// The input, output or timer that an instruction names, with its byte range in the text. Empty if it names none.
fn operands(one: &source::Instruction, outputs: &BTreeSet<u32>) -> Arc<[Operand]> {
    let (area, index) = match one.op {
        Op::And { bit, .. } if !outputs.contains(&bit) => (INPUTS, bit),
        Op::And { bit, .. } | Op::Out { bit, .. } => (OUTPUTS, bit),
        Op::Timer { timer, .. } | Op::ResetTimer(timer) => (TIMERS, timer),
        _ => return Arc::default(),
    };
    let device = Device { cell: Cell { area, index }, bit: None };
    let mut start = 0;
    for word in one.text.split(' ') {
        let end = start + word.len();
        if word.parse() == Ok(index) {
            return [Operand { start: start as u32, end: end as u32, device }].into();
        }
        start = end + 1;
    }
    Arc::default()
}

fn name(routine: &Routine) -> String {
    routine.group.map_or("Main".to_owned(), |group| format!("GN{group}"))
}

/// The timers whose state the lowered program keeps from pass to pass: all, or none if there are so many that storing
/// them at each end of a pass would make the program too large.
fn timers(source: &Source) -> BTreeSet<u32> {
    const MAX_TIMERS: usize = 20_000;
    let all: BTreeSet<u32> = source
        .instructions
        .iter()
        .filter_map(|one| match one.op {
            Op::Timer { timer, .. } => Some(timer),
            _ => None,
        })
        .collect();
    let ends =
        source.instructions.iter().filter(|one| one.op.leaves() || one.op.uses_condition()).count();
    if all.len().saturating_mul(ends) <= MAX_TIMERS { all } else { BTreeSet::new() }
}

/// For each instruction of the source, the number (from 1) of the flowchart's box that contains it. Reports show a box
/// as a rung.
fn blocks(source: &Source) -> Vec<u32> {
    let mut block = 0;
    let mut ended = true;
    let mut tests = false;
    let mut blocks = Vec::with_capacity(source.instructions.len());
    for one in &source.instructions {
        let begins = matches!(one.op, Op::Label(_) | Op::Head(_));
        let condition = one.op.is_test() || one.op.uses_condition();
        // A label belongs to the box after it.
        if begins || ended || condition != tests {
            block += 1;
        }
        ended = one.op.uses_condition() || one.op.leaves();
        tests = if begins { blocks_begin_with_test(source, blocks.len()) } else { condition };
        blocks.push(block);
    }
    blocks
}

/// Whether the instruction after the label or group head with index `label` is a test.
fn blocks_begin_with_test(source: &Source, label: usize) -> bool {
    source.instructions.get(label + 1).is_some_and(|next| next.op.is_test())
}

/// A position in an unrolled routine: the number of the copy, and the instruction in the source.
type Spot = (usize, usize);

/// The program under construction.
struct Lowering<'s> {
    source: &'s Source,
    /// Whether an input has one value during a pass.
    latched: bool,
    outputs: BTreeSet<u32>,
    blocks: Vec<u32>,
    /// The timers whose state is remembered from pass to pass.
    timers: BTreeSet<u32>,
    program: Program,
    /// The calls of groups: the index of the lowered call, and the group. Their targets are set when the group is
    /// lowered.
    calls: Vec<(usize, u32)>,
    /// Instructions whose over-approximation is already listed.
    reported: BTreeSet<usize>,
}

/// The routine that is being lowered.
struct RoutineLayout {
    routine: usize,
    is_main: bool,
    /// The number of copies that unrolling adds to the first one. This is also the number of the last copy, since
    /// copies are numbered from 0.
    copies: usize,
    /// The index of the first lowered instruction of each spot.
    laid: BTreeMap<Spot, usize>,
    /// The jumps to spots of the routine: the index of the lowered jump, and its target. They are resolved when all
    /// spots are lowered.
    jumps: Vec<(usize, Spot)>,
    /// Jumps back out of the last copy of a group: the lowered jump, its index in the source, and the index of its
    /// target in the source.
    rounds: Vec<(usize, usize, usize)>,
}

impl Lowering<'_> {
    /// The bit that says that a routine continues at this position; `None` for the head of the main routine.
    fn position_bit(&self, routine: usize, place: usize) -> Option<Cell> {
        let body = &self.source.routines[routine];
        if place == body.body.start {
            return body.group.map(|group| Cell { area: HEADS, index: group });
        }
        if let Op::Label(label) = self.source.instructions[place].op {
            return Some(Cell { area: BACK, index: label });
        }
        let waits = self.source.instructions[place..].iter().find(|one| one.op == Op::Wait)?;
        let area = AreaId(WAITS + u16::try_from(routine).unwrap_or(u16::MAX));
        Some(Cell { area, index: waits.line })
    }

    fn places(&self, routine: usize) -> Vec<(usize, Cell)> {
        let places = self.source.positions(&self.source.routines[routine]);
        places.into_iter().filter_map(|at| Some((at, self.position_bit(routine, at)?))).collect()
    }

    fn routine(&mut self, index: usize, routine: &Routine) {
        let is_main = routine.group.is_none();
        let most = MAX_UNROLLED / routine.body.len().max(1);
        let jumps = match is_main {
            true => Some(0),
            false => jumps_back(self.source, routine, self.latched),
        };
        let copies = jumps.unwrap_or(MAX_BACK_JUMPS).min(most);
        let reached = self.reached(routine, copies);
        let mut routine_layout = RoutineLayout {
            routine: index,
            is_main,
            copies,
            laid: BTreeMap::new(),
            jumps: Vec::new(),
            rounds: Vec::new(),
        };
        let start = self.program.instructions.len();
        let places = self.places(index);
        for &(place, cell) in &places {
            let step = Step::Jump { fires: Logic::cell(cell), target: 0 };
            let head = place == routine.body.start;
            // At its head, a group also clears the position at which it was stopped.
            let left = places.iter().filter(|other| (!is_main && head) || other.0 == place);
            let left = left.map(|&(_, cell)| Effect { when: When::Fired, write: set(cell, false) });
            let effects = left.collect();
            let at = self.add(place, None, step, effects);
            routine_layout.jumps.push((at, (0, place)));
        }
        if !is_main {
            self.add(routine.body.start, None, Step::Return, vec![]);
        }
        for &spot in &reached {
            routine_layout.laid.insert(spot, self.program.instructions.len());
            self.instruction(spot, &mut routine_layout);
        }
        for (jump, at, to) in std::mem::take(&mut routine_layout.rounds) {
            let from = routine_layout.laid.range((0, to)..).find(|(spot, _)| spot.1 == to);
            let from = from.map_or(start, |(_, &from)| from);
            let certain = jumps == Some(copies);
            let round = self.add(at, None, Step::Unbounded { from, certain }, vec![]);
            self.aim(jump, round);
        }
        for (jump, spot) in std::mem::take(&mut routine_layout.jumps) {
            self.aim(jump, routine_layout.laid[&spot]);
        }
        match routine.group {
            None => self.program.mains.push(start..self.program.instructions.len()),
            Some(group) => {
                for (call, called) in self.calls.clone() {
                    if called == group {
                        self.aim(call, start);
                    }
                }
            }
        }
    }

    /// The instructions of a routine that control can reach, with the copy in which they are. The copies are numbered
    /// from 0.
    fn reached(&self, routine: &Routine, copies: usize) -> BTreeSet<Spot> {
        let mut reached = BTreeSet::new();
        let mut open: Vec<Spot> =
            self.source.positions(routine).into_iter().map(|place| (0, place)).collect();
        while let Some((copy, at)) = open.pop() {
            if !reached.insert((copy, at)) {
                continue;
            }
            let op = self.source.instructions[at].op;
            if !op.leaves() {
                open.push((copy, at + 1));
            }
            if let Op::Jump(to) | Op::JumpIf(to) = op {
                match to <= at {
                    false => open.push((copy, to)),
                    true if routine.group.is_some() && copy < copies => open.push((copy + 1, to)),
                    true => {}
                }
            }
        }
        reached
    }

    fn instruction(&mut self, spot: Spot, routine_layout: &mut RoutineLayout) {
        let (copy, at) = spot;
        let whenever = Logic::Const(true);
        match self.source.instructions[at].op {
            Op::And { bit, negated } => {
                let value = self.test(bit);
                let value = if negated { value.not() } else { value };
                let step = Step::Logic { join: self.join(at), value };
                self.add(at, Some(("contact", false)), step, vec![]);
            }
            Op::Timer { timer, tenths } => {
                self.approximate(at, "a timer from an earlier pass may or may not have timed out");
                let cell = Cell { area: TIMERS, index: timer };
                let elapsed = self.elapsed(cell, tenths);
                let value = match tenths {
                    0 => elapsed,
                    _ => Logic::All(vec![Logic::cell(cell), elapsed]),
                };
                let step = Step::Logic { join: self.join(at), value };
                let started = Cell { area: STARTED, index: timer };
                let idle = |cell| Effect { when: When::Fired, write: set(cell, false) };
                let effects = vec![always(started, true), idle(started), idle(cell)];
                self.add(at, Some(("timer", false)), step, effects);
            }
            Op::Out { bit, on } => {
                let effect = always(self.bit(bit), on);
                self.add(at, Some(("coil", true)), Step::Act { fires: whenever }, vec![effect]);
            }
            Op::ResetTimer(timer) => {
                self.approximate(at, "CNR TIM may reset the timer or keep its remaining time");
                let rest = self.free_bit();
                let effects = [TIMERS, STARTED].map(|area| {
                    let cell = Cell { area, index: timer };
                    let stays = Logic::All(vec![Logic::cell(cell), rest.clone()]);
                    Effect { when: When::Always, write: Write::Bit(BitTarget::Cell(cell), stays) }
                });
                let step = Step::Act { fires: whenever };
                self.add(at, Some(("timer", true)), step, effects.into());
            }
            Op::Jump(to) => self.jump(spot, to, whenever, routine_layout),
            Op::JumpIf(to) => self.jump(spot, to, Logic::Condition, routine_layout),
            Op::Wait => {
                let step = Step::Jump { fires: Logic::Condition, target: 0 };
                let jump = self.add(at, Some(("jump", false)), step, vec![]);
                routine_layout.jumps.push((jump, (copy, at + 1)));
                if routine_layout.is_main {
                    let effects =
                        self.end_effects(routine_layout.routine, self.source.condition(at));
                    self.add(at, None, Step::Stop { fires: whenever }, effects);
                } else {
                    let here = self.position_bit(routine_layout.routine, self.source.condition(at));
                    let here = here.into_iter().map(|cell| always(cell, true)).collect();
                    self.add(at, None, Step::Return, here);
                }
            }
            Op::Groups => {
                self.add(at, Some(("call", true)), Step::Act { fires: whenever }, vec![]);
                let groups: Vec<u32> = self.source.groups().map(|(group, _)| group).collect();
                for group in groups {
                    let step = Step::Call { fires: Logic::cell(runs(group)), target: 0 };
                    let call = self.add(at, None, step, vec![]);
                    self.program.instructions[call].text = format!("GJ, group {group}").into();
                    self.calls.push((call, group));
                }
            }
            Op::Start(group) => self.start(at, group),
            Op::Stop(group) => {
                let effects = vec![always(runs(group), false)];
                self.add(at, Some(("call", true)), Step::Act { fires: whenever }, effects);
            }
            Op::End(group) => {
                let effects = vec![always(runs(group), false)];
                self.add(at, Some(("call", true)), Step::Return, effects);
            }
            Op::Label(_) | Op::Head(_) => {
                self.add(at, Some(("nothing", true)), Step::Nothing, vec![]);
            }
        }
    }

    /// Lowers GS: a stopped group starts at its head; a running one may or may not start again there.
    fn start(&mut self, at: usize, group: u32) {
        self.approximate(at, "GS may or may not restart a group that is running");
        // The documents do not say which, so no lower bound may depend on it.
        let again = self.free_bit();
        let fires = Logic::Any(vec![Logic::cell(runs(group)).not(), again]);
        let head = Cell { area: HEADS, index: group };
        let on = |cell| Effect { when: When::Fired, write: set(cell, true) };
        let effects = vec![on(runs(group)), on(head)];
        self.add(at, Some(("call", true)), Step::Act { fires }, effects);
    }

    fn jump(
        &mut self,
        (copy, at): Spot,
        to: usize,
        fires: Logic,
        routine_layout: &mut RoutineLayout,
    ) {
        if to <= at && routine_layout.is_main {
            let effects = self.end_effects(routine_layout.routine, to);
            self.add(at, Some(("jump", false)), Step::Stop { fires }, effects);
            return;
        }
        let jump = self.add(at, Some(("jump", false)), Step::Jump { fires, target: 0 }, vec![]);
        if to > at {
            routine_layout.jumps.push((jump, (copy, to)));
        } else if copy < routine_layout.copies {
            routine_layout.jumps.push((jump, (copy + 1, to)));
        } else {
            routine_layout.rounds.push((jump, at, to));
        }
    }

    /// The effects of the instruction that ends a pass: they store where the main routine continues, and which timers
    /// were started in this pass.
    fn end_effects(&self, routine: usize, place: usize) -> Vec<Effect> {
        let fired = |write| Effect { when: When::Fired, write };
        let place = self.position_bit(routine, place).map(|cell| fired(set(cell, true)));
        let timers = self.timers.iter().flat_map(|&index| {
            let [old, started] = [TIMERS, STARTED].map(|area| Cell { area, index });
            let runs = Logic::Any(vec![Logic::cell(old), Logic::cell(started)]);
            [fired(Write::Bit(BitTarget::Cell(old), runs)), fired(set(started, false))]
        });
        place.into_iter().chain(timers).collect()
    }

    /// A new external choice, whether a timer that was started in an earlier pass has timed out. `memory` is the bit
    /// that says that it was started; `tenths` is its time in tenths of a second.
    fn elapsed(&mut self, memory: Cell, tenths: u32) -> Logic {
        let over = ChoiceId(self.program.choices);
        let words = [tenths as u16, (tenths >> 16) as u16].map(WordSource::Const);
        let expiry = Expiry {
            setting: words.into(),
            ..Expiry::of_on_delay(memory, WordSource::Const(0), Picos(TENTH))
        };
        self.program.timekeeping.expiries.insert(over, expiry);
        self.external_bit()
    }

    /// How a test is combined with the condition: the first test begins a new condition.
    fn join(&self, at: usize) -> Join {
        let follows =
            at.checked_sub(1).is_some_and(|before| self.source.instructions[before].op.is_test());
        if follows { Join::And } else { Join::Start }
    }

    fn bit(&self, bit: u32) -> Cell {
        let area = if self.outputs.contains(&bit) { OUTPUTS } else { INPUTS };
        Cell { area, index: bit }
    }

    /// The expression for the value that a test of an input or output reads: its bit, or a new external choice for an
    /// input without an image.
    fn test(&mut self, bit: u32) -> Logic {
        if self.latched || self.outputs.contains(&bit) {
            Logic::cell(self.bit(bit))
        } else {
            self.external_bit()
        }
    }

    /// An expression for a bit that may have any value, from a new choice.
    fn free_bit(&mut self) -> Logic {
        self.program.choices += 1;
        Logic::Bit(BitSource::Free(ChoiceId(self.program.choices - 1)))
    }

    /// An expression for a bit that something outside the program determines, from a new choice.
    fn external_bit(&mut self) -> Logic {
        self.program.kinds.insert(ChoiceId(self.program.choices), ChoiceKind::External);
        self.free_bit()
    }

    /// Records an over-approximation at the lowered instruction that will be added next, unless one is already recorded
    /// for instruction `at` of the source.
    fn approximate(&mut self, at: usize, what: &str) {
        if self.reported.insert(at) {
            let instruction = self.program.instructions.len();
            self.program.approximate(instruction, what);
        }
    }

    /// Adds an instruction for instruction `at` of the source, and returns its index. `class` is the timing class, and
    /// whether the larger of the two times always applies; without it the instruction takes no time.
    fn add(
        &mut self,
        at: usize,
        class: Option<(&'static str, bool)>,
        step: Step,
        effects: Vec<Effect>,
    ) -> usize {
        let one = &self.source.instructions[at];
        self.program.instructions.push(Instruction {
            place: Location { file: 0, line: one.line, step: one.step },
            block: self.blocks[at],
            text: one.text.as_str().into(),
            operands: operands(one, &self.outputs),
            timing: class.map(|(class, use_larger_time)| {
                Box::new(TimingKey {
                    names: vec![mnemonic(one.op).to_owned()],
                    class,
                    units: Units::None,
                    use_larger_time,
                    optional: false,
                    accessed: AccessedDevices::default(),
                })
            }),
            effects,
            step,
        });
        self.program.instructions.len() - 1
    }

    fn aim(&mut self, jump: usize, to: usize) {
        if let Step::Jump { target, .. } | Step::Call { target, .. } =
            &mut self.program.instructions[jump].step
        {
            *target = to;
        }
    }

    /// Constrains the start of a pass to the states that can be reached from power-up, whether CNR TIM resets a timer
    /// or keeps its remaining time. In a real run, the states must satisfy the constraints for both cases: that CNR TIM
    /// always resets a timer, and that it always keeps the remaining time.
    fn invariant(&mut self) {
        self.program.invariants = self.starts(Reset::Either);
        let is_reset = |one: &source::Instruction| matches!(one.op, Op::ResetTimer(_));
        if self.source.instructions.iter().any(is_reset) {
            let readings = [Reset::Nothing, Reset::Rest].map(|reset| self.starts(reset));
            self.program.power_up.certain_invariants = readings.concat();
        }
    }

    /// Formulas that are together true exactly in the states in which a pass can begin if CNR TIM has this effect, as
    /// far as the search distinguishes states. Empty if there are too many states.
    fn starts(&self, reset: Reset) -> Vec<Logic> {
        let Some(begun) = pass_starts(self.source, self.latched, reset) else { return Vec::new() };
        let bits = |area, of: &BTreeSet<u32>| -> Vec<Cell> {
            of.iter().map(|&index| Cell { area, index }).collect()
        };
        let routines =
            self.source.routines.iter().enumerate().map(|(index, routine)| RoutinePositions {
                runs: routine.group.map(runs),
                places: self.places(index).into_iter().map(|(_, cell)| cell).collect(),
            });
        let routines: Vec<RoutinePositions> = routines.collect();
        let states = begun.starts.iter().map(|start| {
            let places = self.source.routines.iter().enumerate().map(|(index, routine)| {
                let place = match routine.group {
                    None => start.main,
                    Some(group) => *start.groups.get(&group)?,
                };
                self.position_bit(index, place)
            });
            let on = [bits(TIMERS, &start.timers), bits(OUTPUTS, &start.outputs)].concat();
            StartState { places: places.collect(), on: on.into_iter().collect() }
        });
        let cells = [bits(TIMERS, &begun.timers), bits(OUTPUTS, &begun.outputs)].concat();
        let states: Vec<StartState> = states.collect();
        invariants(&routines, &states, &cells)
    }

    fn finish(mut self) -> Program {
        let all = 0..self.program.instructions.len();
        let (name, count) = (self.source.name.clone(), self.source.instructions.len());
        self.program.files = vec![SourceFile { name, instructions: all, count }];
        self.program
    }
}

/// The cell of the bit that says whether a group runs.
fn runs(group: u32) -> Cell {
    Cell { area: RUNS, index: group }
}

fn always(cell: Cell, to: bool) -> Effect {
    Effect { when: When::Always, write: set(cell, to) }
}

fn set(cell: Cell, to: bool) -> Write {
    Write::Bit(BitTarget::Cell(cell), Logic::Const(to))
}

/// The name of an instruction's row in timing tables.
#[must_use]
pub fn mnemonic(op: Op) -> &'static str {
    match op {
        Op::And { negated: false, .. } => "AND",
        Op::And { .. } => "AND NOT",
        Op::Timer { .. } => "TIM",
        Op::Out { on: true, .. } => "OUT",
        Op::Out { .. } => "OUT NOT",
        Op::ResetTimer(_) => "CNR TIM",
        Op::Jump(_) => "JMP",
        Op::JumpIf(_) => "CJP",
        Op::Wait => "WAIT",
        Op::Label(_) => "LBL",
        Op::Groups => "GJ",
        Op::Start(_) => "GS",
        Op::Stop(_) => "GOFF",
        Op::Head(_) => "GN",
        Op::End(_) => "GE",
    }
}
