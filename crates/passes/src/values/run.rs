//! One scan with what words may hold in place of values: every way at once, loops until nothing new comes.

use super::condition::{Condition, Literal, Perhaps};
use super::evaluate::Evaluation;
use super::reach::Reach;
use super::state::{Followed, State};
use super::value::Value;
use super::write::{To, Writer};
use rustc_hash::FxHashSet;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{ChoiceId, Effect, Instruction, Join, Program, Step, When, WordSource};
use std::cell::Cell as Shared;
use std::collections::BTreeMap;

/// So many instructions are carried out in a scan before it is given up.
const MOST_WORK: u64 = 4_000_000;
/// It is asked once in so many whether the time is over.
const EVERY: u64 = 256;
/// A loop is followed turn by turn if that takes no more instructions than these; one of which it is not known how many
/// turns it makes, than those.
const EXACT_WORK: u64 = 400_000;
const EXACT_WORK_OPEN: u64 = 10_000;
/// So many turns of other loops are followed before what they change is taken as far as it can go.
const TURNS: u64 = 3;
/// As long as a loop has taken no more instructions than these, what grows in it grows to the next limit, so many times
/// at most, and what was found of it is then narrowed.
const CHEAP_WORK: u64 = 10_000;
const MOST_GROWN: u64 = 16;

/// What was found at single instructions, over all ways there.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Found {
    /// The most turns that a loop makes, by what its count may hold.
    pub turns: BTreeMap<usize, i64>,
    /// The largest count of units.
    pub units: BTreeMap<usize, u64>,
    /// The cells that an indexed write reaches; `None` where that is not known.
    pub reaches: BTreeMap<ChoiceId, Option<Reach>>,
}

impl Found {
    /// Takes what was found closer to what else was: both hold. Where one of them never got to, the other one's holds.
    pub fn closer(&mut self, other: Found) {
        for (at, turns) in other.turns {
            let known = self.turns.entry(at).or_insert(turns);
            *known = turns.min(*known);
        }
        for (at, units) in other.units {
            let known = self.units.entry(at).or_insert(units);
            *known = units.min(*known);
        }
        for (choice, reach) in other.reaches {
            let known = self.reaches.entry(choice).or_insert(reach);
            *known = match (*known, reach) {
                (Some(known), Some(reach)) => Some(known.closer(reach)),
                (known, reach) => known.or(reach),
            };
        }
    }
}

/// It took too much, or something in it cannot be followed.
#[derive(Debug)]
pub struct NotFollowed;

/// One activation of a routine.
#[derive(Default)]
struct Activation {
    state: Option<State>,
    stack: Vec<Condition>,
    /// The stack's depth is not known: two ways with different ones met.
    lost: bool,
    slots: BTreeMap<u32, Condition>,
    /// The open zones, each with its level and the condition of all up to it.
    zones: Vec<(u32, Condition)>,
    landings: BTreeMap<usize, Landing>,
    returned: Option<State>,
}

impl Activation {
    /// Takes results that were left by whatever turn as not known.
    fn forget_results(&mut self) {
        (self.stack, self.lost) = (Vec::new(), true);
        self.slots.values_mut().for_each(|saved| *saved = Condition::default());
    }
}

/// What was noted up to a place.
struct Noted {
    found: Found,
    written: Vec<Option<Value>>,
    lost: FxHashSet<(usize, usize)>,
    landings: BTreeMap<usize, Landing>,
    /// Where the routine returns, the main routine ended and the scan was stopped, and where a loop is left.
    ends: [Option<State>; 4],
}

/// A jump on its way.
#[derive(Clone)]
struct Landing {
    state: State,
    stack: Vec<Condition>,
    lost: bool,
    slots: BTreeMap<u32, Condition>,
}

