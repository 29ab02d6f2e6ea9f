//! States that no run from power-up leads to: relays that are never both on when a scan starts.

use crate::base::budget::Budget;
use crate::passes::values::{Trust, is_ours};
use crate::program::{
    Apart, BitSource, BitTarget, Cell, ChoiceKind, Join, Logic, Program, Region, Source, Step,
    WordSource, Write, flow,
};
use crate::scan::fit::SizeLimits;
use crate::scan::model::{Atom, Lit, Origin, ScanModel, VarId, VarKind};
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

/// The model without scans that start where two relays are on that no run from power-up leaves on together, if any are
/// found. What they are is noted in the program.
pub fn exclude(
    program: &mut Program,
    prices: &Prices,
    model: &ScanModel,
    trust: Trust,
    budget: &Budget<'_>,
) -> Option<ScanModel> {
    let cells = own(program, model, trust);
    let rungs = Rungs::of(program, &cells);
    let all = rungs.pairs();
    if all.is_empty() {
        return None;
    }
    let is_over = || budget.reached_part(UNTIL);
    let limits = SizeLimits { is_over: &is_over, ..SizeLimits::default() };
    let cut =
        || budget.cut_part(UNTIL, STAGE, "fewer relays are taken as never both on than may be");
    let Ok((mut model, ends)) = scan_model_to_end(program, &prices.times(), &limits, &cells) else {
        cut();
        return None;
    };
    let bits: Vec<Kept> = starts(&mut model, &cells)
        .into_iter()
        .zip(ends)
        .map(|(start, end)| Kept { start, end })
        .collect();
    // Pairs that lie close together first: they may be all that there is time for.
    let mut apart = Vec::new();
    for pairs in [rungs.near(), all] {
        let now = Instant::now();
        let left = budget.deadline().map(|end| end.saturating_duration_since(now) / PARTS);
        let deadline = Some(now + left.unwrap_or(LONGEST).min(LONGEST));
        let limits = Limits { deadline, cancelled: &is_over, ..Limits::default() };
        match keep_apart(&model, &bits, &rungs, pairs, &limits) {
            Some(found) => apart = found,
            None => cut(),
        }
    }
    if apart.is_empty() {
        return None;
    }
    for pair in &apart {
        let all = pair.iter().map(|&bit| bits[bit].start);
        let both = model.circuit.all(all);
        model.constraints.push(!both);
        let on = pair.iter().map(|&bit| Logic::cell(cells[bit])).collect();
        program.invariants.push(Logic::All(on).not());
    }
    program.apart = groups(program, &cells, &apart);
    Some(model)
}

/// Those of the pairs that scans keep apart, where the program is trusted with the relays that it turns on. `None` if the
/// limits end the search.
fn keep_apart(
    model: &ScanModel,
    bits: &[Kept],
    rungs: &Rungs,
    mut pairs: Vec<Vec<usize>>,
    limits: &Limits<'_>,
) -> Option<Vec<Vec<usize>>> {
    // A relay that the program never turns on is turned on by somebody else: it is free, and then others may be too.
    let mut own: BTreeSet<usize> = (0..bits.len()).collect();
    loop {
        let singles = own.iter().map(|&bit| vec![bit]);
        let candidates = singles.chain(pairs.iter().cloned()).collect();
        let found = inductive(model, bits, candidates, limits)?;
        let never: Vec<usize> =
            found.iter().filter(|one| one.len() == 1).map(|one| one[0]).collect();
        if never.is_empty() {
            return Some(found);
        }
        let freed = rungs.first(&never);
        own.retain(|bit| !freed.contains(bit));
        pairs.retain(|pair| pair.iter().all(|bit| own.contains(bit)));
    }
}

/// The relays that a scan's costs may hang on and that nobody but the program writes, and only in ways that are known.
fn own(program: &Program, model: &ScanModel, trust: Trust) -> Vec<Cell> {
    let read = model.variables.iter().filter_map(|one| match (one.kind, &one.origin) {
        (VarKind::Bit, Origin::Start(cell)) => Some(*cell),
        _ => None,
    });
    let is_trusted = |&cell: &Cell| is_ours(program, cell) && trust.holds_alone(program, cell);
    let read: BTreeSet<Cell> = read.filter(is_trusted).collect();
    let mut own = BTreeSet::new();
    let mut others = BTreeSet::new();
    for instruction in &program.instructions {
        for effect in &instruction.effects {
            match &effect.write {
                Write::Bit(BitTarget::Cell(cell), value) => {
                    if mentions_choice(value) {
                        others.insert(*cell);
                    } else {
                        own.insert(*cell);
                    }
                }
                Write::Havoc(region, choice) => {
                    // What is delivered later is written at any moment from then on.
                    let at_once = program.indexed.contains_key(choice)
                        || matches!(program.kinds.get(choice), Some(ChoiceKind::Exact(_)));
                    if !at_once {
                        others.extend(within(&read, *region));
                    }
                }
                Write::Bit(BitTarget::WordBit(..), _) | Write::Words(..) => {}
            }
        }
    }
    let latched = |cell: &Cell| program.power_up.latched.iter().any(|one| one.holds(*cell));
    own.retain(|cell| read.contains(cell) && !others.contains(cell) && !latched(cell));
    own.into_iter().collect()
}

