//! Unreachable states: sets of relays that are never all on when a scan starts.

use super::exclusive_relays::ExclusiveRelays;
use super::related_relays::RelatedRelays;
use scanbound_base::budget::Budget;
use scanbound_ir::{
    BitTarget, Cell, Effect, ExclusiveBits, Logic, Program, Region, Step, Write, flow,
};
use scanbound_model::{Atom, Circuit, Lit, Node, Origin, ScanModel, VarId, VarKind};
use scanbound_passes::values::Trust;
use scanbound_scan::scan_model_to_end;
use scanbound_scan::size_limits::SizeLimits;
use scanbound_solve::Limits;
use scanbound_solve::inductive::{BitTransition, inductive};
use scanbound_timing::price::Prices;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// The name of this stage in the progress display.
pub const STAGE: &str = "searching for invariants";
/// The stage may use 1/`UNTIL` of the time limit.
const UNTIL: u32 = 2;
/// Each search of the stage may use 1/`PARTS` of the remaining time.
const PARTS: u32 = 8;
/// Each search of the stage may take at most this time.
const LONGEST: Duration = Duration::from_secs(20);
/// The mutually exclusive relays of a program that the search found. A relay is here a bit that only the program
/// writes.
#[derive(Debug, Clone, Default)]
pub struct Relays {
    /// The sets of relays that are never all on when a scan starts. Most are pairs.
    pub exclusive: Vec<Vec<BitTarget>>,
    /// Relays that the program never turns on. Other writers may turn them on, so their values are free.
    pub freed: BTreeSet<BitTarget>,
    /// Relays on which the time of a scan may depend, and which only the program writes, in known ways: those that were
    /// examined.
    pub known: BTreeSet<BitTarget>,
    /// Whether the search completed at least its first round. Then each additional candidate set (`hints`) was either
    /// proved or refuted.
    pub decided: bool,
}

/// The model without scans that start in an unreachable state: with relays all on that no run from power-up leaves on
/// together. `None` if nothing is excluded: no such set was found, or the time was over. The sets are recorded in the
/// program's invariants, and all that was found in the second result. `hints` are additional candidate sets.
pub fn exclude(
    program: &mut Program,
    prices: &Prices,
    model: &ScanModel,
    trust: Trust,
    hints: &[Vec<BitTarget>],
    budget: &Budget<'_>,
) -> (Option<ScanModel>, Relays) {
    let bits = exclusive_relays(program, model, trust);
    let mut relays = Relays { known: bits.iter().copied().collect(), ..Relays::default() };
    let related = RelatedRelays::of(program, &bits);
    let candidates = Candidates { hinted: places(hints, &bits), pairs: related.pairs() };
    if candidates.pairs.is_empty() && candidates.hinted.is_empty() {
        return (None, relays);
    }
    let is_over = || budget.must_stop_at_part(UNTIL);
    let limits = SizeLimits { is_over: &is_over, ..SizeLimits::default() };
    let Ok((mut model, ends)) = scan_model_to_end(program, &prices.times(), &limits, &bits) else {
        cut(budget);
        return (None, relays);
    };
    let starts = starts(&mut model, &bits);
    let transitions: Vec<BitTransition> =
        starts.into_iter().zip(ends).map(|(start, end)| BitTransition { start, end }).collect();
    let fresh = fresh(program, &mut model);
    let question = Question { model: &model, bits: &transitions, related: &related, fresh };
    let Some(answer) = question.ask(candidates, budget) else { return (None, relays) };
    relays.decided = true;
    relays.freed = answer.freed.iter().map(|&bit| bits[bit]).collect();
    let own: BTreeSet<usize> = (0..bits.len()).filter(|bit| !answer.freed.contains(bit)).collect();
    let fresh = fresh.filter(|_| !own.is_empty());
    if answer.exclusive.is_empty() && fresh.is_none() {
        return (None, relays);
    }
    program.mutually_exclusive = groups(program, &bits, &answer.exclusive);
    if let Some(fresh) = fresh {
        let off = off_where(fresh, &transitions, &own, &mut model.circuit);
        model.constraints.extend(off);
        note_off_where_fresh(program, own.iter().map(|&bit| bits[bit]).collect());
    }
    for set in &answer.exclusive {
        let all = set.iter().map(|&bit| transitions[bit].start);
        let all = model.circuit.all(all);
        model.constraints.push(!all);
        let on = set.iter().map(|&bit| Logic::Bit(bits[bit].source())).collect();
        program.invariants.push(Logic::All(on).not());
    }
    let named = |set: Vec<usize>| set.into_iter().map(|bit| bits[bit]).collect();
    relays.exclusive = answer.exclusive.into_iter().map(named).collect();
    (Some(model), relays)
}

