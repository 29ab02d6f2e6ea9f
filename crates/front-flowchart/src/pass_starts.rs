//! Finds the states in which a pass can begin: positions of all routines, started timers, and outputs.
//!
//! The search follows all passes from power-up, for any inputs and times. If there are too many states, outputs and
//! then timers are left out of them and may have any value, so that no possible state is missing.

use super::source::{Op, Source};
use std::collections::{BTreeMap, BTreeSet};

/// The largest total size of the states of all steps of the search.
const MAX_STEPS: usize = 2_000_000;
/// If there are more timers than this, states do not contain timers.
const MAX_TIMERS: usize = 250;
/// If the program tests more outputs than this, states do not contain outputs: since each may be on or off at power-up,
/// the search would begin with too many states.
const MAX_OUTPUTS: usize = 6;

/// A state at the beginning of a pass.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Start {
    /// The instruction at which the main routine continues.
    pub main: usize,
    /// The running groups, each with the instruction at which it continues.
    pub groups: BTreeMap<u32, usize>,
    /// The timers, among those in [`PassStarts::timers`], that earlier passes started, that were not reset, and that no
    /// TIM has since found to have timed out.
    pub timers: BTreeSet<u32>,
    /// The outputs that are on, among those in [`PassStarts::outputs`].
    pub outputs: BTreeSet<u32>,
}

/// All states in which a pass can begin, and the timers and outputs that they contain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PassStarts {
    /// The states in which a pass can begin.
    pub starts: BTreeSet<Start>,
    /// The timers that states contain; other timers may be in any state.
    pub timers: BTreeSet<u32>,
    /// The outputs that states contain; other outputs may be on or off.
    pub outputs: BTreeSet<u32>,
    /// The inputs without an image, which are read again at each test.
    direct: BTreeSet<u32>,
    /// The assumed effect of CNR TIM on a timer.
    reset: Reset,
}

/// The effect of CNR TIM on a timer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reset {
    /// CNR TIM resets the timer: the next TIM starts it with its full time.
    Nothing,
    /// CNR TIM keeps the remaining time of the timer: the next TIM continues with it.
    Rest,
    /// CNR TIM may have either effect.
    Either,
}

/// The states in which a pass can begin, found by a search from power-up. `None` if there are too many even without
/// timers and outputs. `latched`: an input has one value during a pass, otherwise any value at each test. `reset` is
/// the assumed effect of CNR TIM.
#[must_use]
pub fn pass_starts(source: &Source, latched: bool, reset: Reset) -> Option<PassStarts> {
    let every = |pick: &dyn Fn(Op) -> Option<u32>| -> BTreeSet<u32> {
        source.instructions.iter().filter_map(|one| pick(one.op)).collect()
    };
    let timers = every(&|op| match op {
        Op::Timer { timer, .. } => Some(timer),
        _ => None,
    });
    let set = every(&|op| match op {
        Op::Out { bit, .. } => Some(bit),
        _ => None,
    });
    let outputs = every(&|op| match op {
        Op::And { bit, .. } if set.contains(&bit) => Some(bit),
        _ => None,
    });
    let direct = if latched { BTreeSet::new() } else { source.inputs() };
    let none = BTreeSet::new();
    [(&timers, &outputs), (&timers, &none), (&none, &none)]
        .into_iter()
        .filter(|(timers, outputs)| timers.len() <= MAX_TIMERS && outputs.len() <= MAX_OUTPUTS)
        .find_map(|(timers, outputs)| {
            let (starts, direct) = (BTreeSet::new(), direct.clone());
            let (timers, outputs) = (timers.clone(), outputs.clone());
            follow(source, PassStarts { starts, timers, outputs, direct, reset })
        })
}

fn follow(source: &Source, mut view: PassStarts) -> Option<PassStarts> {
    let all: Vec<u32> = view.outputs.iter().copied().collect();
    let mut open: Vec<Start> = (0..1_u32 << all.len())
        .map(|mask| Start {
            main: source.routines[0].body.start,
            groups: BTreeMap::new(),
            timers: BTreeSet::new(),
            outputs: all
                .iter()
                .enumerate()
                .filter(|(i, _)| mask >> i & 1 == 1)
                .map(|(_, &bit)| bit)
                .collect(),
        })
        .collect();
    let mut steps = 0;
    while let Some(start) = open.pop() {
        if !view.starts.insert(start.clone()) {
            continue;
        }
        let mut seen = BTreeSet::new();
        let mut walks = vec![Walk::from(start)];
        while let Some(walk) = walks.pop() {
            if !seen.insert(walk.clone()) {
                continue;
            }
            steps += walk.size();
            if steps > MAX_STEPS {
                return None;
            }
            for next in walk.nexts(source, &view) {
                match next {
                    Next::On(walk) => walks.push(walk),
                    Next::Ends(start) => open.push(start),
                }
            }
        }
    }
    Some(view)
}

/// A pass that was followed up to the instruction `at`, not to its end.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Walk {
    state: Start,
    /// The index of the next instruction.
    at: usize,
    /// The condition that the tests so far have computed.
    holds: bool,
    /// The group whose turn it is, and where the main routine continues afterwards. `None` while the main routine runs.
    turn: Option<(u32, usize)>,
    /// The values that are known in this pass, of inputs with an image and of outputs that states do not contain.
    known: BTreeMap<u32, bool>,
    /// The timers that this pass has started.
    fresh: BTreeSet<u32>,
}

