//! Makes the longest real run longer: changes its start so that expensive instructions fire that did not, and so that
//! it no longer reaches what stopped it. The changes follow from what the run read and wrote, so that indices, pointers
//! and loops are no obstacle. Each changed run is made anew; it counts only if it is longer.

use super::real::{RunResults, RunSearch};
use super::start_changes::Changes;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{Cell, Frame, Join, Program, Region, Source, Step, Witness, WordSource, flow};
use scanbound_replay::{Event, RealRun, StopReason, Trace};
use std::collections::{BTreeMap, BTreeSet};

/// The largest number of instructions that all runs of one call execute.
const MAX_EXECUTED: usize = 4_000_000;
/// Steering ends when runs that executed so many instructions in all were not longer.
const MAX_FRUITLESS: usize = 1_000_000;
/// The largest number of instructions that one change of the start is meant for.
const MAX_TARGETS: usize = 1000;
/// Changes that would make the run longer by less than this part of it are not tried.
const LEAST_GAIN: u64 = 2000;
/// The largest number of steps in which a change is worked out.
const MAX_STEPS: usize = 4000;

/// A condition of the run: an index into [`Conditions::nodes`].
pub(super) type Node = usize;
/// The condition that is always true.
const ALWAYS: Node = 0;

#[derive(Clone, Copy)]
pub(super) enum Condition {
    Always,
    /// Whether an event fired.
    Fired(usize),
    And(Node, Node),
    Or(Node, Node),
}

/// The conditions under which the instructions of a run were executed.
pub(super) struct Conditions<'a> {
    pub(super) program: &'a Program,
    pub(super) run: &'a RealRun,
    pub(super) trace: &'a Trace,
    /// Each condition with its value in the run.
    pub(super) nodes: Vec<(Condition, bool)>,
    /// The execution condition of each event.
    pub(super) of_events: Vec<Node>,
    /// The execution condition of the instruction that would follow the last event in the same routine.
    pub(super) end: Node,
}

/// The stack and the slots of a routine, as the interpreter has them, with conditions in place of values.
#[derive(Default)]
struct Routine {
    stack: Vec<Node>,
    slots: BTreeMap<u32, Node>,
    masters: Vec<(u32, Node)>,
}

/// What a change of the start is meant for: an instruction in a call context.
type Target = (usize, Vec<Frame>);

/// An instruction that would make the run longer, by about this time in picoseconds, with the changes for it.
#[derive(Clone)]
struct Wanted {
    target: Target,
    gain: u64,
    changes: Changes,
}

/// What has been done in a call of [`RunSearch::steer`].
#[derive(Default)]
struct Effort {
    /// The number of instructions that all runs executed.
    executed: usize,
    /// That number when the last longer run was found.
    gained_at: usize,
    /// The instructions that need not be tried again.
    tried: BTreeSet<Target>,
}

impl Effort {
    fn is_spent(&self) -> bool {
        self.executed >= MAX_EXECUTED || self.executed - self.gained_at > MAX_FRUITLESS
    }
}

/// What an instruction shall do.
#[derive(Clone, Copy)]
enum Goal {
    /// It fires, or does not.
    Fires(bool),
    /// This loop makes so many iterations.
    Iterates(u16),
    /// No operation error stops the CPU there.
    Runs,
}

