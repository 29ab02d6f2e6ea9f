//! Executes one scan symbolically: each instruction is executed once for all scans, with guards for its charges.
//!
//! It implements the semantics in the documentation of `scanbound_ir` exactly. Control is a literal: an instruction
//! that is not reached writes nothing and costs nothing, so one memory serves all paths.

mod answer;
mod charge;
#[cfg(test)]
mod choice_tests;
mod choices;
mod derived;
mod expression;
mod implied;
mod intervals;
mod known;
mod loops;
mod memory;
mod number;
mod operation;
mod resolution;
mod run;
mod settings;
pub mod size_limits;
mod term;
mod unknown_writes;
mod violation_log;
pub mod violations;
mod word;

pub use settings::{Purpose, ScanError, SizeLimits};

use known::KnownChoices;
use memory::Memory;
use run::{Activation, ForLoop, OpenRegion, PendingJump, Run, RungResults};
use scanbound_base::time::Times;
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{
    BitTarget, Cell, Effect, Frame, Join, Logic, Program, Source, Step, When, WordSource, Write,
};
use scanbound_model::{Lit, ScanModel, Unbounded};
use settings::ScanSettings;
use std::collections::{BTreeMap, BTreeSet};
use violation_log::ViolationLog;
use word::Word;

/// The largest number of instruction executions in the symbolic execution of one scan. Each call and each iteration of
/// a loop counts again.
const MAX_EXECUTED: usize = 10_000_000;

/// Executes one scan of the program symbolically, into a model for upper bounds ([`Purpose::UpperBound`]), without size
/// limits and without results of real runs ([`Knowledge`]). `times` has one entry for each instruction.
///
/// # Errors
/// If there are too many executions, a time overflows, or the program is not well formed.
pub fn scan_model(program: &Program, times: &[Times]) -> Result<ScanModel, ScanError> {
    scan_model_within(program, times, &SizeLimits::default())
}

/// Like [`scan_model`], within size limits.
///
/// # Errors
/// If the model exceeds the limits or `is_over` stops it, there are too many executions, a time overflows, or the
/// program is not well formed.
pub fn scan_model_within(
    program: &Program,
    times: &[Times],
    limits: &SizeLimits<'_>,
) -> Result<ScanModel, ScanError> {
    scan_model_with_knowledge(program, times, &Knowledge::new(), Purpose::UpperBound, limits)
}

/// Like [`scan_model_within`], for either purpose, and with the results of operations that real runs showed. Where the
/// values that an observation names are read again in the same call context, the choice has the observed result.
///
/// # Errors
/// As for [`scan_model_within`].
pub fn scan_model_with_knowledge(
    program: &Program,
    times: &[Times],
    knowledge: &Knowledge,
    purpose: Purpose,
    limits: &SizeLimits<'_>,
) -> Result<ScanModel, ScanError> {
    let settings = ScanSettings { times, knowledge, purpose, limits };
    Ok(run(program, settings, None, |_| ())?.0)
}

/// The model for upper bounds, without results of real runs, and for each of `bits` the literal that says whether it is
/// on at the end of the scan, after the interrupts.
///
/// # Errors
/// As for [`scan_model_within`].
pub fn scan_model_to_end(
    program: &Program,
    times: &[Times],
    limits: &SizeLimits<'_>,
    bits: &[BitTarget],
) -> Result<(ScanModel, Vec<Lit>), ScanError> {
    let ends = |memory: &mut Memory<'_>| bits.iter().map(|&bit| is_on(memory, bit)).collect();
    run(program, ScanSettings::of_upper_bounds(times, limits), None, ends)
}

