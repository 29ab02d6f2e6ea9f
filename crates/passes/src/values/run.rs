//! Abstract interpretation of one scan: all paths at once, loops until a fixpoint.

use super::condition::{Condition, ConditionalWrite, Literal};
use super::evaluate::Evaluation;
use super::reach::Reach;
use super::state::{State, Tracked};
use super::value::Value;
use super::write::{Given, Origin, To, Writer};
use rustc_hash::FxHashSet;
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{ChoiceId, Effect, Instruction, Join, Program, Step, When, WordSource};
use std::cell::Cell as Shared;
use std::collections::{BTreeMap, BTreeSet};

/// The largest number of instructions executed in the analysis of one scan; beyond it, the scan is not analysed.
const MAX_WORK: u64 = 4_000_000;
/// `is_over` is called once in this many instructions.
const EVERY: u64 = 256;
/// A loop with a known number of iterations is executed iteration by iteration if that takes at most this many
/// instructions.
const EXACT_WORK: u64 = 400_000;
/// A loop whose smallest and largest numbers of iterations differ is executed iteration by iteration if that takes at
/// most this many instructions.
const EXACT_WORK_OPEN: u64 = 10_000;
/// The number of iterations of a loop that are executed before widening begins, unless all of its iterations are
/// executed.
const ITERATIONS_BEFORE_WIDENING: u64 = 3;
/// If the iterations of one loop have executed more instructions than this, the loop's state is widened to the extreme
/// values, and the result is not narrowed.
const CHEAP_WORK: u64 = 10_000;
/// The largest number of times that a loop's state is widened to the next limit, before it is widened to the extreme
/// values.
const MAX_WIDENINGS: u64 = 16;

/// The limits of iterations, units and indexed writes that the abstract interpretation found, over all paths. A loop,
/// instruction or write that no path reaches has no entry.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct CountLimits {
    /// The largest number of iterations of each loop, by the index of its begin, from the values of the word that gives
    /// it.
    pub iterations: BTreeMap<usize, i64>,
    /// The largest number of units of each instruction, by its index.
    pub units: BTreeMap<usize, u64>,
    /// The cells that each indexed write reaches; `None` if unknown.
    pub reaches: BTreeMap<ChoiceId, Option<Reach>>,
    /// Unbounded loops ([`Step::Unbounded`]) that no path reaches.
    pub unreached: BTreeSet<usize>,
}

impl CountLimits {
    /// Combines two results that both hold: takes the smaller limits. An entry that exists in only one of them is taken
    /// from that one.
    pub fn meet(&mut self, other: CountLimits) {
        for (at, turns) in other.iterations {
            let known = self.iterations.entry(at).or_insert(turns);
            *known = turns.min(*known);
        }
        for (at, units) in other.units {
            let known = self.units.entry(at).or_insert(units);
            *known = units.min(*known);
        }
        self.unreached.extend(other.unreached);
        for (choice, reach) in other.reaches {
            let known = self.reaches.entry(choice).or_insert(reach);
            *known = match (*known, reach) {
                (Some(known), Some(reach)) => Some(known.meet(reach)),
                (known, reach) => known.or(reach),
            };
        }
    }
}

/// The error that the analysis of a scan took too long, or that it contains something that cannot be analysed.
#[derive(Debug)]
pub struct NotAnalysed;

/// One execution of a routine, from its call to its return.
#[derive(Default)]
struct Activation {
    state: Option<State>,
    stack: Vec<Condition>,
    /// Whether the depth of the stack is unknown, because paths with different depths have joined, or because an
    /// iteration of a loop has begun or ended.
    lost: bool,
    slots: BTreeMap<u32, Condition>,
    /// The open master control regions: the level of each, and the conjunction of the conditions of all regions so far.
    mc_regions: Vec<(u32, Condition)>,
    pending_jumps: BTreeMap<usize, PendingJump>,
    returned: Option<State>,
}

