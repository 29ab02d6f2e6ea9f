//! Executes a flowchart program pass by pass from its source. Tests compare its lowering with this interpreter.

use super::{Op, Routine, Source};
use std::collections::{BTreeMap, BTreeSet};

/// Chooses the values that the program does not determine. A value is asked for again only after it may have changed:
/// that of an input at each test, or once in a pass if there is an input image.
pub trait Plant {
    /// The state of an input: asked at each test, or at the first test of a pass if there is an input image. The state
    /// of an output that nothing has set or read before.
    fn bit(&mut self, bit: u32) -> bool;
    /// Whether a timer that was not used before is running or has timed out.
    fn started(&mut self, timer: u32) -> bool;
    /// Whether a timer that was started in an earlier pass has timed out.
    fn elapsed(&mut self, timer: u32) -> bool;
    /// Whether CNR TIM keeps the timer's remaining time, so that the next TIM continues with it.
    fn keeps_rest(&mut self, timer: u32) -> bool;
    /// The initial position of a routine, from 0 to `places` - 1. For a group, 0 means that the group is stopped.
    fn position(&mut self, group: Option<u32>, places: usize) -> usize;
    /// Whether GS restarts a group that already runs.
    fn restarts(&mut self, group: u32) -> bool;
}

/// How a pass of the program ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The pass ended at a jump back or a WAIT of the main routine.
    Pass,
    /// The pass did not end within 20,000 instructions, and is taken to repeat for ever.
    Never,
}

/// The result of one pass.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PassResult {
    /// The executed instructions (indices into [`Source::instructions`]), and whether each was true: a test, a jump
    /// that was taken, a WAIT that passed; true for all others.
    pub ran: Vec<(usize, bool)>,
    /// How the pass ended.
    pub ended: Ended,
}

/// A pass with more instructions is treated as endless.
const ENDLESS: usize = 20_000;

/// Whether a timer was started, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Timer {
    /// The timer was not started.
    Idle,
    /// The timer was started in this pass.
    Fresh,
    /// The timer was started in an earlier pass; it runs or has timed out.
    Old,
}

/// What is known of the memory between two passes: outputs, timers, and where each routine continues.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct State {
    bits: BTreeMap<u32, bool>,
    timers: BTreeMap<u32, Timer>,
    /// The instruction at which each group continues; `None` if the group is stopped. A group is missing if its state
    /// is not known yet.
    groups: BTreeMap<u32, Option<usize>>,
    /// The instruction at which the main routine continues; `None` if it is not known yet.
    main: Option<usize>,
}

/// A PLC that executes a program.
#[derive(Debug, Clone)]
pub struct Machine<'s> {
    source: &'s Source,
    /// Whether inputs are read once in a pass.
    latched: bool,
    outputs: BTreeSet<u32>,
    state: State,
}

