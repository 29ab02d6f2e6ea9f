//! States that no run from power-up leads to: relays that are never all on when a scan starts.

use super::meeting::Meeting;
use super::own::Owners;
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

/// What it is called while it runs.
pub const STAGE: &str = "looking for what scans keep";
/// It ends when one part of so many of the time allowed is over, and each of its searches takes one part of so many of what
/// is left.
const UNTIL: u32 = 2;
const PARTS: u32 = 8;
/// It takes no longer than this where there is no limit to the time.
const LONGEST: Duration = Duration::from_secs(20);
/// What was found of relays.
#[derive(Debug, Clone, Default)]
pub struct Relays {
    /// The sets that are never all on.
    pub apart: Vec<Vec<BitTarget>>,
    /// Those that the program never turns on: somebody else does, so they are free.
    pub freed: BTreeSet<BitTarget>,
    /// Those that a scan's costs may hang on, and that are known.
    pub known: BTreeSet<BitTarget>,
    /// Whether all sets were asked for.
    pub decided: bool,
}

/// The model without scans that start where relays are all on that no run from power-up leaves on together, if any are found.
/// What they are is noted in the program. `hints` are sets of relays of which somebody thinks so: they are asked for, too.
pub fn exclude(
    program: &mut Program,
    prices: &Prices,
    model: &ScanModel,
    trust: Trust,
    hints: &[Vec<BitTarget>],
    budget: &Budget<'_>,
) -> (Option<ScanModel>, Relays) {
    let bits = own(program, model, trust);
    let mut relays = Relays { known: bits.iter().copied().collect(), ..Relays::default() };
    let meeting = Meeting::of(program, &bits);
    let candidates = Candidates { hinted: places(hints, &bits), pairs: meeting.pairs() };
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
    let kept: Vec<BitTransition> =
        starts.into_iter().zip(ends).map(|(start, end)| BitTransition { start, end }).collect();
    let fresh = fresh(program, &mut model);
    let question = Question { model: &model, bits: &kept, meeting: &meeting, fresh };
    let Some(answer) = question.ask(candidates, budget) else { return (None, relays) };
    relays.decided = true;
    relays.freed = answer.freed.iter().map(|&bit| bits[bit]).collect();
    let own: BTreeSet<usize> = (0..bits.len()).filter(|bit| !answer.freed.contains(bit)).collect();
    let fresh = fresh.filter(|_| !own.is_empty());
    if answer.apart.is_empty() && fresh.is_none() {
        return (None, relays);
    }
    program.mutually_exclusive = groups(program, &bits, &answer.apart);
    if let Some(fresh) = fresh {
        let off = off_where(fresh, &kept, &own, &mut model.circuit);
        model.constraints.extend(off);
        note_off_where_fresh(program, own.iter().map(|&bit| bits[bit]).collect());
    }
    for set in &answer.apart {
        let all = set.iter().map(|&bit| kept[bit].start);
        let all = model.circuit.all(all);
        model.constraints.push(!all);
        let on = set.iter().map(|&bit| Logic::Bit(bits[bit].source())).collect();
        program.invariants.push(Logic::All(on).not());
    }
    let named = |set: Vec<usize>| set.into_iter().map(|bit| bits[bit]).collect();
    relays.apart = answer.apart.into_iter().map(named).collect();
    (Some(model), relays)
}

/// Notes that the stage could not do all that it is for.
fn cut(budget: &Budget<'_>) {
    budget.record_stop_at_part(UNTIL, STAGE, "fewer relays are taken as never both on than may be");
}

/// The places of these sets' relays among the bits; without sets of which a relay is not among them.
fn places(sets: &[Vec<BitTarget>], bits: &[BitTarget]) -> Vec<Vec<usize>> {
    let place: BTreeMap<BitTarget, usize> =
        bits.iter().enumerate().map(|(place, &bit)| (bit, place)).collect();
    let of = |set: &Vec<BitTarget>| -> Option<Vec<usize>> {
        set.iter().map(|bit| place.get(bit).copied()).collect()
    };
    sets.iter().filter_map(of).collect()
}

/// Notes in the program that these relays are off where its flag says that memory was cleared before the scan.
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

/// The sets, each once, and none that has another in it.
fn joined(sets: impl Iterator<Item = Vec<usize>>) -> Vec<Vec<usize>> {
    let sorted = |mut set: Vec<usize>| {
        set.sort_unstable();
        set.dedup();
        set
    };
    let all: BTreeSet<Vec<usize>> = sets.map(sorted).filter(|set| set.len() > 1).collect();
    all.into_iter().collect()
}

/// Sets of relays that scans may keep from being all on, by the relays' places among the bits.
struct Candidates {
    hinted: Vec<Vec<usize>>,
    pairs: Vec<Vec<usize>>,
}

/// What scans were found to keep, by places among the bits.
struct Answer {
    /// The sets that are never all on.
    apart: Vec<Vec<usize>>,
    /// The relays that the program never turns on.
    freed: BTreeSet<usize>,
}

/// What is asked of a scan.
struct Question<'a> {
    model: &'a ScanModel,
    bits: &'a [BitTransition],
    meeting: &'a Meeting,
    /// What is true only in scans before which memory was cleared.
    fresh: Option<Lit>,
}

