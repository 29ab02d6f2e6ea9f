//! Keeps lower bounds from resting on scans that start in a state which no earlier scan leaves: an edge whose memory
//! contradicts that of another instruction, a timer that runs although its condition was off, or a counter beyond its
//! setting.

use super::exclusive_relays::ExclusiveRelays;
use super::modelling::LONGEST_SCAN;
use super::reachable;
use super::real::{self, EarlyRuns, RunResults, RunSearch};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::{ChoiceKind, Knowledge, Operation};
use scanbound_ir::timers::Expiry;
use scanbound_ir::{
    BitSource, BitTarget, Cell, ChoiceId, ChoiceKey, Logic, Program, Region, Role, Source, Witness,
    WordSource, flow,
};
use scanbound_model::groups::witness;
use scanbound_model::lower_bound::{Treatment, lower_bound_model_with};
use scanbound_model::{Lit, Origin, ScanModel, VarId, VarKind, Variable};
use scanbound_passes::values::Trust;
use scanbound_scan::size_limits::SizeLimits;
use scanbound_scan::{lower_bound_scan_to_end, scan_model_to_end, scan_model_within};
use scanbound_solve::Limits;
use scanbound_solve::predecessors::{Predecessors, StartState, StateBit};
use scanbound_timing::price::Prices;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// The largest number of start states that are excluded. If they are not enough, there is no lower bound.
const MAX_ROUNDS: usize = 100;
/// The largest number of changes of a start state that make it one that occurs.
const MAX_CHANGES: usize = 400;
/// If a start state breaks so many invariants, it is not changed for one after another.
const MANY: usize = 8;
/// The longest time that the exclusion of start states may take.
const LONGEST: Duration = Duration::from_secs(10);
/// The largest model that is examined: its nodes and questions about words.
const LARGEST: usize = 4_000_000;
/// The most relays whose states are examined. With more, it is not decided which states occur.
const MAX_RELAYS: usize = 200;
/// The most words whose states are examined. With more, it is not decided which states occur.
const MAX_WORDS: usize = 32;

/// Replaces the longest real run until some earlier scan can leave the state in which it starts; if none is longer, by
/// the run that was examined before ([`RunResults::kept`]). If it is not decided within the limits, the last run stays,
/// and [`RunResults::is_start_undecided`] says so: with [`Trust::All`], where
/// all start states are those that the program reaches; if the user states devices that only the program writes; if the
/// program has charts, whose state nobody else writes; and after many replacements. `longest` is the start of the
/// model's longest scan, and `upper` the bound on all charges.
pub(super) fn keep_possible(
    search: &RunSearch<'_>,
    prices: &Prices,
    trust: Trust,
    longest: (&Witness, Picos),
    found: RunResults,
) -> Result<RunResults, String> {
    let Some((took, kept)) = found.kept.clone() else {
        return occurring(search, prices, trust, longest, found);
    };
    if found.witness == kept {
        return Ok(found);
    }
    let mut found = occurring(search, prices, trust, longest, found)?;
    if !found.best.is_possible() || found.best.replay.total < took {
        let run = search.real(&kept)?;
        if run.is_possible() {
            (found.best, found.witness) = (run, kept);
            found.is_start_undecided = false;
        }
    }
    Ok(found)
}

