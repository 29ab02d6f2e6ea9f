//! Says what a flowchart program means to the analysis: one pass as a scan of jumps forward and calls.
//!
//! Where a routine stands when the pass begins is a bit a place, and whether a group runs is a bit too: the main
//! routine and every group begin with jumps to where they stand. A group leaves its place with the jump, and takes
//! its next where its turn ends. A jump back in the main routine ends the pass. A group is laid out once for each
//! jump back that its turn can make, one layout behind the other, so that all its jumps go forward; a turn that
//! makes more of them goes round for ever ([`Step::Unbounded`]).
//!
//! An input is any value wherever it is tested, unless the user states an image of the inputs: then it has one
//! value through the pass. A timer is one bit: whether it was started in an earlier pass. Only then may it have run out.
//! CNR TIM may reset it, or stop it and leave it the rest of its time, as the document has it of a timer that is used again
//! before it was over (3.2.1 (1)): either may be, so after it the timer may still be over in the pass that starts it again.

use super::beginning::{Beginning, Stands, invariants};
use super::pass_starts::{Reset, pass_starts};
use super::source::{self, NAME, Op, Routine, Source};
use super::turn::jumps_back;
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

const INPUTS: AreaId = AreaId(0);
const OUTPUTS: AreaId = AreaId(1);
const TIMERS: AreaId = AreaId(2);
const HEADS: AreaId = AreaId(3);
const BACK: AreaId = AreaId(4);
const RUNS: AreaId = AreaId(5);
/// Timers that this pass has started.
const STARTED: AreaId = AreaId(6);
/// The first of the areas of WAITs, one a routine.
const WAITS: u16 = 7;
/// No group is laid out with more instructions than this, unless a single copy of it has more.
const MOST_LAID: usize = 100_000;

/// A tenth of a second.
const TENTH: u64 = 100_000_000_000;

/// The program of a source: one scan is one pass. `latched`: inputs are read once a pass, not at each test.
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
    let (calls, told) = (Vec::new(), BTreeSet::new());
    let timers = timers(source);
    let mut layout = Layout { source, latched, outputs, blocks, timers, program, calls, told };
    for (index, routine) in source.routines.iter().enumerate() {
        layout.routine(index, routine);
    }
    layout.invariant();
    layout.finish()
}

/// The input, output or timer that an instruction names: the number in its text.
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

/// The timers, as long as all of them together with all ends of passes are few enough to be carried from pass to pass.
fn timers(source: &Source) -> BTreeSet<u32> {
    const MOST: usize = 20_000;
    let all: BTreeSet<u32> = source
        .instructions
        .iter()
        .filter_map(|one| match one.op {
            Op::Timer { timer, .. } => Some(timer),
            _ => None,
        })
        .collect();
    let ends = source.instructions.iter().filter(|one| one.op.leaves() || one.op.asks()).count();
    if all.len().saturating_mul(ends) <= MOST { all } else { BTreeSet::new() }
}

/// The flowchart's boxes, numbered from 1: for each instruction the box in which it stands.
fn blocks(source: &Source) -> Vec<u32> {
    let mut block = 0;
    let mut ended = true;
    let mut tests = false;
    let mut blocks = Vec::with_capacity(source.instructions.len());
    for one in &source.instructions {
        let begins = matches!(one.op, Op::Label(_) | Op::Head(_));
        let condition = one.op.is_test() || one.op.asks();
        // A label stands at the box behind it.
        if begins || ended || condition != tests {
            block += 1;
        }
        ended = one.op.asks() || one.op.leaves();
        tests = if begins { blocks_begin_with_test(source, blocks.len()) } else { condition };
        blocks.push(block);
    }
    blocks
}

/// Whether what stands behind a label is a condition.
fn blocks_begin_with_test(source: &Source, label: usize) -> bool {
    source.instructions.get(label + 1).is_some_and(|next| next.op.is_test())
}

/// A place in the layout of a routine: which copy, and the source's instruction.
type Spot = (usize, usize);

