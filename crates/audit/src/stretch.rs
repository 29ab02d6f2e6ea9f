//! An upper bound on the longest time between two restarts of the watchdog, from the structure of the program.
//!
//! All paths are followed at once. At each place, only the longest time since the last restart matters, whether the
//! restart is inside the part being followed or before it. A restart counts only if it certainly fires. Loops and
//! routines are followed once, and their times are then combined.

use scanbound_base::time::{Picos, Times};
use scanbound_ir::{BitSource, Cell, Counted, Exit, Join, Logic, Program, Setting, Step, Summary};
use std::collections::BTreeMap;
use std::ops::Range;

/// The longest times at a place, in picoseconds: `through` since the part began, if no restart is on the path; `since`
/// since a restart inside the part. `None` if there is no such path.
#[derive(Debug, Clone, Copy, Default)]
struct PassedTimes {
    through: Option<u128>,
    since: Option<u128>,
}

impl PassedTimes {
    /// The state at the beginning of a part.
    const BEGIN: PassedTimes = PassedTimes { through: Some(0), since: None };

    fn is_reached(self) -> bool {
        self.through.is_some() || self.since.is_some()
    }

    fn join(self, other: PassedTimes) -> PassedTimes {
        PassedTimes { through: self.through.max(other.through), since: self.since.max(other.since) }
    }

    fn plus(self, time: u128) -> PassedTimes {
        let more = |passed: u128| passed.saturating_add(time);
        PassedTimes { through: self.through.map(more), since: self.since.map(more) }
    }

    /// The times after a part of the program that begins with the times `self`, if the part itself takes `part`.
    fn then(self, part: PassedTimes) -> PassedTimes {
        let along = part.through.map_or(PassedTimes::default(), |time| self.plus(time));
        PassedTimes { since: along.since.max(part.since.filter(|_| self.is_reached())), ..along }
    }

    fn restarted(self) -> PassedTimes {
        PassedTimes { through: None, since: self.is_reached().then_some(0) }
    }
}

/// The times in a part of the program that was followed from its beginning. `None` stands for: no such path.
#[derive(Debug, Clone, Default)]
struct Part {
    /// The longest time from the beginning of the part to its first watchdog restart. `None` if no path has a restart.
    head: Option<u128>,
    /// The longest time between two watchdog restarts within the part.
    inner: u128,
    /// The times at the end of the part.
    out: PassedTimes,
    /// The times at the returns in the part.
    returned: PassedTimes,
    /// The times at the places where an END or FEND ends the main routine within the part.
    ended: PassedTimes,
    /// The times at the places within the part where a stop or an endless loop ends the whole scan.
    stopped: PassedTimes,
    /// The times at jumps out of the part, by the target of the jump.
    exits: BTreeMap<usize, PassedTimes>,
}

impl Part {
    /// Includes another part (a routine or a loop's iteration) that begins where `from` is the state. Its time to its
    /// first watchdog restart is added to the times in `from`; its stretches between restarts count as they are; where
    /// it ends the main routine or the scan, the times are joined. Its end, returns and jumps are left to the caller.
    fn enter(&mut self, from: PassedTimes, part: &Part) {
        let longest = |passed: Option<u128>| Some(passed?.saturating_add(part.head?));
        self.head = self.head.max(longest(from.through));
        self.inner = self.inner.max(longest(from.since).unwrap_or(0));
        if from.is_reached() {
            self.inner = self.inner.max(part.inner);
        }
        self.ended = self.ended.join(from.then(part.ended));
        self.stopped = self.stopped.join(from.then(part.stopped));
    }

    fn restart(&mut self, at: PassedTimes) {
        self.head = self.head.max(at.through);
        self.inner = self.inner.max(at.since.unwrap_or(0));
    }
}

