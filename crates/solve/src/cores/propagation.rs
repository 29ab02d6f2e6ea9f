//! Finds cores by unit propagation alone, over the whole program.
//!
//! The soft literals are assumed one after another, heaviest first, on one trail that is kept from literal to literal,
//! so each costs only its new consequences. If the trail makes a literal false, this literal and the assumptions that
//! cause it are a core. A literal whose whole weight was subtracted stays on the trail and may prevent others; the next
//! pass leaves it out.
//!
//! Mode bits and run flags connect thousands of soft literals: each literal that needs a mode is a core with each that
//! excludes it. Therefore such a *pivot* is assumed first, by itself, with the value that more weight needs. In a core
//! it is replaced by a soft literal that needs it.

use super::objective::Objective;
use super::search::PartitionSearch;
use crate::limits::Limits;
use crate::propagator::Propagator;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The number of variables, of those in most clauses, that are examined as pivots.
const CANDIDATES: usize = 16;

/// A pivot is a literal that at least this many soft literals need, and that at least as many exclude.
const FEWEST: usize = 8;

/// Another pass follows if the last one lowered the bound by at least 1/`LEAST_GAIN` (0.2 %). Of cores that overlap, a
/// pass finds only one. Cores that bring less are left to the solver, which takes longer for each but finds more.
const LEAST_GAIN: u64 = 500;

/// Cores with more literals than this are not minimised literal by literal, but only reduced to what propagation uses.
const LARGEST: usize = 40;

/// The number of soft literals after which the search checks the clock again.
const LOOK: usize = 64;

/// Propagators over all clauses, kept from pass to pass.
struct Extraction {
    /// The current assumptions and all their consequences.
    trail: Propagator,
    /// A second propagator, for queries independent of the trail.
    probe: Propagator,
    /// The number of the formula's clauses that both propagators already have.
    passed_clauses: usize,
}

/// A literal that many soft literals need.
struct Pivot {
    literal: i32,
    /// The soft literals that can be true only if the pivot is true; the heaviest is last.
    needed_by: Vec<i32>,
    /// The total weight of the soft literals that can be true only if the pivot is false.
    against: u64,
}

/// Soft literals as a queue, with their weights: heaviest first, then by variable.
type Queue = BinaryHeap<(u64, Reverse<u32>, i32)>;

impl PartitionSearch<'_, '_> {
    /// Extracts and relaxes the cores that unit propagation finds, in passes as long as each lowers the bound enough
    /// ([`LEAST_GAIN`]), and records the scan that each pass leads to.
    pub(super) fn propagation_cores(&self, objective: &mut Objective) {
        let formula = &objective.formula;
        // The arena stores the length and the literals of each clause with more than two literals.
        let long = formula.since(0).filter(|clause| clause.len() > 2);
        let literals = long.map(|clause| clause.len() + 1).sum();
        let passed_clauses = || {
            let mut propagator = Propagator::with_room(formula.variable_count() + 1, literals);
            formula.since(0).for_each(|clause| propagator.add(clause));
            propagator
        };
        // Filling both in parallel takes no longer than filling one and copying it.
        let (trail, probe) = rayon::join(passed_clauses, passed_clauses);
        let mut extraction = Extraction { trail, probe, passed_clauses: formula.len() };
        loop {
            let before = self.bounds().upper();
            let more = self.pass(objective, &mut extraction);
            // The trail is nearly a scan; its unassigned variables get the values of the partitions' scans.
            let (values, trail) = (&self.values, &extraction.trail);
            let holds = |literal: i32| match trail.value(literal) {
                0 => values[literal.unsigned_abs() as usize] == (literal > 0),
                value => value > 0,
            };
            let assignment = self.clauses.assignment(self.problem, holds);
            self.bounds().record_assignment(assignment);
            let gain = before - self.bounds().upper();
            if !more || gain < before / LEAST_GAIN || self.done() {
                return;
            }
        }
    }

    /// Assumes every soft literal once, and extracts a core for each that cannot be true. Returns whether one more pass
    /// may find more cores.
    fn pass(&self, objective: &mut Objective, extraction: &mut Extraction) -> bool {
        extraction.trail.retract_to(0);
        extraction.learn(objective);
        let mut pivots = extraction.pivots(objective, self.limits);
        pivots.retain(|pivot| {
            extraction.trail.value(pivot.literal) == 0
                && extraction.trail.assume(pivot.literal).is_none()
        });
        let mut queue: Queue = objective.soft_literals(1).map(ranked).collect();
        let (mut found, mut blocked) = (false, false);
        let mut looked = 0;
        while let Some((weight, _, literal)) = queue.pop() {
            looked += 1;
            if looked % LOOK == 0 && self.done() {
                return false;
            }
            if objective.weight(literal) != weight {
                continue;
            }
            let Some(core) = extraction.trail.require(literal) else { continue };
            let core = without_pivots(core, &mut pivots, objective);
            if core.iter().any(|&literal| objective.weight(literal) == 0) {
                blocked = true;
                continue;
            }
            let core = shrunk(core, objective, &mut extraction.probe, self.limits);
            if core.is_empty() {
                // The constraints exclude every scan.
                return false;
            }
            let weight = objective.subtract_core(&core);
            self.bounds().step(|| self.core(&core, weight));
            let new = objective.relax(&core, weight, |_, _| false);
            self.bounds().falsified(objective.take_falsified());
            extraction.learn(objective);
            for &literal in core.iter().chain(&new) {
                if objective.weight(literal) > 0 && extraction.trail.value(literal) != 1 {
                    queue.push(ranked((literal, objective.weight(literal))));
                }
            }
            found = true;
        }
        found && blocked
    }
}