/// As [`keep_possible`], whatever is known of other runs.
fn occurring(
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
        let new: Vec<&Logic> = given
            .filter_map(|(&present, holds)| Some((present, holds.as_ref()?)))
            .filter_map(|(present, holds)| known.insert(present).then_some(holds))
            .collect();
        if new.is_empty() {
            break;
        }
        let program = program.get_or_insert_with(|| search.program.clone());
        program.invariants.extend(new.into_iter().cloned());
        found = again(search, program, prices, (longest, upper), found)?;
    }
    if !found.best.is_possible() {
        return Ok(found);
    }
    let knowledge = found.knowledge.clone();
    let stricter = program.clone();
    let left = States {
        program: stricter.as_ref().unwrap_or(search.program),
        times: prices.times(),
        knowledge: &knowledge,
        trust,
        limits: &limits,
    };
    let is_required = trust == Trust::All
        || !search.program.internal.is_empty()
        || !search.program.charts.active.is_empty();
    let undecided = |found: RunResults| match is_required {
        true => RunResults { is_start_undecided: true, ..found },
        false => examined(found),
    };
    let (bits, mut states) = match left.find() {
        Ok(Some(left)) => left,
        Ok(None) => return Ok(examined(found)),
        Err(Undecided) => return Ok(undecided(found)),
    };
    // The longest run so far whose start state may occur.
    let mut kept: Option<RunResults> = None;
    for _ in 0..MAX_ROUNDS {
        let started = search.started(&found.witness);
        let state =
            |(at, bit): (usize, &BitTarget)| Some((at, bit_of(*started.get(&bit.cell())?, *bit)));
        let state: Vec<(usize, bool)> = bits.iter().enumerate().filter_map(state).collect();
        let occurs = states.occurs(&state);
        let program = program.get_or_insert_with(|| search.program.clone());
        // Another run may start with other present values, which must be consistent, too.
        let keeping = search.program.timekeeping.consistency.iter();
        let more = keeping.filter(|(present, _)| known.insert(**present));
        program.invariants.extend(more.filter_map(|(_, holds)| holds.clone()));
        match occurs {
            StartState::MayOccur if !search.is_large() => return Ok(examined(found)),
            StartState::MayOccur => {
                let before = found.best.replay.total;
                kept = Some(examined(found.clone()));
                if trust == Trust::All {
                    let earlier = earlier_choices(search.program);
                    program.kinds.retain(|choice, _| !earlier.contains(choice));
                }
                // The other half of the time is for examining where the longer run starts.
                RunSearch { program, limits, ..*search }
                    .half_time()
                    .steer(&mut found, Some(upper))?;
                if found.best.replay.total == before || Instant::now() >= deadline {
                    break;
                }
            }
            StartState::Undecided => return Ok(kept.unwrap_or_else(|| undecided(found))),
            StartState::Excluded(part) => {
                let holds = |&(bit, value): &(usize, bool)| {
                    let on = Logic::Bit(bits[bit].source());
                    if value { on } else { on.not() }
                };
                program.invariants.push(Logic::All(part.iter().map(holds).collect()).not());
                found = again(search, program, prices, (longest, upper), found)?;
                let least = kept.as_ref().map_or(Picos::ZERO, |kept| kept.best.replay.total);
                if !found.best.is_possible() || found.best.replay.total < least {
                    return Ok(kept.unwrap_or(found));
                }
            }
        }
    }
    Ok(kept.unwrap_or(RunResults { is_start_undecided: true, ..found }))
}

/// The results, with their longest run as one whose start state was examined.
fn examined(found: RunResults) -> RunResults {
    let kept = Some((found.best.replay.total, found.witness.clone()));
    RunResults { kept, ..found }
}

/// The run, if it starts as this program allows it; otherwise one that is changed little, or the longest one that a new
/// search finds.
fn again(
    search: &RunSearch<'_>,
    program: &Program,
    prices: &Prices,
    longest: (&Witness, Picos),
    found: RunResults,
) -> Result<RunResults, String> {
    let stricter = RunSearch { program, ..*search };
    if stricter.real(&found.witness)?.is_possible() {
        return Ok(found);
    }
    let repaired = if search.is_large() { stricter.repaired(&found)? } else { None };
    repaired.map_or_else(|| search_again(search, program, prices, longest, found), Ok)
}