/// What is known about the conditions of a rung at one instruction. A condition is `None` if it is not the same in
/// every scan.
struct Conditions {
    /// The results of contacts on the stack, the newest last, as far as they are known. Results below them are unknown.
    stack: Vec<Option<bool>>,
    /// Whether the stack has no results below those in `stack`.
    is_whole: bool,
    slots: BTreeMap<u32, Option<bool>>,
    /// The open master control regions: the level of each, and whether it is certainly on.
    masters: Vec<(u32, Option<bool>)>,
    /// Whether all master control regions around the part that is followed are certainly on. `None` if unknown.
    around: Option<bool>,
    /// Bits that are known to be on.
    on: Vec<Cell>,
}

impl Conditions {
    fn new(around: Option<bool>, is_whole: bool) -> Conditions {
        let (stack, slots, masters) = (Vec::new(), BTreeMap::new(), Vec::new());
        Conditions { stack, is_whole, slots, masters, around, on: Vec::new() }
    }

    /// Whether a step fires. `None` if that is not the same in every scan.
    fn fires(&self, step: &Step) -> Option<bool> {
        let condition = if step.depends_on_master_control() {
            and(self.top(), self.masters())
        } else {
            self.top()
        };
        step.fires().map_or(Some(true), |logic| truth(logic, condition, &self.on))
    }

    /// Updates the conditions for a step after which the next instruction follows. Returns false, and changes nothing,
    /// for steps that may continue elsewhere.
    fn follow(&mut self, step: &Step, fires: Option<bool>) -> bool {
        match step {
            Step::Logic { join: Join::Start, .. } => {
                (self.stack, self.is_whole) = (vec![fires], true);
            }
            Step::Logic { join: Join::Load, .. } => self.stack.push(fires),
            Step::Logic { join, .. } => {
                let top = self.pop();
                self.stack.push(match join {
                    Join::And => and(top, fires),
                    Join::Or => or(top, fires),
                    Join::Start | Join::Load | Join::Replace => fires,
                });
            }
            Step::AndBlock | Step::OrBlock => {
                let (b, a) = (self.pop(), self.pop());
                self.stack.push(if *step == Step::AndBlock { and(a, b) } else { or(a, b) });
            }
            Step::Save(slot) => _ = self.slots.insert(*slot, self.top()),
            Step::Fetch(slot) => {
                let value = self.slots.get(slot).copied().unwrap_or(None);
                self.pop();
                self.stack.push(value);
            }
            Step::MasterControlBegin { level, .. } => self.masters.push((*level, fires)),
            Step::MasterControlEnd { level } => self.masters.retain(|(open, _)| open < level),
            Step::Act { .. } | Step::Nothing | Step::ForEnd => {}
            _ => return false,
        }
        true
    }

    fn top(&self) -> Option<bool> {
        self.stack.last().copied().unwrap_or(if self.is_whole { Some(true) } else { None })
    }

    fn pop(&mut self) -> Option<bool> {
        let top = self.top();
        self.stack.pop();
        top
    }

    fn masters(&self) -> Option<bool> {
        self.masters.iter().fold(self.around, |all, &(_, one)| and(all, one))
    }

    /// Forgets what is known about conditions, because control may also come by a jump.
    fn forget(&mut self) {
        (self.stack, self.is_whole) = (Vec::new(), false);
        self.slots.clear();
    }
}

fn and(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    match (a, b) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), Some(true)) => Some(true),
        _ => None,
    }
}

fn or(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    and(a.map(|a| !a), b.map(|b| !b)).map(|neither| !neither)
}

/// The state while a program is followed to measure the times between watchdog restarts.
struct Walk<'p> {
    program: &'p Program,
    times: &'p [Times],
    /// The routines that were followed, by their first instruction.
    routines: BTreeMap<usize, Part>,
    /// Whether an instruction that restarts the watchdog begins a new measurement. Otherwise such instructions have no
    /// effect.
    restarts: bool,
}

