//! Lowers the control of actions, with the standard's rules and those of controllers that differ (`docs/sfc.md`).

use super::Assembler;
use super::memory::{ActionMemory, InputMemory, Memory, all, any, set};
use super::value::{constant, signed};
use scanbound_front::builder::always;
use scanbound_iec::chart::{Feed, Qualifier};
use scanbound_ir::{BitSource, Cell, Logic, Number, Relation, Step, Write};

/// How all action controls of a chart work on this controller.
pub(crate) struct Whole {
    /// Whether R ends only stored actions, so that others continue.
    pub(crate) reset_only_stored: Logic,
    /// Whether controllers skip the final execution of an action's body after the action ends.
    pub(crate) no_final_scan: Logic,
    /// Whether initial steps are active in the first scan without counting as entered.
    pub(crate) not_entered: Logic,
    /// True in the first scan, on controllers where the times of initial steps run before it.
    pub(crate) runs_early: Logic,
    /// The initial steps of the chart, by number.
    pub(crate) initial_steps: Vec<usize>,
    /// The initial steps to which a transition leads, by number.
    pub(crate) entered_again: Vec<usize>,
}

impl Whole {
    /// Whether one of an input's steps is an initial step.
    fn has_initial(&self, feed: &Feed) -> bool {
        feed.steps.iter().any(|step| self.initial_steps.contains(step))
    }

    /// Whether a transition leads to each initial step of an input.
    fn is_entered_again(&self, feed: &Feed) -> bool {
        let mut initial = feed.steps.iter().filter(|step| self.initial_steps.contains(step));
        initial.all(|step| self.entered_again.contains(step))
    }
}

/// The result of an action's control.
#[derive(Clone)]
pub(crate) struct Output {
    /// True where the action is on, pulses included.
    pub(crate) on: Logic,
    /// True where its body is executed in this scan: also once more after the action ends, on controllers with a final
    /// scan.
    pub(crate) runs: Logic,
    /// What the blocks write to the action's Boolean variable on controllers where each block writes it by itself.
    /// `None` if the action is not a variable.
    pub(crate) written: Option<Written>,
}

/// What the blocks of an action write to its Boolean variable on controllers where each block writes it by itself
/// (matiec: "Steps association" and "Actions execution" of `generate_c_sfc.cc`).
#[derive(Clone)]
pub(crate) struct Written {
    /// True where they switch it on.
    sets: Logic,
    /// True where they do not write it.
    stays: Logic,
    /// Whether this may differ from the action's state although nothing else writes the variable: blocks that store or
    /// reset the action stand beside blocks that do not.
    differs: bool,
}

/// The value of a Boolean variable before its action sets it.
pub(crate) enum Before {
    /// The bit in this cell.
    Cell(Cell),
    /// This bit of a word.
    Bit(Cell, u8),
    /// It is not modelled: any value.
    Any,
}

/// The result of one input of an action's control.
struct Given {
    /// True where this input turns the action on.
    on: Logic,
    /// Whether this is stored, so that R ends it.
    is_stored: bool,
    /// True where it may switch off an action that another block has switched on.
    off: Logic,
}

/// The time of an input of an action's control.
pub(crate) struct InputTime {
    /// Whether it is 0 or less, so that it may be over at once.
    pub(crate) is_over: Logic,
    /// The time in units of half a millisecond, if it is a constant.
    pub(crate) units: Option<u32>,
}

fn now(cell: Cell) -> Logic {
    Logic::cell(cell)
}

/// True where one of these steps became active in this scan.
fn entered(memory: &Memory, steps: &[usize]) -> Logic {
    any(steps.iter().map(|&at| all([now(memory.steps[at]), now(memory.were[at]).not()])))
}

/// True where one of these steps ended in this scan.
fn left(memory: &Memory, steps: &[usize]) -> Logic {
    any(steps.iter().map(|&at| all([now(memory.were[at]), now(memory.steps[at]).not()])))
}