impl RunSearch<'_> {
    /// These runs, of which the longest is replaced until some earlier scan can leave the state in which it starts.
    ///
    /// # Errors
    /// As for [`Self::search_early`].
    pub fn kept(
        &self,
        mut early: EarlyRuns,
        prices: &Prices,
        trust: Trust,
    ) -> Result<EarlyRuns, String> {
        let longest = (&early.found.witness.clone(), LONGEST_SCAN);
        early.found = keep_possible(self, prices, trust, longest, early.found)?;
        Ok(early)
    }

    /// The run changed at its start so that it breaks no invariant of the program, one after another: of the values
    /// that the first broken one names, that is taken after which the fewest are broken, and the run is the longest.
    /// `None` if no such changes lead to a possible run.
    pub(super) fn repaired(&self, found: &RunResults) -> Result<Option<RunResults>, String> {
        let mut witness = found.witness.clone();
        let mut seen = vec![witness.start.clone()];
        let mut broken = self.broken(&witness);
        // Of many, each is changed at the same time, as long as that helps.
        let mut nth = 0;
        while broken.len() >= MANY && nth < MANY {
            let mut changed = witness.clone();
            for holds in broken.iter().filter_map(|&at| self.program.invariants.get(at)) {
                changed.start.extend(values(self, &witness, holds).get(nth).copied());
            }
            let left = self.broken(&changed);
            if left.len() < broken.len() {
                (broken, witness) = (left, changed);
            } else {
                nth += 1;
            }
        }
        while let Some(&first) = broken.first() {
            let Some(holds) = self.program.invariants.get(first) else { return Ok(None) };
            if seen.len() > MAX_CHANGES || self.is_over() {
                return Ok(None);
            }
            let mut least: Vec<(Vec<usize>, Witness)> = Vec::new();
            for (cell, value) in values(self, &witness, holds) {
                let mut changed = witness.clone();
                changed.start.insert(cell, value);
                let left = self.broken(&changed);
                if left.contains(&first) || seen.contains(&changed.start) {
                    continue;
                }
                let fewest = least.first().map_or(usize::MAX, |(one, _)| one.len());
                if left.len() < fewest {
                    least.clear();
                }
                if left.len() <= fewest {
                    least.push((left, changed));
                }
            }
            let mut longest = 0;
            if least.len() > 1 {
                let times = least.iter().map(|(_, one)| Ok(self.real(one)?.replay.total));
                let times = times.collect::<Result<Vec<Picos>, String>>()?;
                longest = (0..times.len()).max_by_key(|&at| times[at]).unwrap_or(0);
            }
            if least.is_empty() {
                return Ok(None);
            }
            (broken, witness) = least.swap_remove(longest);
            seen.push(witness.start.clone());
        }
        let mut run = self.real(&witness)?;
        if !run.is_possible() {
            return Ok(None);
        }
        let mut repaired = found.clone();
        repaired.note(self.program, &mut run);
        (repaired.best, repaired.witness) = (run, witness);
        Ok(Some(repaired))
    }
}

/// Other values for each cell that a condition on a start state reads, those of words first: for a word those with
/// which it is compared; for a bit the other one.
fn values(search: &RunSearch<'_>, witness: &Witness, holds: &Logic) -> Vec<(Cell, u16)> {
    let start = |cell| search.start_value(witness, cell);
    let (mut bits, mut words, mut compared) = (Vec::new(), Vec::new(), vec![0]);
    holds.each_read(&mut |source| match source {
        Source::Bit(BitSource::Cell(cell)) => bits.push((cell, start(cell) ^ 1)),
        Source::Bit(BitSource::WordBit(cell, bit)) => bits.push((cell, start(cell) ^ 1 << bit)),
        Source::Word(WordSource::Cell(cell)) => {
            words.push(cell);
            compared.push(start(cell));
        }
        Source::Word(WordSource::Const(value)) => compared.push(value),
        _ => {}
    });
    compared.sort_unstable();
    compared.dedup();
    let compared = &compared;
    let of_word = |word| compared.iter().map(move |&value| (word, value));
    words.into_iter().flat_map(of_word).chain(bits).collect()
}

/// The longest real run in which no timer runs out, in this scan or before it. `None` if the longest run found is
/// impossible, or the program has no timer that can be kept from running out.
pub(super) fn keep_timers(
    search: &RunSearch<'_>,
    prices: &Prices,
    trust: Trust,
    longest: (&Witness, Picos),
    found: &RunResults,
) -> Result<Option<RunResults>, String> {
    let mut expiries = search.program.timekeeping.expiries.values();
    if !found.best.is_possible() || !expiries.any(Expiry::can_be_kept) {
        return Ok(None);
    }
    let mut program = search.program.clone();
    program.timekeeping.are_kept = true;
    let kept = RunSearch { program: &program, ..*search };
    let upper = longest.1;
    let first = kept.run([longest.0, &found.witness], upper, found.knowledge.clone())?;
    keep_possible(&kept, prices, trust, longest, first).map(Some)
}

/// Searches for the longest real run again, in a program that excludes more scans. It begins with the longest scan of
/// this program's model, or with `longest` if that is not found.
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
    // In a large model, the longest scan takes as long to find as two rounds of the search for real runs.
    let model =
        (!others.is_large()).then(|| scan_model_within(program, &prices.times(), &size).ok());
    let first = model.flatten().and_then(|model| {
        let (assignment, _) = others.longest(&model)?;
        Some(witness(&model, &assignment))
    });
    let start = found.witness.clone();
    others.run([first.as_ref().unwrap_or(longest), &start], upper, found.knowledge)
}

