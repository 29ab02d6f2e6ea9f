//! Keeps lower bounds from resting on scans that start in a state which no earlier scan leaves: an edge whose memory
//! contradicts that of another instruction, or a timer that runs although its condition was off.

use super::exclusive_relays::ExclusiveRelays;
use super::reachable;
use super::real::{RunResults, RunSearch};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::{
    BitTarget, Cell, ChoiceId, ChoiceKey, Logic, Program, Region, Role, Witness, flow,
};
use scanbound_model::groups::witness;
use scanbound_model::{Lit, ScanModel};
use scanbound_passes::values::Trust;
use scanbound_scan::size_limits::SizeLimits;
use scanbound_scan::{scan_model_to_end, scan_model_within};
use scanbound_solve::Limits;
use scanbound_solve::inductive::BitTransition;
use scanbound_solve::predecessors::Predecessors;
use scanbound_timing::price::Prices;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// The largest number of states that are excluded.
const MAX_ROUNDS: usize = 100;
/// The longest time that excluding states may take.
const LONGEST: Duration = Duration::from_secs(10);
/// The largest model that is examined: its nodes and questions about words.
const LARGEST: usize = 4_000_000;
/// The largest number of relays of the program whose states are examined.
const MAX_RELAYS: usize = 200;

/// Replaces the longest real run until some scan can leave the state in which it starts. `longest` is the start of the
/// model's longest scan, which takes `upper`.
pub(super) fn keep_possible(
    search: &RunSearch<'_>,
    prices: &Prices,
    trust: Trust,
    (longest, upper): (&Witness, Picos),
    mut found: RunResults,
) -> Result<RunResults, String> {
    if !found.best.is_possible() {
        return Ok(found);
    }
    let deadline = Instant::now() + LONGEST;
    let deadline = search.limits.deadline.map_or(deadline, |end| end.min(deadline));
    let limits = Limits { deadline: Some(deadline), ..search.limits };
    let mut program: Option<Program> = None;
    if trust == Trust::All {
        // If only the program writes, earlier scans determine a counter's value.
        let earlier = earlier_choices(search.program);
        let rests = |key: &ChoiceKey| earlier.contains(&key.choice);
        if found.witness.choices.iter().any(|(key, &value)| value != 0 && rests(key)) {
            let program = program.get_or_insert_with(|| search.program.clone());
            program.kinds.retain(|choice, _| !earlier.contains(choice));
            found = search_again(search, program, prices, (longest, upper), found)?;
        }
    }
    let mut known = BTreeSet::new();
    while found.best.is_possible() {
        // Others may write a present value and not its flag. No lower bound may rest on that.
        let keeping = search.program.timekeeping.consistency.iter();
        let given = keeping.filter(|(present, _)| found.witness.start.contains_key(present));
        let new: Vec<Logic> = given
            .filter_map(|(&present, holds)| holds.clone().filter(|_| known.insert(present)))
            .collect();
        if new.is_empty() {
            break;
        }
        let program = program.get_or_insert_with(|| search.program.clone());
        program.invariants.extend(new);
        let others = RunSearch { program, least: search.least, limits: search.limits };
        if !others.real(&found.witness)?.is_possible() {
            found = search_again(search, program, prices, (longest, upper), found)?;
        }
    }
    if !found.best.is_possible() {
        return Ok(found);
    }
    let Some((bits, mut states)) = states(search.program, prices, trust, &limits) else {
        return Ok(found);
    };
    for _ in 0..MAX_ROUNDS {
        let state = |(at, bit): (usize, &BitTarget)| Some((at, value(&found.witness, *bit)?));
        let state: Vec<(usize, bool)> = bits.iter().enumerate().filter_map(state).collect();
        let Some(part) = states.excluded(&state) else { return Ok(found) };
        let holds = |&(bit, value): &(usize, bool)| {
            let on = Logic::Bit(bits[bit].source());
            if value { on } else { on.not() }
        };
        let program = program.get_or_insert_with(|| search.program.clone());
        program.invariants.push(Logic::All(part.iter().map(holds).collect()).not());
        found = search_again(search, program, prices, (longest, upper), found)?;
        if !found.best.is_possible() {
            return Ok(found);
        }
    }
    // It is not decided whether a scan leaves this state, so no lower bound may rest on it.
    found.best.replay.total = Picos::ZERO;
    found.best.replay.events.clear();
    Ok(found)
}

/// Searches for the longest real run again, in a program that excludes more: first that of its model's longest scan.
fn search_again(
    search: &RunSearch<'_>,
    program: &Program,
    prices: &Prices,
    (longest, upper): (&Witness, Picos),
    found: RunResults,
) -> Result<RunResults, String> {
    let others = RunSearch { program, least: search.least, limits: search.limits };
    let is_over = || search.limits.reached();
    let size = SizeLimits { per_execution: usize::MAX, in_all: LARGEST, is_over: &is_over };
    let model = scan_model_within(program, &prices.times(), &size).ok();
    let first = model.and_then(|model| {
        let (assignment, _) = others.longest(&model)?;
        Some(witness(&model, &assignment))
    });
    let start = found.witness.clone();
    others.run([first.as_ref().unwrap_or(longest), &start], upper, found.knowledge)
}