impl Assembler {
    /// Lowers the control of an action and charges it. `times`: the time of each input. `is_variable`: whether the
    /// action is a Boolean variable.
    pub(crate) fn control(
        &mut self,
        memory: &Memory,
        action: &ActionMemory,
        whole: &Whole,
        times: &[InputTime],
        is_variable: bool,
    ) -> Output {
        let reset = self.keep_bit(action.active(memory, Qualifier::R));
        let now_stores = self.keep_bit(action.active(memory, Qualifier::S));
        let stored = all([any([now(action.stored), now_stores.clone()]), reset.clone().not()]);
        let mut changes = vec![set(action.stored, stored)];
        let (mut levels, mut stored, mut offs) = (Vec::new(), vec![now(action.stored)], Vec::new());
        let mut pulses = Vec::new();
        let mut keep = Vec::new();
        let is_timed = |feed: &Feed| feed.qualifier.is_stored() && feed.qualifier.is_timed();
        let timed: Vec<(Qualifier, Cell, Logic)> = { action.feeds.iter().zip(&action.inputs) }
            .filter(|(feed, _)| is_timed(feed))
            .map(|(feed, input)| (feed.qualifier, input.over, self.keep_bit(now(input.over))))
            .collect();
        let inputs = action.feeds.iter().zip(&action.inputs).zip(times);
        for ((feed, input), time) in inputs {
            keep.push(set(input.was, memory.active(&feed.steps)));
            let resets = action.has_reset().then_some(&reset);
            let given = self.input((memory, whole), (feed, input), time, resets, &mut changes);
            match feed.qualifier {
                Qualifier::R | Qualifier::S => {}
                Qualifier::P1 | Qualifier::P0 => pulses.push(given.on),
                _ if given.is_stored => stored.push(given.on),
                _ => levels.push(given.on),
            }
            offs.push(given.off);
        }
        self.write(changes);
        let expires = |limits: bool| {
            let some = timed.iter().filter(move |one| (one.0 == Qualifier::Sl) == limits);
            any(some.map(|(_, over, was)| all([now(*over), was.clone().not()])))
        };
        let (limit_ends, delay_ends) =
            (self.keep_bit(expires(true)), self.keep_bit(expires(false)));
        if action.feeds.iter().filter(|feed| feed.qualifier.is_stored()).count() > 1 {
            self.limits_end_all(action, &limit_ends);
        }
        // If several blocks without storing name the action, on some controllers the last one decides. Which one is
        // last depends on the order of the steps there, so the action may be off if any of them has it off.
        let blocks: usize = action.feeds.iter().map(|feed| feed.steps.len()).sum();
        let is_off = self.keep_bit(any(offs));
        let (overruled, last_is_off) = match blocks {
            2.. => {
                let last = self.differs("of several blocks of an action, the last one decides");
                let last_is_off = self.left_open();
                let overruled = all([is_off.clone(), last, last_is_off.clone()]);
                (self.keep_bit(overruled), last_is_off)
            }
            _ => (Logic::Const(false), Logic::Const(true)),
        };
        let held = match action.has_reset() {
            true => all([reset.clone(), whole.reset_only_stored.clone().not()]),
            false => Logic::Const(false),
        };
        let is_on = self.keep_bit(any(levels.iter().chain(&pulses).cloned()));
        let unstored = all([any(levels), held.not(), overruled.clone().not()]);
        let was_on = self.keep_bit(now(action.on));
        let stored = self.keep_bit(all([any(stored), reset.clone().not()]));
        let on = self.keep_bit(any([unstored, stored.clone()]));
        let pulse = self.keep_bit(all([any(pulses), overruled.not()]));
        let ends = self.keep_bit(all([was_on.clone(), on.clone().not()]));
        let last = all([ends.clone(), whole.no_final_scan.clone().not()]);
        let runs = self.keep_bit(any([on.clone(), pulse.clone(), last]));
        keep.push(set(action.on, on.clone()));
        let effects = keep.into_iter().map(always).collect();
        let key = Assembler::key(&["ACTION"], "nothing");
        self.builder.add(Some(key), effects, Step::Act { fires: runs.clone() });
        let written = is_variable.then(|| {
            // A block that stores or resets the action comes after the others, and R comes last.
            let begins = { action.feeds.iter() }.filter(|feed| feed.qualifier == Qualifier::Sl);
            let begins = any(begins.map(|feed| entered(memory, &feed.steps)));
            let stores = any([now_stores, begins, delay_ends, all([stored, was_on.not()])]);
            let clears = any([reset, limit_ends]);
            let switches_on = all([is_on.clone(), all([is_off.clone(), last_is_off]).not()]);
            let on = any([stores.clone(), switches_on]);
            let sets = self.keep_bit(all([on, clears.clone().not()]));
            let stays = self.keep_bit(any([clears, stores, is_on, is_off]).not());
            let keeps = |feed: &Feed| feed.qualifier.is_stored() || feed.qualifier == Qualifier::R;
            let differs = action.feeds.iter().any(keeps) && !action.feeds.iter().all(keeps);
            Written { sets, stays, differs }
        });
        Output { on: any([on, pulse]), runs, written }
    }