/// The choices whose values follow from earlier scans, other than from the time that has passed: such as a counter's
/// value.
fn earlier_choices(program: &Program) -> BTreeSet<ChoiceId> {
    let keeping = &program.timekeeping;
    let is_timed = |choice: &ChoiceId| {
        keeping.expiries.contains_key(choice) || keeping.elapsed.contains_key(choice)
    };
    keeping.untracked.iter().copied().filter(|choice| !is_timed(choice)).collect()
}

/// The value of a bit, from that of its cell.
fn bit_of(value: u16, bit: BitTarget) -> bool {
    match bit {
        BitTarget::Cell(_) => value & 1 == 1,
        BitTarget::WordBit(_, bit) => value >> bit & 1 == 1,
    }
}

/// The error if it cannot be examined which states a scan leaves: there are too many relays or words, the scan is too
/// large, or the time is over.
struct Undecided;

/// Finds which states a scan leaves.
struct States<'a> {
    program: &'a Program,
    times: Vec<Times>,
    /// What real runs showed about operations.
    knowledge: &'a Knowledge,
    trust: Trust,
    limits: &'a Limits<'a>,
}

impl<'a> States<'a> {
    /// The bits that hold when a scan starts what the scan before left, and the solver that knows which of their states
    /// occur. `None` if there are no such bits.
    fn find(&self) -> Result<Option<(Vec<BitTarget>, Predecessors<'a>)>, Undecided> {
        let program = self.program;
        let exclusive = ExclusiveRelays::of(program, self.trust);
        let is_over = || self.limits.reached();
        let size = SizeLimits { per_execution: usize::MAX, in_all: LARGEST, is_over: &is_over };
        let mut memories = Vec::new();
        // Relays, and the bits of words.
        let mut left: Option<Vec<Vec<BitTarget>>> = None;
        let select = |model: &ScanModel| {
            memories = self::memories(program, model);
            left = self.left(model, &memories, &exclusive);
            memories.iter().chain(left.iter().flatten().flatten()).copied().collect()
        };
        let scan = lower_bound_scan_to_end(program, &self.times, self.knowledge, &size, select);
        let (full, ends) = scan.map_err(|_| Undecided)?;
        let left = left.ok_or(Undecided)?;
        let mut bits: Vec<BitTarget> =
            memories.iter().chain(left.iter().flatten()).copied().collect();
        if bits.is_empty() {
            return Ok(None);
        }
        let changed = self.changed(&memories, left, &bits, &exclusive, &size)?;
        let standing = |variable| self.standing(&full, variable);
        let (model, ends) = lower_bound_model_with(&full, &standing, false, &ends);
        let mut ends: BTreeMap<BitTarget, (Lit, Lit)> = bits.iter().copied().zip(ends).collect();
        bits.retain(|bit| changed.contains(bit));
        ends.retain(|bit, _| changed.contains(bit));
        if bits.is_empty() {
            return Ok(None);
        }
        let states = self.predecessors(model, &mut bits, |bit| ends[bit]);
        Ok(Some((bits, states)))
    }