/// The program as it is being laid out.
struct Layout<'s> {
    source: &'s Source,
    /// Whether inputs have one value through a pass.
    latched: bool,
    outputs: BTreeSet<u32>,
    blocks: Vec<u32>,
    /// The timers whose state is carried from pass to pass.
    timers: BTreeSet<u32>,
    program: Program,
    /// Calls of groups whose place is not yet known: the instruction and the group.
    calls: Vec<(usize, u32)>,
    /// Instructions whose approximation is listed.
    told: BTreeSet<usize>,
}

/// One routine while it is laid out.
struct Open {
    routine: usize,
    is_main: bool,
    copies: usize,
    /// Where each spot begins.
    laid: BTreeMap<Spot, usize>,
    /// Jumps whose spot is laid out later.
    jumps: Vec<(usize, Spot)>,
    /// Jumps back from the last copy: the jump and its target in the source.
    rounds: Vec<(usize, usize, usize)>,
}

impl Layout<'_> {
    /// The bit that says that a routine stands at a place; `None` for the main routine's head.
    fn stands(&self, routine: usize, place: usize) -> Option<Cell> {
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
        let places = self.source.stands(&self.source.routines[routine]);
        places.into_iter().filter_map(|at| Some((at, self.stands(routine, at)?))).collect()
    }

    fn routine(&mut self, index: usize, routine: &Routine) {
        let is_main = routine.group.is_none();
        let most = MOST_LAID / routine.body.len().max(1);
        let copies = match is_main {
            true => 0,
            false => jumps_back(self.source, routine, self.latched).min(most),
        };
        let reached = self.reached(routine, copies);
        let mut open = Open {
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
            // At its head a group also clears the places where it stood when it was stopped.
            let left = places.iter().filter(|other| (!is_main && head) || other.0 == place);
            let left = left.map(|&(_, cell)| Effect { when: When::Fired, write: set(cell, false) });
            let effects = left.collect();
            let at = self.put(place, None, step, effects);
            open.jumps.push((at, (0, place)));
        }
        if !is_main {
            self.put(routine.body.start, None, Step::Return, vec![]);
        }
        for &spot in &reached {
            open.laid.insert(spot, self.program.instructions.len());
            self.instruction(spot, &mut open);
        }
        for (jump, at, to) in std::mem::take(&mut open.rounds) {
            let from = open.laid.range((0, to)..).find(|(spot, _)| spot.1 == to);
            let from = from.map_or(start, |(_, &from)| from);
            let round = self.put(at, None, Step::Unbounded { from, certain: true }, vec![]);
            self.aim(jump, round);
        }
        for (jump, spot) in std::mem::take(&mut open.jumps) {
            self.aim(jump, open.laid[&spot]);
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

    /// The spots that control can come to.
    fn reached(&self, routine: &Routine, copies: usize) -> BTreeSet<Spot> {
        let mut reached = BTreeSet::new();
        let mut open: Vec<Spot> =
            self.source.stands(routine).into_iter().map(|place| (0, place)).collect();
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

    fn instruction(&mut self, spot: Spot, open: &mut Open) {
        let (copy, at) = spot;
        let whenever = Logic::Const(true);
        match self.source.instructions[at].op {
            Op::And { bit, negated } => {
                let value = self.test(bit);
                let value = if negated { value.not() } else { value };
                let step = Step::Logic { join: self.join(at), value };
                self.put(at, Some(("contact", false)), step, vec![]);
            }
            Op::Timer { timer, tenths } => {
                self.tell(at, "a timer of an earlier pass may or may not have run out");
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
                self.put(at, Some(("timer", false)), step, effects);
            }
            Op::Out { bit, on } => {
                let effect = always(self.bit(bit), on);
                self.put(at, Some(("coil", true)), Step::Act { fires: whenever }, vec![effect]);
            }
            Op::ResetTimer(timer) => {
                self.tell(at, "CNR TIM may reset a timer or leave it the rest of its time");
                let rest = self.unknown();
                let effects = [TIMERS, STARTED].map(|area| {
                    let cell = Cell { area, index: timer };
                    let stays = Logic::All(vec![Logic::cell(cell), rest.clone()]);
                    Effect { when: When::Always, write: Write::Bit(BitTarget::Cell(cell), stays) }
                });
                let step = Step::Act { fires: whenever };
                self.put(at, Some(("timer", true)), step, effects.into());
            }
            Op::Jump(to) => self.jump(spot, to, whenever, open),
            Op::JumpIf(to) => self.jump(spot, to, Logic::Condition, open),
            Op::Wait => {
                let step = Step::Jump { fires: Logic::Condition, target: 0 };
                let jump = self.put(at, Some(("jump", false)), step, vec![]);
                open.jumps.push((jump, (copy, at + 1)));
                if open.is_main {
                    let effects = self.ends(open.routine, self.source.condition(at));
                    self.put(at, None, Step::Stop { fires: whenever }, effects);
                } else {
                    let here = self.stands(open.routine, self.source.condition(at));
                    let here = here.into_iter().map(|cell| always(cell, true)).collect();
                    self.put(at, None, Step::Return, here);
                }
            }
            Op::Groups => {
                self.put(at, Some(("call", true)), Step::Act { fires: whenever }, vec![]);
                let groups: Vec<u32> = self.source.groups().map(|(group, _)| group).collect();
                for group in groups {
                    let step = Step::Call { fires: Logic::cell(runs(group)), target: 0 };
                    let call = self.put(at, None, step, vec![]);
                    self.program.instructions[call].text = format!("GJ, group {group}").into();
                    self.calls.push((call, group));
                }
            }
            Op::Start(group) => self.start(at, group),
            Op::Stop(group) => {
                let effects = vec![always(runs(group), false)];
                self.put(at, Some(("call", true)), Step::Act { fires: whenever }, effects);
            }
            Op::End(group) => {
                let effects = vec![always(runs(group), false)];
                self.put(at, Some(("call", true)), Step::Return, effects);
            }
            Op::Label(_) | Op::Head(_) => {
                self.put(at, Some(("nothing", true)), Step::Nothing, vec![]);
            }
        }
    }

    /// GS: a group that is stopped begins at its head; one that runs may begin again or not.
    fn start(&mut self, at: usize, group: u32) {
        self.tell(at, "GS on a group that runs may start it again or leave it as it is");
        // Which of both a PLC does is not documented: no lower bound may rest on it.
        let again = self.unknown();
        let fires = Logic::Any(vec![Logic::cell(runs(group)).not(), again]);
        let head = Cell { area: HEADS, index: group };
        let on = |cell| Effect { when: When::Fired, write: set(cell, true) };
        let effects = vec![on(runs(group)), on(head)];
        self.put(at, Some(("call", true)), Step::Act { fires }, effects);
    }

    fn jump(&mut self, (copy, at): Spot, to: usize, fires: Logic, open: &mut Open) {
        if to <= at && open.is_main {
            let effects = self.ends(open.routine, to);
            self.put(at, Some(("jump", false)), Step::Stop { fires }, effects);
            return;
        }
        let jump = self.put(at, Some(("jump", false)), Step::Jump { fires, target: 0 }, vec![]);
        if to > at {
            open.jumps.push((jump, (copy, to)));
        } else if copy < open.copies {
            open.jumps.push((jump, (copy + 1, to)));
        } else {
            open.rounds.push((jump, at, to));
        }
    }

    /// What the end of a pass leaves: where the main routine goes on, and the timers that the pass has started.
    fn ends(&self, routine: usize, place: usize) -> Vec<Effect> {
        let fired = |write| Effect { when: When::Fired, write };
        let place = self.stands(routine, place).map(|cell| fired(set(cell, true)));
        let timers = self.timers.iter().flat_map(|&index| {
            let [old, started] = [TIMERS, STARTED].map(|area| Cell { area, index });
            let runs = Logic::Any(vec![Logic::cell(old), Logic::cell(started)]);
            [fired(Write::Bit(BitTarget::Cell(old), runs)), fired(set(started, false))]
        });
        place.into_iter().chain(timers).collect()
    }

    /// Whether a timer that was started in an earlier pass is over, which the outside decides.
    fn elapsed(&mut self, memory: Cell, tenths: u32) -> Logic {
        let over = ChoiceId(self.program.choices);
        let words = [tenths as u16, (tenths >> 16) as u16].map(WordSource::Const);
        let expiry = Expiry {
            setting: words.into(),
            ..Expiry::of_on_delay(memory, WordSource::Const(0), Picos(TENTH))
        };
        self.program.timekeeping.expiries.insert(over, expiry);
        self.any()
    }

    /// How a test joins the condition: the first begins a new one.
    fn join(&self, at: usize) -> Join {
        let follows =
            at.checked_sub(1).is_some_and(|before| self.source.instructions[before].op.is_test());
        if follows { Join::And } else { Join::Start }
    }

    fn bit(&self, bit: u32) -> Cell {
        let area = if self.outputs.contains(&bit) { OUTPUTS } else { INPUTS };
        Cell { area, index: bit }
    }

    /// What a test finds.
    fn test(&mut self, bit: u32) -> Logic {
        if self.latched || self.outputs.contains(&bit) {
            Logic::cell(self.bit(bit))
        } else {
            self.any()
        }
    }

    /// A value that is not known.
    fn unknown(&mut self) -> Logic {
        self.program.choices += 1;
        Logic::Bit(BitSource::Free(ChoiceId(self.program.choices - 1)))
    }

    /// A value that the outside decides.
    fn any(&mut self) -> Logic {
        self.program.kinds.insert(ChoiceId(self.program.choices), ChoiceKind::External);
        self.unknown()
    }

    /// Lists an over-approximation at the instruction that comes next.
    fn tell(&mut self, at: usize, what: &str) {
        if self.told.insert(at) {
            let instruction = self.program.instructions.len();
            self.program.approximate(instruction, what);
        }
    }

    /// Adds an instruction of the program for one of the source. `class` names the timing class and whether both
    /// times are the dearer; without it the instruction costs nothing.
    fn put(
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
            timing: class.map(|(class, dearer)| {
                Box::new(TimingKey {
                    names: vec![mnemonic(one.op).to_owned()],
                    class,
                    units: Units::None,
                    use_larger_time: dearer,
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

    /// Holds the start of a pass to the states in which one can begin. A real pass begins where one can whatever CNR TIM
    /// leaves.
    fn invariant(&mut self) {
        self.program.invariants = self.starts(Reset::Either);
        let is_reset = |one: &source::Instruction| matches!(one.op, Op::ResetTimer(_));
        if self.source.instructions.iter().any(is_reset) {
            let readings = [Reset::Nothing, Reset::Rest].map(|reset| self.starts(reset));
            self.program.power_up.certain_invariants = readings.concat();
        }
    }

    /// What holds in the states in which a pass can begin; nothing if these are too many.
    fn starts(&self, reset: Reset) -> Vec<Logic> {
        let Some(begun) = pass_starts(self.source, self.latched, reset) else { return Vec::new() };
        let bits = |area, of: &BTreeSet<u32>| -> Vec<Cell> {
            of.iter().map(|&index| Cell { area, index }).collect()
        };
        let routines = self.source.routines.iter().enumerate().map(|(index, routine)| Stands {
            runs: routine.group.map(runs),
            places: self.places(index).into_iter().map(|(_, cell)| cell).collect(),
        });
        let routines: Vec<Stands> = routines.collect();
        let states = begun.starts.iter().map(|start| {
            let places = self.source.routines.iter().enumerate().map(|(index, routine)| {
                let place = match routine.group {
                    None => start.main,
                    Some(group) => *start.groups.get(&group)?,
                };
                self.stands(index, place)
            });
            let on = [bits(TIMERS, &start.timers), bits(OUTPUTS, &start.outputs)].concat();
            Beginning { places: places.collect(), on: on.into_iter().collect() }
        });
        let cells = [bits(TIMERS, &begun.timers), bits(OUTPUTS, &begun.outputs)].concat();
        let states: Vec<Beginning> = states.collect();
        invariants(&routines, &states, &cells)
    }

    fn finish(mut self) -> Program {
        let all = 0..self.program.instructions.len();
        let (name, count) = (self.source.name.clone(), self.source.instructions.len());
        self.program.files = vec![SourceFile { name, instructions: all, count }];
        self.program
    }
}

/// The bit that says that a group runs.
fn runs(group: u32) -> Cell {
    Cell { area: RUNS, index: group }
}

fn always(cell: Cell, to: bool) -> Effect {
    Effect { when: When::Always, write: set(cell, to) }
}

fn set(cell: Cell, to: bool) -> Write {
    Write::Bit(BitTarget::Cell(cell), Logic::Const(to))
}

/// The name of an instruction's row in a timing table.
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