enum Next {
    On(Walk),
    Ends(Start),
}

impl From<Start> for Walk {
    fn from(state: Start) -> Walk {
        let (known, fresh) = (BTreeMap::new(), BTreeSet::new());
        Walk { at: state.main, state, holds: true, turn: None, known, fresh }
    }
}

impl Walk {
    fn nexts(self, source: &Source, view: &PassStarts) -> Vec<Next> {
        match source.instructions[self.at].op {
            Op::And { bit, negated } => self.test(bit, negated, view),
            Op::Timer { timer, tenths } => self.timer(timer, tenths, view),
            Op::Start(group) => self.start(source, group),
            // A timer that is reset may keep its remaining time.
            Op::ResetTimer(timer) => {
                let mut reset = self.clone().step();
                reset.state.timers.remove(&timer);
                reset.fresh.remove(&timer);
                match view.reset {
                    Reset::Nothing => vec![Next::On(reset)],
                    Reset::Rest => vec![Next::On(self.step())],
                    Reset::Either => vec![Next::On(reset), Next::On(self.step())],
                }
            }
            op => vec![self.act(source, view, op)],
        }
    }

    /// The size of the state, which counts towards [`MAX_STEPS`].
    fn size(&self) -> usize {
        let Start { groups, timers, outputs, .. } = &self.state;
        10 + groups.len() + timers.len() + outputs.len() + self.known.len() + self.fresh.len()
    }

    fn step(mut self) -> Walk {
        self.at += 1;
        self
    }

    fn test(self, bit: u32, negated: bool, view: &PassStarts) -> Vec<Next> {
        let values = if view.outputs.contains(&bit) {
            vec![self.state.outputs.contains(&bit)]
        } else {
            self.known.get(&bit).map_or(vec![false, true], |&value| vec![value])
        };
        let each = values.into_iter().map(|value| {
            let mut next = self.clone().step();
            if !view.outputs.contains(&bit) && !view.direct.contains(&bit) {
                next.known.insert(bit, value);
            }
            next.holds &= value != negated;
            Next::On(next)
        });
        each.collect()
    }

    fn timer(self, timer: u32, tenths: u32, view: &PassStarts) -> Vec<Next> {
        let in_view = view.timers.contains(&timer);
        let old = self.state.timers.contains(&timer);
        let mut waits = self.clone().step();
        waits.holds = false;
        if in_view && !old {
            waits.fresh.insert(timer);
        }
        let mut all = vec![Next::On(waits)];
        if old || tenths == 0 || !in_view {
            let mut out = self.step();
            out.state.timers.remove(&timer);
            out.fresh.remove(&timer);
            all.push(Next::On(out));
        }
        all
    }

    /// The ways in which a pass can continue after a GS, which may or may not restart a group that already runs.
    fn start(self, source: &Source, group: u32) -> Vec<Next> {
        let head = source.groups().find(|(number, _)| *number == group);
        let head = head.map_or(0, |(_, routine)| routine.body.start);
        let mut begins = self.clone().step();
        begins.state.groups.insert(group, head);
        let mut all = vec![Next::On(begins)];
        if self.state.groups.contains_key(&group) {
            all.push(Next::On(self.step()));
        }
        all
    }

    fn act(mut self, source: &Source, view: &PassStarts, op: Op) -> Next {
        let holds = std::mem::replace(&mut self.holds, true);
        match op {
            Op::Out { bit, on } => {
                if !view.outputs.contains(&bit) {
                    self.known.insert(bit, on);
                } else if on {
                    self.state.outputs.insert(bit);
                } else {
                    self.state.outputs.remove(&bit);
                }
            }
            Op::Jump(to) => return self.jump(to),
            Op::JumpIf(to) if holds => return self.jump(to),
            Op::Wait if !holds => {
                let here = source.condition(self.at);
                let Some((group, back)) = self.turn.take() else {
                    return self.end(here);
                };
                self.state.groups.insert(group, here);
                return self.groups(group + 1, back);
            }
            Op::Groups => {
                let back = self.at + 1;
                return self.groups(0, back);
            }
            Op::Stop(group) => {
                self.state.groups.remove(&group);
            }
            Op::End(group) => {
                self.state.groups.remove(&group);
                let back = self.turn.take().map_or(0, |(_, back)| back);
                return self.groups(group + 1, back);
            }
            _ => {}
        }
        Next::On(self.step())
    }

    fn jump(mut self, to: usize) -> Next {
        if self.turn.is_none() && to <= self.at {
            return self.end(to);
        }
        self.at = to;
        Next::On(self)
    }

    /// Gives the turn to the running group with the smallest number from `from` on; if there is none, the main routine
    /// continues at `back`.
    fn groups(mut self, from: u32, back: usize) -> Next {
        let next = self.state.groups.range(from..).next().map(|(&group, &place)| (group, place));
        self.turn = next.map(|(group, _)| (group, back));
        self.at = next.map_or(back, |(_, place)| place);
        Next::On(self)
    }

    fn end(mut self, main: usize) -> Next {
        self.state.main = main;
        self.state.timers.append(&mut self.fresh);
        Next::Ends(self.state)
    }
}