    /// The relays and words that hold when a scan starts what the scan before left, each with its bits, as far as the
    /// model reads them, apart from the memories of instructions. Words of one number are one. Empty without
    /// [`Trust::All`] if the facts name no devices under `[internal]`. `None` if there are too many.
    fn left(
        &self,
        model: &ScanModel,
        memories: &[BitTarget],
        exclusive: &ExclusiveRelays<'_>,
    ) -> Option<Vec<Vec<BitTarget>>> {
        let mut left: Vec<Vec<BitTarget>> = Vec::new();
        if self.trust != Trust::All && self.program.internal.is_empty() {
            return Some(left);
        }
        let lasts = |cell: Cell| !self.program.timekeeping.scratch.contains(&cell.area);
        let known: BTreeSet<Cell> = memories.iter().map(|bit| bit.cell()).collect();
        let is_new = |cell: Cell| lasts(cell) && !known.contains(&cell);
        // With a word, the others of the same number: the program may change only these.
        let mut numbers = BTreeSet::new();
        for mut word in words(model) {
            while exclusive.is_upper_word(word) {
                word.index -= 1;
            }
            numbers.insert(word);
            while exclusive.is_upper_word(word.plus(1)) {
                word = word.plus(1);
                numbers.insert(word);
            }
        }
        let is_left = |cell: &Cell| is_new(*cell) && exclusive.is_word_left_by_scan(*cell);
        let words: Vec<Cell> = numbers.into_iter().filter(is_left).collect();
        if words.len() > MAX_WORDS {
            return None;
        }
        let is_next = |a: &Cell, b: &Cell| *b == a.plus(1) && exclusive.is_upper_word(*b);
        let numbers = words.chunk_by(is_next);
        left.extend(numbers.map(|words| words.iter().copied().flat_map(bits_of_word).collect()));
        let known: BTreeSet<BitTarget> = left.iter().flatten().copied().collect();
        let relays = reachable::read(model).into_iter();
        let is_left = |bit: &BitTarget| {
            is_new(bit.cell()) && !known.contains(bit) && exclusive.is_left_by_scan(*bit)
        };
        let relays: Vec<BitTarget> = relays.filter(is_left).collect();
        if relays.len() > MAX_RELAYS {
            return None;
        }
        left.extend(relays.into_iter().map(|bit| vec![bit]));
        Some(left)
    }

    /// The memories, and the bits of those relays and words of `left` that some scan may change, or to which an
    /// instruction writes an unknown value. Whether a scan may change them is decided with the model of all scans, not
    /// only of those for lower bounds. `bits` are all memories and all bits of `left`.
    fn changed(
        &self,
        memories: &[BitTarget],
        mut left: Vec<Vec<BitTarget>>,
        bits: &[BitTarget],
        exclusive: &ExclusiveRelays<'_>,
        size: &SizeLimits<'_>,
    ) -> Result<BTreeSet<BitTarget>, Undecided> {
        let all = |left: &[Vec<BitTarget>]| -> Vec<BitTarget> {
            memories.iter().chain(left.iter().flatten()).copied().collect()
        };
        if left.is_empty() {
            return Ok(memories.iter().copied().collect());
        }
        let scan = scan_model_to_end(self.program, &self.times, size, bits);
        let (model, ends) = scan.map_err(|_| Undecided)?;
        let ends: BTreeMap<BitTarget, Lit> = bits.iter().copied().zip(ends).collect();
        loop {
            let end = |bit: &BitTarget| (ends[bit], !ends[bit]);
            let mut states = self.predecessors(model.clone(), &mut all(&left), end);
            let before = left.len();
            let mut at = memories.len();
            left.retain(|cell| {
                let mut places = (at..).zip(cell);
                at += cell.len();
                // What the program never changes is changed by others. No lower bound rests on what others write to a
                // timer or a counter.
                cell.iter().any(|&bit| exclusive.takes_any_value(bit))
                    || places.any(|(at, &bit)| {
                        let changed = [(at, !self.initial(bit))];
                        !matches!(states.occurs(&changed), StartState::Excluded(_))
                    })
            });
            if left.len() == before || all(&left).is_empty() {
                return Ok(all(&left).into_iter().collect());
            }
        }
    }

