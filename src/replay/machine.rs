//! The control of one scan: stack, slots, zones, loops, calls and the order of the routines.

use super::state::State;
use super::{Event, Free, Replay};
use crate::program::{
    ChoiceId, Exit, Frame, Instruction, Join, Logic, Program, Region, Step, When,
};
use crate::time::Picos;
use std::collections::BTreeMap;

/// A loop that is being run.
struct Loop {
    begin: usize,
    end: usize,
    turn: u32,
    turns: u32,
}

/// What belongs to one routine while it runs.
#[derive(Default)]
struct Routine {
    stack: Vec<bool>,
    slots: BTreeMap<u32, bool>,
    zones: Vec<(u32, bool)>,
    loops: Vec<Loop>,
    /// Where its caller goes on.
    back: usize,
}

/// Where control goes from an instruction.
enum Next {
    Go(usize),
    Return,
    End,
    Stop,
}

/// Why a main or interrupt routine ended.
#[derive(PartialEq)]
enum Ended {
    Itself,
    Scan,
}

pub(super) struct Machine<'p, F> {
    program: &'p Program,
    times: &'p [(Picos, Picos)],
    state: State<'p, F>,
    routines: Vec<Routine>,
    total: Picos,
    events: Vec<Event>,
    unbounded: Option<usize>,
}

impl<'p, F: Free> Machine<'p, F> {
    pub(super) fn new(program: &'p Program, times: &'p [(Picos, Picos)], free: F) -> Self {
        assert_eq!(times.len(), program.instructions.len(), "a time for every instruction");
        Machine {
            program,
            times,
            state: State::new(program, free),
            routines: Vec::new(),
            total: Picos::ZERO,
            events: Vec::new(),
            unbounded: None,
        }
    }

    pub(super) fn scan(mut self) -> Replay {
        let program = self.program;
        let broken = program.invariants.iter().enumerate();
        let broken = broken.filter(|(_, holds)| !self.state.logic(holds, true));
        let broken_invariants: Vec<usize> = broken.map(|(index, _)| index).collect();
        for main in &program.mains {
            if self.run(main.start, main.end) == Ended::Scan {
                break;
            }
        }
        for interrupt in &program.interrupts {
            for turn in 0..interrupt.times {
                self.state.enter(Frame { at: interrupt.entry, turn });
                self.run(interrupt.entry, program.instructions.len());
                self.state.leave();
            }
        }
        let broken_ranges = self.state.broken_ranges();
        let unbounded = self.unbounded;
        Replay {
            total: self.total,
            events: self.events,
            broken_ranges,
            broken_invariants,
            unbounded,
        }
    }

    /// Runs a routine that nobody called, `limit` being the instruction before which it ends by itself.
    fn run(&mut self, entry: usize, limit: usize) -> Ended {
        self.routines = vec![Routine::default()];
        let mut at = entry;
        let ended = loop {
            let limit = if self.routines.len() > 1 { usize::MAX } else { limit };
            if at >= limit.min(self.program.instructions.len()) {
                break Ended::Itself;
            }
            match self.execute(at) {
                Next::Go(target) => at = target,
                Next::Return => {
                    self.leave_loops(0);
                    at = self.routine().back;
                    self.routines.pop();
                    if self.routines.is_empty() {
                        break Ended::Itself;
                    }
                    self.state.leave();
                }
                Next::End => break Ended::Itself,
                Next::Stop => break Ended::Scan,
            }
        };
        while !self.routines.is_empty() {
            self.leave_loops(0);
            self.routines.pop();
            if !self.routines.is_empty() {
                self.state.leave();
            }
        }
        ended
    }

    fn routine(&mut self) -> &mut Routine {
        self.routines.last_mut().expect("a routine is running")
    }

    /// Ends the innermost loops of the routine until so many are open.
    fn leave_loops(&mut self, open: usize) {
        while self.routine().loops.len() > open {
            self.routine().loops.pop();
            self.state.leave();
        }
    }

    fn execute(&mut self, at: usize) -> Next {
        let instruction = &self.program.instructions[at];
        let condition = self.condition(&instruction.step);
        let (expression, count) = match &instruction.step {
            Step::Logic { value, .. } => (Some(value), 0),
            Step::Act { fires }
            | Step::Jump { fires, .. }
            | Step::Call { fires, .. }
            | Step::Stop { fires }
            | Step::ZoneBegin { fires, .. } => (Some(fires), 0),
            Step::ForBegin { count, .. } => (None, self.state.word(*count)),
            _ => (None, 0),
        };
        let fired = expression.is_none_or(|logic: &Logic| self.state.logic(logic, condition));
        let (on, off) = self.times[at];
        self.charge(at, fired, if fired { on } else { off });
        self.change(instruction, condition, fired);
        self.step(at, &instruction.step, fired, count)
    }

    fn condition(&mut self, step: &Step) -> bool {
        let acts = match step {
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
            | Step::Bulk { .. }
            | Step::ZoneBegin { .. }
            | Step::ZoneEnd { .. }
            | Step::Nothing => true,
        };
        let routine = self.routine();
        let top = routine.stack.last().copied().unwrap_or(true);
        top && (!acts || routine.zones.iter().all(|&(_, condition)| condition))
    }

