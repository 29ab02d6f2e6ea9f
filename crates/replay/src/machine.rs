//! The control flow of one scan: stack, slots, master control regions, loops, calls and the order of the routines.

use super::cases::{Cases, Readings};
use super::free::{FreeValues, Mode};
use super::outcome::{Event, RealRun, Replay, StopReason, Stopped};
use super::state::{Doubt, State, Truth};
use super::trace::Trace;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::{ChoiceKind, Knowledge};
use scanbound_ir::{
    ChoiceId, Counted, Exit, Frame, Instruction, Join, Program, Region, Resolution, Step, Summary,
    When, WordSource, Write,
};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// A loop that is being executed.
struct Loop {
    begin: usize,
    end: usize,
    iteration: u32,
    iterations: u32,
    /// The state at the start of the current iteration. `None` unless only the total time is wanted.
    begun: Option<Snapshot>,
}

/// The state of the interpreter when an iteration began. `executed` is the number of instructions that could still be
/// executed then.
struct Snapshot {
    total: Picos,
    executed: u64,
    changes: u64,
    stack: Vec<Truth>,
    slots: BTreeMap<u32, Truth>,
    masters: usize,
}

/// The state of one routine while it runs.
#[derive(Default)]
struct Routine {
    stack: Vec<Truth>,
    slots: BTreeMap<u32, Truth>,
    /// The open master control regions: the level, the region's condition, and the conjunction with those of all outer
    /// regions.
    masters: Vec<(u32, Truth, Truth)>,
    loops: Vec<Loop>,
    /// The instruction of the caller at which control continues after the return.
    back: usize,
}

/// Where control goes after an instruction.
enum Next {
    Go(usize),
    Return,
    End,
    Stop,
}

/// How a main or interrupt routine ended.
#[derive(PartialEq)]
enum RoutineEnd {
    Normal,
    Scan,
}

pub(super) struct Machine<'p> {
    program: &'p Program,
    times: &'p [Times],
    state: State<'p>,
    routines: Vec<Routine>,
    total: Picos,
    events: Vec<Event>,
    unbounded: Option<usize>,
    /// Where and why a real run stopped early. `None` if it did not.
    stopped: Option<Stopped>,
    /// The number of instructions that may still be executed.
    remaining: u64,
    /// Whether only the total time is wanted.
    sums: bool,
    /// The instructions of a timer or counter that was already executed as a whole, so that their effects are skipped.
    executed: Range<usize>,
}

impl<'p> Machine<'p> {
    pub(super) fn new(
        program: &'p Program,
        times: &'p [Times],
        free: impl FreeValues + 'p,
        mode: Mode,
    ) -> Self {
        assert_eq!(times.len(), program.instructions.len(), "a time for every instruction");
        Machine {
            program,
            times,
            state: State::new(program, Box::new(free), mode),
            routines: Vec::new(),
            total: Picos::ZERO,
            events: Vec::with_capacity(program.instructions.len()),
            unbounded: None,
            stopped: None,
            remaining: u64::MAX,
            sums: false,
            executed: 0..0,
        }
    }

    /// Requests only the total time: no events are kept, and of identical iterations only one is executed.
    pub(super) fn summing(mut self) -> Self {
        self.sums = true;
        self.events = Vec::new();
        self
    }

    /// Makes a real run of at most `most` instructions on a controller that follows the standard. Returns its time, the
    /// number of executed instructions, where it stopped, the endless loop that it reached, and the final state.
    pub(super) fn summed(
        mut self,
        most: u64,
    ) -> (Picos, u64, Option<Stopped>, Option<usize>, State<'p>) {
        self.remaining = most;
        self.state.cases = Cases::of_standard();
        let replay = self.scan();
        (replay.total, most - self.remaining, self.stopped, replay.unbounded, self.state)
    }

    /// Lets operations give the results that earlier real runs observed for the same values.
    pub(super) fn knowing(mut self, knowledge: &Knowledge) -> Self {
        self.state.learned = knowledge.clone();
        self
    }