/// As [`scan_model_with_knowledge`], for lower bounds. Also returns for each bit that `bits` selects, given the model
/// of the scan, the literal that says whether it is on at the end of the scan, after the interrupts.
///
/// # Errors
/// As for [`scan_model_within`].
pub fn lower_bound_scan_to_end(
    program: &Program,
    times: &[Times],
    knowledge: &Knowledge,
    limits: &SizeLimits<'_>,
    bits: impl FnOnce(&ScanModel) -> Vec<BitTarget>,
) -> Result<(ScanModel, Vec<Lit>), ScanError> {
    let ends = |memory: &mut Memory<'_>| {
        bits(&memory.model).into_iter().map(|bit| is_on(memory, bit)).collect()
    };
    let settings = ScanSettings { times, knowledge, purpose: Purpose::LowerBound, limits };
    run(program, settings, None, ends)
}

/// The literal that says whether a bit is on at this point of the scan.
fn is_on(memory: &mut Memory<'_>, bit: BitTarget) -> Lit {
    match bit {
        BitTarget::Cell(cell) => memory.read_bit(cell),
        BitTarget::WordBit(cell, bit) => {
            let word = memory.read_word(cell);
            memory.words.bits(&mut memory.model.circuit, word)[usize::from(bit)]
        }
    }
}

