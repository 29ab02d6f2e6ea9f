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
use crate::solve::propagator::Propagator;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// So many of the variables with most clauses may be pivots.
const CANDIDATES: usize = 16;

/// A pivot is needed by so many wishes and excluded by so many.
const FEWEST: usize = 8;

/// What is not found in so many passes is left to the solver.
const PASSES: usize = 16;

/// Between two looks at the clock there are so many wishes.
const LOOK: usize = 64;

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
    pub(super) fn mine(&mut self) {
        self.start_apart();
        let (trail, probe) = (Propagator::default(), Propagator::default());
        let mut mine = Mine { trail, probe, told: 0 };
        for _ in 0..PASSES {
            let more = self.pass(&mut mine);
            // The trail is nearly a scan: what it leaves open is as in the parts' scans.
            let (values, trail) = (&self.values, &mine.trail);
            let holds = |literal: i32| match trail.value(literal) {
                0 => values[literal.unsigned_abs() as usize] == (literal > 0),
                value => value > 0,
            };
            let assignment = self.clauses.assignment(self.problem, holds);
            self.bounds.found(assignment);
            if !more || self.done() {
                return;
            }
        }
    }

    /// Assumes every wish once. Whether another pass may find more.
    fn pass(&mut self, mine: &mut Mine) -> bool {
        mine.trail.back(0);
        self.tell(mine);
        let mut pivots = self.pivots(mine);
        pivots.retain(|pivot| {
            mine.trail.value(pivot.literal) == 0 && mine.trail.assume(pivot.literal).is_none()
        });
        let mut queue = Queue::new();
        for literal in self.all_wishes() {
            self.enqueue(literal, &mut queue);
        }
        let (mut found, mut blocked) = (false, false);
        let mut looked = 0;
        while let Some((weight, _, wish)) = queue.pop() {
            looked += 1;
            if looked % LOOK == 0 && self.done() {
                return false;
            }
            if self.weight(wish) != weight {
                continue;
            }
            let core = match mine.trail.value(wish) {
                0 => mine.trail.assume(wish),
                1 => None,
                _ => Some(mine.trail.against(wish)),
            };
            let Some(core) = core else { continue };
            let core = self.without_pivots(core, &mut pivots);
            if core.iter().any(|&literal| self.weight(literal) == 0) {
                blocked = true;
                continue;
            }
            let core = self.shrunk(core, &mut mine.probe);
            self.wishes.clear();
            self.wishes.extend(&core);
            self.pay(core);
            for (core, weight) in std::mem::take(&mut self.unpaid) {
                self.relax(&core, weight, 0);
            }
            self.tell(mine);
            for wish in std::mem::take(&mut self.wishes) {
                if mine.trail.value(wish) != 1 {
                    self.enqueue(wish, &mut queue);
                }
            }
            found = true;
        }
        found && blocked
    }

    fn enqueue(&self, wish: i32, queue: &mut Queue) {
        if self.weight(wish) > 0 {
            queue.push((self.weight(wish), Reverse(wish.unsigned_abs()), wish));
        }
    }

    fn tell(&self, mine: &mut Mine) {
        for clause in self.formula.since(mine.told) {
            mine.trail.add(clause);
            mine.probe.add(clause);
        }
        mine.told = self.formula.len();
    }

    /// The pivots as the weights are now, the most contested first.
    fn pivots(&self, mine: &mut Mine) -> Vec<Pivot> {
        let mut busy: Vec<i32> = self.formula.variables().collect();
        busy.sort_by_cached_key(|&variable| Reverse(mine.probe.occurrences(variable)));
        busy.truncate(CANDIDATES);
        let weigh = |wishes: &[i32]| wishes.iter().map(|&wish| self.weight(wish)).sum::<u64>();
        let mut pivots = Vec::new();
        for variable in busy {
            let needing = |literal: i32, probe: &mut Propagator| -> Vec<i32> {
                probe.back(0);
                if probe.value(literal) != 0 || probe.assume(-literal).is_some() {
                    return Vec::new();
                }
                let excluded = probe.implied().iter().map(|&implied| -implied);
                excluded.filter(|&wish| self.weight(wish) > 0).collect()
            };
            let mut sides =
                [variable, -variable].map(|literal| (literal, needing(literal, &mut mine.probe)));
            sides.sort_by_key(|(_, wishes)| Reverse(weigh(wishes)));
            let [(literal, mut needed_by), (_, against)] = sides;
            if needed_by.len().min(against.len()) >= FEWEST {
                needed_by.sort_unstable_by_key(|&wish| (self.weight(wish), wish));
                pivots.push(Pivot { literal, needed_by, against: weigh(&against) });
            }
        }
        mine.probe.back(0);
        pivots.sort_by_key(|pivot| (Reverse(pivot.against), pivot.literal));
        pivots
    }

    /// Each pivot in a core gives its place to the heaviest wish that needs it.
    fn without_pivots(&self, mut core: Vec<i32>, pivots: &mut [Pivot]) -> Vec<i32> {
        for literal in &mut core {
            let pivot = pivots.iter_mut().find(|pivot| pivot.literal == *literal);
            if let (Some(pivot), 0) = (pivot, self.weight(*literal)) {
                while pivot.needed_by.last().is_some_and(|&wish| self.weight(wish) == 0) {
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
    fn shrunk(&self, mut core: Vec<i32>, probe: &mut Propagator) -> Vec<i32> {
        if core.len() <= 2 {
            return core;
        }
        core.sort_unstable_by_key(|&wish| (Reverse(self.weight(wish)), wish));
        let mut at = core.len();
        while at > 0 && core.len() > 1 {
            at -= 1;
            probe.back(0);
            let others = core.iter().enumerate().filter(|&(other, _)| other != at);
            let smaller = others.map(|(_, &wish)| wish).find_map(|wish| match probe.value(wish) {
                0 => probe.assume(wish),
                1 => None,
                _ => Some(probe.against(wish)),
            });
            if let Some(smaller) = smaller {
                core.retain(|wish| smaller.contains(wish));
                at = at.min(core.len());
            }
        }
        probe.back(0);
        core
    }
}