impl Activation {
    /// Marks all results as unknown, as after an unknown number of iterations.
    fn forget_results(&mut self) {
        (self.stack, self.lost) = (Vec::new(), true);
        self.slots.values_mut().for_each(|saved| *saved = Condition::default());
    }
}

/// What a loop's narrowing restores: everything that was recorded before widening began.
struct Snapshot {
    found: CountLimits,
    written: Vec<Option<Value>>,
    given: Given,
    lost: FxHashSet<(usize, usize)>,
    pending_jumps: BTreeMap<usize, PendingJump>,
    /// The states at which the routine returned, the main routine ended, the scan was stopped, and the loop was left.
    ends: [Option<State>; 4],
}

/// A forward jump that may be taken, while its target is not reached yet: the state and results at the jump.
#[derive(Clone)]
struct PendingJump {
    state: State,
    stack: Vec<Condition>,
    lost: bool,
    slots: BTreeMap<u32, Condition>,
}

/// The abstract execution of one scan, and what it records.
pub struct Run<'p> {
    program: &'p Program,
    followed: &'p Tracked,
    /// Returns true if the analysis must stop, because the time is over.
    is_over: &'p dyn Fn() -> bool,
    pub found: CountLimits,
    /// The unbounded loops that paths have reached so far.
    endless: BTreeSet<usize>,
    /// For each slot, all values written to its word during the scan; `None` if it was not written.
    pub written: Vec<Option<Value>>,
    pub given: Given,
    /// Ranges of slots for which any value is already recorded in `written`.
    lost: FxHashSet<(usize, usize)>,
    /// The last stamp that was used: stamps number the writes and the results of contacts and comparisons.
    stamp: Shared<u32>,
    /// The number of instructions executed.
    pub work: u64,
    /// The joined states at which the current main routine was ended by an END. `None` if no path came to one yet.
    ended: Option<State>,
    /// The joined states at which the scan was stopped. `None` if no path stopped it yet.
    stopped: Option<State>,
}

/// Joins `state` with the state in `into`, if there is one.
fn join(stamp: u32, into: &mut Option<State>, state: State) {
    match into {
        None => *into = Some(state),
        Some(known) => known.meet(&state, stamp),
    }
}