impl<'s> Machine<'s> {
    /// A machine whose state is unknown; `plant` chooses each value that a pass needs.
    #[must_use]
    pub fn anywhere(source: &'s Source, latched: bool) -> Machine<'s> {
        Machine { source, latched, outputs: source.outputs(), state: State::default() }
    }

    /// A machine after power-up: timers are idle, groups are stopped, the main routine is at its beginning. The plant
    /// is asked for the outputs.
    #[must_use]
    pub fn switched_on(source: &'s Source, latched: bool) -> Machine<'s> {
        let mut machine = Machine::anywhere(source, latched);
        machine.state.groups = source.groups().map(|(group, _)| (group, None)).collect();
        machine.state.main = Some(0);
        for one in &source.instructions {
            if let Op::Timer { timer, .. } = one.op {
                machine.state.timers.insert(timer, Timer::Idle);
            }
        }
        machine
    }

    /// The state in which the next pass begins.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Whether an output is on after the passes so far. `None` if nothing has set or read it yet.
    #[must_use]
    pub fn output(&self, bit: u32) -> Option<bool> {
        self.state.bits.get(&bit).copied()
    }

    /// Whether a group runs after the passes so far. `None` if they did not determine it.
    #[must_use]
    pub fn runs(&self, group: u32) -> Option<bool> {
        self.state.groups.get(&group).map(Option::is_some)
    }

    /// Executes one pass. `plant` chooses the values that the program does not determine.
    pub fn pass(&mut self, plant: &mut impl Plant) -> PassResult {
        let source = self.source;
        let main = &source.routines[0];
        let start = match self.state.main {
            Some(at) => at,
            None => {
                let places = source.positions(main);
                places[plant.position(None, places.len())]
            }
        };
        let mut pass = PassResult { ran: Vec::new(), ended: Ended::Pass };
        let (stands, ended) = self.turn(main, start, plant, &mut pass.ran);
        self.state.main = stands;
        pass.ended = ended;
        let outputs = &self.outputs;
        self.state.bits.retain(|bit, _| outputs.contains(bit));
        for timer in self.state.timers.values_mut().filter(|timer| **timer == Timer::Fresh) {
            *timer = Timer::Old;
        }
        pass
    }

    /// Executes a routine from `start` until its turn ends, and adds its instructions to `ran`. Returns the instruction
    /// at which its next turn begins (`None` for a group that has ended), and how the turn ended.
    fn turn(
        &mut self,
        routine: &Routine,
        start: usize,
        plant: &mut impl Plant,
        ran: &mut Vec<(usize, bool)>,
    ) -> (Option<usize>, Ended) {
        let is_main = routine.group.is_none();
        let mut at = start;
        let mut holds = true;
        loop {
            if ran.len() >= ENDLESS {
                return (Some(at), Ended::Never);
            }
            let index = ran.len();
            ran.push((at, true));
            match self.source.instructions[at].op {
                Op::And { bit, negated } => {
                    let value = self.bit(bit, plant) != negated;
                    ran[index].1 = value;
                    holds &= value;
                }
                Op::Timer { timer, tenths } => {
                    let value = self.timer(timer, tenths, plant);
                    ran[index].1 = value;
                    holds &= value;
                }
                Op::Out { bit, on } => {
                    self.state.bits.insert(bit, on);
                }
                Op::ResetTimer(timer) => {
                    if !plant.keeps_rest(timer) {
                        self.state.timers.insert(timer, Timer::Idle);
                    }
                }
                Op::Jump(to) | Op::JumpIf(to) => {
                    let taken = std::mem::replace(&mut holds, true);
                    ran[index].1 = taken;
                    if taken {
                        if is_main && to <= at {
                            return (Some(to), Ended::Pass);
                        }
                        at = to;
                        continue;
                    }
                }
                Op::Wait => {
                    let passes = std::mem::replace(&mut holds, true);
                    ran[index].1 = passes;
                    if !passes {
                        return (Some(self.source.condition(at)), Ended::Pass);
                    }
                }
                Op::Groups => {
                    if self.groups_turn(plant, ran) == Ended::Never {
                        return (Some(at), Ended::Never);
                    }
                }
                Op::Start(group) => {
                    let head = self.head(group);
                    if self.place(group, plant).is_none() || plant.restarts(group) {
                        self.state.groups.insert(group, Some(head));
                    }
                }
                Op::Stop(group) => {
                    self.state.groups.insert(group, None);
                }
                Op::End(_) => return (None, Ended::Pass),
                Op::Label(_) | Op::Head(_) => {}
            }
            at += 1;
        }
    }

    /// The value that a test reads: the one that was written or read last, otherwise one that `plant` chooses. Without
    /// an input image, `plant` chooses an input's value at each test.
    fn bit(&mut self, bit: u32, plant: &mut impl Plant) -> bool {
        if !self.latched && !self.outputs.contains(&bit) {
            return plant.bit(bit);
        }
        *self.state.bits.entry(bit).or_insert_with(|| plant.bit(bit))
    }

    fn groups_turn(&mut self, plant: &mut impl Plant, ran: &mut Vec<(usize, bool)>) -> Ended {
        let source = self.source;
        for (group, routine) in source.groups() {
            if let Some(start) = self.place(group, plant) {
                let (stands, ended) = self.turn(routine, start, plant, ran);
                self.state.groups.insert(group, stands);
                if ended == Ended::Never {
                    return Ended::Never;
                }
            }
        }
        Ended::Pass
    }

    /// Executes TIM: starts an idle timer, and returns whether the timer has timed out. If it has, it is idle again.
    fn timer(&mut self, timer: u32, tenths: u32, plant: &mut impl Plant) -> bool {
        let unknown = || if plant.started(timer) { Timer::Old } else { Timer::Idle };
        let state = self.state.timers.entry(timer).or_insert_with(unknown);
        if *state == Timer::Idle {
            *state = Timer::Fresh;
        }
        // A timer with time 0 may time out at once.
        let out = (*state == Timer::Old || tenths == 0) && plant.elapsed(timer);
        if out {
            *state = Timer::Idle;
        }
        out
    }

    fn head(&self, group: u32) -> usize {
        let found = self.source.groups().find(|(number, _)| *number == group);
        found.map_or(0, |(_, routine)| routine.body.start)
    }

    /// The index of the instruction at which a group continues; `None` if the group is stopped. If the pass so far does
    /// not determine it, `plant` chooses, and the state keeps the choice.
    fn place(&mut self, group: u32, plant: &mut impl Plant) -> Option<usize> {
        if let Some(place) = self.state.groups.get(&group) {
            return *place;
        }
        let (_, routine) = self.source.groups().find(|(number, _)| *number == group)?;
        let places = self.source.positions(routine);
        let chosen = plant.position(Some(group), places.len() + 1);
        let place = chosen.checked_sub(1).map(|index| places[index]);
        self.state.groups.insert(group, place);
        place
    }
}
