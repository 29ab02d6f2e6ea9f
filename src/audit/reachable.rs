//! States that no run from power-up leads to: relays that are never all on when a scan starts.

use super::own::Owners;
use crate::base::budget::Budget;
use crate::passes::values::Trust;
use crate::program::{
    Apart, BitSource, BitTarget, Cell, Effect, Join, Logic, Program, Region, Source, Step,
    WordSource, Write, flow,
};
use crate::scan::fit::SizeLimits;
use crate::scan::model::{Atom, Circuit, Lit, Node, Origin, ScanModel, VarId, VarKind};
use crate::scan::scan_model_to_end;
use crate::solve::Limits;
use crate::solve::inductive::{Kept, inductive};
use crate::timing::price::Prices;
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
/// A relay that has to do with more others than these is a mode, which tells nothing of single pairs.
const MOST_AKIN: usize = 40;
/// What more relays than these hang on tells nothing of single pairs, either.
const MOST_SHARED: usize = 24;
/// So many pairs are looked at.
const MOST_PAIRS: usize = 20_000;

/// What was found of relays.
#[derive(Debug, Clone, Default)]
pub struct Found {
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
) -> (Option<ScanModel>, Found) {
    let bits = own(program, model, trust);
    let mut result = Found { known: bits.iter().copied().collect(), ..Found::default() };
    let rungs = Rungs::of(program, &bits);
    let place: BTreeMap<BitTarget, usize> =
        bits.iter().enumerate().map(|(place, &bit)| (bit, place)).collect();
    let of = |hint: &Vec<BitTarget>| -> Option<Vec<usize>> {
        hint.iter().map(|bit| place.get(bit).copied()).collect()
    };
    let hinted: Vec<Vec<usize>> = hints.iter().filter_map(of).collect();
    let all = rungs.pairs();
    if all.is_empty() && hinted.is_empty() {
        return (None, result);
    }
    let is_over = || budget.reached_part(UNTIL);
    let limits = SizeLimits { is_over: &is_over, ..SizeLimits::default() };
    let cut =
        || budget.cut_part(UNTIL, STAGE, "fewer relays are taken as never both on than may be");
    let Ok((mut model, ends)) = scan_model_to_end(program, &prices.times(), &limits, &bits) else {
        cut();
        return (None, result);
    };
    let starts = starts(&mut model, &bits);
    let kept: Vec<Kept> =
        starts.into_iter().zip(ends).map(|(start, end)| Kept { start, end }).collect();
    let fresh = fresh(program, &mut model);
    let question = Question { model: &model, bits: &kept, rungs: &rungs, fresh };
    // Pairs that lie close together first: they may be all that there is time for.
    let mut apart = Vec::new();
    let rounds = [Vec::new(), rungs.near(), all];
    for pairs in rounds.into_iter().skip(usize::from(hinted.is_empty())) {
        let now = Instant::now();
        let left = budget.deadline().map(|end| end.saturating_duration_since(now) / PARTS);
        let deadline = Some(now + left.unwrap_or(LONGEST).min(LONGEST));
        let limits = Limits { deadline, cancelled: &is_over, ..Limits::default() };
        let candidates = joined(hinted.iter().cloned().chain(pairs));
        match question.keep_apart(candidates, &limits) {
            Some((found, freed)) => {
                apart = found;
                result.decided = true;
                result.freed = freed.into_iter().map(|bit| bits[bit]).collect();
            }
            None => cut(),
        }
    }
    let place_of_freed = |bit: &usize| result.freed.contains(&bits[*bit]);
    let own: BTreeSet<usize> = (0..bits.len()).filter(|bit| !place_of_freed(bit)).collect();
    let is_fresh_known = result.decided && fresh.is_some() && !own.is_empty();
    if apart.is_empty() && !is_fresh_known {
        return (None, result);
    }
    program.apart = groups(program, &bits, &apart);
    if is_fresh_known {
        let cleared = off_where(fresh, &kept, &own, &mut model.circuit);
        model.constraints.extend(cleared);
        let own: Vec<BitTarget> = own.iter().map(|&bit| bits[bit]).collect();
        let flag = program.power_up.fresh.map(|bit| Logic::Bit(bit.source()));
        let both = |bit: &BitTarget| {
            Logic::All(flag.iter().cloned().chain([Logic::Bit(bit.source())]).collect())
        };
        program.invariants.extend(own.iter().map(|bit| both(bit).not()));
        program.apart.push(Apart { written: written(program, &own), bits: own, most: 0 });
    }
    for set in &apart {
        let all = set.iter().map(|&bit| kept[bit].start);
        let all = model.circuit.all(all);
        model.constraints.push(!all);
        let on = set.iter().map(|&bit| Logic::Bit(bits[bit].source())).collect();
        program.invariants.push(Logic::All(on).not());
    }
    result.apart =
        apart.into_iter().map(|set| set.into_iter().map(|bit| bits[bit]).collect()).collect();
    (Some(model), result)
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

/// What is asked of a scan.
struct Question<'a> {
    model: &'a ScanModel,
    bits: &'a [Kept],
    rungs: &'a Rungs,
    /// What is true only in scans before which memory was cleared.
    fresh: Option<Lit>,
}