fn ranked((literal, weight): (i32, u64)) -> (u64, Reverse<u32>, i32) {
    (weight, Reverse(literal.unsigned_abs()), literal)
}

impl Extraction {
    /// Adds the clauses that are new since the last call.
    fn learn(&mut self, objective: &Objective) {
        for clause in objective.formula.since(self.passed_clauses) {
            self.trail.add(clause);
            self.probe.add(clause);
        }
        self.passed_clauses = objective.formula.len();
    }

    /// The pivots for the current weights, the most contested first.
    fn pivots(&mut self, objective: &Objective, limits: &Limits<'_>) -> Vec<Pivot> {
        let ranked = |variable| (Reverse(self.probe.occurrences(variable)), variable);
        let mut busy: Vec<(Reverse<usize>, i32)> =
            objective.formula.variables().map(ranked).collect();
        if busy.len() > CANDIDATES {
            busy.select_nth_unstable(CANDIDATES);
            busy.truncate(CANDIDATES);
        }
        busy.sort_unstable();
        let weigh = |literals: &[i32]| {
            literals.iter().map(|&literal| objective.weight(literal)).sum::<u64>()
        };
        let mut pivots = Vec::new();
        for (_, variable) in busy {
            if limits.reached() {
                break;
            }
            let needing = |literal: i32, probe: &mut Propagator| -> Vec<i32> {
                probe.retract_to(0);
                if probe.value(literal) != 0 || probe.assume(-literal).is_some() {
                    return Vec::new();
                }
                let excluded = probe.implied().iter().map(|&implied| -implied);
                excluded.filter(|&literal| objective.weight(literal) > 0).collect()
            };
            let mut sides =
                [variable, -variable].map(|literal| (literal, needing(literal, &mut self.probe)));
            sides.sort_by_key(|(_, literals)| Reverse(weigh(literals)));
            let [(literal, mut needed_by), (_, against)] = sides;
            if needed_by.len().min(against.len()) >= FEWEST {
                needed_by.sort_unstable_by_key(|&literal| (objective.weight(literal), literal));
                pivots.push(Pivot { literal, needed_by, against: weigh(&against) });
            }
        }
        self.probe.retract_to(0);
        pivots.sort_by_key(|pivot| (Reverse(pivot.against), pivot.literal));
        pivots
    }
}

/// Replaces each pivot in a core that is no soft literal itself by the heaviest soft literal that needs it.
fn without_pivots(mut core: Vec<i32>, pivots: &mut [Pivot], objective: &Objective) -> Vec<i32> {
    for literal in &mut core {
        let pivot = pivots.iter_mut().find(|pivot| pivot.literal == *literal);
        if let (Some(pivot), 0) = (pivot, objective.weight(*literal)) {
            while pivot.needed_by.last().is_some_and(|&literal| objective.weight(literal) == 0) {
                pivot.needed_by.pop();
            }
            *literal = pivot.needed_by.last().copied().unwrap_or(*literal);
        }
    }
    core.sort_unstable();
    core.dedup();
    core
}

/// Removes from a core the literals that propagation does not need. Cores of two are left unchanged, because soft
/// literals that cannot be true alone are rare.
fn shrunk(
    mut core: Vec<i32>,
    objective: &Objective,
    probe: &mut Propagator,
    limits: &Limits<'_>,
) -> Vec<i32> {
    if core.len() <= 2 {
        return core;
    }
    // The last literals are used least.
    loop {
        probe.retract_to(0);
        let used = core.iter().find_map(|&literal| probe.require(literal));
        let Some(used) = used.filter(|used| used.len() < core.len()) else { break };
        core.retain(|literal| used.contains(literal));
        core.reverse();
    }
    if core.len() > LARGEST {
        probe.retract_to(0);
        return core;
    }
    core.sort_unstable_by_key(|&literal| (Reverse(objective.weight(literal)), literal));
    // The levels of the probe after each of the core's first literals; they are kept from one query to the next.
    let mut levels = vec![0];
    let mut at = core.len();
    while at > 0 && core.len() > 1 && !limits.reached() {
        at -= 1;
        levels.truncate(at + 1);
        probe.retract_to(levels[levels.len() - 1]);
        let mut smaller = None;
        while smaller.is_none() && levels.len() <= at {
            smaller = probe.require(core[levels.len() - 1]);
            levels.push(probe.level());
        }
        let behind = || core[at + 1..].iter().find_map(|&literal| probe.require(literal));
        if let Some(smaller) = smaller.or_else(behind) {
            let gone = core.iter().position(|literal| !smaller.contains(literal));
            levels.truncate(gone.map_or(levels.len(), |gone| gone + 1));
            core.retain(|literal| smaller.contains(literal));
            at = at.min(core.len());
        }
    }
    probe.retract_to(0);
    core
}