/// An upper bound on the longest time without a restart of the watchdog. `around` is the time outside of the program,
/// between the end of a scan and the beginning of the next. `times` are the largest of each instruction. All interrupts
/// of a scan are included. `None` if nothing in the program restarts the watchdog.
pub fn upper(program: &Program, times: &[Times], around: Picos) -> Option<Picos> {
    if program.scan_control.restarts.is_empty() {
        return None;
    }
    let mut walk = Walk { program, times, routines: BTreeMap::new(), restarts: true };
    let mut all = Part { out: PassedTimes::BEGIN, ..Part::default() };
    for main in &program.mains {
        let part = walk.part(main.clone(), Some(true), true);
        let from = all.out;
        all.enter(from, &part);
        all.out = from.then(part.out).join(all.ended);
        all.ended = PassedTimes::default();
    }
    let end = all.out.join(all.stopped);
    let around = u128::from(around.0);
    let edge = [all.head, end.through, end.since].into_iter().flatten().max().unwrap_or(0);
    let stretch = all.inner.max(edge.saturating_add(around));
    // Interrupts may occur at any place.
    let stretch = Picos(u64::try_from(stretch).unwrap_or(u64::MAX / 2));
    Some(stretch + interrupts(program, times))
}

/// An upper bound on the time of all interrupts in one scan together.
pub fn interrupts(program: &Program, times: &[Times]) -> Picos {
    let mut walk = Walk { program, times, routines: BTreeMap::new(), restarts: false };
    let mut all = 0_u128;
    for interrupt in &program.interrupts {
        let part = walk.part(interrupt.entry..program.instructions.len(), Some(true), true);
        let most = [part.out, part.returned, part.ended, part.stopped]
            .map(|passed| passed.through.unwrap_or(0));
        let most = most.into_iter().max().unwrap_or(0);
        all = all.saturating_add(most.saturating_mul(interrupt.times.into()));
    }
    Picos(u64::try_from(all).unwrap_or(u64::MAX / 2))
}

/// By how much these instructions (`extensions`: each with the least and the largest time that it adds) certainly
/// extend the watchdog's time in every scan before it runs out. Only those count that precede any jump or call and are
/// executed in time. `default` is the watchdog time without them, and `around` the time outside of the program.
pub fn certain_extension(
    program: &Program,
    times: &[Times],
    (default, around): (Picos, Picos),
    extensions: &BTreeMap<usize, (Picos, Picos)>,
) -> Picos {
    let mut longer = Picos::ZERO;
    follow_beginning(program, times, &[], |at, passed| {
        if let Some(&(least, _)) = extensions.get(&at)
            && around + passed <= default + longer
        {
            longer += least;
        }
        true
    });
    longer
}

/// The longest time of the first scan until it has certainly set and then restarted the watchdog. `None` if it does not
/// do so before any jump or call. `around` is the time outside of the program.
pub fn until_set(program: &Program, times: &[Times], around: Picos) -> Option<Picos> {
    let control = &program.scan_control;
    let (mut is_set, mut found) = (false, None);
    follow_beginning(program, times, &program.power_up.first_scan, |at, passed| {
        is_set |= control.watchdog.contains_key(&at);
        if is_set && control.restarts.contains(&at) {
            found = Some(around + passed);
        }
        found.is_none()
    });
    found
}

/// Whether each scan in which the bits `on` are on certainly executes one of these instructions, and it fires, before
/// any jump or call.
pub fn surely_sets(
    program: &Program,
    times: &[Times],
    on: &[Cell],
    settings: &BTreeMap<usize, Setting>,
) -> bool {
    let mut is_set = false;
    follow_beginning(program, times, on, |at, _| {
        is_set |= settings.contains_key(&at);
        !is_set
    });
    is_set
}

