//! Cores that unit propagation alone shows, over the whole program at once.
//!
//! The wishes are assumed one after another, the heaviest first, on one trail that is kept from wish to wish: a
//! wish costs only what newly follows from it. A wish that the trail excludes makes a core with the assumptions
//! behind that. A wish that was paid for in full stays on the trail and may stand in the way of others; the next
//! pass does without it.
//!
//! Modes and run flags tie thousands of wishes together: each wish that needs a mode makes a core with each that
//! excludes it. So such a *pivot* is assumed first, by itself, the way that more weight needs it, and gives its
//! place in a core to a wish that needs it.

use super::Search;
use super::ledger::Ledger;
use crate::solve::propagator::Propagator;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// So many of the variables with most clauses may be pivots.
const CANDIDATES: usize = 16;

/// A pivot is needed by so many wishes and excluded by so many.
const FEWEST: usize = 8;

/// What is not found in so many passes is left to the solver.
const PASSES: usize = 3;

/// So many wishes go by between two looks at the clock.
const LOOK: usize = 64;

/// Propagation over all clauses, kept from pass to pass.
struct Mine {
    /// The assumptions so far and all that follows.
    trail: Propagator,
    /// For questions apart from the trail.
    probe: Propagator,
    /// How many of the formula's clauses both know.
    told: usize,
}

/// A literal that many wishes need.
struct Pivot {
    literal: i32,
    /// The wishes that need it, the heaviest last.
    needed_by: Vec<i32>,
    /// What the wishes that exclude it weigh.
    against: u64,
}

/// Wishes by weight, the heaviest first, then by variable.
type Queue = BinaryHeap<(u64, Reverse<u32>, i32)>;

impl Search<'_, '_> {
    /// Pays for cores that propagation shows, as far as a few passes find them.
    pub(super) fn mine(&self, ledger: &mut Ledger) {
        let mut trail = Propagator::default();
        ledger.formula.since(0).for_each(|clause| trail.add(clause));
        let mut mine = Mine { probe: trail.clone(), trail, told: ledger.formula.len() };
        for _ in 0..PASSES {
            let more = self.pass(ledger, &mut mine);
            // The trail is nearly a scan: what it leaves open is as in the parts' scans.
            let (values, trail) = (&self.values, &mine.trail);
            let holds = |literal: i32| match trail.value(literal) {
                0 => values[literal.unsigned_abs() as usize] == (literal > 0),
                value => value > 0,
            };
            let assignment = self.clauses.assignment(self.problem, holds);
            self.bounds().found(assignment);
            if !more || self.done() {
                return;
            }
        }
    }

    /// Assumes every wish once. Whether another pass may find more.
    fn pass(&self, ledger: &mut Ledger, mine: &mut Mine) -> bool {
        mine.trail.back(0);
        mine.learn(ledger);
        let mut pivots = mine.pivots(ledger);
        pivots.retain(|pivot| {
            mine.trail.value(pivot.literal) == 0 && mine.trail.assume(pivot.literal).is_none()
        });
        let mut queue: Queue = ledger.wishes(1).map(|(wish, weight)| place(wish, weight)).collect();
        let (mut found, mut blocked) = (false, false);
        let mut looked = 0;
        while let Some((weight, _, wish)) = queue.pop() {
            looked += 1;
            if looked % LOOK == 0 && self.done() {
                return false;
            }
            if ledger.weight(wish) != weight {
                continue;
            }
            let Some(core) = mine.trail.require(wish) else { continue };
            let core = without_pivots(core, &mut pivots, ledger);
            if core.iter().any(|&literal| ledger.weight(literal) == 0) {
                blocked = true;
                continue;
            }
            let core = shrunk(core, ledger, &mut mine.probe);
            let paid = ledger.pay(&core);
            self.bounds().step(|| self.core(&core, paid));
            let new = ledger.relax(&core, paid, |_, _| false);
            self.bounds().lost(ledger.take_lost());
            mine.learn(ledger);
            for &wish in core.iter().chain(&new) {
                if ledger.weight(wish) > 0 && mine.trail.value(wish) != 1 {
                    queue.push(place(wish, ledger.weight(wish)));
                }
            }
            found = true;
        }
        found && blocked
    }
}

