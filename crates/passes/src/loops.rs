//! Loop summaries: charges loops and routines as often as they can run, at the larger of their times, without following
//! them.
//!
//! Nested loops and calls multiply, so the number of executions in a scan is computed before the scan is followed. If
//! it exceeds the limit, the innermost loops and routines that are too large are summarised.

use super::pass::Pass;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_ir::flow::{self, written};
use scanbound_ir::{
    Approximated, BitSource, ChoiceId, Exit, Instruction, Logic, Program, Region, Step, Summary,
    SummaryReason, WordSource,
};
use std::collections::{BTreeMap, BTreeSet};

/// If a summary writes more ranges of an area than this, it havocs the whole area.
const MAX_RANGES: usize = 256;

/// A loop that unrolls to more executed instructions than this is summarised.
const MAX_UNROLLED: u64 = 200_000;

/// The smallest limit that is tried: if a scan is still too long after all loops and routines with more executions were
/// summarised, the whole program is summarised.
const SMALLEST: u64 = 64;

/// The largest number of charges of all loops and routines that are not followed. Beyond it, nothing of the program is
/// followed.
const MAX_CHARGES: usize = 4_000_000;

/// The error that calls and loops execute an instruction more often than can be counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CountOverflow {
    /// The instruction whose number of executions overflows.
    pub instruction: usize,
}

/// Summarises loops whose number of iterations is unknown, and loops that are too large to follow iteration by
/// iteration.
pub const PASS: Pass = Pass { name: "summarising loops", run: |program, _| summarise(program) };