/// Records that the search for mutually exclusive relays was cut short.
fn cut(budget: &Budget<'_>) {
    budget.record_stop_at_part(
        UNTIL,
        STAGE,
        "there may be more mutually exclusive relays than the search found",
    );
}

/// The sets as indices into `bits`. Sets with a relay that is not in `bits` are left out.
fn places(sets: &[Vec<BitTarget>], bits: &[BitTarget]) -> Vec<Vec<usize>> {
    let place: BTreeMap<BitTarget, usize> =
        bits.iter().enumerate().map(|(place, &bit)| (bit, place)).collect();
    let of = |set: &Vec<BitTarget>| -> Option<Vec<usize>> {
        set.iter().map(|bit| place.get(bit).copied()).collect()
    };
    sets.iter().filter_map(of).collect()
}

/// Records in the program that these relays are off while its flag says that memory was cleared before the scan.
fn note_off_where_fresh(program: &mut Program, relays: Vec<BitTarget>) {
    let flag = program.power_up.after_clear.map(|bit| Logic::Bit(bit.source()));
    let both = |bit: &BitTarget| {
        Logic::All(flag.iter().cloned().chain([Logic::Bit(bit.source())]).collect())
    };
    program.invariants.extend(relays.iter().map(|bit| both(bit).not()));
    program.mutually_exclusive.push(ExclusiveBits {
        writers: written(program, &relays),
        bits: relays,
        max_on: 0,
    });
}

/// The sets, each sorted, without duplicates and without sets of a single relay.
fn joined(sets: impl Iterator<Item = Vec<usize>>) -> Vec<Vec<usize>> {
    let sorted = |mut set: Vec<usize>| {
        set.sort_unstable();
        set.dedup();
        set
    };
    let all: BTreeSet<Vec<usize>> = sets.map(sorted).filter(|set| set.len() > 1).collect();
    all.into_iter().collect()
}

/// Candidates: sets of relays, as indices, that are perhaps never all on when a scan starts.
struct Candidates {
    hinted: Vec<Vec<usize>>,
    pairs: Vec<Vec<usize>>,
}

/// The mutually exclusive relays, as indices of a list of relays.
struct Answer {
    /// The sets that are never all on when a scan starts.
    exclusive: Vec<Vec<usize>>,
    /// The relays that the program never turns on.
    freed: BTreeSet<usize>,
}

/// The model of a scan, and the literals that a question about the relays needs.
struct Question<'a> {
    model: &'a ScanModel,
    bits: &'a [BitTransition],
    related: &'a RelatedRelays,
    /// A literal that is true only if memory was cleared before the scan. `None` if no bit that the scan reads shows
    /// this certainly.
    fresh: Option<Lit>,
}