impl<'p> Run<'p> {
    /// Prepares the execution of one scan.
    pub fn new(
        program: &'p Program,
        followed: &'p Tracked,
        is_over: &'p dyn Fn() -> bool,
    ) -> Run<'p> {
        Run {
            program,
            followed,
            is_over,
            found: CountLimits::default(),
            endless: BTreeSet::new(),
            written: vec![None; followed.words.cells().len()],
            given: Given::default(),
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

    /// Executes the scan from `start`. Returns the state at its end; `None` if no path reaches an end.
    ///
    /// # Errors
    /// If it takes too long, or contains something that cannot be analysed.
    pub fn scan(&mut self, start: State) -> Result<Option<State>, NotAnalysed> {
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
        // Interrupt routines write none of the tracked words, but their loops and units are counted too.
        if let Some(stopped) = self.stopped.take() {
            join(self.fresh(), &mut state, stopped);
        }
        for interrupt in &program.interrupts {
            let unknown = self.followed.anything();
            self.routine(interrupt.entry, program.instructions.len(), unknown)?;
        }
        self.ended = None;
        self.stopped = None;
        let instructions = program.instructions.iter().enumerate();
        let unbounded = instructions.filter(|(_, one)| matches!(one.step, Step::Unbounded { .. }));
        let unreached = unbounded.map(|(at, _)| at).filter(|at| !self.endless.contains(at));
        self.found.unreached = unreached.collect();
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
    ) -> Result<Option<State>, NotAnalysed> {
        let mut act = Activation { state: Some(state), ..Activation::default() };
        self.span(&mut act, from, to)?;
        let mut back = act.returned.take();
        if let Some(state) = act.state.take() {
            join(self.fresh(), &mut back, state);
        }
        Ok(back)
    }

    fn span(&mut self, act: &mut Activation, from: usize, to: usize) -> Result<(), NotAnalysed> {
        let mut at = from;
        while at < to {
            if let Some(pending) = act.pending_jumps.remove(&at) {
                self.land(act, pending);
            }
            if act.state.is_none() {
                match act.pending_jumps.range(at..to).next() {
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
            if self.work > MAX_WORK || self.work.is_multiple_of(EVERY) && (self.is_over)() {
                return Err(NotAnalysed);
            }
            at = self.instruction(act, at)?;
        }
        Ok(())
    }

    fn land(&mut self, act: &mut Activation, pending: PendingJump) {
        let PendingJump { state, stack, lost, slots } = pending;
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
            // A slot that only one of the paths has saved is unknown.
            *here = slots.get(slot).map_or_else(Condition::default, |there| here.either(there));
        }
        for slot in slots.into_keys() {
            act.slots.entry(slot).or_default();
        }
    }

    /// Records the state and results that a jump carries to its target.
    fn depart(act: &Activation, state: State) -> PendingJump {
        let (stack, slots) = (act.stack.clone(), act.slots.clone());
        PendingJump { state, stack, lost: act.lost, slots }
    }

    fn leave(&mut self, act: &mut Activation, target: usize, state: State) {
        let pending = Run::depart(act, state);
        match act.pending_jumps.remove(&target) {
            None => {
                act.pending_jumps.insert(target, pending);
            }
            Some(other) => {
                let mut met = Activation {
                    state: Some(pending.state),
                    stack: pending.stack,
                    lost: pending.lost,
                    slots: pending.slots,
                    ..Activation::default()
                };
                self.land(&mut met, other);
                let Activation { state, stack, lost, slots, .. } = met;
                if let Some(state) = state {
                    act.pending_jumps.insert(target, PendingJump { state, stack, lost, slots });
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

    fn instruction(&mut self, act: &mut Activation, at: usize) -> Result<usize, NotAnalysed> {
        let program = self.program;
        let instruction = &program.instructions[at];
        let Some(state) = &act.state else { return Ok(at + 1) };
        let top = Run::top(act);
        let condition = match act.mc_regions.last() {
            Some((_, all)) if instruction.step.depends_on_master_control() => top.and(all),
            _ => top,
        };
        // For a contact in series, only its value while the contacts before it are on matters, unless it has effects or
        // a count itself.
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
            let stated = self.program.stated_counts.get(&at).map(|&(_, most)| most.unsigned_abs());
            most = Some(stated.map_or(count, |stated| count.min(stated)));
        }
        for (slot, value) in before.into_iter().rev() {
            state.restrict(slot, value);
        }
        if let Some(most) = most {
            let known = self.found.units.entry(at).or_default();
            *known = most.max(*known);
        }
    }

    /// Executes the effects of an instruction on the state; `condition` is the value of `Logic::Condition`.
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
                    state.restrict(slot, value);
                }
                self.given.note(&writes);
                for to in writes {
                    self.stamp.set(self.stamp.get() + 1);
                    let stamp = self.stamp.get();
                    match to {
                        To::Bit(bit, truth) => {
                            state.write_bit(bit, truth.filter(|_| guard.surely), stamp);
                        }
                        To::Word { slot, value, origin: Origin { kept, .. } } => {
                            let unwritten =
                                (!guard.surely).then(|| state.value_unless(slot, guard));
                            match unwritten.flatten() {
                                None => state.write(slot, value, kept, stamp),
                                Some(unwritten) => {
                                    let perhaps =
                                        ConditionalWrite { when: guard.conjunction(), value };
                                    state.write_perhaps(slot, perhaps, unwritten, &kept, stamp);
                                }
                            }
                            let all = &mut self.written[slot];
                            *all = Some(all.map_or(value, |all| all.join(value)));
                        }
                        To::Words(slots) => {
                            state.forget(slots.clone(), stamp);
                            if self.lost.insert((slots.start, slots.end)) {
                                self.given.note_any(slots.clone());
                                self.written[slots].fill(Some(Value::TOP));
                            }
                        }
                        To::Bits(bits) => state.forget_bits(bits, stamp),
                    }
                }
            } else {
                for (slot, value) in before.into_iter().rev() {
                    state.restrict(slot, value);
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
    ) -> Result<usize, NotAnalysed> {
        let next = at + 1;
        match step {
            Step::Act { .. } | Step::Nothing => {}
            Step::Logic { join, .. } => self.join(act, *join, fires),
            Step::AndBlock | Step::OrBlock => {
                let (b, a) = (act.stack.pop(), act.stack.pop());
                let (a, b) = (a.unwrap_or_default(), b.unwrap_or_default());
                let both = if *step == Step::AndBlock { a.and(&b) } else { a.or(&b) };
                act.stack.push(both.with_literal(|| self.fresh()));
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
            Step::Unbounded { .. } => {
                if act.state.take().is_some() {
                    self.endless.insert(at);
                }
            }
            Step::ForBegin { count, least, most, end } => {
                let turns = self.iteration_limits(act, at, *count, *least, *most);
                self.execute_loop(act, at, *end, turns)?;
                return Ok(end + 1);
            }
            Step::ForEnd => {}
            Step::Summary(summary) => match summary.iterations {
                Some((count, least, most)) => {
                    let turns = self.iteration_limits(act, at, count, least, most);
                    self.execute_loop(act, at, summary.end, turns)?;
                    return Ok(summary.end + 1);
                }
                // A summary of something other than a loop cannot be executed iteration by iteration.
                None => return Err(NotAnalysed),
            },
            Step::MasterControlBegin { level, .. } => {
                let all = match act.mc_regions.last() {
                    Some((_, outer)) => outer.and(&fires),
                    None => fires,
                };
                act.mc_regions.push((*level, all));
            }
            Step::MasterControlEnd { level } => act.mc_regions.retain(|(open, _)| open < level),
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
                act.stack.push(joined.with_literal(|| self.fresh()));
            }
            Join::Replace => {
                act.stack.pop();
                act.stack.push(value);
            }
        }
    }

    /// Splits the state: returns it for the case that the condition is true (`None`: impossible), and leaves in `act`
    /// what is known if it is false (nothing if it cannot be false).
    fn part(&mut self, act: &mut Activation, fires: &Condition) -> Option<State> {
        if fires.never {
            return None;
        }
        let mut taken = act.state.clone()?;
        taken.restrict_where(fires.literals());
        let possible = taken.assume(fires, &mut Vec::new());
        if fires.surely || act.state.as_mut().is_some_and(|stays| !stays.assume_not(fires)) {
            act.state = None;
        }
        possible.then_some(taken)
    }

    /// The smallest and the largest number of iterations of a loop, from the values of its count, within
    /// `least..=most`. The largest is also recorded.
    fn iteration_limits(
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
                Some(ChoiceKind::UnsignedIterations(word)) => (*word, false, false),
                _ => (count, false, true),
            },
            word => (word, false, true),
        };
        let (mut low, mut high) = match word {
            // If the front gives no kind for the count's choice, the count need not be the word's signed value.
            WordSource::Free(choice) if !self.program.kinds.contains_key(&choice) => {
                (i64::from(least), i64::from(most))
            }
            word if is_signed => evaluation.word(word).signed(),
            word => evaluation.word(word).unsigned(),
        };
        if let Some(&(least, largest)) = self.program.stated_counts.get(&at) {
            (low, high) = (low.max(least), high.min(largest));
            // Paths on which the word has another value do not exist.
            if let WordSource::Cell(cell) = word
                && let Some(slot) = self.followed.words.slot(cell)
                && let Some(value) = state.value(slot).meet(Value::range(least, largest))
            {
                state.restrict(slot, value);
            }
        }
        let within = |turns: i64| turns.clamp(least.into(), most.into());
        let high = within(if odd { high.max(1) } else { high });
        let low = if odd && low < 1 { i64::from(least) } else { within(low) };
        let known = self.found.iterations.entry(at).or_default();
        *known = high.max(*known);
        (low.max(0).unsigned_abs(), high.max(0).unsigned_abs())
    }

    /// Executes a loop: iteration by iteration if that takes few instructions, otherwise up to a fixpoint.
    fn execute_loop(
        &mut self,
        act: &mut Activation,
        at: usize,
        end: usize,
        (least, most): (u64, u64),
    ) -> Result<(), NotAnalysed> {
        let Some(begun) = act.state.take() else { return Ok(()) };
        let mut exits: Option<State> = None;
        if least == 0 {
            exits = Some(begun.clone());
        }
        let (mut head, mut settled) = (begun, false);
        // The records before widening began, and how often the state was widened to a limit.
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
            // The test whether the state still changes takes long, so it is rarely made in a loop of many iterations.
            let is_asked = turn < ITERATIONS_BEFORE_WIDENING || turn.is_power_of_two();
            if !settled && is_asked && head.covers(&state) {
                // All further iterations are the same.
                if turn < least {
                    join(self.fresh(), &mut exits, state);
                }
                break;
            }
            let spent = self.work - began;
            let all = (spent / turn).saturating_mul(most);
            if !settled && (turn < ITERATIONS_BEFORE_WIDENING || all <= exact_work) {
                head = state;
                continue;
            }
            // From here on, the state at the loop head covers all further iterations.
            let is_cheap = spent <= CHEAP_WORK;
            if !settled && is_cheap {
                before = Some(self.snapshot(act, &exits));
            }
            settled = true;
            let stamp = self.fresh();
            let mut wider = head.clone();
            let is_last = !is_cheap || grown >= MAX_WIDENINGS;
            grown += u64::from(!is_last);
            if turn < 2 * ITERATIONS_BEFORE_WIDENING + grown || spent < EXACT_WORK {
                wider.widen(&state, stamp, &self.followed.limits, is_last);
            } else {
                wider = self.followed.anything();
            }
            if head.covers(&wider) {
                // The iteration adds nothing to the state at its head, so all further iterations are the same.
                join(self.fresh(), &mut exits, state.clone());
                if let Some(before) = before.filter(|_| is_cheap) {
                    exits = self.narrow(act, at..end, state, before)?;
                }
                break;
            }
            head = wider;
        }
        act.state = exits;
        act.forget_results();
        Ok(())
    }

    /// A copy of everything that was recorded so far, for [`Run::narrow`].
    fn snapshot(&mut self, act: &Activation, exits: &Option<State>) -> Snapshot {
        // A copy counts as the work of some instructions.
        self.work +=
            (self.found.units.len() + self.found.reaches.len() + self.written.len()) as u64 / 64;
        Snapshot {
            found: self.found.clone(),
            written: self.written.clone(),
            given: self.given.clone(),
            lost: self.lost.clone(),
            pending_jumps: act.pending_jumps.clone(),
            ends: [&act.returned, &self.ended, &self.stopped, exits].map(Clone::clone),
        }
    }

    /// Narrowing: executes one more iteration from the widened state, and takes the result as the new state at the loop
    /// head, since every iteration but the first begins with what another one left. The records of the widened
    /// iterations are discarded. Returns the state at which the loop is left.
    fn narrow(
        &mut self,
        act: &mut Activation,
        body: std::ops::Range<usize>,
        left: State,
        before: Snapshot,
    ) -> Result<Option<State>, NotAnalysed> {
        let Snapshot { found, written, given, lost, pending_jumps, ends } = before;
        (self.found, self.written, self.given) = (found, written, given);
        (self.lost, act.pending_jumps) = (lost, pending_jumps);
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