/// Summarises loops whose number of iterations is unknown, then those that unroll to more than [`MAX_UNROLLED`]
/// instructions. Outer loops come first, because their summaries include the loops within them. A loop whose number of
/// executions overflows is an error.
fn summarise(program: &mut Program) -> Result<(), Vec<Diagnostic>> {
    let mut faults = Vec::new();
    let (unknown, known): (Vec<_>, Vec<_>) = flow::loops(program)
        .into_iter()
        .partition(|(begin, _)| program.loops_without_count.contains(begin));
    // First and last instruction of each summarised loop; for nested loops only the outer one.
    let mut taken: BTreeMap<usize, usize> = BTreeMap::new();
    let (mut behind, unknowns) = (0, unknown.len());
    for (place, (begin, end)) in unknown.into_iter().chain(known).enumerate() {
        let unknown = place < unknowns;
        if place == unknowns {
            behind = 0;
        }
        let outer = taken.range(..begin).next_back();
        if begin < behind || outer.is_some_and(|(_, &end)| begin < end) {
            continue;
        }
        let Step::ForBegin { most, .. } = program.instructions[begin].step else { continue };
        let size = flow::unrolled(program, begin + 1, end).saturating_mul(u64::from(most));
        if !unknown && size <= MAX_UNROLLED {
            continue;
        }
        behind = end;
        if unknown {
            taken.insert(begin, end);
        }
        let Some(step) = of_loop(program, begin, end, u64::from(most)) else {
            let message =
                "nested loops and calls execute the instructions of this loop too often to count";
            let help =
                "state in a facts file ([counts]) how many iterations the loops around it have";
            faults.push(program.fault(&program.instructions[begin], Code::Loop, message, help));
            continue;
        };
        program.instructions[begin].step = step;
        program.approximate(begin, Approximated::LoopSummary(most));
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The summary step of the loop from `begin` to `end`: everything in it is charged `iterations` times, and as often as
/// nested loops and calls multiply that. `None` if the number of executions overflows.
fn of_loop(program: &mut Program, begin: usize, end: usize, iterations: u64) -> Option<Step> {
    let gathered = RoutineGraph::of(program).gather(program, begin + 1, end, iterations).ok()?;
    let iterations = iterations_of(program, begin);
    Some(gathered.step(program, end, iterations))
}

/// Summarises loops, routines and interrupt routines so that a scan executes at most `most` instructions more than the
/// program has; if that is not possible, the whole program. Returns the largest number of instructions that a scan then
/// executes. Every summary is recorded as over-approximation.
///
/// # Errors
/// If the number of executions of an instruction overflows.
pub fn fit(program: &mut Program, most: u64) -> Result<u64, CountOverflow> {
    let shape = RoutineGraph::of(program);
    let most = most.saturating_add(program.instructions.len() as u64);
    let mut limit = most;
    loop {
        let plan = shape.plan(program, limit);
        if plan.total <= most {
            if !plan.is_empty() {
                shape.carry_out(program, &plan)?;
            }
            return Ok(plan.total);
        }
        limit /= 8;
        if limit < SMALLEST {
            summarise_all(program, SummaryReason::TooManyInstructions)?;
            return Ok(program.instructions.len() as u64);
        }
    }
}

/// A copy of the program that follows again those summarised loops whose counts turned out to be smaller than what was
/// charged. `iterations` gives the largest number of iterations of each loop, by the index of its begin. `None` if
/// there are no such loops.
///
/// A loop that also runs within another summary, such as a routine that is called there, stays summarised, because its
/// iterations there were not analysed.
pub fn restore(program: &Program, iterations: &BTreeMap<usize, u32>) -> Option<Program> {
    let summaries = program.instructions.iter().filter_map(|one| match &one.step {
        Step::Summary(summary) => Some(summary),
        _ => None,
    });
    let unfollowed: BTreeSet<usize> =
        summaries.flat_map(|summary| summary.charges.iter().map(|&(at, _)| at)).collect();
    let mut closer: Option<Program> = None;
    for (&begin, &known) in iterations.iter().filter(|(begin, _)| !unfollowed.contains(begin)) {
        let Step::Summary(summary) = &program.instructions[begin].step else { continue };
        let (end, Some((count, least, most))) = (summary.end, summary.iterations) else { continue };
        if known < most {
            let closer = closer.get_or_insert_with(|| program.clone());
            closer.instructions[begin].step = Step::ForBegin { count, least, most: known, end };
            closer
                .approximations
                .retain(|one| one.instruction != begin || !one.what.is_loop_summary());
        }
    }
    closer
}

/// Lowers the largest number of iterations of loops to what was found over all paths to them (by the index of the
/// loop's begin). Summarised loops are followed again if their number was lowered; the others are summarised anew.
/// Changes nothing if no number becomes smaller.
pub fn lower(program: &mut Program, iterations: &BTreeMap<usize, i64>) {
    let lowered = |at: usize, most: u32| {
        let known = u32::try_from(*iterations.get(&at)?).ok()?;
        (known < most).then_some(known)
    };
    let is_lowered = |(at, one): (usize, &Instruction)| match &one.step {
        Step::ForBegin { most, .. } => lowered(at, *most).is_some(),
        Step::Summary(summary) => {
            summary.iterations.is_some_and(|(.., most)| lowered(at, most).is_some())
        }
        _ => false,
    };
    if !program.instructions.iter().enumerate().any(is_lowered) {
        return;
    }
    let mut unknown: Vec<(usize, usize, u32)> = Vec::new();
    for at in 0..program.instructions.len() {
        match &mut program.instructions[at].step {
            Step::ForBegin { least, most, .. } => {
                *most = lowered(at, *most).map_or(*most, |known| known.max(*least));
            }
            Step::Summary(summary) => {
                let (end, Some((count, least, most))) = (summary.end, summary.iterations) else {
                    continue;
                };
                let known = lowered(at, most).map(|known| known.max(least));
                if known.is_none() {
                    unknown.push((at, end, most));
                }
                let most = known.unwrap_or(most);
                program.instructions[at].step = Step::ForBegin { count, least, most, end };
            }
            _ => {}
        }
    }
    let mut behind = 0;
    program.approximations.retain(|one| !matches!(one.what, Approximated::LoopSummary(_)));
    for (begin, end, most) in unknown {
        // A loop within a summarised loop is part of its summary.
        if begin < behind {
            continue;
        }
        behind = end;
        let Some(step) = of_loop(program, begin, end, u64::from(most)) else { continue };
        program.instructions[begin].step = step;
        program.approximate(begin, Approximated::LoopSummary(most));
    }
}

/// Removes the unbounded loops that no scan reaches.
pub fn without_unreached(program: &mut Program, unreached: &BTreeSet<usize>) {
    for (at, instruction) in program.instructions.iter_mut().enumerate() {
        match &mut instruction.step {
            step @ Step::Unbounded { .. } if unreached.contains(&at) => *step = Step::Nothing,
            Step::Summary(summary) => summary.exits.retain(|(_, exit)| match exit {
                Exit::Unbounded(at) => !unreached.contains(at),
                _ => true,
            }),
            _ => {}
        }
    }
}

/// Summarises each main program and interrupt routine as a whole: the sum of everything that can run, each at the
/// larger of its times, without examining what excludes what.
///
/// # Errors
/// If the number of executions of an instruction overflows.
pub fn summarise_all(program: &mut Program, why: SummaryReason) -> Result<(), CountOverflow> {
    let shape = RoutineGraph::of(program);
    for index in 0..program.mains.len() {
        let main = program.mains[index].clone();
        let Some(last) = main.end.checked_sub(1).filter(|&last| last >= main.start) else {
            continue;
        };
        let mut gathered = shape.gather(program, main.start, last, 1)?;
        // All its exits lead to the end of the routine, which comes next.
        gathered.own.clear();
        // The summary may be skipped as a whole, so that none of its charges counts as certain.
        let at = program.instructions.len();
        program.choices += 1;
        let runs = Logic::Bit(BitSource::Free(ChoiceId(program.choices - 1)));
        let past = Step::Jump { fires: runs.not(), target: at + 2 };
        append(program, main.start, past);
        stub(program, gathered, main.start, Step::End);
        program.mains[index] = at..program.instructions.len();
        program.approximate(main.start, Approximated::WholeSummary(why));
    }
    for index in 0..program.interrupts.len() {
        shape.interrupt(program, index)?;
    }
    Ok(())
}

/// Which loops, routines (by their first instruction) and interrupts (by index) are to be summarised.
#[derive(Default)]
struct SummaryPlan {
    loops: BTreeSet<usize>,
    routines: BTreeSet<usize>,
    interrupts: BTreeSet<usize>,
    /// The largest number of instructions that a scan executes after summarising.
    total: u64,
}

impl SummaryPlan {
    fn is_empty(&self) -> bool {
        self.loops.is_empty() && self.routines.is_empty() && self.interrupts.is_empty()
    }
}

/// The routines of a program and their calls.
struct RoutineGraph {
    /// For each called routine, by its first instruction: its last instruction.
    ends: BTreeMap<usize, usize>,
    /// The routines; callers come before the routines that they call.
    order: Vec<usize>,
    /// The position of each routine in `order`.
    place: BTreeMap<usize, usize>,
}

impl RoutineGraph {
    fn of(program: &Program) -> RoutineGraph {
        let calls = flow::calls(program);
        let entries: BTreeSet<usize> = calls.iter().map(|&(_, target)| target).collect();
        let last = program.instructions.len().saturating_sub(1);
        let ends: BTreeMap<usize, usize> = entries
            .into_iter()
            .map(|entry| (entry, flow::routine_end(program, entry).unwrap_or(last)))
            .collect();
        let inside = |entry: usize, end: usize| {
            let from = calls.partition_point(|&(at, _)| at < entry);
            let to = calls.partition_point(|&(at, _)| at <= end);
            calls[from..to].iter().map(|&(_, target)| target).collect::<BTreeSet<usize>>()
        };
        let mut graph = petgraph::graphmap::DiGraphMap::<usize, ()>::new();
        for (&entry, &end) in &ends {
            graph.add_node(entry);
            for target in inside(entry, end) {
                graph.add_edge(entry, target, ());
            }
        }
        let order = petgraph::algo::toposort(&graph, None).unwrap_or_default();
        let place = order.iter().enumerate().map(|(place, &entry)| (entry, place)).collect();
        RoutineGraph { ends, order, place }
    }

    /// Decides which loops and routines are summarised, so that no loop, routine or interrupt that is followed executes
    /// more than `limit` instructions.
    fn plan(&self, program: &Program, limit: u64) -> SummaryPlan {
        let mut plan = SummaryPlan::default();
        let mut sizes: BTreeMap<usize, u64> = BTreeMap::new();
        for &entry in self.order.iter().rev() {
            let mut size = self.size(program, entry, self.ends[&entry], limit, &sizes, &mut plan);
            if size > limit {
                plan.routines.insert(entry);
                // In a summary, each of its instructions is one charge.
                size = self.reached(program, entry).len() as u64;
            }
            sizes.insert(entry, size);
        }
        for main in program.mains.iter().filter(|main| !main.is_empty()) {
            let size = self.size(program, main.start, main.end - 1, limit, &sizes, &mut plan);
            plan.total = plan.total.saturating_add(size);
        }
        for (index, interrupt) in program.interrupts.iter().enumerate() {
            let last = program.instructions.len() - 1;
            let end = flow::routine_end(program, interrupt.entry).unwrap_or(last);
            let mut size = self.size(program, interrupt.entry, end, limit, &sizes, &mut plan);
            let all = size.saturating_mul(u64::from(interrupt.times));
            if all > limit.max(size) {
                plan.interrupts.insert(index);
            } else {
                size = all;
            }
            plan.total = plan.total.saturating_add(size);
        }
        plan
    }

    /// The number of instructions executed from `from` to `to` (inclusive) under the current plan, to which loops with
    /// more than `limit` are added. `sizes` has the numbers of called routines.
    fn size(
        &self,
        program: &Program,
        from: usize,
        to: usize,
        limit: u64,
        sizes: &BTreeMap<usize, u64>,
        plan: &mut SummaryPlan,
    ) -> u64 {
        let mut total = 0u64;
        let mut at = from;
        while at <= to {
            let more = match &program.instructions[at].step {
                Step::ForBegin { most, end, .. } => {
                    let begin = std::mem::replace(&mut at, *end);
                    let iteration = self.size(program, begin + 1, *end, limit, sizes, plan);
                    let all = iteration.saturating_mul(u64::from(*most));
                    if all > limit {
                        plan.loops.insert(begin);
                        (*end - begin) as u64
                    } else {
                        all
                    }
                }
                Step::Summary(summary) => {
                    at = summary.end;
                    summary.charges.len() as u64
                }
                Step::Call { target, .. } => sizes.get(target).copied().unwrap_or(0),
                _ => 0,
            };
            total = total.saturating_add(more).saturating_add(1);
            at += 1;
        }
        total
    }

    /// The instructions of a routine and of all routines that it calls.
    fn reached(&self, program: &Program, entry: usize) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        let mut open = vec![entry];
        let mut seen: BTreeSet<usize> = BTreeSet::from([entry]);
        while let Some(entry) = open.pop() {
            for at in entry..=self.ends[&entry] {
                found.insert(at);
                if let Step::Call { target, .. } = program.instructions[at].step
                    && seen.insert(target)
                {
                    open.push(target);
                }
            }
        }
        found
    }

    fn carry_out(&self, program: &mut Program, plan: &SummaryPlan) -> Result<(), CountOverflow> {
        // Everything is collected from the program before anything is replaced, so that nothing is charged twice.
        let (mut loops, mut routines) = (Vec::new(), Vec::new());
        let mut charges = 0;
        let mut keep = |gathered: &SummaryContents| {
            charges += gathered.charges.len();
            charges <= MAX_CHARGES
        };
        for &begin in &plan.loops {
            let Step::ForBegin { most, end, .. } = program.instructions[begin].step else {
                continue;
            };
            let gathered = self.gather(program, begin + 1, end, u64::from(most))?;
            if keep(&gathered) {
                loops.push((begin, end, most, gathered));
            }
        }
        for &entry in &plan.routines {
            let mut gathered = self.gather(program, entry, self.ends[&entry], 1)?;
            gathered.own.clear();
            if keep(&gathered) {
                routines.push((entry, gathered));
            }
        }
        if charges > MAX_CHARGES {
            return summarise_all(program, SummaryReason::TooManyInstructions);
        }
        for &index in &plan.interrupts {
            self.interrupt(program, index)?;
        }
        let mut stubs: BTreeMap<usize, usize> = BTreeMap::new();
        for (entry, gathered) in routines {
            stubs.insert(entry, program.instructions.len());
            stub(program, gathered, entry, Step::Return);
            program.approximate(entry, Approximated::RoutineSummary);
        }
        for instruction in &mut program.instructions {
            if let Step::Call { target, .. } = &mut instruction.step
                && let Some(&stub) = stubs.get(target)
            {
                *target = stub;
            }
        }
        for (begin, end, iterations, gathered) in loops {
            let count = iterations_of(program, begin);
            program.instructions[begin].step = gathered.step(program, end, count);
            program.approximate(begin, Approximated::NestedSummary(iterations));
        }
        Ok(())
    }

    /// Summarises all runs of an interrupt routine in a scan as one run.
    fn interrupt(&self, program: &mut Program, index: usize) -> Result<(), CountOverflow> {
        let (entry, times) = (program.interrupts[index].entry, program.interrupts[index].times);
        if times == 0 {
            return Ok(());
        }
        let last = program.instructions.len() - 1;
        let end = flow::routine_end(program, entry).unwrap_or(last);
        let mut gathered = self.gather(program, entry, end, u64::from(times))?;
        gathered.own.clear();
        program.interrupts[index].entry = program.instructions.len();
        program.interrupts[index].times = 1;
        stub(program, gathered, entry, Step::Return);
        program.approximate(entry, Approximated::InterruptSummary(times));
        Ok(())
    }

    /// Collects how often the instructions from `from` to `to` (inclusive) and the routines that they call run in
    /// total, if control passes through this range `times` times. Also collects what they may write, and where control
    /// may continue.
    fn gather(
        &self,
        program: &Program,
        from: usize,
        to: usize,
        times: u64,
    ) -> Result<SummaryContents, CountOverflow> {
        let mut gathered = SummaryContents::default();
        // Keyed by position in `order`, so that each routine is collected once, after all its callers.
        let mut called: BTreeMap<usize, u64> = BTreeMap::new();
        self.span(program, from, to, times, &mut gathered, &mut called)?;
        gathered.own = gathered.exits(program, to);
        while let Some((place, times)) = called.pop_first() {
            let entry = self.order[place];
            self.span(program, entry, self.ends[&entry], times, &mut gathered, &mut called)?;
        }
        gathered.finish(program);
        Ok(gathered)
    }

    fn span(
        &self,
        program: &Program,
        from: usize,
        to: usize,
        times: u64,
        gathered: &mut SummaryContents,
        called: &mut BTreeMap<usize, u64>,
    ) -> Result<(), CountOverflow> {
        let mut at = from;
        while at <= to {
            let too_often = CountOverflow { instruction: at };
            let add = |sum: &mut u64, more: u64| -> Result<(), CountOverflow> {
                *sum = sum.checked_add(more).ok_or(too_often)?;
                Ok(())
            };
            add(gathered.charges.entry(at).or_default(), times)?;
            match &program.instructions[at].step {
                Step::ForBegin { most, end, .. } => {
                    let iterations = times.checked_mul(u64::from(*most)).ok_or(too_often)?;
                    self.span(program, at + 1, *end, iterations, gathered, called)?;
                    at = *end;
                }
                Step::Summary(summary) => {
                    for &(charged, often) in &summary.charges {
                        let often = often.checked_mul(times).ok_or(too_often)?;
                        add(gathered.charges.entry(charged).or_default(), often)?;
                    }
                    at = summary.end;
                }
                Step::Call { target, .. } => {
                    let place = *self.place.get(target).ok_or(too_often)?;
                    add(called.entry(place).or_default(), times)?;
                }
                _ => {}
            }
            at += 1;
        }
        Ok(())
    }
}

/// What was collected for a summary.
#[derive(Default)]
struct SummaryContents {
    /// How often each instruction can run, by its index.
    charges: BTreeMap<usize, u64>,
    /// The regions that may be written.
    regions: BTreeSet<Region>,
    /// The exits of the loop or routine itself by jumps and returns, without those of called routines.
    own: BTreeSet<Exit>,
    /// Exits that end the main routine or the scan, or lead into unbounded loops, including those of called routines.
    out: BTreeSet<Exit>,
}

impl SummaryContents {
    /// The exits by a `Return`, or by a jump to an instruction after `to`.
    fn exits(&self, program: &Program, to: usize) -> BTreeSet<Exit> {
        let mut found = BTreeSet::new();
        for &at in self.charges.keys() {
            match &program.instructions[at].step {
                Step::Jump { target, .. } if *target > to => {
                    found.insert(Exit::To(*target));
                }
                Step::Return => {
                    found.insert(Exit::Return);
                }
                Step::Summary(summary) => {
                    found.extend(summary.exits.iter().map(|&(_, exit)| exit).filter(|exit| {
                        match exit {
                            Exit::To(target) => *target > to,
                            _ => true,
                        }
                    }))
                }
                _ => {}
            }
        }
        found
    }

    fn finish(&mut self, program: &Program) {
        for &at in self.charges.keys() {
            self.regions.extend(written(program, at));
            match &program.instructions[at].step {
                Step::End => {
                    self.out.insert(Exit::End);
                }
                Step::Stop { .. } => {
                    self.out.insert(Exit::Stop);
                }
                Step::Summary(summary) => {
                    let out = summary.exits.iter().map(|&(_, exit)| exit);
                    let ends =
                        |exit: &Exit| matches!(exit, Exit::End | Exit::Stop | Exit::Unbounded(_));
                    self.out.extend(out.filter(ends));
                }
                Step::Unbounded { .. } => {
                    self.out.insert(Exit::Unbounded(at));
                }
                _ => {}
            }
        }
    }

    fn step(
        self,
        program: &mut Program,
        end: usize,
        iterations: Option<(WordSource, u32, u32)>,
    ) -> Step {
        let mut choice = || {
            program.choices += 1;
            ChoiceId(program.choices - 1)
        };
        let exits = self.own.union(&self.out).map(|&exit| (choice(), exit)).collect();
        let choice = choice();
        Step::Summary(Box::new(Summary {
            end,
            charges: self.charges.into_iter().collect(),
            havocs: merged(self.regions),
            choice,
            exits,
            iterations,
        }))
    }
}

/// The word that gives a loop's number of iterations, and the smallest and largest number. `None` if `begin` does not
/// begin a loop.
fn iterations_of(program: &Program, begin: usize) -> Option<(WordSource, u32, u32)> {
    match program.instructions[begin].step {
        Step::ForBegin { count, least, most, .. } => Some((count, least, most)),
        _ => None,
    }
}

/// Appends a summary of what was collected to the program, followed by the step `then`, which costs nothing.
fn stub(program: &mut Program, gathered: SummaryContents, of: usize, then: Step) {
    let at = program.instructions.len();
    let summary = gathered.step(program, at, None);
    [summary, then].into_iter().for_each(|step| append(program, of, step));
}

/// Appends an instruction with this step that takes its source position from instruction `of`.
fn append(program: &mut Program, of: usize, step: Step) {
    let Instruction { place, block, text, operands, .. } = &program.instructions[of];
    let (place, block, text, operands) = (*place, *block, text.clone(), operands.clone());
    let instruction =
        Instruction { place, block, text, operands, timing: None, effects: vec![], step };
    program.instructions.push(instruction);
}

/// The regions; if there are more than [`MAX_RANGES`] ranges of one area, the whole area in their place.
fn merged(regions: BTreeSet<Region>) -> Vec<Region> {
    let mut ranges: BTreeMap<_, usize> = BTreeMap::new();
    for region in &regions {
        if let Region::Range { first, .. } = region {
            *ranges.entry(first.area).or_default() += 1;
        }
    }
    let is_many = |region: &Region| matches!(region, Region::Range { first, .. } if ranges[&first.area] > MAX_RANGES);
    let mut merged: Vec<Region> =
        regions.iter().copied().filter(|region| !is_many(region)).collect();
    merged.extend(
        ranges
            .iter()
            .filter(|(_, count)| **count > MAX_RANGES)
            .map(|(&area, _)| Region::Area(area)),
    );
    merged
}