impl RunSearch<'_> {
    /// Replaces the longest run by longer ones as long as changes of its start find them; a run that an operation error
    /// ends, by one that gets further. No run may take longer than `upper`, if that is given.
    ///
    /// # Errors
    /// That a run contradicts the analysis.
    pub(super) fn steer(&self, found: &mut RunResults, upper: Option<Picos>) -> Result<(), String> {
        let sums = Sums::of(self.program, self.least);
        let mut effort = Effort::default();
        let goes_on = |run: &RealRun| run.is_possible() || ends_in_error(run);
        while goes_on(&found.best) && !effort.is_spent() && !self.is_over() {
            let (run, trace) = self.traced(&found.witness);
            effort.executed += run.replay.events.len();
            let conditions = Conditions::of(self.program, &run, &trace);
            let wanted = self.wanted(&conditions, &sums, &mut effort.tried);
            if wanted.is_empty() {
                break;
            }
            self.try_changes(found, wanted, &mut effort, upper)?;
        }
        Ok(())
    }

    /// The instructions that would make a run longer, with changes that do not contradict each other. Those for which
    /// there are none count as tried.
    fn wanted(
        &self,
        conditions: &Conditions<'_>,
        sums: &Sums,
        tried: &mut BTreeSet<Target>,
    ) -> Vec<Wanted> {
        let mut wanted: Vec<Wanted> = Vec::new();
        let mut all = Changes::default();
        // If one iteration of a loop cannot be changed, the others hardly can.
        let mut failed: BTreeSet<usize> = BTreeSet::new();
        for (gain, target, event, goal) in conditions.targets(self.least, sums) {
            if wanted.len() >= MAX_TARGETS || self.is_over() {
                break;
            }
            if tried.contains(&target) || failed.contains(&target.0) {
                continue;
            }
            let mut changes = Changes::default();
            let mut steps = MAX_STEPS;
            let made = conditions.make(&target, event, goal, &mut changes, &mut steps);
            if !made || changes.is_empty() {
                failed.insert(target.0);
                tried.insert(target);
            } else if all.add(&changes) {
                wanted.push(Wanted { target, gain, changes });
            }
        }
        wanted
    }

    /// Makes a run with all changes together. If it is not longer, makes one without those changes that keep expensive
    /// instructions of the longest run from firing; if there are none, one with each quarter of the changes.
    fn try_changes(
        &self,
        found: &mut RunResults,
        wanted: Vec<Wanted>,
        effort: &mut Effort,
        upper: Option<Picos>,
    ) -> Result<(), String> {
        let mut open = vec![wanted];
        while let Some(part) = open.pop() {
            if effort.is_spent() || self.is_over() {
                break;
            }
            let worth = part.iter().map(|one| one.gain).fold(0, u64::saturating_add);
            if worth < found.best.replay.total.0 / LEAST_GAIN {
                effort.tried.extend(part.into_iter().map(|one| one.target));
                continue;
            }
            let mut changes = Changes::default();
            for one in &part {
                changes.add(&one.changes);
            }
            let witness = self.changed(&found.witness, &changes);
            let mut run = self.real(&witness)?;
            effort.executed += run.replay.events.len();
            if let Some(upper) = upper {
                self.within(&run, upper)?;
            }
            let rank = |run: &RealRun| (run.is_possible(), run.replay.total);
            if (run.is_possible() || ends_in_error(&run)) && rank(&run) > rank(&found.best) {
                effort.gained_at = effort.executed;
                found.note(self.program, &mut run);
                (found.best, found.witness) = (run, witness);
                continue;
            }
            // Without the changes of what a broken invariant reads, the others may lead to a run.
            let broken = self.read_by(&run.replay.broken_invariants);
            let before = part.len();
            let (left, guilty): (Vec<_>, Vec<_>) = part
                .into_iter()
                .partition(|one| one.changes.start.keys().all(|cell| !broken.contains(cell)));
            effort.tried.extend(guilty.into_iter().map(|one| one.target));
            let (left, guilty) = match left.len() == before {
                true => {
                    effort.executed += run.replay.events.len();
                    self.without_spoilers(&found.best, &witness, left)
                }
                false => (left, Vec::new()),
            };
            effort.tried.extend(guilty.into_iter().map(|one| one.target));
            match left.len() {
                0 => {}
                count if count < before => open.push(left),
                1 => effort.tried.extend(left.into_iter().map(|one| one.target)),
                count => {
                    let quarters = left.chunks(count.div_ceil(4)).rev();
                    open.extend(quarters.map(<[_]>::to_vec));
                }
            }
        }
        Ok(())
    }

    /// Takes changes out that cost more than they gain: instructions that fired in the longest run do not fire with all
    /// changes, and could if some of the changes were left out, which share their time. `changed` is the witness with
    /// all changes. Returns the other changes and these.
    fn without_spoilers(
        &self,
        longest: &RealRun,
        changed: &Witness,
        part: Vec<Wanted>,
    ) -> (Vec<Wanted>, Vec<Wanted>) {
        let (run, trace) = self.traced(changed);
        let conditions = Conditions::of(self.program, &run, &trace);
        let sums = Sums::of(self.program, self.least);
        let fired: BTreeMap<(usize, &[Frame]), bool> = longest
            .replay
            .events
            .iter()
            .map(|event| ((event.instruction, &*event.frames), event.fired))
            .collect();
        let mut costs = vec![0; part.len()];
        for (lost, target, event, goal) in conditions.targets(self.least, &sums) {
            if self.is_over() {
                break;
            }
            let before = fired.get(&(target.0, &target.1[..]));
            let is_lost = match goal {
                Goal::Fires(on) => before == Some(&on),
                Goal::Runs => before.is_some(),
                Goal::Iterates(_) => false,
            };
            let mut undone = Changes::default();
            let mut steps = MAX_STEPS;
            if !is_lost || !conditions.make(&target, event, goal, &mut undone, &mut steps) {
                continue;
            }
            // A call takes the time of everything that it executed.
            let depth = target.1.len();
            let is_within = |event: &&Event| {
                event.frames.len() > depth
                    && event.frames[..depth] == target.1[..]
                    && event.frames[depth].at == target.0
            };
            let within = longest.replay.events.iter().filter(is_within);
            let lost = lost.max(within.map(|event| event.cost.0).sum());
            let spoils = |one: &Wanted| one.changes.contradicts(&undone);
            let count = part.iter().filter(|one| spoils(one)).count() as u64;
            for (cost, _) in costs.iter_mut().zip(&part).filter(|(_, one)| spoils(one)) {
                *cost = (lost / count).saturating_add(*cost);
            }
        }
        let (left, spoilers): (Vec<_>, Vec<_>) =
            part.into_iter().zip(costs).partition(|(one, cost)| *cost <= one.gain);
        let without_cost = |all: Vec<(Wanted, u64)>| all.into_iter().map(|(one, _)| one).collect();
        (without_cost(left), without_cost(spoilers))
    }

    /// The cells that these invariants of the program read.
    fn read_by(&self, invariants: &[usize]) -> BTreeSet<Cell> {
        let mut found = BTreeSet::new();
        for holds in invariants.iter().filter_map(|&at| self.program.invariants.get(at)) {
            holds.each_read(&mut |source| {
                if let Some(Region::Range { first, .. }) = source.region() {
                    found.insert(first);
                }
            });
        }
        found
    }

    /// The witness with these changes of its start.
    fn changed(&self, witness: &Witness, changes: &Changes) -> Witness {
        let mut changed = witness.clone();
        for (&cell, &(mask, value)) in &changes.start {
            let before = self.start_value(witness, cell);
            changed.start.insert(cell, before & !mask | value & mask);
        }
        for (key, &(mask, value)) in &changes.outside {
            let before = witness.choices.get(key).copied().unwrap_or(0);
            changed.choices.insert(key.clone(), before & !mask | value & mask);
        }
        changed
    }
}