    /// Makes a real run of at most `most` instructions, in one case. Returns the final state, too.
    pub(super) fn real(mut self, most: u64, cases: Cases) -> (RealRun, State<'p>) {
        self.remaining = most;
        self.state.cases = cases;
        (self.real_run(), self.state)
    }

    /// As [`Self::real`] in the first case. Also returns what the run read and wrote.
    pub(super) fn traced(mut self, most: u64) -> (RealRun, Trace) {
        self.remaining = most;
        self.state.cases = Cases::of_scan(Readings::new());
        self.state.trace = Some(Box::default());
        let run = self.real_run();
        let mut trace = self.state.trace.take().map_or_else(Trace::default, |trace| *trace);
        if run.stopped.is_some() {
            trace.reads.push(std::mem::take(&mut trace.current));
        }
        (run, trace)
    }

    fn real_run(&mut self) -> RealRun {
        let replay = self.scan();
        let undeclared_writes = std::mem::take(&mut self.state.undeclared_writes);
        let learned = std::mem::take(&mut self.state.learned);
        let (range_violations, exclusion_violations) = self.end_violations(&replay);
        RealRun {
            replay,
            stopped: self.stopped.take(),
            learned,
            range_violations,
            exclusion_violations,
            readings: BTreeSet::new(),
            undeclared_writes,
            needed_devices: std::mem::take(&mut self.state.needed),
        }
    }

    /// The stated ranges and exclusive pairs that hold at the start of the scan and not at its end. Both are empty if
    /// the run stopped early.
    fn end_violations(&mut self, replay: &Replay) -> (Vec<(usize, i64)>, Vec<usize>) {
        if self.stopped.is_some() {
            return (Vec::new(), Vec::new());
        }
        let mut exclusion_violations = Vec::new();
        for index in self.program.stated_exclusions.clone() {
            let holds = &self.program.invariants[index];
            let end = self.state.logic(holds, Truth::TRUE);
            if !end.value && end.doubt.is_none() && !replay.broken_invariants.contains(&index) {
                exclusion_violations.push(index);
            }
        }
        (self.state.range_violations(), exclusion_violations)
    }

    pub(super) fn scan(&mut self) -> Replay {
        let program = self.program;
        let readings = match self.state.mode {
            Mode::Real => &program.power_up.certain_invariants[..],
            Mode::Model => &[],
        };
        let broken = program.invariants.iter().chain(readings).enumerate();
        let broken = broken.filter(|(_, holds)| !self.state.logic(holds, Truth::TRUE).value);
        let broken_invariants: Vec<usize> = broken.map(|(index, _)| index).collect();
        for main in &program.mains {
            if self.run(main.start, main.end) == RoutineEnd::Scan {
                break;
            }
        }
        self.state.interrupting = true;
        for interrupt in &program.interrupts {
            for iteration in 0..interrupt.times {
                if self.stopped.is_some() {
                    break;
                }
                self.state.enter(Frame { at: interrupt.entry, iteration });
                self.run(interrupt.entry, program.instructions.len());
                self.state.leave();
            }
        }
        let broken_ranges = self.state.broken_ranges();
        let unbounded = self.unbounded;
        Replay {
            total: self.total,
            events: std::mem::take(&mut self.events),
            broken_ranges,
            broken_invariants,
            unbounded,
        }
    }

