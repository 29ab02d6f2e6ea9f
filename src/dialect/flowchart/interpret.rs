//! Runs a flowchart program pass by pass as it stands, apart from its translation: the translation's judge.

use super::{Op, Routine, Source};
use std::collections::BTreeMap;

/// What the program does not decide. Each question is asked once at most while its answer holds.
pub trait Plant {
    /// An input's or an output's state when the pass starts, where nothing has set it before.
    fn bit(&mut self, bit: u32) -> bool;
    /// Whether a timer that nothing has touched before runs or has run out already.
    fn started(&mut self, timer: u32) -> bool;
    /// Whether a timer that was started in an earlier pass has run out by now.
    fn elapsed(&mut self, timer: u32) -> bool;
    /// Which of so many places the routine stands at when nothing has moved it before. For a group the
    /// first means that it is stopped.
    fn stands(&mut self, group: Option<u32>, places: usize) -> usize;
    /// Whether GS starts a group again that runs already.
    fn restarts(&mut self, group: u32) -> bool;
}

/// How a pass ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// At a jump back or a WAIT of the main routine.
    Pass,
    /// Not at all: so many instructions ran that it goes round for ever.
    Never,
}

/// One pass.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pass {
    /// The instructions that ran, as indices into [`Source::instructions`], and whether each held: a test,
    /// a jump that was taken, a WAIT that let pass; true for all others.
    pub ran: Vec<(usize, bool)>,
    /// How it ended.
    pub ended: Ended,
}

/// More instructions than this in one pass are taken to be endless.
const ENDLESS: usize = 20_000;

/// What a timer does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Timer {
    /// Nothing.
    Idle,
    /// It was started in this pass.
    Fresh,
    /// It was started in an earlier pass, and runs or has run out.
    Old,
}

/// The program's state from pass to pass.
pub struct Machine<'s> {
    source: &'s Source,
    outputs: Vec<u32>,
    bits: BTreeMap<u32, bool>,
    timers: BTreeMap<u32, Timer>,
    /// Where each group stands; `None` if it is stopped.
    groups: BTreeMap<u32, Option<usize>>,
    main: Option<usize>,
}

impl<'s> Machine<'s> {
    /// A machine of whose state nothing is known: the plant is asked.
    #[must_use]
    pub fn anywhere(source: &'s Source) -> Machine<'s> {
        let outputs = source.instructions.iter().filter_map(|one| match one.op {
            Op::Out { bit, .. } => Some(bit),
            _ => None,
        });
        Machine {
            source,
            outputs: outputs.collect(),
            bits: BTreeMap::new(),
            timers: BTreeMap::new(),
            groups: BTreeMap::new(),
            main: None,
        }
    }

    /// A machine that was just switched on: outputs off, timers idle, groups stopped, the main routine at its
    /// beginning.
    #[must_use]
    pub fn switched_on(source: &'s Source) -> Machine<'s> {
        let mut machine = Machine::anywhere(source);
        machine.bits = machine.outputs.iter().map(|&bit| (bit, false)).collect();
        machine.groups = source.groups().map(|(group, _)| (group, None)).collect();
        machine.main = Some(0);
        for one in &source.instructions {
            if let Op::Timer { timer, .. } = one.op {
                machine.timers.insert(timer, Timer::Idle);
            }
        }
        machine
    }

    /// An output's state, as far as it is known.
    #[must_use]
    pub fn output(&self, bit: u32) -> Option<bool> {
        self.bits.get(&bit).copied()
    }

    /// Whether a group runs, as far as it is known.
    #[must_use]
    pub fn runs(&self, group: u32) -> Option<bool> {
        self.groups.get(&group).map(Option::is_some)
    }

    /// Runs one pass. Inputs are asked anew.
    pub fn pass(&mut self, plant: &mut impl Plant) -> Pass {
        let outputs = &self.outputs;
        self.bits.retain(|bit, _| outputs.contains(bit));
        for timer in self.timers.values_mut().filter(|timer| **timer == Timer::Fresh) {
            *timer = Timer::Old;
        }
        let source = self.source;
        let main = &source.routines[0];
        let start = match self.main {
            Some(at) => at,
            None => {
                let places = source.stands(main);
                places[plant.stands(None, places.len())]
            }
        };
        let mut pass = Pass { ran: Vec::new(), ended: Ended::Pass };
        let (stands, ended) = self.turn(main, start, plant, &mut pass.ran);
        self.main = stands;
        pass.ended = ended;
        pass
    }

    /// Runs a routine from a place on until its turn ends; where it stands then.
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
                    let value = *self.bits.entry(bit).or_insert_with(|| plant.bit(bit)) != negated;
                    ran[index].1 = value;
                    holds &= value;
                }
                Op::Timer { timer, tenths } => {
                    let value = self.timer(timer, tenths, plant);
                    ran[index].1 = value;
                    holds &= value;
                }
                Op::Out { bit, on } => {
                    self.bits.insert(bit, on);
                }
                Op::ResetTimer(timer) => {
                    self.timers.insert(timer, Timer::Idle);
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
                        self.groups.insert(group, Some(head));
                    }
                }
                Op::Stop(group) => {
                    self.groups.insert(group, None);
                }
                Op::End(_) => return (None, Ended::Pass),
                Op::Label(_) | Op::Head(_) => {}
            }
            at += 1;
        }
    }

    fn groups_turn(&mut self, plant: &mut impl Plant, ran: &mut Vec<(usize, bool)>) -> Ended {
        let source = self.source;
        for (group, routine) in source.groups() {
            if let Some(start) = self.place(group, plant) {
                let (stands, ended) = self.turn(routine, start, plant, ran);
                self.groups.insert(group, stands);
                if ended == Ended::Never {
                    return Ended::Never;
                }
            }
        }
        Ended::Pass
    }

    /// Whether the timer has run out; then it is idle again. An idle one is started.
    fn timer(&mut self, timer: u32, tenths: u32, plant: &mut impl Plant) -> bool {
        let unknown = || if plant.started(timer) { Timer::Old } else { Timer::Idle };
        let state = self.timers.entry(timer).or_insert_with(unknown);
        if *state == Timer::Idle {
            *state = Timer::Fresh;
        }
        // A time of nothing may be over at once.
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

    /// Where a group stands.
    fn place(&mut self, group: u32, plant: &mut impl Plant) -> Option<usize> {
        if let Some(place) = self.groups.get(&group) {
            return *place;
        }
        let (_, routine) = self.source.groups().find(|(number, _)| *number == group)?;
        let places = self.source.stands(routine);
        let chosen = plant.stands(Some(group), places.len() + 1);
        let place = chosen.checked_sub(1).map(|index| places[index]);
        self.groups.insert(group, place);
        place
    }
}