/// Follows the beginning of the program up to the first jump or call, as long as `visit` returns true. Calls `visit`
/// for each instruction that certainly fires if these bits are on, with the longest time passed so far.
fn follow_beginning(
    program: &Program,
    times: &[Times],
    on: &[Cell],
    mut visit: impl FnMut(usize, Picos) -> bool,
) {
    let walk = Walk { program, times, routines: BTreeMap::new(), restarts: false };
    let mut known = Conditions { on: on.to_vec(), ..Conditions::new(Some(true), true) };
    let mut passed = 0_u128;
    for at in program.mains.first().cloned().unwrap_or_default() {
        let instruction = &program.instructions[at];
        let fires = known.fires(&instruction.step);
        passed = passed.saturating_add(walk.cost(at, fires));
        let so_far = Picos(u64::try_from(passed).unwrap_or(u64::MAX / 2));
        let goes_on = fires != Some(true) || visit(at, so_far);
        if !goes_on || !known.follow(&instruction.step, fires) {
            break;
        }
    }
}

impl Walk<'_> {
    /// Follows the instructions of a range. `is_whole`: it begins with an empty stack, as a program or routine does.
    /// `around` says whether the surrounding master control regions are on.
    fn part(&mut self, range: Range<usize>, around: Option<bool>, is_whole: bool) -> Part {
        let program = self.program;
        let mut part = Part::default();
        let mut here = PassedTimes::BEGIN;
        let mut pending: BTreeMap<usize, PassedTimes> = BTreeMap::new();
        let mut known = Conditions::new(around, is_whole);
        let mut at = range.start;
        while at < range.end {
            if let Some(passed) = pending.remove(&at) {
                here = here.join(passed);
                known.forget();
            }
            if !here.is_reached() {
                // Control does not fall through to here: continue at the next jump target.
                match pending.keys().next() {
                    Some(&next) => at = next,
                    None => break,
                }
                continue;
            }
            let instruction = &program.instructions[at];
            let fires = known.fires(&instruction.step);
            here = here.plus(self.cost(at, fires));
            if self.restarts && fires == Some(true) && program.scan_control.restarts.contains(&at) {
                part.restart(here);
                // The time of the restart instruction itself may count after the restart, too.
                here = here.restarted().plus(self.cost(at, fires));
            }
            let mut next = at + 1;
            match &instruction.step {
                step if known.follow(step, fires) => {}
                Step::Jump { target, .. } => {
                    if fires != Some(false) {
                        let to = pending.entry(*target).or_default();
                        *to = to.join(here);
                    }
                    if fires == Some(true) {
                        here = PassedTimes::default();
                    }
                }
                Step::Call { target, .. } => {
                    let routine = self.routine(*target);
                    if fires != Some(false) {
                        part.enter(here, &routine);
                        let behind = here.then(routine.out);
                        here = if fires == Some(true) { behind } else { here.join(behind) };
                    }
                }
                Step::Return => {
                    part.returned = part.returned.join(here);
                    here = PassedTimes::default();
                }
                Step::End => {
                    part.ended = part.ended.join(here);
                    here = PassedTimes::default();
                }
                Step::Stop { .. } | Step::Unbounded { .. } => {
                    part.stopped = part.stopped.join(here);
                    if fires == Some(true) {
                        here = PassedTimes::default();
                    }
                }
                Step::ForBegin { least, most, end, .. } => {
                    let turn = self.part(at + 1..end + 1, known.masters(), false);
                    here = around_loop(&mut part, &mut pending, here, &turn, (*least, *most));
                    known.forget();
                    next = end + 1;
                }
                Step::Summary(summary) => {
                    here =
                        self.summary(&mut part, &mut pending, here, (at, summary), known.masters());
                    known.forget();
                    next = summary.end + 1;
                }
                _ => {}
            }
            at = next;
        }
        part.out = part.out.join(here);
        part.exits = pending;
        part
    }

    /// Follows a loop summary or a summarised routine from the times `here`, and returns the times after it. Its jumps
    /// are added to `pending`.
    fn summary(
        &mut self,
        part: &mut Part,
        pending: &mut BTreeMap<usize, PassedTimes>,
        here: PassedTimes,
        (at, summary): (usize, &Summary),
        around: Option<bool>,
    ) -> PassedTimes {
        if let Some((_, least, most)) = summary.iterations {
            let turn = self.part(at + 1..summary.end + 1, around, false);
            return around_loop(part, pending, here, &turn, (least, most));
        }
        let charge = |&(instruction, times): &(usize, u64)| {
            self.cost(instruction, None).saturating_mul(times.into())
        };
        let all = summary.charges.iter().map(charge).fold(0, u128::saturating_add);
        let here = here.plus(all);
        for (_, exit) in &summary.exits {
            let to = match exit {
                Exit::To(target) => pending.entry(*target).or_default(),
                Exit::Return => &mut part.returned,
                Exit::End => &mut part.ended,
                Exit::Stop | Exit::Unbounded(_) => &mut part.stopped,
            };
            *to = to.join(here);
        }
        here
    }

    fn routine(&mut self, entry: usize) -> Part {
        if let Some(known) = self.routines.get(&entry) {
            return known.clone();
        }
        let mut part = self.part(entry..self.program.instructions.len(), Some(true), true);
        part.out = part.returned;
        self.routines.insert(entry, part.clone());
        part
    }

    /// The longest time of an instruction that control reaches. `fires` is `None` if unknown.
    fn cost(&self, at: usize, fires: Option<bool>) -> u128 {
        let times = self.times[at];
        let units = self.program.instructions[at].counted().map_or(0, Counted::most_units);
        let on = times.with(units);
        u128::from(match fires {
            Some(true) => on.0,
            Some(false) => times.off.0,
            None => on.max(times.off).0,
        })
    }
}