    /// On controllers where an action has one common store, clears it where the time of an SL input is over (`ends`),
    /// whoever set it.
    fn limits_end_all(&mut self, action: &ActionMemory, ends: &Logic) {
        if !action.feeds.iter().any(|feed| feed.qualifier == Qualifier::Sl) {
            return;
        }
        let one =
            self.differs("an action has one common store, which the end of an SL time clears");
        let ends = self.keep_bit(all([one, ends.clone()]));
        let goes_on = |cell: Cell| set(cell, all([now(cell), ends.clone().not()]));
        let mut changes = vec![goes_on(action.stored)];
        for (feed, input) in action.feeds.iter().zip(&action.inputs) {
            match feed.qualifier {
                // After its time, the input is off until its step is entered again.
                Qualifier::Sl => {
                    let over = any([now(input.over), all([now(input.stored), ends.clone()])]);
                    changes.push(set(input.over, over));
                }
                Qualifier::Sd | Qualifier::Ds => {
                    changes.extend([goes_on(input.stored), goes_on(input.over)]);
                }
                _ => {}
            }
        }
        self.write(changes);
    }

    /// Lowers one input of an action's control, and adds the writes of its state to `changes`. `reset`: whether R is
    /// on; None if the action has no R.
    fn input(
        &mut self,
        (memory, whole): (&Memory, &Whole),
        (feed, input): (&Feed, &InputMemory),
        time: &InputTime,
        reset: Option<&Logic>,
        changes: &mut Vec<Write>,
    ) -> Given {
        let steps = &feed.steps;
        let mut active = memory.active(steps);
        // On controllers where initial steps do not count as entered in the first scan, SD and SL store when a step is
        // entered.
        if matches!(feed.qualifier, Qualifier::Sd | Qualifier::Sl) && whole.has_initial(feed) {
            let by_itself = all([active, whole.not_entered.clone().not()]);
            active = any([by_itself, entered(memory, steps)]);
        }
        if feed.qualifier == Qualifier::Ds
            && whole.has_initial(feed)
            && whole.not_entered != Logic::Const(false)
        {
            let stored = self.any_bit("DS may or may not store the action of an initial step");
            active = all([active, any([whole.not_entered.clone().not(), stored])]);
        }
        // In the standard, the steps of one input act together; on some controllers, each acts by itself.
        let apart = match steps.len() {
            2.. => self.differs("each step of an action has pulses and times of its own"),
            _ => Logic::Const(false),
        };
        let anew = all([now(input.was), active.clone(), entered(memory, steps), apart.clone()]);
        let ran = self.keep_bit(all([now(input.was), anew.not()]));
        let free = match feed.qualifier {
            Qualifier::L | Qualifier::D | Qualifier::Ds => self.time_bit(input.was, time.units),
            _ if feed.qualifier.is_timed() => self.time_bit(input.stored, time.units),
            _ => Logic::Const(false),
        };
        // L and D look at the time of their step.
        let early = match feed.qualifier {
            Qualifier::L | Qualifier::D
                if whole.has_initial(feed) && whole.runs_early != Logic::Const(false) =>
            {
                // No lower bound rests on the time of a step that is active in one stretch only: some controllers have
                // only times from 0 on there, others only long ones.
                let over = match whole.is_entered_again(feed) {
                    true => free.clone(),
                    false => self.left_open(),
                };
                all([whole.runs_early.clone(), over])
            }
            _ => Logic::Const(false),
        };
        let at_once = any([time.is_over.clone(), early]);
        // A running timer may expire in any scan and stays expired. In the scan in which it starts, it expires only if
        // its time is 0.
        let over = |runs: Logic, ran: Logic| {
            all([runs, any([at_once.clone(), all([ran, any([now(input.over), free.clone()])])])])
        };
        let free_of =
            |reset: Option<&Logic>| reset.map_or(Logic::Const(true), |on| on.clone().not());
        let rises = all([active.clone(), ran.clone().not()]);
        let given = |on, off| Given { on, is_stored: false, off };
        let kept = |on| Given { on, is_stored: true, off: Logic::Const(false) };
        match feed.qualifier {
            Qualifier::N => given(active, left(memory, steps)),
            Qualifier::R | Qualifier::S => given(Logic::Const(false), Logic::Const(false)),
            Qualifier::L => {
                changes.push(set(input.over, over(active.clone(), ran)));
                let off = any([left(memory, steps), now(input.over)]);
                given(all([active, now(input.over).not()]), off)
            }
            Qualifier::D => {
                changes.push(set(input.over, over(active, ran)));
                given(now(input.over), left(memory, steps))
            }
            Qualifier::P | Qualifier::P1 => {
                let off = if steps.len() > 1 { Logic::Const(true) } else { rises.clone().not() };
                given(rises, off)
            }
            Qualifier::P0 => {
                let own = all([now(input.was), left(memory, steps), apart]);
                let falls = any([all([now(input.was), active.not()]), own]);
                let off = if steps.len() > 1 { Logic::Const(true) } else { falls.clone().not() };
                given(falls, off)
            }
            Qualifier::Sd | Qualifier::Sl => {
                let enters = entered(memory, steps);
                let again =
                    self.differs("the time of SD or SL restarts when its step is entered again");
                // On matiec, a time that is over in the same scan still counts, and what SD has stored stays stored.
                let restarts = match again {
                    Logic::Const(false) => Logic::Const(false),
                    _ => self.left_open(),
                };
                let again = self.keep_bit(all([enters.clone(), again, restarts]));
                let goes_on = all([now(input.stored), again.not()]);
                let mut holds = any([now(input.stored), active.clone()]);
                if let Some(reset) = reset {
                    let other =
                        self.differs("SD and SL store their action only when a step is entered");
                    let active = all([active, other.not()]);
                    holds = any([now(input.stored), enters.clone(), active]);
                    let outlasts = match feed.qualifier {
                        Qualifier::Sd => self.differs("an SD delay continues although R is active"),
                        _ => Logic::Const(false),
                    };
                    let pending = any([all([now(input.stored), now(input.over).not()]), enters]);
                    let stays = all([reset.clone(), outlasts, pending]);
                    holds = any([all([holds, reset.clone().not()]), stays]);
                }
                let holds = self.keep_bit(holds);
                changes.push(set(input.over, over(holds.clone(), goes_on)));
                changes.push(set(input.stored, holds));
                if let Some(reset) = reset {
                    // What is stored while R is on is lost.
                    let gone = all([reset.clone(), now(input.over)]);
                    changes.push(set(input.stored, all([now(input.stored), gone.clone().not()])));
                    changes.push(set(input.over, all([now(input.over), gone.not()])));
                }
                kept(match feed.qualifier {
                    Qualifier::Sd => now(input.over),
                    _ => all([now(input.stored), now(input.over).not()]),
                })
            }
            Qualifier::Ds => {
                let late = self.differs("a DS delay that expires when its step ends is stored");
                let late = all([now(input.was), active.clone().not(), free.clone(), late]);
                changes.push(set(input.over, over(active, ran)));
                let holds = any([now(input.stored), now(input.over), late]);
                changes.push(set(input.stored, all([holds, free_of(reset)])));
                kept(now(input.stored))
            }
        }
    }