fn place(wish: i32, weight: u64) -> (u64, Reverse<u32>, i32) {
    (weight, Reverse(wish.unsigned_abs()), wish)
}

impl Mine {
    /// Takes in the clauses that came since.
    fn learn(&mut self, ledger: &Ledger) {
        for clause in ledger.formula.since(self.told) {
            self.trail.add(clause);
            self.probe.add(clause);
        }
        self.told = ledger.formula.len();
    }

    /// The pivots as the weights are now, the most contested first.
    fn pivots(&mut self, ledger: &Ledger) -> Vec<Pivot> {
        let mut busy: Vec<i32> = ledger.formula.variables().collect();
        busy.sort_by_cached_key(|&variable| Reverse(self.probe.occurrences(variable)));
        busy.truncate(CANDIDATES);
        let weigh = |wishes: &[i32]| wishes.iter().map(|&wish| ledger.weight(wish)).sum::<u64>();
        let mut pivots = Vec::new();
        for variable in busy {
            let needing = |literal: i32, probe: &mut Propagator| -> Vec<i32> {
                probe.back(0);
                if probe.value(literal) != 0 || probe.assume(-literal).is_some() {
                    return Vec::new();
                }
                let excluded = probe.implied().iter().map(|&implied| -implied);
                excluded.filter(|&wish| ledger.weight(wish) > 0).collect()
            };
            let mut sides =
                [variable, -variable].map(|literal| (literal, needing(literal, &mut self.probe)));
            sides.sort_by_key(|(_, wishes)| Reverse(weigh(wishes)));
            let [(literal, mut needed_by), (_, against)] = sides;
            if needed_by.len().min(against.len()) >= FEWEST {
                needed_by.sort_unstable_by_key(|&wish| (ledger.weight(wish), wish));
                pivots.push(Pivot { literal, needed_by, against: weigh(&against) });
            }
        }
        self.probe.back(0);
        pivots.sort_by_key(|pivot| (Reverse(pivot.against), pivot.literal));
        pivots
    }
}

/// Each pivot in a core gives its place to the heaviest wish that needs it.
fn without_pivots(mut core: Vec<i32>, pivots: &mut [Pivot], ledger: &Ledger) -> Vec<i32> {
    for literal in &mut core {
        let pivot = pivots.iter_mut().find(|pivot| pivot.literal == *literal);
        if let (Some(pivot), 0) = (pivot, ledger.weight(*literal)) {
            while pivot.needed_by.last().is_some_and(|&wish| ledger.weight(wish) == 0) {
                pivot.needed_by.pop();
            }
            *literal = pivot.needed_by.last().copied().unwrap_or(*literal);
        }
    }
    core.sort_unstable();
    core.dedup();
    core
}

/// A core without wishes that propagation does not need. Cores of two are taken as they are: wishes that
/// cannot hold even alone are rare.
fn shrunk(mut core: Vec<i32>, ledger: &Ledger, probe: &mut Propagator) -> Vec<i32> {
    if core.len() <= 2 {
        return core;
    }
    core.sort_unstable_by_key(|&wish| (Reverse(ledger.weight(wish)), wish));
    let mut at = core.len();
    while at > 0 && core.len() > 1 {
        at -= 1;
        probe.back(0);
        let others = core.iter().enumerate().filter(|&(other, _)| other != at);
        if let Some(smaller) = others.map(|(_, &wish)| wish).find_map(|wish| probe.require(wish)) {
            core.retain(|wish| smaller.contains(wish));
            at = at.min(core.len());
        }
    }
    probe.back(0);
    core
}