impl Question<'_> {
    /// The candidates that scans preserve, as far as the time allows. First the hinted sets, then with them the
    /// directly related pairs, then all pairs. `None` if there was no time even for the first round.
    fn ask(&self, candidates: Candidates, budget: &Budget<'_>) -> Option<Answer> {
        let Candidates { hinted, pairs } = candidates;
        let is_over = || budget.must_stop_at_part(UNTIL);
        // Closely related pairs first: there may be no time for others.
        let rounds = [Vec::new(), self.related.directly_related(), pairs];
        let mut answer = None;
        for pairs in rounds.into_iter().skip(usize::from(hinted.is_empty())) {
            let now = Instant::now();
            let left = budget.deadline().map(|end| end.saturating_duration_since(now) / PARTS);
            let deadline = Some(now + left.unwrap_or(LONGEST).min(LONGEST));
            let limits = Limits { deadline, cancelled: &is_over, ..Limits::default() };
            match self.keep_exclusive(joined(hinted.iter().cloned().chain(pairs)), &limits) {
                Some(found) => answer = Some(found),
                None => cut(budget),
            }
        }
        answer
    }

    /// The sets that scans preserve, if only the program turns on their relays. `None` if the limits end the search.
    fn keep_exclusive(&self, mut sets: Vec<Vec<usize>>, limits: &Limits<'_>) -> Option<Answer> {
        // A relay that the program never turns on is turned on by others: it is free, and because of it others may be
        // free, too.
        let mut own: BTreeSet<usize> = (0..self.bits.len()).collect();
        loop {
            let singles = own.iter().map(|&bit| vec![bit]);
            let candidates = singles.chain(sets.iter().cloned()).collect();
            let found = self.preserved(candidates, &own, limits)?;
            let never: Vec<usize> =
                found.iter().filter(|one| one.len() == 1).map(|one| one[0]).collect();
            if never.is_empty() {
                let freed = (0..self.bits.len()).filter(|bit| !own.contains(bit)).collect();
                return Some(Answer { exclusive: found, freed });
            }
            let freed = self.related.first(&never);
            own.retain(|bit| !freed.contains(bit));
            sets.retain(|set| set.iter().all(|bit| own.contains(bit)));
        }
    }

    /// The candidates of which, at the end of every scan that starts with none of them violated, none is violated
    /// either. If memory was cleared before the scan, none is violated at its start. `None` if the limits end the
    /// search.
    fn preserved(
        &self,
        candidates: Vec<Vec<usize>>,
        own: &BTreeSet<usize>,
        limits: &Limits<'_>,
    ) -> Option<Vec<Vec<usize>>> {
        let Some(fresh) = self.fresh else {
            return inductive(self.model, self.bits, candidates, limits);
        };
        let mut cleared = self.model.clone();
        let off = off_where(fresh, self.bits, own, &mut cleared.circuit);
        cleared.constraints.extend(off);
        inductive(&cleared, self.bits, candidates, limits)
    }
}

/// For each relay in `own`, the condition that it is off when the scan starts if memory was cleared before the scan.
fn off_where(
    fresh: Lit,
    bits: &[BitTransition],
    own: &BTreeSet<usize>,
    circuit: &mut Circuit,
) -> Vec<Lit> {
    own.iter().map(|&bit| !circuit.and(fresh, bits[bit].start)).collect()
}

/// The literal that says whether memory was cleared before the scan. `None` if the CPU has no flag for it, or the
/// program writes the flag.
pub(super) fn fresh(program: &Program, model: &mut ScanModel) -> Option<Lit> {
    let bit = program.power_up.after_clear?;
    let holds = program.power_up.memory_hold_word;
    let is_written = |first| flow::may_write(program, Region::Range { first, count: 1 });
    if is_written(bit.cell()) || holds.is_some_and(is_written) {
        return None;
    }
    let variable =
        model.variables.iter().position(|one| one.origin == Origin::Start(bit.cell()))?;
    let variable = VarId(u32::try_from(variable).ok()?);
    Some(model.circuit.atom(atom(bit, variable)))
}

fn atom(bit: BitTarget, variable: VarId) -> Atom {
    match bit {
        BitTarget::Cell(_) => Atom::Bit(variable),
        BitTarget::WordBit(_, bit) => Atom::WordBit(variable, bit),
    }
}

/// The relays on which the time of a scan may depend and which only the program writes, in known ways.
pub(super) fn exclusive_relays(
    program: &Program,
    model: &ScanModel,
    trust: Trust,
) -> Vec<BitTarget> {
    let exclusive = ExclusiveRelays::of(program, trust);
    let read = read(model);
    read.into_iter().filter(|&bit| exclusive.start_unknown(bit).is_none()).collect()
}