/// Whether nothing but an operation error makes a run impossible.
fn ends_in_error(run: &RealRun) -> bool {
    run.stopped.as_ref().is_some_and(|stopped| stopped.reason == StopReason::Error)
        && run.replay.broken_ranges.is_empty()
        && run.replay.broken_invariants.is_empty()
}

/// The sums of the larger times of the instructions before each instruction.
struct Sums(Vec<u64>);

impl Sums {
    fn of(program: &Program, times: &[Times]) -> Sums {
        let mut sums = vec![0u64];
        for at in 0..program.instructions.len() {
            let time = times.get(at).map_or(0, |times| times.on.max(times.off).0);
            sums.push(sums.last().copied().unwrap_or(0).saturating_add(time));
        }
        Sums(sums)
    }

    fn between(&self, from: usize, to: usize) -> u64 {
        let sum = |at: usize| self.0.get(at).copied().unwrap_or(0);
        sum(to).saturating_sub(sum(from))
    }
}

impl<'a> Conditions<'a> {
    fn of(program: &'a Program, run: &'a RealRun, trace: &'a Trace) -> Conditions<'a> {
        let nodes = vec![(Condition::Always, true)];
        let mut found =
            Conditions { program, run, trace, nodes, of_events: Vec::new(), end: ALWAYS };
        let mut routines = vec![Routine::default()];
        let starts: BTreeSet<usize> = program
            .mains
            .iter()
            .map(|main| main.start)
            .chain(program.interrupts.iter().map(|interrupt| interrupt.entry))
            .collect();
        for (number, event) in run.replay.events.iter().enumerate() {
            if starts.contains(&event.instruction) {
                routines = vec![Routine::default()];
            }
            let Some(routine) = routines.last_mut() else { break };
            let step = &program.instructions[event.instruction].step;
            let condition = found.condition(routine, step);
            found.of_events.push(condition);
            found.step(routine, step, number, event.fired);
            match step {
                Step::Call { .. } if event.fired => routines.push(Routine::default()),
                Step::Return if routines.len() > 1 => _ = routines.pop(),
                _ => {}
            }
        }
        if let (Some(stopped), Some(routine)) = (&run.stopped, routines.last()) {
            let step = &program.instructions[stopped.at].step;
            found.end = found.condition(routine, step);
        }
        found
    }

    fn node(&mut self, condition: Condition, value: bool) -> Node {
        self.nodes.push((condition, value));
        self.nodes.len() - 1
    }

    fn and(&mut self, a: Node, b: Node) -> Node {
        match (a, b) {
            (ALWAYS, one) | (one, ALWAYS) => one,
            _ => self.node(Condition::And(a, b), self.nodes[a].1 && self.nodes[b].1),
        }
    }

    fn or(&mut self, a: Node, b: Node) -> Node {
        if a == ALWAYS || b == ALWAYS {
            return ALWAYS;
        }
        self.node(Condition::Or(a, b), self.nodes[a].1 || self.nodes[b].1)
    }

    fn condition(&mut self, routine: &Routine, step: &Step) -> Node {
        let top = routine.stack.last().copied().unwrap_or(ALWAYS);
        if !step.depends_on_master_control() {
            return top;
        }
        routine.masters.iter().fold(top, |all, &(_, master)| self.and(all, master))
    }

    fn step(&mut self, routine: &mut Routine, step: &Step, event: usize, fired: bool) {
        match step {
            Step::Logic { join, .. } => {
                let value = self.node(Condition::Fired(event), fired);
                let top = match join {
                    Join::Start => {
                        routine.stack.clear();
                        value
                    }
                    Join::Load => value,
                    Join::And => {
                        let before = routine.stack.pop().unwrap_or(ALWAYS);
                        self.and(before, value)
                    }
                    Join::Or => {
                        let before = routine.stack.pop().unwrap_or(ALWAYS);
                        self.or(before, value)
                    }
                    Join::Replace => {
                        routine.stack.pop();
                        value
                    }
                };
                routine.stack.push(top);
            }
            Step::AndBlock | Step::OrBlock => {
                let upper = routine.stack.pop().unwrap_or(ALWAYS);
                let lower = routine.stack.pop().unwrap_or(ALWAYS);
                let both = match step {
                    Step::AndBlock => self.and(lower, upper),
                    _ => self.or(lower, upper),
                };
                routine.stack.push(both);
            }
            Step::Save(slot) => {
                let top = routine.stack.last().copied().unwrap_or(ALWAYS);
                routine.slots.insert(*slot, top);
            }
            Step::Fetch(slot) => {
                routine.stack.pop();
                routine.stack.push(routine.slots.get(slot).copied().unwrap_or(ALWAYS));
            }
            Step::MasterControlBegin { level, .. } => {
                let master = self.node(Condition::Fired(event), fired);
                routine.masters.push((*level, master));
            }
            Step::MasterControlEnd { level } => routine.masters.retain(|(open, _)| open < level),
            _ => {}
        }
    }

    /// The instructions that would make the run longer if they fired, did not fire, or iterated more often, the most
    /// time first, each with that time and its event. The instruction that stopped the run, which may have no event,
    /// comes first: the number of events stands for its event.
    fn targets(&self, times: &[Times], sums: &Sums) -> Vec<(u64, Target, usize, Goal)> {
        let mut found: Vec<(u64, Target, usize, Goal)> = Vec::new();
        for (number, event) in self.run.replay.events.iter().enumerate() {
            if event.is_uncertain {
                continue;
            }
            let at = event.instruction;
            let (on, off) = (times[at].on.0, times[at].off.0);
            let units = times[at].per_unit.0.saturating_mul(100);
            let step = &self.program.instructions[at].step;
            let (gain, goal) = match step {
                Step::Call { target, .. } if !event.fired => {
                    let end = flow::routine_end(self.program, *target).unwrap_or(*target);
                    (sums.between(*target, end), Goal::Fires(true))
                }
                Step::Jump { target, .. } if event.fired => {
                    (sums.between(at, *target), Goal::Fires(false))
                }
                Step::Stop { .. } if event.fired => {
                    (sums.between(at, usize::MAX), Goal::Fires(false))
                }
                Step::ForBegin { end, .. } => {
                    let most = self.most_iterations(at);
                    let Some(now) = self.count(number) else { continue };
                    let more = u64::from(most.saturating_sub(now));
                    (sums.between(at, *end).saturating_mul(more), Goal::Iterates(most))
                }
                Step::Act { .. } if !event.fired => {
                    (on.saturating_add(units).saturating_sub(off), Goal::Fires(true))
                }
                Step::Act { .. } if event.fired => (off.saturating_sub(on), Goal::Fires(false)),
                _ => continue,
            };
            if gain > 0 {
                found.push((gain, (at, event.frames.to_vec()), number, goal));
            }
        }
        found.sort_by(|a, b| b.0.cmp(&a.0).then(a.2.cmp(&b.2)));
        let stopped = self.run.stopped.as_ref();
        let is_avoided = |reason| matches!(reason, StopReason::Unknown(_) | StopReason::Error);
        let stopped = stopped.filter(|one| is_avoided(one.reason));
        let first = stopped.map(|one| {
            let step = &self.program.instructions[one.at].step;
            let events = self.run.replay.events.len();
            let (event, goal) = match step {
                _ if one.reason == StopReason::Error => (events, Goal::Runs),
                Step::ForBegin { .. } | Step::Summary(_) => {
                    (events.saturating_sub(1), Goal::Iterates(self.most_iterations(one.at).max(1)))
                }
                _ => (events, Goal::Fires(false)),
            };
            (u64::MAX, (one.at, one.frames.to_vec()), event, goal)
        });
        first.into_iter().chain(found).collect()
    }

    /// The word with the number of iterations of a loop.
    fn counted(&self, at: usize) -> Option<WordSource> {
        let count = match &self.program.instructions[at].step {
            Step::ForBegin { count, .. } => *count,
            Step::Summary(summary) => summary.iterations?.0,
            _ => return None,
        };
        match count {
            WordSource::Free(choice) => match self.program.kinds.get(&choice)? {
                ChoiceKind::Iterations(word) | ChoiceKind::UnsignedIterations(word) => Some(*word),
                _ => None,
            },
            word => Some(word),
        }
    }

    /// The number of iterations that an event of a loop read, if it is not constant.
    fn count(&self, event: usize) -> Option<u16> {
        let word = self.counted(self.run.replay.events.get(event)?.instruction)?;
        Some(self.read(event, Source::Word(word))?.value)
    }

    /// The largest number of iterations of a loop, as the user states it or the analysis proved it.
    fn most_iterations(&self, at: usize) -> u16 {
        let proved = match &self.program.instructions[at].step {
            Step::ForBegin { most, .. } => *most,
            Step::Summary(summary) => summary.iterations.map_or(0, |(_, _, most)| most),
            _ => 0,
        };
        let stated = self.program.stated_counts.get(&at).map(|&(_, most)| most);
        let stated = stated.and_then(|most| u32::try_from(most).ok()).unwrap_or(u32::MAX);
        let ranges = self.program.stated_ranges.iter();
        let word = self.counted(at);
        let start = ranges
            .filter(|one| matches!(one.cells[..], [cell] if word == Some(WordSource::Cell(cell))));
        let start = start.filter_map(|one| u32::try_from(one.high).ok()).min().unwrap_or(u32::MAX);
        u16::try_from(proved.min(stated).min(start).min(0x7FFF)).unwrap_or(0)
    }

    /// Works out changes of the start after which this event does what it shall. Returns false if none are found; the
    /// changes are then of no use.
    fn make(
        &self,
        target: &Target,
        event: usize,
        goal: Goal,
        changes: &mut Changes,
        steps: &mut usize,
    ) -> bool {
        match goal {
            Goal::Fires(on) if event < self.run.replay.events.len() => {
                self.fires(event, on, changes, steps)
            }
            Goal::Fires(on) => self.solve(self.end, on, changes, steps),
            Goal::Runs => {
                let error = self.program.errors.get(&target.0);
                let mut more = changes.clone();
                if error.is_some_and(|error| self.logic(event, error, false, &mut more, steps)) {
                    *changes = more;
                    return true;
                }
                self.solve(self.end, false, changes, steps)
            }
            Goal::Iterates(count) => self
                .counted(target.0)
                .is_some_and(|word| self.word(event, word, count, changes, steps)),
        }
    }
}