impl Question<'_> {
    /// What scans keep of the candidates, as far as there is time to ask. `None` if there was none for the fewest.
    fn ask(&self, candidates: Candidates, budget: &Budget<'_>) -> Option<Answer> {
        let Candidates { hinted, pairs } = candidates;
        let is_over = || budget.must_stop_at_part(UNTIL);
        // Pairs that lie close together first: they may be all that there is time for.
        let rounds = [Vec::new(), self.meeting.near(), pairs];
        let mut answer = None;
        for pairs in rounds.into_iter().skip(usize::from(hinted.is_empty())) {
            let now = Instant::now();
            let left = budget.deadline().map(|end| end.saturating_duration_since(now) / PARTS);
            let deadline = Some(now + left.unwrap_or(LONGEST).min(LONGEST));
            let limits = Limits { deadline, cancelled: &is_over, ..Limits::default() };
            match self.keep_apart(joined(hinted.iter().cloned().chain(pairs)), &limits) {
                Some(found) => answer = Some(found),
                None => cut(budget),
            }
        }
        answer
    }

    /// What scans keep of the sets, where the program is trusted with the relays that it turns on. `None` if the limits end
    /// the search.
    fn keep_apart(&self, mut sets: Vec<Vec<usize>>, limits: &Limits<'_>) -> Option<Answer> {
        // A relay that the program never turns on is turned on by somebody else: it is free, and then others may be too.
        let mut own: BTreeSet<usize> = (0..self.bits.len()).collect();
        loop {
            let singles = own.iter().map(|&bit| vec![bit]);
            let candidates = singles.chain(sets.iter().cloned()).collect();
            let found = self.kept(candidates, &own, limits)?;
            let never: Vec<usize> =
                found.iter().filter(|one| one.len() == 1).map(|one| one[0]).collect();
            if never.is_empty() {
                let freed = (0..self.bits.len()).filter(|bit| !own.contains(bit)).collect();
                return Some(Answer { apart: found, freed });
            }
            let freed = self.meeting.first(&never);
            own.retain(|bit| !freed.contains(bit));
            sets.retain(|set| set.iter().all(|bit| own.contains(bit)));
        }
    }

    /// Those of the candidates that every scan keeps which starts where they all hold. Where memory was cleared, all do.
    fn kept(
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

/// That these relays are off where memory was cleared before the scan.
fn off_where(
    fresh: Lit,
    bits: &[BitTransition],
    own: &BTreeSet<usize>,
    circuit: &mut Circuit,
) -> Vec<Lit> {
    own.iter().map(|&bit| !circuit.and(fresh, bits[bit].start)).collect()
}

/// Whether memory was cleared before the scan, where a bit says so that the program leaves alone.
fn fresh(program: &Program, model: &mut ScanModel) -> Option<Lit> {
    let bit = program.power_up.after_clear?;
    let holds = program.power_up.memory_hold_word;
    let writes = |at: usize| {
        let marks = |region: Region| {
            region.contains(bit.cell()) || holds.is_some_and(|cell| region.contains(cell))
        };
        flow::written(program, at).into_iter().any(marks)
    };
    if (0..program.instructions.len()).any(writes) {
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

/// The relays that a scan's costs may hang on and that nobody but the program writes, and only in ways that are known.
fn own(program: &Program, model: &ScanModel, trust: Trust) -> Vec<BitTarget> {
    let owners = Owners::of(program, trust);
    let read = read(model);
    read.into_iter().filter(|&bit| owners.refuses(bit).is_none()).collect()
}

/// The bits that are read as they are when a scan starts.
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

/// The bits' values when a scan starts.
fn starts(model: &mut ScanModel, bits: &[BitTarget]) -> Vec<Lit> {
    let variables = model.variables.iter().zip(0..).filter_map(|(one, at)| match one.origin {
        Origin::Start(cell) => Some((cell, VarId(at))),
        _ => None,
    });
    let variables: BTreeMap<Cell, VarId> = variables.collect();
    let circuit: &mut Circuit = &mut model.circuit;
    bits.iter().map(|&bit| circuit.atom(atom(bit, variables[&bit.cell()]))).collect()
}

/// The pairs put together: of each group's relays no two are ever on. Larger sets stand by themselves.
fn groups(program: &Program, bits: &[BitTarget], sets: &[Vec<usize>]) -> Vec<ExclusiveBits> {
    let (pairs, larger): (Vec<&Vec<usize>>, Vec<&Vec<usize>>) =
        sets.iter().partition(|set| set.len() == 2);
    let mut left: BTreeSet<(usize, usize)> = pairs.iter().map(|pair| (pair[0], pair[1])).collect();
    let all = left.clone();
    let is_apart = |a: usize, b: usize| all.contains(&(a.min(b), a.max(b)));
    let mut groups: Vec<(Vec<usize>, usize)> = Vec::new();
    while let Some(&(a, b)) = left.first() {
        let mut group = vec![a, b];
        for next in b + 1..bits.len() {
            if group.iter().all(|&one| is_apart(one, next)) {
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
        // A bit of a word is written alone, or with its word.
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