/// Builds the model: the constraints on the start, then the main programs, then the interrupts. Also returns the result
/// of `end`, which is called on the memory at the end of the scan. `watch` records violations, if given.
fn run<T>(
    program: &Program,
    settings: ScanSettings<'_>,
    watch: Option<Box<ViolationLog>>,
    end: impl FnOnce(&mut Memory<'_>) -> T,
) -> Result<(ScanModel, T), ScanError> {
    let ScanSettings { times, knowledge, purpose, limits } = settings;
    let mut run = Run {
        program,
        times,
        knowledge,
        purpose,
        known: KnownChoices::default(),
        memory: Memory::new(program, word_choices(program)),
        frames: Vec::new(),
        stopped: Lit::FALSE,
        executed: 0,
        limits,
        costly: BTreeSet::new(),
    };
    run.memory.watch = watch;
    for range in &program.stated_ranges {
        run.constrain(&range.cells, range.low, range.high);
        run.constrain_to(&range.cells, &range.values);
    }
    let readings = match purpose {
        Purpose::LowerBound => &program.power_up.certain_invariants[..],
        Purpose::UpperBound => &[],
    };
    for invariant in program.invariants.iter().chain(readings) {
        let holds = run.logic(invariant, Lit::TRUE, 0);
        if holds != Lit::TRUE {
            run.memory.model.constraints.push(holds);
        }
    }
    let model = &run.memory.model;
    run.known.start(&model.circuit, &run.memory.words, &model.constraints);
    for main in &program.mains {
        let alive = !run.stopped;
        run.routine(main.start, main.end, alive)?;
    }
    for interrupt in &program.interrupts {
        for iteration in 0..interrupt.times {
            run.frames.push(Frame { at: interrupt.entry, iteration });
            run.routine(interrupt.entry, program.instructions.len(), Lit::TRUE)?;
            run.frames.pop();
        }
    }
    let found = end(&mut run.memory);
    // If no query was given up, the model is complete, however costly single instructions were.
    if run.memory.words.given_up == 0 {
        return Ok((run.memory.model, found));
    }
    let instruction = run.costly.first().copied().unwrap_or(0);
    Err(ScanError::TooLarge { instruction, costly: run.costly })
}

/// For each choice, whether an instruction, an operation or the condition of an operation error reads it as a word. All
/// others are single bits.
fn word_choices(program: &Program) -> Vec<bool> {
    let mut words = vec![false; program.choices as usize];
    for kind in program.kinds.values() {
        kind.each_word(&mut |source| {
            if let WordSource::Free(choice) = source {
                words[choice.0 as usize] = true;
            }
        });
    }
    let mut see = |source| {
        if let Source::Word(WordSource::Free(choice)) = source {
            words[choice.0 as usize] = true;
        }
    };
    program.instructions.iter().for_each(|instruction| instruction.each_read(&mut see));
    program.errors.values().for_each(|error| error.each_read(&mut see));
    words
}

impl Run<'_> {
    /// Executes a routine from `from` (inclusive) to `to` (exclusive) at most; `active` says whether it is entered.
    /// Returns the literal that says whether control returns from it, by a `Return` or at `to`.
    fn routine(&mut self, from: usize, to: usize, active: Lit) -> Result<Lit, ScanError> {
        let mut act = Activation {
            active,
            results: RungResults { stack: Some(Vec::new()), ..RungResults::default() },
            open_regions: Vec::new(),
            pending_jumps: BTreeMap::new(),
            returned: Lit::FALSE,
        };
        self.span(&mut act, from, to)?;
        Ok(self.memory.circuit().or(act.returned, act.active))
    }

    /// Executes the instructions from `from` (inclusive) to `to` (exclusive).
    fn span(&mut self, act: &mut Activation, from: usize, to: usize) -> Result<(), ScanError> {
        let mut at = from;
        while at < to {
            if let Some(pending) = act.pending_jumps.remove(&at) {
                self.merge_jump(act, pending);
            }
            if act.active == Lit::FALSE {
                // No path reaches the instructions before the next jump target.
                match act.pending_jumps.range(at..to).next() {
                    Some((&next, _)) => at = next,
                    None => return Ok(()),
                }
                continue;
            }
            let before = self.size();
            self.memory.words.allowance = self.limits.per_execution;
            let next = self.instruction(act, at)?;
            self.check_size(at, before)?;
            at = next;
        }
        Ok(())
    }

    /// Merges the state of a jump whose target is the next instruction with the state of the instructions before it.
    fn merge_jump(&mut self, act: &mut Activation, pending: PendingJump) {
        let here = PendingJump { taken: act.active, results: std::mem::take(&mut act.results) };
        let PendingJump { taken, results } = self.meet(here, pending);
        (act.active, act.results) = (taken, results);
    }

    /// Merges the states of two paths to one instruction, of which at most one is taken in a scan. The stack becomes
    /// unknown if its depths differ.
    fn meet(&mut self, here: PendingJump, there: PendingJump) -> PendingJump {
        if here.taken == Lit::FALSE {
            return there;
        }
        let circuit = self.memory.circuit();
        let PendingJump { taken, results } = there;
        let mut met = here;
        met.results.stack = match (met.results.stack, results.stack) {
            (Some(here), Some(there)) if here.len() == there.len() => {
                Some(here.iter().zip(&there).map(|(&h, &t)| circuit.ite(taken, t, h)).collect())
            }
            _ => None,
        };
        // A slot that only one path has saved must not be read.
        met.results.slots.retain(|slot, _| results.slots.contains_key(slot));
        for (slot, here) in &mut met.results.slots {
            *here = circuit.ite(taken, results.slots[slot], *here);
        }
        met.taken = circuit.or(met.taken, taken);
        met
    }

    /// The size of the model so far: circuit nodes and steps of queries on words, as [`SizeLimits`] defines it.
    fn size(&self) -> usize {
        self.memory.model.circuit.nodes().len() + self.memory.words.spent
    }

    /// Returns an error if the whole model is too large or the caller stops the execution. If only instruction `at`
    /// added too much, it is recorded as costly. `before` is the size before the instruction. Calls and loops are not
    /// costly themselves, because what they execute is checked by itself.
    fn check_size(&mut self, at: usize, before: usize) -> Result<(), ScanError> {
        /// `is_over` is called once in this many instructions.
        const EVERY: usize = 256;
        let size = self.size();
        let runs_others =
            matches!(self.program.instructions[at].step, Step::ForBegin { .. } | Step::Call { .. });
        if size - before > self.limits.per_execution && !runs_others {
            self.costly.insert(at);
        }
        if size > self.limits.in_all {
            let costly = std::mem::take(&mut self.costly);
            return Err(ScanError::TooLarge { instruction: at, costly });
        }
        if self.executed.is_multiple_of(EVERY) && (self.limits.is_over)() {
            return Err(ScanError::Stopped { instruction: at });
        }
        Ok(())
    }

    /// Executes one instruction with its charge and effects. Returns the index of the next one (after the end of a loop
    /// or summary, if it begins one).
    fn instruction(&mut self, act: &mut Activation, at: usize) -> Result<usize, ScanError> {
        self.executed += 1;
        if self.executed > MAX_EXECUTED {
            return Err(ScanError::TooManyExecutions { most: MAX_EXECUTED, instruction: at });
        }
        let program = self.program;
        let instruction = &program.instructions[at];
        let top = match &act.results.stack {
            Some(stack) => stack.last().copied().unwrap_or(Lit::TRUE),
            // The result is unknown, but instructions between rungs do not need it.
            None if needs_no_result(&instruction.step) => Lit::TRUE,
            None => return Err(ScanError::NoResult { instruction: at }),
        };
        let condition = if instruction.step.depends_on_master_control() {
            let open_regions = act.open_regions.last().map_or(Lit::TRUE, |master| master.all);
            self.memory.circuit().and(top, open_regions)
        } else {
            top
        };
        self.known.begin(condition);
        self.known.reach(act.active);
        let fires =
            instruction.step.fires().map_or(Lit::TRUE, |fires| self.logic(fires, condition, at));
        let fired = self.memory.circuit().and(act.active, fires);
        self.known.reach(fired);
        let executed =
            if matches!(instruction.step, Step::Logic { .. }) { act.active } else { fired };
        self.fail(at, executed, condition);
        self.charge(at, act.active, fired);
        for effect in &instruction.effects {
            self.effect(effect, act.active, fired, condition, at);
        }
        self.known.reach(act.active);
        self.step(act, at, &instruction.step, fires, fired)
    }

    /// Records, for lower bounds only, under which condition an operation error may end the scan at this instruction.
    fn fail(&mut self, at: usize, executed: Lit, condition: Lit) {
        if self.purpose == Purpose::LowerBound
            && let Some(error) = self.program.errors.get(&at)
        {
            let error = self.logic(error, condition, at);
            let error = self.memory.circuit().and(executed, error);
            if error != Lit::FALSE {
                self.memory.model.errors.push(error);
            }
        }
    }

    /// Executes one effect of the instruction `at`. It happens under `active` (the instruction is reached) or `fired`
    /// (it also fires); `condition` is the value of [`Logic::Condition`].
    fn effect(&mut self, effect: &Effect, active: Lit, fired: Lit, condition: Lit, at: usize) {
        let guard = match effect.when {
            When::Always => active,
            When::Fired => fired,
        };
        self.known.reach(guard);
        match &effect.write {
            Write::Bit(target, value) => {
                let value = self.logic(value, condition, at);
                self.memory.write_bit(*target, guard, value);
            }
            Write::Words(targets, number) => {
                let words = self.number(number, at);
                for (&target, &word) in targets.iter().zip(&words) {
                    self.memory.write_word(target, guard, word);
                }
            }
            Write::Havoc(region, choice) => {
                let guard = self.write_observed(*choice, guard, at);
                if guard != Lit::FALSE {
                    self.note_unknown_write(*choice, *region, at);
                    self.check_reach(guard, *choice, at);
                    for region in self.reached(*choice, *region, at) {
                        self.memory.havoc(region, guard, &self.frames, *choice);
                    }
                }
            }
        }
    }

    /// Executes what the instruction does besides its writes. Returns the index of the next instruction.
    fn step(
        &mut self,
        act: &mut Activation,
        at: usize,
        step: &Step,
        fires: Lit,
        fired: Lit,
    ) -> Result<usize, ScanError> {
        let next = at + 1;
        match step {
            Step::Act { .. } | Step::Nothing => {}
            Step::Logic { join, .. } => self.join(&mut act.results, *join, fires, at)?,
            Step::AndBlock | Step::OrBlock => {
                let stack = act.results.stack.as_mut().filter(|stack| stack.len() >= 2);
                let stack = stack.ok_or(ScanError::NoResult { instruction: at })?;
                let (b, a) = (stack.pop().unwrap_or(Lit::TRUE), stack.pop().unwrap_or(Lit::TRUE));
                let circuit = self.memory.circuit();
                stack.push(if *step == Step::AndBlock {
                    circuit.and(a, b)
                } else {
                    circuit.or(a, b)
                });
            }
            Step::Save(slot) => {
                let top = act
                    .results
                    .stack
                    .as_ref()
                    .and_then(|stack| stack.last().copied())
                    .unwrap_or(Lit::TRUE);
                act.results.slots.insert(*slot, top);
            }
            Step::Fetch(slot) => {
                let saved =
                    *act.results.slots.get(slot).ok_or(ScanError::NoResult { instruction: at })?;
                self.join(&mut act.results, Join::Replace, saved, at)?;
            }
            Step::Jump { target, .. } => self.jump(act, *target, fires, fired),
            Step::Call { target, .. } => {
                self.frames.push(Frame { at, iteration: 0 });
                let back = self.routine(*target, self.program.instructions.len(), fired)?;
                self.frames.pop();
                let circuit = self.memory.circuit();
                let passed = circuit.and(act.active, !fires);
                act.active = circuit.or(passed, back);
            }
            Step::Return => {
                act.returned = self.memory.circuit().or(act.returned, act.active);
                act.active = Lit::FALSE;
            }
            Step::End => act.active = Lit::FALSE,
            Step::Stop { .. } => {
                let circuit = self.memory.circuit();
                act.active = circuit.and(act.active, !fires);
                self.stopped = circuit.or(self.stopped, fired);
            }
            Step::Unbounded { .. } => {
                let (frames, reached) = (self.frames.clone(), act.active);
                self.memory.model.unbounded.push(Unbounded { instruction: at, frames, reached });
                self.stopped = self.memory.circuit().or(self.stopped, reached);
                act.active = Lit::FALSE;
            }
            Step::ForBegin { count, least, most, end } => {
                let (count, least, most, end) = (*count, *least, *most, *end);
                return self.for_loop(act, ForLoop { at, count, least, most, end });
            }
            Step::ForEnd => {}
            Step::Summary(summary) => return self.summary(act, at, summary),
            Step::MasterControlBegin { level, .. } => {
                self.open_region(&mut act.open_regions, *level, fires)
            }
            Step::MasterControlEnd { level } => self.close_regions(&mut act.open_regions, *level),
        }
        Ok(next)
    }

    /// Opens a master control region with this condition, inside the regions that are open.
    fn open_region(&mut self, open_regions: &mut Vec<OpenRegion>, level: u32, condition: Lit) {
        let (all, highest) =
            open_regions.last().map_or((Lit::TRUE, 0), |master| (master.all, master.highest));
        let all = self.memory.circuit().and(all, condition);
        open_regions.push(OpenRegion { level, condition, all, highest: highest.max(level) });
    }

    /// Closes all master control regions of this level or higher.
    fn close_regions(&mut self, open_regions: &mut Vec<OpenRegion>, level: u32) {
        while open_regions.last().is_some_and(|master| master.level >= level) {
            open_regions.pop();
        }
        // Rare case: a region of a higher level was opened before one of a lower level.
        if open_regions.last().is_some_and(|master| master.highest >= level) {
            for master in
                std::mem::take(open_regions).into_iter().filter(|master| master.level < level)
            {
                self.open_region(open_regions, master.level, master.condition);
            }
        }
    }

    /// Combines the value of a contact with the rung's stack of results. An error if the stack is unknown, except at
    /// the start of a rung.
    fn join(
        &mut self,
        results: &mut RungResults,
        join: Join,
        value: Lit,
        at: usize,
    ) -> Result<(), ScanError> {
        if join == Join::Start {
            results.stack = Some(vec![value]);
            return Ok(());
        }
        let stack = results.stack.as_mut().ok_or(ScanError::NoResult { instruction: at })?;
        let circuit = self.memory.circuit();
        let value = match join {
            Join::Start | Join::Load => value,
            Join::Replace => {
                stack.pop();
                value
            }
            Join::And | Join::Or => {
                let top = stack.pop().unwrap_or(Lit::TRUE);
                if join == Join::And { circuit.and(top, value) } else { circuit.or(top, value) }
            }
        };
        stack.push(value);
        Ok(())
    }

    /// Jumps to the later instruction `target` where control is here and `fires` is true; `fired` is both together. The
    /// state waits as a pending jump until the target is reached.
    fn jump(&mut self, act: &mut Activation, target: usize, fires: Lit, fired: Lit) {
        let circuit = self.memory.circuit();
        act.active = circuit.and(act.active, !fires);
        if fired == Lit::FALSE {
            return;
        }
        let mut pending = PendingJump { taken: fired, results: act.results.clone() };
        if let Some(earlier) = act.pending_jumps.remove(&target) {
            pending = self.meet(earlier, pending);
        }
        act.pending_jumps.insert(target, pending);
    }

    /// Adds the constraint that the signed number in these words at the start of the scan, low word first, is in
    /// `low..=high`.
    fn constrain(&mut self, cells: &[Cell], low: i64, high: i64) {
        let value: Vec<Word> = cells.iter().map(|&cell| self.memory.read_word(cell)).collect();
        let within = self.within(&value, true, low, high);
        self.exclude_unless(Lit::TRUE, within);
    }

    /// Adds the constraint that the start value of a word is in the list `values`. No constraint if the list is empty,
    /// or if there is not exactly one cell.
    fn constrain_to(&mut self, cells: &[Cell], values: &[u16]) {
        let ([cell], false) = (cells, values.is_empty()) else { return };
        let word = self.memory.read_word(*cell);
        let Memory { words, model, .. } = &mut self.memory;
        let mut is_one = Lit::FALSE;
        for &value in values {
            let one = words.in_range(&mut model.circuit, word, value, value);
            is_one = model.circuit.or(is_one, one);
        }
        self.exclude_unless(Lit::TRUE, is_one);
    }

    /// The literal that says whether the number in these words, low word first, lies in `low..=high`.
    fn within(&mut self, value: &[Word], signed: bool, low: i64, high: i64) -> Lit {
        let Memory { words, model, .. } = &mut self.memory;
        number::within(words, &mut model.circuit, value, signed, low, high)
    }

    /// Excludes all scans in which `reached` is true and `holds` is false.
    fn exclude_unless(&mut self, reached: Lit, holds: Lit) {
        let holds = self.memory.circuit().or(!reached, holds);
        if holds != Lit::TRUE {
            self.memory.model.constraints.push(holds);
        }
    }
}

/// Whether the step needs no result of a rung: it starts a rung, its `fires` does not mention [`Logic::Condition`], or
/// it has no `fires` and does not use the stack. Such a step may follow paths whose stacks differ.
fn needs_no_result(step: &Step) -> bool {
    match step {
        Step::Logic { join, .. } => *join == Join::Start,
        Step::Act { fires }
        | Step::Jump { fires, .. }
        | Step::Call { fires, .. }
        | Step::Stop { fires }
        | Step::MasterControlBegin { fires, .. } => !mentions_condition(fires),
        Step::AndBlock | Step::OrBlock | Step::Save(_) | Step::Fetch(_) => false,
        _ => true,
    }
}

fn mentions_condition(logic: &Logic) -> bool {
    match logic {
        Logic::Condition => true,
        Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => false,
        Logic::Not(inner) => mentions_condition(inner),
        Logic::All(parts) | Logic::Any(parts) => parts.iter().any(mentions_condition),
    }
}