impl Question<'_> {
    /// Those of the sets that scans keep from being all on, where the program is trusted with the relays that it turns on; and
    /// the relays that it does not. `None` if the limits end the search.
    fn keep_apart(
        &self,
        mut sets: Vec<Vec<usize>>,
        limits: &Limits<'_>,
    ) -> Option<(Vec<Vec<usize>>, BTreeSet<usize>)> {
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
                return Some((found, freed));
            }
            let freed = self.rungs.first(&never);
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
        if self.fresh.is_none() {
            return inductive(self.model, self.bits, candidates, limits);
        }
        let mut cleared = self.model.clone();
        let off = off_where(self.fresh, self.bits, own, &mut cleared.circuit);
        cleared.constraints.extend(off);
        inductive(&cleared, self.bits, candidates, limits)
    }
}

/// That these relays are off where memory was cleared before the scan.
fn off_where(
    fresh: Option<Lit>,
    bits: &[Kept],
    own: &BTreeSet<usize>,
    circuit: &mut Circuit,
) -> Vec<Lit> {
    let Some(fresh) = fresh else { return Vec::new() };
    own.iter().map(|&bit| !circuit.and(fresh, bits[bit].start)).collect()
}

/// Whether memory was cleared before the scan, where a bit says so that the program leaves alone.
fn fresh(program: &Program, model: &mut ScanModel) -> Option<Lit> {
    let bit = program.power_up.fresh?;
    let holds = program.power_up.holds;
    let writes = |at: usize| {
        let marks = |region: Region| {
            region.holds(bit.cell()) || holds.is_some_and(|cell| region.holds(cell))
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

/// What is read: a relay or word, or a bit of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Read(Cell, Option<u8>);

impl From<BitTarget> for Read {
    fn from(bit: BitTarget) -> Read {
        match bit {
            BitTarget::Cell(cell) => Read(cell, None),
            BitTarget::WordBit(cell, bit) => Read(cell, Some(bit)),
        }
    }
}

/// Which relays meet in a rung.
struct Rungs {
    /// By relay: those that are read in rungs which write it.
    read: Vec<BTreeSet<usize>>,
    /// By relay: those with which it meets in a rung that writes one of the two, or that hang on the same input or word.
    akin: Vec<BTreeSet<usize>>,
}

impl Rungs {
    fn of(program: &Program, bits: &[BitTarget]) -> Rungs {
        let place: BTreeMap<Read, usize> =
            bits.iter().enumerate().map(|(place, &bit)| (Read::from(bit), place)).collect();
        let none = vec![BTreeSet::new(); bits.len()];
        let mut rungs = Rungs { read: none.clone(), akin: none };
        let mut shared: BTreeMap<Read, BTreeSet<usize>> = BTreeMap::new();
        let (mut read, mut written) = (BTreeSet::new(), BTreeSet::new());
        let mut close = |read: &mut BTreeSet<Read>, written: &mut BTreeSet<usize>| {
            let own = read.iter().filter_map(|one| place.get(one).copied()).collect();
            rungs.add(&own, written);
            for one in std::mem::take(read) {
                shared.entry(one).or_default().extend(written.iter());
            }
            written.clear();
        };
        for instruction in &program.instructions {
            if let Step::Logic { join: Join::Start, .. } = instruction.step {
                close(&mut read, &mut written);
            }
            instruction.each_read(&mut |source| {
                read.extend(match source {
                    Source::Bit(BitSource::WordBit(cell, bit)) => Some(Read(cell, Some(bit))),
                    Source::Bit(BitSource::Cell(cell)) | Source::Word(WordSource::Cell(cell)) => {
                        Some(Read(cell, None))
                    }
                    Source::Bit(_) | Source::Word(_) => None,
                });
            });
            for effect in &instruction.effects {
                if let Write::Bit(bit, _) = &effect.write {
                    written.extend(place.get(&Read::from(*bit)));
                }
            }
        }
        close(&mut read, &mut written);
        for relays in shared.into_values().filter(|relays| relays.len() <= MOST_SHARED) {
            for &relay in &relays {
                rungs.akin[relay].extend(relays.iter().filter(|&&other| other != relay));
            }
        }
        rungs
    }

    fn add(&mut self, read: &BTreeSet<usize>, written: &BTreeSet<usize>) {
        for &a in written {
            self.read[a].extend(read);
            for &b in read.iter().chain(written).filter(|&&b| b != a) {
                self.akin[a].insert(b);
                self.akin[b].insert(a);
            }
        }
    }

    /// Of relays that never come on those that need none of the others for that: what these turn on would come on then.
    fn first(&self, never: &[usize]) -> Vec<usize> {
        let needs = |&from: &usize| {
            let mut found = BTreeSet::new();
            let mut open = vec![from];
            while let Some(relay) = open.pop() {
                let more = self.read[relay].iter().filter(|one| never.contains(one));
                open.extend(more.copied().filter(|&one| found.insert(one)));
            }
            found
        };
        let all: BTreeMap<usize, BTreeSet<usize>> =
            never.iter().map(|one| (*one, needs(one))).collect();
        let is_first = |one: &usize| all[one].iter().all(|other| all[other].contains(one));
        never.iter().copied().filter(is_first).collect()
    }

    /// Pairs of relays that meet.
    fn near(&self) -> Vec<Vec<usize>> {
        let pairs = self
            .akin
            .iter()
            .enumerate()
            .flat_map(|(a, others)| others.range(a + 1..).map(move |&b| vec![a, b]));
        pairs.take(MOST_PAIRS).collect()
    }

    /// Pairs of relays that may be never both on: those that meet in a rung which writes one of them, and those that meet
    /// the same third one so, in steps from one to the next.
    fn pairs(&self) -> Vec<Vec<usize>> {
        let few: Vec<Vec<usize>> = self
            .akin
            .iter()
            .map(|others| others.iter().copied().filter(|_| others.len() <= MOST_AKIN).collect())
            .collect();
        let mut found: BTreeSet<(usize, usize)> = BTreeSet::new();
        let mut near: Vec<BTreeSet<usize>> = self.akin.clone();
        let mut before = usize::MAX;
        // In each round pairs are one relay further apart.
        while found.len() != before && found.len() < MOST_PAIRS {
            before = found.len();
            let all = near.iter().enumerate().flat_map(|(a, others)| {
                let others = others.iter().filter(move |&&b| b != a);
                others.map(move |&b| (a.min(b), a.max(b)))
            });
            for pair in all {
                if found.len() >= MOST_PAIRS {
                    break;
                }
                found.insert(pair);
            }
            let further = |others: &BTreeSet<usize>| {
                let next = others.iter().flat_map(|&other| few[other].iter().copied());
                next.chain(others.iter().copied()).collect()
            };
            near = near.iter().map(further).collect();
        }
        found.into_iter().map(|(a, b)| vec![a, b]).collect()
    }
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
fn groups(program: &Program, bits: &[BitTarget], sets: &[Vec<usize>]) -> Vec<Apart> {
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
        Apart { written: written(program, &bits), bits, most }
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
        let holds = |region: Region| bits.iter().any(|one| region.holds(one.cell()));
        let regions = flow::written(program, *at);
        regions.into_iter().any(|one| matches!(one, Region::Range { .. }) && holds(one))
    };
    (0..program.instructions.len()).filter(writes).collect()
}