    /// A bit that may be true only where a computed time is 0 or less, so that a timed input expires at once.
    pub(crate) fn is_no_time(&mut self, time: Number) -> Logic {
        let words = Number::Words(self.words(time, 2));
        let none = signed(Relation::LessOrEqual, words, constant(0, 2));
        // A time of 0 may stand for a time below 1 ms, and controllers differ for a time of exactly 0.
        let short = self.left_open();
        self.keep_bit(all([none, short]))
    }

    /// The value that a Boolean variable gets from its action: its state, or on some controllers what its blocks write.
    /// For a variable with a cell, also returns that cell and the instruction that allows the second; the allowance is
    /// void if only its actions write the variable, unless its blocks alone can make a difference.
    pub(crate) fn held(
        &mut self,
        before: &Before,
        output: &Output,
    ) -> (Logic, Option<(usize, Cell)>) {
        let Output { on, written: Some(written), .. } = output else {
            return (output.on.clone(), None);
        };
        let other =
            self.differs("a Boolean variable keeps its value if nothing switches its action");
        let value = |other: Logic, before: Logic| {
            let kept = all([written.stays.clone(), before]);
            let by_blocks = any([written.sets.clone(), kept]);
            any([all([on.clone(), other.clone().not()]), all([other, by_blocks])])
        };
        match *before {
            Before::Cell(cell) if written.differs => (value(other, now(cell)), None),
            Before::Cell(cell) => {
                let (other, at) = self.unless_settled(other);
                (value(other, now(cell)), Some((at, cell)))
            }
            Before::Bit(cell, bit) => {
                (value(other, Logic::Bit(BitSource::WordBit(cell, bit))), None)
            }
            Before::Any => {
                let before = self.any_bit("an array element that an action may leave unchanged");
                (value(other, before), None)
            }
        }
    }
}