    /// The solver for these bits in a model of the scan. `end` gives the literals that the scan leaves a bit on, and
    /// off. Adds the flags that are on in the first scan of a run only.
    fn predecessors(
        &self,
        mut model: ScanModel,
        bits: &mut Vec<BitTarget>,
        end: impl Fn(&BitTarget) -> (Lit, Lit),
    ) -> Predecessors<'a> {
        let program = self.program;
        add_starts(program, &mut model, bits);
        let starts = reachable::starts(&mut model, bits);
        let state = |(bit, start): (&BitTarget, Lit)| {
            let (on, off) = end(bit);
            StateBit { start, on, off, initial: self.initial(*bit) }
        };
        let mut kept: Vec<StateBit> = bits.iter().zip(starts).map(state).collect();
        let flag = |start| StateBit { start, on: Lit::FALSE, off: Lit::TRUE, initial: true };
        let read = reachable::read(&model);
        let is_written = |first| flow::may_write(program, Region::Range { first, count: 1 });
        let flags = program.power_up.first_scan.iter().map(|&cell| BitTarget::Cell(cell));
        for bit in flags.filter(|bit| read.contains(bit) && !is_written(bit.cell())) {
            let start = reachable::starts(&mut model, &[bit])[0];
            bits.push(bit);
            kept.push(flag(start));
        }
        if let Some(start) = reachable::fresh(program, &mut model) {
            bits.extend(program.power_up.after_clear);
            kept.push(flag(start));
        }
        Predecessors::new(&model, kept, self.limits)
    }

    /// How a variable of the earlier scan is treated. [`Treatment::Unknown`]: nothing is assumed about results that the
    /// model does not know, nor about points that controllers or manuals leave open. [`Treatment::Zero`]: no timer
    /// advances during the scan or runs out between two instructions, and nothing unusual happens. Others may have any
    /// value.
    fn standing(&self, model: &ScanModel, variable: VarId) -> Treatment {
        let (kinds, keeping) = (&self.program.kinds, &self.program.timekeeping);
        real::standing_of(model, variable, &|choice| match kinds.get(&choice) {
            _ if keeping.between_instructions.contains_key(&choice)
                || keeping.unusual.contains(&choice) =>
            {
                Treatment::Zero
            }
            _ if keeping.readings.contains(&choice) => Treatment::Unknown,
            Some(
                ChoiceKind::External
                | ChoiceKind::StableExternal(_)
                | ChoiceKind::PresentValue { .. }
                | ChoiceKind::UnsignedIterations(_),
            ) => Treatment::Free,
            // How far a timer has run.
            Some(ChoiceKind::Exact(one)) if one.operation == Operation::Elapsed => Treatment::Free,
            Some(ChoiceKind::ScanTicks { .. } | ChoiceKind::ExtraTime | ChoiceKind::Parameter) => {
                Treatment::Zero
            }
            Some(
                ChoiceKind::Exact(_)
                | ChoiceKind::Iterations(_)
                | ChoiceKind::Reading(_)
                | ChoiceKind::AddressOf { .. }
                | ChoiceKind::Unreachable(_),
            )
            | None => Treatment::Unknown,
        })
    }

    /// The value of a bit when a run begins with cleared memory: its declared first value, otherwise off.
    fn initial(&self, bit: BitTarget) -> bool {
        bit_of(self.program.power_up.initial_value(bit.cell()), bit)
    }
}

/// Adds variables for the start values of bits that this model of the scan does not read.
fn add_starts(program: &Program, model: &mut ScanModel, bits: &[BitTarget]) {
    let start = |one: &Variable| match one.origin {
        Origin::Start(cell) => Some(cell),
        _ => None,
    };
    let mut known: BTreeSet<Cell> = model.variables.iter().filter_map(start).collect();
    for bit in bits {
        let (kind, cell) = match *bit {
            BitTarget::Cell(cell) => (VarKind::Bit, cell),
            BitTarget::WordBit(cell, _) => (VarKind::Word, cell),
        };
        if known.insert(cell) {
            let (origin, name) = (Origin::Start(cell), program.cell_name(cell));
            model.variables.push(Variable { kind, origin, name });
        }
    }
}

/// The words whose start values the scan reads.
fn words(model: &ScanModel) -> Vec<Cell> {
    let word = |one: &Variable| match (one.kind, &one.origin) {
        (VarKind::Word, Origin::Start(cell)) => Some(*cell),
        _ => None,
    };
    model.variables.iter().filter_map(word).collect()
}

/// The bits in which instructions and charts remember something from scan to scan, as far as the scan reads them:
/// nothing but the program writes them.
fn memories(program: &Program, model: &ScanModel) -> Vec<BitTarget> {
    let is_own = |cell: Cell| {
        let within = |region: &Region| region.contains(cell);
        let is_hidden = program.area(cell.area).role == Role::Internal
            && !program.timekeeping.scratch.contains(&cell.area);
        (is_hidden || program.charts.areas.contains(&cell.area))
            && !program.volatile.iter().any(within)
            && !program.external.iter().any(within)
    };
    let words = words(model).into_iter().filter(|cell| program.charts.areas.contains(&cell.area));
    let read = reachable::read(model).into_iter().chain(words.flat_map(bits_of_word));
    read.filter(|bit| is_own(bit.cell())).collect::<BTreeSet<BitTarget>>().into_iter().collect()
}

fn bits_of_word(cell: Cell) -> Vec<BitTarget> {
    (0..16).map(|bit| BitTarget::WordBit(cell, bit)).collect()
}