    fn charge(&mut self, instruction: usize, fired: bool, cost: Picos) {
        self.total += cost;
        let frames = self.state.frames().clone();
        self.events.push(Event { instruction, frames, fired, cost });
    }

    fn change(&mut self, instruction: &Instruction, condition: bool, fired: bool) {
        for effect in &instruction.effects {
            if effect.when == When::Always || fired {
                self.state.write(&effect.write, condition);
            }
        }
    }

    fn step(&mut self, at: usize, step: &Step, fired: bool, count: u16) -> Next {
        match step {
            Step::Logic { join, .. } => self.join(*join, fired),
            Step::AndBlock => self.block(|a, b| a && b),
            Step::OrBlock => self.block(|a, b| a || b),
            Step::Save(slot) => {
                let routine = self.routine();
                let top = routine.stack.last().copied().unwrap_or(true);
                routine.slots.insert(*slot, top);
            }
            Step::Fetch(slot) => {
                let saved = self.routine().slots.get(slot).copied().unwrap_or(true);
                self.join(Join::Replace, saved);
            }
            Step::Jump { target, .. } if fired => return self.go(*target),
            Step::Call { target, .. } if fired => {
                self.routines.push(Routine { back: at + 1, ..Routine::default() });
                self.state.enter(Frame { at, turn: 0 });
                return Next::Go(*target);
            }
            Step::Return => return Next::Return,
            Step::End => return Next::End,
            Step::Unbounded { .. } => {
                self.unbounded = Some(at);
                return Next::Stop;
            }
            Step::Stop { .. } if fired => return Next::Stop,
            Step::ForBegin { least, most, end, .. } => {
                let turns = u32::try_from(count.cast_signed()).unwrap_or(0);
                let turns = turns.max(*least).min(*most);
                if turns == 0 {
                    return Next::Go(end + 1);
                }
                self.routine().loops.push(Loop { begin: at, end: *end, turn: 0, turns });
                self.state.enter(Frame { at, turn: 0 });
            }
            Step::ForEnd => return self.end_turn(at),
            Step::Bulk { end, charges, forgets, choice, exits } => {
                return self.bulk(*end, charges, forgets, *choice, exits);
            }
            Step::ZoneBegin { level, .. } => self.routine().zones.push((*level, fired)),
            Step::ZoneEnd { level } => self.routine().zones.retain(|(open, _)| open < level),
            Step::Act { .. }
            | Step::Jump { .. }
            | Step::Call { .. }
            | Step::Stop { .. }
            | Step::Nothing => {}
        }
        Next::Go(at + 1)
    }

    fn join(&mut self, join: Join, value: bool) {
        let stack = &mut self.routine().stack;
        let top = match join {
            Join::Start => {
                stack.clear();
                value
            }
            Join::Load => value,
            Join::And => stack.pop().unwrap_or(true) && value,
            Join::Or => stack.pop().unwrap_or(true) || value,
            Join::Replace => {
                stack.pop();
                value
            }
        };
        stack.push(top);
    }

    fn block(&mut self, join: fn(bool, bool) -> bool) {
        let stack = &mut self.routine().stack;
        let upper = stack.pop().unwrap_or(true);
        let lower = stack.pop().unwrap_or(true);
        stack.push(join(lower, upper));
    }

    /// Goes on elsewhere in the same routine; loops in which the target does not stand end.
    fn go(&mut self, target: usize) -> Next {
        let loops = &self.routine().loops;
        let open = loops.iter().take_while(|l| l.begin < target && target <= l.end).count();
        self.leave_loops(open);
        Next::Go(target)
    }

    fn end_turn(&mut self, at: usize) -> Next {
        let Some(current) = self.routine().loops.last_mut().filter(|current| current.end == at)
        else {
            return Next::Go(at + 1);
        };
        current.turn += 1;
        let (begin, turn, turns) = (current.begin, current.turn, current.turns);
        if turn == turns {
            let open = self.routine().loops.len() - 1;
            self.leave_loops(open);
            return Next::Go(at + 1);
        }
        self.state.leave();
        self.state.enter(Frame { at: begin, turn });
        Next::Go(begin + 1)
    }

    /// Charges what is taken in bulk and says where control goes on.
    fn bulk(
        &mut self,
        end: usize,
        charges: &[(usize, u64)],
        forgets: &[Region],
        choice: ChoiceId,
        exits: &[(ChoiceId, Exit)],
    ) -> Next {
        for &(instruction, repetitions) in charges {
            let (on, off) = self.times[instruction];
            self.charge(instruction, on >= off, on.max(off).times(repetitions));
        }
        for &region in forgets {
            self.state.forget(region, choice);
        }
        let routine = self.routine();
        routine.stack.clear();
        routine.slots.clear();
        match exits.iter().find(|(exit, _)| self.state.choose_bit(*exit)) {
            None => self.go(end + 1),
            Some((_, Exit::To(target))) => self.go(*target),
            Some((_, Exit::Return)) => Next::Return,
            Some((_, Exit::End)) => Next::End,
            Some((_, Exit::Stop)) => Next::Stop,
        }
    }
}