/// A scan under way.
pub struct Run<'p> {
    program: &'p Program,
    followed: &'p Followed,
    /// Whether to give it up.
    is_over: &'p dyn Fn() -> bool,
    pub found: Found,
    /// All that was written into each word at any moment.
    pub written: Vec<Option<Value>>,
    /// The words of which it is noted there that they were written by anything, as ranges of slots.
    lost: FxHashSet<(usize, usize)>,
    /// The last stamp that was given.
    stamp: Shared<u32>,
    /// How many instructions were carried out.
    pub work: u64,
    /// Where a main routine ended by itself, and where the scan was stopped.
    ended: Option<State>,
    stopped: Option<State>,
}

/// Joins a state to others.
fn join(stamp: u32, into: &mut Option<State>, state: State) {
    match into {
        None => *into = Some(state),
        Some(known) => known.meet(&state, stamp),
    }
}

impl<'p> Run<'p> {
    /// No scan yet.
    pub fn new(
        program: &'p Program,
        followed: &'p Followed,
        is_over: &'p dyn Fn() -> bool,
    ) -> Run<'p> {
        Run {
            program,
            followed,
            is_over,
            found: Found::default(),
            written: vec![None; followed.words.cells().len()],
            lost: FxHashSet::default(),
            stamp: Shared::new(0),
            work: 0,
            ended: None,
            stopped: None,
        }
    }

    fn evaluation<'a>(&'a self, state: &'a State, holds: &'a [Literal]) -> Evaluation<'a> {
        let Run { program, followed, stamp, .. } = self;
        Evaluation { program, followed, state, holds, stamp }
    }

    /// Runs the scan; what the words hold at its end, `None` if it has none.
    ///
    /// # Errors
    /// If it takes too much, or something in it cannot be followed.
    pub fn scan(&mut self, start: State) -> Result<Option<State>, NotFollowed> {
        let program = self.program;
        let mut state = Some(start);
        for main in &program.mains {
            let Some(begun) = state.take() else { break };
            let returned = self.routine(main.start, main.end, begun)?;
            state = self.ended.take();
            if let Some(returned) = returned {
                join(self.fresh(), &mut state, returned);
            }
        }
        // What interrupts write is none of the words, but they count loops and units, too.
        if let Some(stopped) = self.stopped.take() {
            join(self.fresh(), &mut state, stopped);
        }
        for interrupt in &program.interrupts {
            let unknown = self.followed.anything();
            self.routine(interrupt.entry, program.instructions.len(), unknown)?;
        }
        self.ended = None;
        self.stopped = None;
        Ok(state)
    }

    fn fresh(&self) -> u32 {
        self.stamp.set(self.stamp.get() + 1);
        self.stamp.get()
    }

    fn routine(
        &mut self,
        from: usize,
        to: usize,
        state: State,
    ) -> Result<Option<State>, NotFollowed> {
        let mut act = Activation { state: Some(state), ..Activation::default() };
        self.span(&mut act, from, to)?;
        let mut back = act.returned.take();
        if let Some(state) = act.state.take() {
            join(self.fresh(), &mut back, state);
        }
        Ok(back)
    }

    fn span(&mut self, act: &mut Activation, from: usize, to: usize) -> Result<(), NotFollowed> {
        let mut at = from;
        while at < to {
            if let Some(landing) = act.landings.remove(&at) {
                self.land(act, landing);
            }
            if act.state.is_none() {
                match act.landings.range(at..to).next() {
                    Some((&next, _)) => at = next,
                    None => return Ok(()),
                }
                continue;
            }
            let behind = self.followed.behind[at];
            if behind != 0 {
                at = behind;
                continue;
            }
            self.work += 1;
            if self.work > MOST_WORK || self.work.is_multiple_of(EVERY) && (self.is_over)() {
                return Err(NotFollowed);
            }
            at = self.instruction(act, at)?;
        }
        Ok(())
    }

    fn land(&mut self, act: &mut Activation, landing: Landing) {
        let Landing { state, stack, lost, slots } = landing;
        let Some(here) = &mut act.state else {
            (act.state, act.stack, act.lost, act.slots) = (Some(state), stack, lost, slots);
            return;
        };
        here.meet(&state, self.fresh());
        act.lost |= lost || act.stack.len() != stack.len();
        for (here, there) in act.stack.iter_mut().zip(&stack) {
            *here = here.either(there);
        }
        for (slot, here) in &mut act.slots {
            // What one of the ways did not save is not what the other did.
            *here = slots.get(slot).map_or_else(Condition::default, |there| here.either(there));
        }
        for slot in slots.into_keys() {
            act.slots.entry(slot).or_default();
        }
    }

    /// What a jump takes with it.
    fn depart(act: &Activation, state: State) -> Landing {
        let (stack, slots) = (act.stack.clone(), act.slots.clone());
        Landing { state, stack, lost: act.lost, slots }
    }

    fn leave(&mut self, act: &mut Activation, target: usize, state: State) {
        let landing = Run::depart(act, state);
        match act.landings.remove(&target) {
            None => {
                act.landings.insert(target, landing);
            }
            Some(other) => {
                let mut met = Activation {
                    state: Some(landing.state),
                    stack: landing.stack,
                    lost: landing.lost,
                    slots: landing.slots,
                    ..Activation::default()
                };
                self.land(&mut met, other);
                let Activation { state, stack, lost, slots, .. } = met;
                if let Some(state) = state {
                    act.landings.insert(target, Landing { state, stack, lost, slots });
                }
            }
        }
    }

    fn top(act: &Activation) -> Condition {
        if act.lost {
            return Condition::default();
        }
        act.stack.last().cloned().unwrap_or_else(Condition::always)
    }

    fn instruction(&mut self, act: &mut Activation, at: usize) -> Result<usize, NotFollowed> {
        let program = self.program;
        let instruction = &program.instructions[at];
        let Some(state) = &act.state else { return Ok(at + 1) };
        let top = Run::top(act);
        let condition = match act.zones.last() {
            Some((_, all)) if instruction.step.acts() => top.and(all),
            _ => top,
        };
        // What a contact in series is worth where what stands before it is on is all that counts, unless it does or
        // counts something by itself.
        let acts = instruction.counted().is_some() || !instruction.effects.is_empty();
        let holds = match &instruction.step {
            Step::Logic { join: Join::And, .. } if !acts => condition.literals(),
            _ => &[],
        };
        let fires = match instruction.step.fires() {
            Some(logic) => self.evaluation(state, holds).logic(logic, &condition),
            None => Condition::always(),
        };
        if !fires.never
            && let Some(counted) = instruction.counted()
        {
            self.count_units(act, at, &fires, &counted.words);
        }
        if !instruction.effects.is_empty() {
            self.effects(act, instruction, &fires, &condition);
        }
        self.step(act, at, &instruction.step, fires)
    }

    fn count_units(
        &mut self,
        act: &mut Activation,
        at: usize,
        fires: &Condition,
        words: &[WordSource],
    ) {
        let Some(state) = &mut act.state else { return };
        let mut before = Vec::new();
        let mut most = None;
        if state.assume(fires, &mut before) {
            let evaluation = self.evaluation(state, fires.literals());
            let count = words.iter().rev().fold(0, |count, &word| {
                count * 65_536 + evaluation.word(word).unsigned().1.unsigned_abs()
            });
            let stated = self.program.counts.get(&at).map(|&(_, most)| most.unsigned_abs());
            most = Some(stated.map_or(count, |stated| count.min(stated)));
        }
        for (slot, value) in before.into_iter().rev() {
            state.know(slot, value);
        }
        if let Some(most) = most {
            let known = self.found.units.entry(at).or_default();
            *known = most.max(*known);
        }
    }

    /// Carries out an instruction's effects.
    fn effects(
        &mut self,
        act: &mut Activation,
        instruction: &Instruction,
        fires: &Condition,
        condition: &Condition,
    ) {
        let Some(state) = &mut act.state else { return };
        let mut done: FxHashSet<ChoiceId> = FxHashSet::default();
        for Effect { when, write } in &instruction.effects {
            let always = Condition::always();
            let guard = if *when == When::Always { &always } else { fires };
            if guard.never {
                continue;
            }
            let mut before = Vec::new();
            if state.assume(guard, &mut before) {
                let mut writer = Writer {
                    evaluation: Evaluation {
                        program: self.program,
                        followed: self.followed,
                        state,
                        holds: guard.literals(),
                        stamp: &self.stamp,
                    },
                    reaches: &mut self.found.reaches,
                    condition,
                    writes: Vec::new(),
                };
                writer.write(write, &mut done);
                let writes = writer.writes;
                for (slot, value) in before.into_iter().rev() {
                    state.know(slot, value);
                }
                for to in writes {
                    self.stamp.set(self.stamp.get() + 1);
                    let stamp = self.stamp.get();
                    match to {
                        To::Bit(bit, truth) => {
                            state.write_bit(bit, truth.filter(|_| guard.surely), stamp);
                        }
                        To::Word { slot, value } => {
                            let unwritten =
                                (!guard.surely).then(|| state.value_unless(slot, guard));
                            match unwritten.flatten() {
                                None => state.write(slot, value, stamp),
                                Some(unwritten) => {
                                    let perhaps = Perhaps { when: guard.conjunction(), value };
                                    state.write_perhaps(slot, perhaps, unwritten, stamp);
                                }
                            }
                            let all = &mut self.written[slot];
                            *all = Some(all.map_or(value, |all| all.join(value)));
                        }
                        To::Words(slots) => {
                            state.lose(slots.clone(), stamp);
                            if self.lost.insert((slots.start, slots.end)) {
                                self.written[slots].fill(Some(Value::TOP));
                            }
                        }
                        To::Bits(bits) => state.lose_bits(bits, stamp),
                    }
                }
            } else {
                for (slot, value) in before.into_iter().rev() {
                    state.know(slot, value);
                }
            }
        }
    }

    fn step(
        &mut self,
        act: &mut Activation,
        at: usize,
        step: &Step,
        fires: Condition,
    ) -> Result<usize, NotFollowed> {
        let next = at + 1;
        match step {
            Step::Act { .. } | Step::Nothing => {}
            Step::Logic { join, .. } => self.join(act, *join, fires),
            Step::AndBlock | Step::OrBlock => {
                let (b, a) = (act.stack.pop(), act.stack.pop());
                let (a, b) = (a.unwrap_or_default(), b.unwrap_or_default());
                let both = if *step == Step::AndBlock { a.and(&b) } else { a.or(&b) };
                act.stack.push(both.seen(|| self.fresh()));
            }
            Step::Save(slot) => {
                act.slots.insert(*slot, Run::top(act));
            }
            Step::Fetch(slot) => {
                let saved = act.slots.get(slot).cloned().unwrap_or_else(Condition::always);
                self.join(act, Join::Replace, saved);
            }
            Step::Jump { target, .. } => {
                if let Some(taken) = self.part(act, &fires) {
                    self.leave(act, *target, taken);
                }
            }
            Step::Call { target, .. } => {
                if let Some(taken) = self.part(act, &fires)
                    && let Some(back) =
                        self.routine(*target, self.program.instructions.len(), taken)?
                {
                    join(self.fresh(), &mut act.state, back);
                }
            }
            Step::Return => {
                if let Some(state) = act.state.take() {
                    join(self.fresh(), &mut act.returned, state);
                }
            }
            Step::End => {
                if let Some(state) = act.state.take() {
                    join(self.fresh(), &mut self.ended, state);
                }
            }
            Step::Stop { .. } => {
                if let Some(state) = self.part(act, &fires) {
                    join(self.fresh(), &mut self.stopped, state);
                }
            }
            Step::Unbounded { .. } => act.state = None,
            Step::ForBegin { count, least, most, end } => {
                let turns = self.turns(act, at, *count, *least, *most);
                self.turn(act, at, *end, turns)?;
                return Ok(end + 1);
            }
            Step::ForEnd => {}
            Step::Summary(summary) => match summary.iterations {
                Some((count, least, most)) => {
                    let turns = self.turns(act, at, count, least, most);
                    self.turn(act, at, summary.end, turns)?;
                    return Ok(summary.end + 1);
                }
                // What is summarised without turns was not laid out to be followed.
                None => return Err(NotFollowed),
            },
            Step::MasterControlBegin { level, .. } => {
                let all = match act.zones.last() {
                    Some((_, outer)) => outer.and(&fires),
                    None => fires,
                };
                act.zones.push((*level, all));
            }
            Step::MasterControlEnd { level } => act.zones.retain(|(open, _)| open < level),
        }
        Ok(next)
    }

    fn join(&self, act: &mut Activation, join: Join, value: Condition) {
        match join {
            Join::Start => {
                act.stack.clear();
                act.lost = false;
                act.stack.push(value);
            }
            Join::Load => act.stack.push(value),
            Join::And | Join::Or => {
                let top = Run::top(act);
                let joined = if join == Join::And { top.and(&value) } else { top.or(&value) };
                act.stack.pop();
                act.stack.push(joined.seen(|| self.fresh()));
            }
            Join::Replace => {
                act.stack.pop();
                act.stack.push(value);
            }
        }
    }

    /// The state with which control leaves if the condition holds; what stays is without it only if that is sure.
    fn part(&mut self, act: &mut Activation, fires: &Condition) -> Option<State> {
        if fires.never {
            return None;
        }
        let mut taken = act.state.clone()?;
        taken.know_where(fires.literals());
        let possible = taken.assume(fires, &mut Vec::new());
        if fires.surely || act.state.as_mut().is_some_and(|stays| !stays.assume_not(fires)) {
            act.state = None;
        }
        possible.then_some(taken)
    }

    /// How many turns a loop makes: at least and at most.
    fn turns(
        &mut self,
        act: &mut Activation,
        at: usize,
        count: WordSource,
        least: u32,
        most: u32,
    ) -> (u64, u64) {
        let Some(state) = &mut act.state else { return (0, 0) };
        let evaluation = self.evaluation(state, &[]);
        let (word, odd, is_signed) = match count {
            WordSource::Free(choice) => match self.program.kinds.get(&choice) {
                Some(ChoiceKind::Iterations(word)) => (*word, true, true),
                Some(ChoiceKind::Unsigned(word)) => (*word, false, false),
                _ => (count, false, true),
            },
            word => (word, false, true),
        };
        let (mut low, mut high) = match word {
            // A front that says nothing of a count may read it otherwise than as a signed number.
            WordSource::Free(choice) if !self.program.kinds.contains_key(&choice) => {
                (i64::from(least), i64::from(most))
            }
            word if is_signed => evaluation.word(word).signed(),
            word => evaluation.word(word).unsigned(),
        };
        if let Some(&(least, largest)) = self.program.counts.get(&at) {
            (low, high) = (low.max(least), high.min(largest));
            // A way on which the word holds something else is no scan's.
            if let WordSource::Cell(cell) = word
                && let Some(slot) = self.followed.words.slot(cell)
                && let Some(value) = state.value(slot).meet(Value::range(least, largest))
            {
                state.know(slot, value);
            }
        }
        let within = |turns: i64| turns.clamp(least.into(), most.into());
        let high = within(if odd { high.max(1) } else { high });
        let low = if odd && low < 1 { i64::from(least) } else { within(low) };
        let known = self.found.turns.entry(at).or_default();
        *known = high.max(*known);
        (low.max(0).unsigned_abs(), high.max(0).unsigned_abs())
    }

    /// Runs a loop: turn by turn where that is not too much, else until nothing new comes.
    fn turn(
        &mut self,
        act: &mut Activation,
        at: usize,
        end: usize,
        (least, most): (u64, u64),
    ) -> Result<(), NotFollowed> {
        let Some(begun) = act.state.take() else { return Ok(()) };
        let mut exits: Option<State> = None;
        if least == 0 {
            exits = Some(begun.clone());
        }
        let (mut head, mut settled) = (begun, false);
        // What was noted before the head was widened, and how often it grew to a limit.
        let (mut before, mut grown) = (None, 0);
        let began = self.work;
        let exact_work = if least == most { EXACT_WORK } else { EXACT_WORK_OPEN };
        for turn in 1..=most {
            act.state = Some(head.clone());
            act.forget_results();
            self.span(act, at + 1, end + 1)?;
            let Some(state) = act.state.take() else { break };
            if turn >= least || settled {
                join(self.fresh(), &mut exits, state.clone());
            }
            // A loop that is followed to its end is seldom asked whether it still changes anything.
            let is_asked = turn < TURNS || turn.is_power_of_two();
            if !settled && is_asked && head.covers(&state) {
                // Every further turn is the same.
                if turn < least {
                    join(self.fresh(), &mut exits, state);
                }
                break;
            }
            let spent = self.work - began;
            let all = (spent / turn).saturating_mul(most);
            if !settled && (turn < TURNS || all <= exact_work) {
                head = state;
                continue;
            }
            // From here on the head stands for any further turn.
            let is_cheap = spent <= CHEAP_WORK;
            if !settled && is_cheap {
                before = Some(self.noted(act, &exits));
            }
            settled = true;
            let stamp = self.fresh();
            let mut wider = head.clone();
            let is_last = !is_cheap || grown >= MOST_GROWN;
            grown += u64::from(!is_last);
            if turn < 2 * TURNS + grown || spent < EXACT_WORK {
                wider.widen(&state, stamp, &self.followed.limits, is_last);
            } else {
                wider = self.followed.anything();
            }
            if head.covers(&wider) {
                // Less comes out than goes in: here too every further turn is the same.
                join(self.fresh(), &mut exits, state.clone());
                if let Some(before) = before.filter(|_| is_cheap) {
                    exits = self.narrower(act, at..end, state, before)?;
                }
                break;
            }
            head = wider;
        }
        act.state = exits;
        act.forget_results();
        Ok(())
    }

    /// What was noted up to here, to come back to.
    fn noted(&mut self, act: &Activation, exits: &Option<State>) -> Noted {
        // It takes as long as some instructions.
        self.work +=
            (self.found.units.len() + self.found.reaches.len() + self.written.len()) as u64 / 64;
        Noted {
            found: self.found.clone(),
            written: self.written.clone(),
            lost: self.lost.clone(),
            landings: act.landings.clone(),
            ends: [&act.returned, &self.ended, &self.stopped, exits].map(Clone::clone),
        }
    }

    /// Runs a loop's turns once more from what a turn leaves that begins with anything that the head was widened to: each
    /// turn but the first of those begins so. What was noted of the widened ones is forgotten. Where the loop is left to.
    fn narrower(
        &mut self,
        act: &mut Activation,
        body: std::ops::Range<usize>,
        left: State,
        before: Noted,
    ) -> Result<Option<State>, NotFollowed> {
        let Noted { found, written, lost, landings, ends } = before;
        (self.found, self.written, self.lost, act.landings) = (found, written, lost, landings);
        let [returned, ended, stopped, mut exits] = ends;
        (act.returned, self.ended, self.stopped) = (returned, ended, stopped);
        act.state = Some(left);
        act.forget_results();
        self.span(act, body.start + 1, body.end + 1)?;
        if let Some(state) = act.state.take() {
            join(self.fresh(), &mut exits, state);
        }
        Ok(exits)
    }
}