/// Choices that earlier scans decide, other than by the time that has passed.
fn earlier_choices(program: &Program) -> BTreeSet<ChoiceId> {
    let keeping = &program.timekeeping;
    let is_timed = |choice: &ChoiceId| {
        keeping.expiries.contains_key(choice) || keeping.elapsed.contains_key(choice)
    };
    keeping.untracked.iter().copied().filter(|choice| !is_timed(choice)).collect()
}

/// The value of a bit in the start state of a scan, if it is given.
fn value(witness: &Witness, bit: BitTarget) -> Option<bool> {
    let value = witness.start.get(&bit.cell())?;
    Some(match bit {
        BitTarget::Cell(_) => value & 1 == 1,
        BitTarget::WordBit(_, bit) => value >> bit & 1 == 1,
    })
}

/// The bits that hold when a scan starts what the scan before left, and the solver that knows which of their states
/// occur. `None` if there are no such bits, or the scan is too large.
fn states<'a>(
    program: &Program,
    prices: &Prices,
    trust: Trust,
    limits: &'a Limits<'a>,
) -> Option<(Vec<BitTarget>, Predecessors<'a>)> {
    let is_over = || limits.reached();
    let size = SizeLimits { per_execution: usize::MAX, in_all: LARGEST, is_over: &is_over };
    let times = prices.times();
    let (model, _) = scan_model_to_end(program, &times, &size, &[]).ok()?;
    let mut bits = memories(program, &model);
    let mut relays = Vec::new();
    if trust == Trust::All || !program.internal.is_empty() {
        let exclusive = ExclusiveRelays::of(program, trust);
        relays.extend(reachable::read(&model));
        relays.retain(|&bit| exclusive.is_left_by_scan(bit) && !bits.contains(&bit));
        relays.truncate(MAX_RELAYS);
    }
    let memories = bits.len();
    loop {
        bits.truncate(memories);
        bits.extend(&relays);
        if bits.is_empty() {
            return None;
        }
        let mut states = predecessors(program, &times, &mut bits, (&size, limits))?;
        // A relay that the program never turns on is turned on by others.
        let is_turned_on = |at: usize| states.excluded(&[(memories + at, true)]).is_none();
        let turned_on: Vec<bool> = (0..relays.len()).map(is_turned_on).collect();
        if turned_on.iter().all(|&on| on) {
            return Some((bits, states));
        }
        let mut turned_on = turned_on.into_iter();
        relays.retain(|_| turned_on.next() == Some(true));
    }
}

/// The solver for these bits. Adds the flags that are on in the first scan of a run only.
fn predecessors<'a>(
    program: &Program,
    times: &[Times],
    bits: &mut Vec<BitTarget>,
    (size, limits): (&SizeLimits<'_>, &'a Limits<'a>),
) -> Option<Predecessors<'a>> {
    let (mut model, ends) = scan_model_to_end(program, times, size, bits).ok()?;
    let starts = reachable::starts(&mut model, bits);
    let mut transitions: Vec<BitTransition> =
        starts.into_iter().zip(ends).map(|(start, end)| BitTransition { start, end }).collect();
    let initial = |bit: &BitTarget| {
        let value = program.power_up.initial_value(bit.cell());
        match *bit {
            BitTarget::Cell(_) => value & 1 == 1,
            BitTarget::WordBit(_, bit) => value >> bit & 1 == 1,
        }
    };
    let mut initials: Vec<bool> = bits.iter().map(initial).collect();
    let read = reachable::read(&model);
    let writes = |cell: Cell, at| {
        flow::written(program, at).into_iter().any(|region: Region| region.contains(cell))
    };
    let is_written = |cell: Cell| (0..program.instructions.len()).any(|at| writes(cell, at));
    let flags = program.power_up.first_scan.iter().map(|&cell| BitTarget::Cell(cell));
    for flag in flags.filter(|flag| read.contains(flag) && !is_written(flag.cell())) {
        let start = reachable::starts(&mut model, &[flag])[0];
        bits.push(flag);
        transitions.push(BitTransition { start, end: Lit::FALSE });
        initials.push(true);
    }
    if let Some(start) = reachable::fresh(program, &mut model) {
        bits.extend(program.power_up.after_clear);
        transitions.push(BitTransition { start, end: Lit::FALSE });
        initials.push(true);
    }
    Some(Predecessors::new(&model, transitions, initials, limits))
}

/// The bits in which instructions remember something from scan to scan, as far as the scan reads them.
fn memories(program: &Program, model: &ScanModel) -> Vec<BitTarget> {
    let is_own = |cell: Cell| {
        let within = |region: &Region| region.contains(cell);
        program.area(cell.area).role == Role::Internal
            && !program.volatile.iter().any(within)
            && !program.external.iter().any(within)
    };
    let read = reachable::read(model).into_iter();
    read.filter(|bit| is_own(bit.cell())).collect()
}
