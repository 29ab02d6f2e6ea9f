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
    /// The initial steps of the chart, by number.
    pub(crate) initial_steps: Vec<usize>,
}

impl Whole {
    /// Whether one of an input's steps is an initial step.
    fn has_initial(&self, feed: &Feed) -> bool {
        feed.steps.iter().any(|step| self.initial_steps.contains(step))
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
    /// True where a Boolean variable may keep its value: nothing switches it on or off in this scan.
    pub(crate) may_stay: Logic,
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
    /// Lowers the control of an action and charges it. `at_once`: for each input, whether its time is 0.
    pub(crate) fn control(
        &mut self,
        memory: &Memory,
        action: &ActionMemory,
        whole: &Whole,
        at_once: &[Logic],
    ) -> Output {
        let reset = self.keep_bit(action.active(memory, Qualifier::R));
        let stores = action.active(memory, Qualifier::S);
        let stored = all([any([now(action.stored), stores]), reset.clone().not()]);
        let mut changes = vec![set(action.stored, stored)];
        let (mut levels, mut stored, mut offs) = (Vec::new(), vec![now(action.stored)], Vec::new());
        let mut pulses = Vec::new();
        let mut keep = Vec::new();
        let limits: Vec<(Cell, Logic)> = Self::shared_limits(action)
            .map(|input| input.over)
            .map(|over| (over, self.keep_bit(now(over))))
            .collect();
        let inputs = action.feeds.iter().zip(&action.inputs).zip(at_once);
        for ((feed, input), at_once) in inputs {
            keep.push(set(input.was, memory.active(&feed.steps)));
            let resets = action.has_reset().then_some(&reset);
            let given = self.input((memory, whole), (feed, input), at_once, resets, &mut changes);
            match feed.qualifier {
                Qualifier::R | Qualifier::S => {}
                Qualifier::P1 | Qualifier::P0 => pulses.push(given.on),
                _ if given.is_stored => stored.push(given.on),
                _ => levels.push(given.on),
            }
            offs.push(given.off);
        }
        self.write(changes);
        if !limits.is_empty() {
            self.limits_end_all(action, &limits);
        }
        // If several blocks without storing name the action, on some controllers the last one decides. Which one is
        // last depends on the order of the steps there, so the action may be off if any of them has it off.
        let blocks: usize = action.feeds.iter().map(|feed| feed.steps.len()).sum();
        let overruled = match blocks {
            2.. => {
                let last = self.differs("of several blocks of an action, the last one decides");
                let is_off = match last {
                    Logic::Const(false) => Logic::Const(false),
                    _ => self.left_open(),
                };
                self.keep_bit(all([any(offs), last, is_off]))
            }
            _ => Logic::Const(false),
        };
        let held = match action.has_reset() {
            true => all([reset.clone(), whole.reset_only_stored.clone().not()]),
            false => Logic::Const(false),
        };
        let unstored = self.keep_bit(all([any(levels), held.not(), overruled.clone().not()]));
        let was_on = self.keep_bit(now(action.on));
        let stored = all([any(stored), reset.clone().not()]);
        let on = self.keep_bit(any([unstored.clone(), stored]));
        let pulse = self.keep_bit(all([any(pulses), overruled.not()]));
        let ends = self.keep_bit(all([was_on.clone(), on.clone().not()]));
        let last = all([ends.clone(), whole.no_final_scan.clone().not()]);
        let runs = self.keep_bit(any([on.clone(), pulse.clone(), last]));
        keep.push(set(action.on, on.clone()));
        let effects = keep.into_iter().map(always).collect();
        let key = Assembler::key(&["ACTION"], "nothing");
        self.builder.add(Some(key), effects, Step::Act { fires: runs.clone() });
        let stays_off = all([on.clone().not(), ends.not(), reset.not()]);
        let stays_on = all([on.clone(), was_on, unstored.not()]);
        let may_stay = all([any([stays_off, stays_on]), pulse.clone().not()]);
        Output { on: any([on, pulse]), runs, may_stay }
    }

    /// The inputs with qualifier SL of an action that another input also stores.
    fn shared_limits(action: &ActionMemory) -> impl Iterator<Item = &InputMemory> {
        let stores = action.feeds.iter().filter(|feed| feed.qualifier.is_stored()).count();
        let inputs = action.feeds.iter().zip(&action.inputs);
        inputs
            .filter(move |(feed, _)| stores > 1 && feed.qualifier == Qualifier::Sl)
            .map(|(_, input)| input)
    }

    /// On controllers where an action has one common store, clears it when the time of an SL input is over, whoever set
    /// it. `limits`: for each SL input, the cell that says whether its time is over, and whether it was over in the
    /// previous scan.
    fn limits_end_all(&mut self, action: &ActionMemory, limits: &[(Cell, Logic)]) {
        let one =
            self.differs("an action has one common store, which the end of an SL time clears");
        let ends = limits.iter().map(|(over, was)| all([now(*over), was.clone().not()]));
        let ends = self.keep_bit(all([one, any(ends)]));
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
        at_once: &Logic,
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
        let free = match feed.qualifier.is_timed() {
            true => self.uncounted_bit(),
            false => Logic::Const(false),
        };
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
                let again = self.keep_bit(all([enters.clone(), again]));
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

    /// The value that a Boolean variable gets from its action. On some controllers it keeps its value if nothing
    /// switches the action. For a variable with a cell, also returns that cell and the instruction that allows this;
    /// the allowance is void if only its actions write the variable.
    pub(crate) fn held(
        &mut self,
        before: &Before,
        on: Logic,
        may_stay: Logic,
    ) -> (Logic, Option<(usize, Cell)>) {
        let other =
            self.differs("a Boolean variable keeps its value if nothing switches its action");
        let stays = all([may_stay, other]);
        let value = |stays: Logic, before: Logic| {
            any([all([on.clone(), stays.clone().not()]), all([stays, before])])
        };
        match *before {
            Before::Cell(cell) => {
                let (stays, at) = self.unless_settled(stays);
                (value(stays, now(cell)), Some((at, cell)))
            }
            Before::Bit(cell, bit) => {
                (value(stays, Logic::Bit(BitSource::WordBit(cell, bit))), None)
            }
            Before::Any => {
                let before = self.any_bit("an array element that an action may leave unchanged");
                (value(stays, before), None)
            }
        }
    }
}