    /// Runs a main or interrupt routine from instruction `entry`. It also ends where control reaches instruction
    /// `limit` outside of called routines.
    fn run(&mut self, entry: usize, limit: usize) -> RoutineEnd {
        self.routines = vec![Routine::default()];
        let mut at = entry;
        let ended = loop {
            let limit = if self.routines.len() > 1 { usize::MAX } else { limit };
            if at >= limit.min(self.program.instructions.len()) {
                break RoutineEnd::Normal;
            }
            match self.execute(at) {
                Next::Go(target) => at = target,
                Next::Return => {
                    self.leave_loops(0);
                    at = self.routine().back;
                    self.routines.pop();
                    if self.routines.is_empty() {
                        break RoutineEnd::Normal;
                    }
                    self.state.leave();
                }
                Next::End => break RoutineEnd::Normal,
                Next::Stop => break RoutineEnd::Scan,
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

    /// Leaves loops, the innermost first, until `open` of them remain.
    fn leave_loops(&mut self, open: usize) {
        while self.routine().loops.len() > open {
            self.routine().loops.pop();
            self.state.leave();
        }
    }

    fn execute(&mut self, at: usize) -> Next {
        if self.remaining == 0 {
            return self.stop(at, StopReason::TooLong);
        }
        self.remaining -= 1;
        self.state.at = at;
        self.state.now = self.total;
        if let Some(trace) = &mut self.state.trace {
            trace.event = self.events.len();
            trace.current.clear();
        }
        let instruction = &self.program.instructions[at];
        let condition = self.condition(&instruction.step);
        self.state.condition = condition;
        let (expression, count) = match &instruction.step {
            Step::Logic { value, .. } => (Some(value), None),
            Step::Act { fires }
            | Step::Jump { fires, .. }
            | Step::Call { fires, .. }
            | Step::Stop { fires }
            | Step::MasterControlBegin { fires, .. } => (Some(fires), None),
            Step::ForBegin { count, .. } => (None, Some(*count)),
            Step::Summary(summary) if self.state.mode == Mode::Real => {
                (None, summary.iterations.map(|(count, ..)| count))
            }
            _ => (None, None),
        };
        let iterations = count.map(|count| self.iterations(&instruction.step, count));
        let fired = match expression {
            Some(logic) => self.state.logic(logic, condition),
            None => Truth::TRUE,
        };
        let times = self.times[at];
        if fired == Truth::TRUE
            && (self.breaks_count(instruction) || self.breaks_index(instruction))
        {
            return self.stop(at, StopReason::Excluded);
        }
        let is_contact = matches!(instruction.step, Step::Logic { .. });
        let executed = if is_contact { Truth::TRUE } else { fired };
        if let Some(why) = self.fails(condition, executed) {
            return self.stop(at, why);
        }
        let cost = match (fired.doubt, fired.value) {
            // It is unknown whether it fires: it takes at least the smaller time.
            (Some(cause), _) => {
                if times.on != times.off || times.per_unit > Picos::ZERO {
                    self.state.cases.depends_on(cause);
                }
                times.on.min(times.off)
            }
            (None, true) => times.with(self.units(instruction, times)),
            (None, false) => times.off,
        };
        let has_fired = match fired.doubt {
            None => fired.value,
            Some(_) => self.program.scan_control.may_have_fired(at, fired.value),
        };
        self.charge(at, (has_fired, fired.doubt.is_some()), cost);
        self.change(instruction, condition, fired);
        if let Some(trace) = &mut self.state.trace {
            let reads = std::mem::take(&mut trace.current);
            trace.reads.push(reads);
        }
        if self.state.is_excluded {
            return self.stop(at, StopReason::Excluded);
        }
        let decides =
            matches!(instruction.step, Step::Jump { .. } | Step::Call { .. } | Step::Stop { .. });
        if let (true, Some(cause)) = (decides, fired.doubt) {
            return self.stop(at, StopReason::Unknown(cause));
        }
        match iterations {
            Some(Err(why)) => self.stop(at, why),
            Some(Ok(iterations)) => self.step(at, &instruction.step, fired, iterations),
            None => self.step(at, &instruction.step, fired, 0),
        }
    }

    /// In a real run: why it ends at this instruction, if an operation error stops the CPU there or may stop it. `None`
    /// in other runs.
    fn fails(&mut self, condition: Truth, executed: Truth) -> Option<StopReason> {
        if self.state.mode != Mode::Real {
            return None;
        }
        let error = self.program.errors.get(&self.state.at)?;
        let fails = self.state.logic(error, condition).and(executed);
        match fails {
            Truth { doubt: Some(cause), .. } => Some(StopReason::Unknown(cause)),
            Truth { value: true, .. } => Some(StopReason::Error),
            Truth { value: false, .. } => None,
        }
    }

    /// In a real run: whether the number in the words that count the instruction's units is known and outside the range
    /// that the user stated. If so, the user's statements exclude the scan.
    fn breaks_count(&mut self, instruction: &Instruction) -> bool {
        let stated = self.program.stated_counts.get(&self.state.at).copied();
        let (Some((low, high)), Some(counted), Mode::Real) =
            (stated, instruction.counted(), self.state.mode)
        else {
            return false;
        };
        let (count, doubt) = self.number_of_units(counted);
        doubt.is_none() && !(low..=high).contains(&i64::try_from(count).unwrap_or(i64::MAX))
    }

    /// In a real run: whether the index of an indexed write is known and outside the range that the user stated. False
    /// if the CPU may interpret the index in several ways.
    fn breaks_index(&mut self, instruction: &Instruction) -> bool {
        if self.state.mode != Mode::Real {
            return false;
        }
        let program = self.program;
        instruction.effects.iter().any(|effect| {
            let Write::Havoc(_, choice) = effect.write else { return false };
            let Some(indexed) = program.indexed.get(&choice) else { return false };
            let (Some((low, high)), [reading]) = (indexed.stated, &indexed.indices[..]) else {
                return false;
            };
            let outer = self.state.doubt.take();
            let words: Vec<u16> = reading.iter().map(|&word| self.state.word(word)).collect();
            let doubt = std::mem::replace(&mut self.state.doubt, outer);
            let index = match words[..] {
                [word] => i64::from(word.cast_signed()),
                [low, high] => i64::from((u32::from(high) << 16 | u32::from(low)).cast_signed()),
                _ => return false,
            };
            doubt.is_none() && !(low..=high).contains(&index)
        })
    }

    /// The number of units in the words that give it, and the instruction that makes it unknown, if it is unknown.
    fn number_of_units(&mut self, counted: &Counted) -> (u64, Doubt) {
        let outer = self.state.doubt.take();
        let number = counted.words.iter().rev();
        let count = number.fold(0, |count, &word| count << 16 | u64::from(self.state.word(word)));
        (count, std::mem::replace(&mut self.state.doubt, outer))
    }

    /// The number of units to charge: 0 if no words count them or the table has no time per unit. In the model, the
    /// largest number where the analysis did not read the words. In a real run, 0 if their number is unknown, or too
    /// large for the PLC to execute the instruction with certainty.
    fn units(&mut self, instruction: &Instruction, times: Times) -> u64 {
        let counted = instruction.counted().filter(|_| times.per_unit > Picos::ZERO);
        let Some(counted) = counted else { return 0 };
        if self.state.mode == Mode::Model
            && !Counted::is_read(self.state.frames())
            && !self.state.was_counted()
        {
            return counted.most_units();
        }
        let (count, doubt) = self.number_of_units(counted);
        if let Some(cause) = doubt {
            self.state.cases.depends_on(cause);
        }
        if self.state.mode == Mode::Real && (doubt.is_some() || count > counted.executes_up_to) {
            return 0;
        }
        count.min(counted.most).saturating_mul(counted.each)
    }

    /// Stops the real run at this instruction.
    fn stop(&mut self, at: usize, reason: StopReason) -> Next {
        if let StopReason::Unknown(cause) = reason {
            self.state.cases.depends_on(cause);
        }
        let frames = self.state.frames().clone();
        self.stopped.get_or_insert(Stopped { at, frames, reason });
        Next::Stop
    }

    /// The number of iterations that a loop makes, or why the run stops: the number is unknown, or excluded by the
    /// user's statements or by the loop's largest number.
    fn iterations(&mut self, step: &Step, count: WordSource) -> Result<u32, StopReason> {
        let (least, most) = match step {
            Step::ForBegin { least, most, .. } => (*least, *most),
            Step::Summary(summary) => {
                summary.iterations.map_or((0, u32::MAX), |(_, least, most)| (least, most))
            }
            _ => (0, u32::MAX),
        };
        let kind = match count {
            WordSource::Free(choice) => self.program.kinds.get(&choice).map(|kind| (choice, kind)),
            _ => None,
        };
        let (word, is_signed, doubtful) = match kind {
            Some((choice, ChoiceKind::Iterations(word))) => (*word, true, Some(choice)),
            Some((_, ChoiceKind::UnsignedIterations(word))) => (*word, false, None),
            _ => (count, true, None),
        };
        let number = |count: u16| match is_signed {
            true => u32::try_from(count.cast_signed()).unwrap_or(0),
            false => u32::from(count),
        };
        let limited = |count: u16| number(count).max(least).min(most);
        let outer = self.state.doubt.take();
        let value = self.state.word(word);
        let doubt: Doubt = std::mem::replace(&mut self.state.doubt, outer);
        match (doubtful, doubt) {
            (_, Some(cause)) => Err(StopReason::Unknown(cause)),
            // What the user stated about this count excludes the scan.
            (_, None)
                if self.state.mode == Mode::Real && !self.allows_iterations(value, is_signed) =>
            {
                Err(StopReason::Excluded)
            }
            (Some(_), None) if number(value) > most && self.state.mode == Mode::Real => {
                Err(StopReason::Excluded)
            }
            (None, None) => Ok(limited(value)),
            (Some(_), None) if number(value) >= 1 => Ok(limited(value)),
            (Some(choice), None) if self.state.mode == Mode::Model => {
                Ok(u32::from(self.state.choose_bit(choice)).max(least).min(most))
            }
            // It makes one iteration or none.
            (Some(_), None) => self
                .state
                .cases
                .makes_one()
                .map(u32::from)
                .ok_or(StopReason::Unknown(self.state.at)),
        }
    }

    /// Whether the range that the user stated for the current loop, if any, contains this count.
    fn allows_iterations(&self, count: u16, is_signed: bool) -> bool {
        let stated = self.program.stated_counts.get(&self.state.at);
        let count = if is_signed { count.cast_signed().into() } else { i64::from(count) };
        stated.is_none_or(|&(low, high)| (low..=high).contains(&count))
    }

    fn condition(&mut self, step: &Step) -> Truth {
        let routine = self.routine();
        let top = routine.stack.last().copied().unwrap_or(Truth::TRUE);
        if !step.depends_on_master_control() {
            return top;
        }
        routine.masters.last().map_or(top, |&(_, _, all)| top.and(all))
    }

    fn charge(&mut self, instruction: usize, (fired, is_uncertain): (bool, bool), cost: Picos) {
        self.total += cost;
        if self.sums {
            return;
        }
        let frames = self.state.frames().clone();
        self.events.push(Event { instruction, frames, fired, is_uncertain, cost });
    }

    fn change(&mut self, instruction: &Instruction, condition: Truth, fired: Truth) {
        let program = self.program;
        if self.executed.contains(&self.state.at) {
            return;
        }
        let timed = self.timed(instruction, condition);
        // The exact choices of this instruction that were executed, and whether each gave a result.
        let mut exact: Vec<(ChoiceId, bool)> = Vec::new();
        for effect in &instruction.effects {
            let fired = if effect.when == When::Always { Truth::TRUE } else { fired };
            if let Write::Havoc(_, choice) = &effect.write
                && let Some(ChoiceKind::Exact(meaning)) = program.kinds.get(choice)
            {
                if !fired.value && fired.doubt.is_none() {
                    continue;
                }
                let known = exact.iter().find(|(done, _)| done == choice).map(|(_, gave)| *gave);
                let gave = match known {
                    Some(gave) => gave,
                    None => {
                        let gave = match self.state.mode {
                            Mode::Model
                                if self.state.resolution(*choice) == Some(&Resolution::Exact) =>
                            {
                                self.state.write_exactly(*choice, meaning, fired)
                            }
                            Mode::Model => self.state.write_learned(*choice),
                            Mode::Real => self.state.write_exactly(*choice, meaning, fired),
                        };
                        exact.push((*choice, gave));
                        gave
                    }
                };
                if gave {
                    continue;
                }
            }
            self.state.write(&effect.write, condition, fired);
        }
        if let Some((flag, present)) = timed
            && let Some(timed) = program.timekeeping.instructions.get(&self.state.at)
        {
            self.state.write_bits(timed.flag, u16::MAX, u16::from(flag), None, Truth::TRUE);
            self.state.write_bits(timed.present, u16::MAX, present, None, Truth::TRUE);
            self.executed = timed.parts.clone();
        }
    }

    /// The flag and present value after a timer or counter was executed. `None` if time is not simulated, if the
    /// instruction is neither, or if something it reads is unknown.
    fn timed(&mut self, instruction: &Instruction, condition: Truth) -> Option<(bool, u16)> {
        if self.state.mode != Mode::Real || instruction.effects.is_empty() {
            return None;
        }
        let timed = self.program.timekeeping.instructions.get(&self.state.at)?;
        let slots = &self.routine().slots;
        let saved = |slot| slots.get(slot).copied().unwrap_or(Truth::TRUE);
        let inputs: Vec<Truth> = timed.inputs.iter().map(saved).collect();
        if condition.doubt.is_some() || inputs.iter().any(|input| input.doubt.is_some()) {
            self.state.free.lose_timed(timed);
            return None;
        }
        let inputs = inputs.iter().map(|input| input.value).collect();
        self.state.executed(timed, self.total, condition.value, inputs)
    }

    fn step(&mut self, at: usize, step: &Step, fired: Truth, iterations: u32) -> Next {
        match step {
            Step::Logic { join, .. } => self.join(*join, fired),
            Step::AndBlock => self.block(Truth::and),
            Step::OrBlock => self.block(Truth::or),
            Step::Save(slot) => {
                let routine = self.routine();
                let top = routine.stack.last().copied().unwrap_or(Truth::TRUE);
                routine.slots.insert(*slot, top);
            }
            Step::Fetch(slot) => {
                let saved = self.routine().slots.get(slot).copied().unwrap_or(Truth::TRUE);
                self.join(Join::Replace, saved);
            }
            Step::Jump { target, .. } if fired.value => return self.jump_to(*target),
            Step::Call { target, .. } if fired.value => {
                self.routines.push(Routine { back: at + 1, ..Routine::default() });
                self.state.enter(Frame { at, iteration: 0 });
                return Next::Go(*target);
            }
            Step::Return => return Next::Return,
            Step::End => return Next::End,
            Step::Unbounded { .. } => {
                self.unbounded = Some(at);
                return Next::Stop;
            }
            Step::Stop { .. } if fired.value => return Next::Stop,
            Step::ForBegin { end, .. } => {
                if iterations == 0 {
                    return Next::Go(end + 1);
                }
                self.begin_loop(at, *end, iterations);
            }
            Step::Summary(summary)
                if summary.iterations.is_some() && self.state.mode == Mode::Real =>
            {
                if iterations == 0 {
                    return Next::Go(summary.end + 1);
                }
                self.begin_loop(at, summary.end, iterations);
            }
            Step::Summary(_) if self.state.mode == Mode::Real => {
                return self.stop(at, StopReason::Unknown(at));
            }
            Step::ForEnd => return self.end_iteration(at),
            Step::Summary(summary) => {
                let Summary { end, charges, havocs, choice, exits, .. } = &**summary;
                return self.summary(*end, charges, havocs, *choice, exits);
            }
            Step::MasterControlBegin { level, .. } => {
                let masters = &mut self.routine().masters;
                let before = masters.last().map_or(Truth::TRUE, |master| master.2);
                masters.push((*level, fired, before.and(fired)));
            }
            Step::MasterControlEnd { level } => {
                let masters = &mut self.routine().masters;
                masters.retain(|(open, ..)| open < level);
                let mut all = Truth::TRUE;
                for master in masters {
                    all = all.and(master.1);
                    master.2 = all;
                }
            }
            Step::Act { .. }
            | Step::Jump { .. }
            | Step::Call { .. }
            | Step::Stop { .. }
            | Step::Nothing => {}
        }
        Next::Go(at + 1)
    }

    fn join(&mut self, join: Join, value: Truth) {
        let stack = &mut self.routine().stack;
        let top = match join {
            Join::Start => {
                stack.clear();
                value
            }
            Join::Load => value,
            Join::And => stack.pop().unwrap_or(Truth::TRUE).and(value),
            Join::Or => stack.pop().unwrap_or(Truth::TRUE).or(value),
            Join::Replace => {
                stack.pop();
                value
            }
        };
        stack.push(top);
    }

    fn block(&mut self, join: fn(Truth, Truth) -> Truth) {
        let stack = &mut self.routine().stack;
        let upper = stack.pop().unwrap_or(Truth::TRUE);
        let lower = stack.pop().unwrap_or(Truth::TRUE);
        stack.push(join(lower, upper));
    }

    /// Jumps within the same routine and leaves the loops that do not contain the target.
    fn jump_to(&mut self, target: usize) -> Next {
        let loops = &self.routine().loops;
        let open = loops.iter().take_while(|l| l.begin < target && target <= l.end).count();
        self.leave_loops(open);
        Next::Go(target)
    }

    fn begin_loop(&mut self, at: usize, end: usize, iterations: u32) {
        let begun = self.snapshot();
        let one = Loop { begin: at, end, iteration: 0, iterations, begun };
        self.routine().loops.push(one);
        self.state.enter(Frame { at, iteration: 0 });
    }

    /// The state now, to compare it with later iterations. `None` unless only the total time is wanted.
    fn snapshot(&mut self) -> Option<Snapshot> {
        if !self.sums {
            return None;
        }
        let (total, executed, changes) = (self.total, self.remaining, self.state.changes);
        let Routine { stack, slots, masters, .. } = self.routine();
        let (stack, slots, masters) = (stack.clone(), slots.clone(), masters.len());
        Some(Snapshot { total, executed, changes, stack, slots, masters })
    }

    /// If only the total time is wanted and an iteration changed nothing, the remaining ones are identical: charges
    /// them without executing them.
    fn skip_identical(&mut self) {
        let now = self.snapshot();
        let (total, remaining) = (self.total, self.remaining);
        let Some(current) = self.routine().loops.last_mut() else { return };
        let (Some(begun), Some(now)) = (current.begun.take(), now) else { return };
        let alike = begun.changes == now.changes
            && begun.masters == now.masters
            && begun.stack == now.stack
            && begun.slots == now.slots;
        let more = u64::from(current.iterations - current.iteration - 1);
        let each = Picos(total.0 - begun.total.0);
        let took = (begun.executed - remaining).saturating_mul(more);
        if alike && took < remaining {
            current.iteration = current.iterations - 1;
            self.total += each.times(more);
            self.remaining -= took;
        } else {
            current.begun = Some(now);
        }
    }

    fn end_iteration(&mut self, at: usize) -> Next {
        if self.routine().loops.last().is_none_or(|current| current.end != at) {
            return Next::Go(at + 1);
        }
        self.skip_identical();
        let Some(current) = self.routine().loops.last_mut() else { return Next::Go(at + 1) };
        current.iteration += 1;
        let (begin, iteration, iterations) = (current.begin, current.iteration, current.iterations);
        if iteration == iterations {
            let open = self.routine().loops.len() - 1;
            self.leave_loops(open);
            return Next::Go(at + 1);
        }
        self.state.leave();
        self.state.enter(Frame { at: begin, iteration });
        Next::Go(begin + 1)
    }

    /// Charges a loop or routine that is not followed, havocs what it may write, and returns where control continues.
    fn summary(
        &mut self,
        end: usize,
        charges: &[(usize, u64)],
        havocs: &[Region],
        choice: ChoiceId,
        exits: &[(ChoiceId, Exit)],
    ) -> Next {
        for &(instruction, repetitions) in charges {
            let times = self.times[instruction];
            let most = self.program.instructions[instruction].counted();
            let on = times.with(most.map_or(0, Counted::most_units));
            let is_on = on >= times.off;
            self.charge(instruction, (is_on, false), on.max(times.off).times(repetitions));
        }
        for &region in havocs {
            self.state.havoc(region, choice, Truth::TRUE);
        }
        let routine = self.routine();
        routine.stack.clear();
        routine.slots.clear();
        match exits.iter().find(|(exit, _)| self.state.choose_bit(*exit)) {
            None => self.jump_to(end + 1),
            Some((_, Exit::To(target))) => self.jump_to(*target),
            Some((_, Exit::Return)) => Next::Return,
            Some((_, Exit::End)) => Next::End,
            Some((_, Exit::Stop)) => Next::Stop,
            Some((_, Exit::Unbounded(at))) => {
                self.unbounded = Some(*at);
                Next::Stop
            }
        }
    }
}