/// The bits whose values at the start of a scan occur in the scan's model.
pub fn read(model: &ScanModel) -> BTreeSet<BitTarget> {
    let start = |variable: VarId| match model.variables[variable.0 as usize].origin {
        Origin::Start(cell) => Some(cell),
        _ => None,
    };
    let mut read: BTreeSet<BitTarget> = BTreeSet::new();
    for one in &model.variables {
        if let (VarKind::Bit, Origin::Start(cell)) = (one.kind, &one.origin) {
            read.insert(BitTarget::Cell(*cell));
        }
    }
    for node in model.circuit.nodes() {
        if let Node::Atom(Atom::WordBit(word, bit)) = *node
            && let Some(cell) = start(word)
        {
            read.insert(BitTarget::WordBit(cell, bit));
        }
    }
    read
}

/// For each bit, the literal of its value when the scan starts.
pub(super) fn starts(model: &mut ScanModel, bits: &[BitTarget]) -> Vec<Lit> {
    let variables = model.variables.iter().zip(0..).filter_map(|(one, at)| match one.origin {
        Origin::Start(cell) => Some((cell, VarId(at))),
        _ => None,
    });
    let variables: BTreeMap<Cell, VarId> = variables.collect();
    let circuit: &mut Circuit = &mut model.circuit;
    bits.iter().map(|&bit| circuit.atom(atom(bit, variables[&bit.cell()]))).collect()
}

/// Combines pairs into groups of mutually exclusive relays, so that each pair is in at least one group. Larger sets
/// stay as they are.
fn groups(program: &Program, bits: &[BitTarget], sets: &[Vec<usize>]) -> Vec<ExclusiveBits> {
    let (pairs, larger): (Vec<&Vec<usize>>, Vec<&Vec<usize>>) =
        sets.iter().partition(|set| set.len() == 2);
    let mut left: BTreeSet<(usize, usize)> = pairs.iter().map(|pair| (pair[0], pair[1])).collect();
    let all = left.clone();
    let are_exclusive = |a: usize, b: usize| all.contains(&(a.min(b), a.max(b)));
    let mut groups: Vec<(Vec<usize>, usize)> = Vec::new();
    while let Some(&(a, b)) = left.first() {
        let mut group = vec![a, b];
        for next in b + 1..bits.len() {
            if group.iter().all(|&one| are_exclusive(one, next)) {
                group.push(next);
            }
        }
        left.retain(|(a, b)| !(group.contains(a) && group.contains(b)));
        groups.push((group, 1));
    }
    groups.extend(larger.into_iter().map(|set| (set.clone(), set.len() - 1)));
    let group = |(group, most): (Vec<usize>, usize)| {
        let bits: Vec<BitTarget> = group.into_iter().map(|place| bits[place]).collect();
        ExclusiveBits { writers: written(program, &bits), bits, max_on: most }
    };
    groups.into_iter().map(group).collect()
}

/// The instructions that write one of these bits.
fn written(program: &Program, bits: &[BitTarget]) -> Vec<usize> {
    let writes = |at: &usize| {
        let instruction = &program.instructions[*at];
        let alone = |effect: &Effect| match &effect.write {
            Write::Bit(bit, _) => Some(*bit),
            _ => None,
        };
        // A bit of a word is written individually, or with its word.
        let all_alone = instruction.effects.iter().all(|effect| alone(effect).is_some());
        if all_alone && matches!(instruction.step, Step::Act { .. }) {
            return instruction.effects.iter().filter_map(alone).any(|bit| bits.contains(&bit));
        }
        let holds = |region: Region| bits.iter().any(|one| region.contains(one.cell()));
        let regions = flow::written(program, *at);
        regions.into_iter().any(|one| matches!(one, Region::Range { .. }) && holds(one))
    };
    (0..program.instructions.len()).filter(writes).collect()
}