fn within(cells: &BTreeSet<Cell>, region: Region) -> Vec<Cell> {
    cells.iter().copied().filter(|&cell| region.holds(cell)).collect()
}

fn mentions_choice(logic: &Logic) -> bool {
    match logic {
        Logic::Bit(BitSource::Free(_)) => true,
        Logic::Condition | Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => false,
        Logic::Not(inner) => mentions_choice(inner),
        Logic::All(parts) | Logic::Any(parts) => parts.iter().any(mentions_choice),
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
    fn of(program: &Program, cells: &[Cell]) -> Rungs {
        let place: BTreeMap<Cell, usize> =
            cells.iter().enumerate().map(|(place, &cell)| (cell, place)).collect();
        let none = vec![BTreeSet::new(); cells.len()];
        let mut rungs = Rungs { read: none.clone(), akin: none };
        let mut shared: BTreeMap<Cell, BTreeSet<usize>> = BTreeMap::new();
        let (mut read, mut written) = (BTreeSet::new(), BTreeSet::new());
        let mut close = |read: &mut BTreeSet<Cell>, written: &mut BTreeSet<usize>| {
            let own = read.iter().filter_map(|cell| place.get(cell).copied()).collect();
            rungs.add(&own, written);
            for cell in std::mem::take(read) {
                shared.entry(cell).or_default().extend(written.iter());
            }
            written.clear();
        };
        for instruction in &program.instructions {
            if let Step::Logic { join: Join::Start, .. } = instruction.step {
                close(&mut read, &mut written);
            }
            instruction.each_read(&mut |source| {
                if let Source::Bit(BitSource::Cell(cell) | BitSource::WordBit(cell, _))
                | Source::Word(WordSource::Cell(cell)) = source
                {
                    read.insert(cell);
                }
            });
            for effect in &instruction.effects {
                if let Write::Bit(BitTarget::Cell(cell), _) = &effect.write {
                    written.extend(place.get(cell));
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

/// The cells' values when a scan starts.
fn starts(model: &mut ScanModel, cells: &[Cell]) -> Vec<Lit> {
    let variables = model.variables.iter().zip(0..).filter_map(|(one, at)| match one.origin {
        Origin::Start(cell) => Some((cell, VarId(at))),
        _ => None,
    });
    let variables: BTreeMap<Cell, VarId> = variables.collect();
    cells.iter().map(|cell| model.circuit.atom(Atom::Bit(variables[cell]))).collect()
}

/// The pairs put together: of each group's relays no two are ever on.
fn groups(program: &Program, cells: &[Cell], pairs: &[Vec<usize>]) -> Vec<Apart> {
    let mut left: BTreeSet<(usize, usize)> = pairs.iter().map(|pair| (pair[0], pair[1])).collect();
    let all = left.clone();
    let is_apart = |a: usize, b: usize| all.contains(&(a.min(b), a.max(b)));
    let mut groups = Vec::new();
    while let Some(&(a, b)) = left.first() {
        let mut group = vec![a, b];
        for next in b + 1..cells.len() {
            if group.iter().all(|&one| is_apart(one, next)) {
                group.push(next);
            }
        }
        left.retain(|(a, b)| !(group.contains(a) && group.contains(b)));
        groups.push(group.into_iter().map(|place| cells[place]).collect::<Vec<_>>());
    }
    let written = |cells: &[Cell]| {
        let writes = |at: &usize| {
            let regions = flow::written(program, *at);
            regions.into_iter().any(|region| {
                matches!(region, Region::Range { .. }) && cells.iter().any(|&one| region.holds(one))
            })
        };
        (0..program.instructions.len()).filter(writes).collect()
    };
    groups.into_iter().map(|cells| Apart { written: written(&cells), cells }).collect()
}