/// The times after a loop that makes between `least` and `most` iterations, computed from the times of one iteration
/// (`turn`). Jumps out of the loop are added to `pending`.
fn around_loop(
    part: &mut Part,
    pending: &mut BTreeMap<usize, PassedTimes>,
    here: PassedTimes,
    turn: &Part,
    (least, most): (u32, u32),
) -> PassedTimes {
    if most == 0 {
        return here;
    }
    // Where an iteration may begin: the first one, and one after others.
    let further = u128::from(most - 1);
    let mut begins = here;
    if further > 0 {
        let along = turn
            .out
            .through
            .map_or(PassedTimes::default(), |turn| here.plus(turn.saturating_mul(further)));
        let since = turn.out.since.filter(|_| here.is_reached());
        let more = turn.out.through.unwrap_or(0).saturating_mul(further);
        let since = since.map(|since| since.saturating_add(more));
        begins = here.join(along).join(PassedTimes { through: None, since });
    }
    part.enter(begins, turn);
    for (&target, &passed) in &turn.exits {
        let to = pending.entry(target).or_default();
        *to = to.join(begins.then(passed));
    }
    part.returned = part.returned.join(begins.then(turn.returned));
    let behind = begins.then(turn.out);
    if least == 0 { here.join(behind) } else { behind }
}

/// The value of an expression if it is the same in every scan in which the bits `on` are on, otherwise `None`.
/// `condition` is the value of the rung's condition.
fn truth(logic: &Logic, condition: Option<bool>, on: &[Cell]) -> Option<bool> {
    let all = |parts: &[Logic]| {
        let values = parts.iter().map(|one| truth(one, condition, on));
        values.reduce(and).unwrap_or(Some(true))
    };
    match logic {
        Logic::Condition => condition,
        Logic::Const(value) | Logic::Bit(BitSource::Const(value)) => Some(*value),
        Logic::Bit(BitSource::Cell(cell)) if on.contains(cell) => Some(true),
        Logic::Bit(_) | Logic::Compare(_) => None,
        Logic::Not(inner) => truth(inner, condition, on).map(|value| !value),
        Logic::All(parts) => all(parts),
        Logic::Any(parts) => {
            let any = parts.iter().map(|one| truth(one, condition, on));
            any.fold(Some(false), or)
        }
    }
}
