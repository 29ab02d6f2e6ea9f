//! Searches problems with charts case by case.
//!
//! The active step of a chart decides which of its actions run, and which charts these call. For the solver, the costs
//! of steps are thousands of mutually exclusive pairs. If a step is fixed, nearly all other guards become false by
//! propagation alone. Therefore the search branches on the bit both values of which lower the bound most; each value is
//! a case. The case with the highest bound comes next, until no case can exceed the best scan found. Slices bound a
//! case; if they show that it cannot be far above that scan, the solver searches it. A case that is still open after a
//! number of decisions is split again.

use super::ground::Ground;
use super::objective::Objective;
use super::slices::{self, Slices};
use crate::bounds::Bounds;
use crate::formula::Formula;
use crate::limits::Limits;
use crate::propagator::Propagator;
use crate::trace::Step;
use rayon::prelude::*;
use std::cmp::Reverse;

/// Problems with fewer clauses are not searched case by case.
pub const FEWEST_CLAUSES: usize = 3_000;

/// Problems with more clauses are not searched case by case, because examining a bit takes too long.
const MAX_CLAUSES: usize = 200_000;

/// The number of bits that are examined to split a case.
const CANDIDATES: usize = 128;

/// The number of cases that are searched in parallel. It is fixed, so that results do not depend on the number of
/// threads.
const TOGETHER: usize = 4;

/// The solver decisions that the search of a case may use in each partition before the case is split.
pub const DECISIONS: u64 = 400_000;

/// A case is split without a search if its upper bound is more than this many times the time of the best scan found,
/// and its best bit leaves less than [`WORTH`] of the bound for each of the bit's two values.
const FAR: u64 = 2;

/// The fraction 49/50. A value of a bit lowers a case's bound noticeably only if less than this fraction of the bound
/// remains.
const WORTH: (u64, u64) = (49, 50);

/// A case: the scans in which these literals are true.
struct Case {
    literals: Vec<i32>,
    /// The upper bound of the case, in picoseconds.
    upper: u64,
    state: CaseState,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum CaseState {
    New,
    /// The case was searched and must be split.
    Searched,
    /// The case was searched completely.
    Ended,
}

/// The result of processing a case: the cases that remain open in its place, and the bounds of its search (`None` if it
/// was not searched).
type CaseOutcome<'a> = (Vec<Case>, Option<Bounds<'a>>);

/// A bit and the bounds that remain if it is on and if it is off, after the sort key: how much both lower the bound.
type Ranked = (Reverse<u128>, i32, [u64; 2]);

/// Whether a problem may be searched case by case: the number of decisions is not limited, and the clauses are neither
/// too few nor too many.
pub fn may_suit(ground: &Ground<'_>, formula: &Formula, limits: &Limits<'_>) -> bool {
    (ground.sizes.least..=MAX_CLAUSES).contains(&formula.len()) && limits.decisions.is_none()
}

/// Searches case by case until the bounds meet or the limits are reached, and returns `None`. If slices or cases would
/// lower the bound by less than half, or the constraints are contradictory, does nothing and returns the objective.
pub fn search(
    ground: &Ground<'_>,
    objective: Objective,
    bounds: &mut Bounds<'_>,
) -> Option<Objective> {
    let softs: Vec<(i32, u64)> = objective.soft_literals(1).collect();
    let split = Split::new(ground, &objective.formula, softs, bounds.remaining());
    let limits = *bounds.limits();
    let quiet = Limits { progress: &|_, _| {}, trace: false, ..limits };
    if split.propagator.has_contradiction() {
        // No scan satisfies the constraints, as the solver finds at once.
        return Some(objective);
    }
    let mut trail = split.propagator.clone();
    let open = split.unassigned(&trail);
    if open.len() <= slices::MAX_SOFT && Slices::of(&open, &mut trail).off < split.most / 2 {
        return Some(objective);
    }
    let candidates = split.candidates();
    if split.largest_cost(&candidates) > split.most / 2 {
        return Some(objective);
    }
    bounds.step(|| Step::Cases);
    // Search one promising case first, so that the others can be compared with a good scan.
    let (first, most) = split.promising(&mut trail, &candidates);
    let (_, found) =
        split.search(&first, &mut trail, most, Some(ground.sizes.decisions), bounds, &quiet);
    bounds.after_case(found);
    let mut open = vec![Case { literals: Vec::new(), upper: split.most, state: CaseState::New }];
    loop {
        open.retain(|case| case.upper > bounds.lower());
        open.sort_by_key(|case| Reverse(case.upper));
        bounds.record_upper(open.first().map_or(bounds.lower(), |case| case.upper));
        let ends = open.first().is_none_or(|case| case.state == CaseState::Ended);
        if ends || limits.reached() {
            break;
        }
        let next: Vec<Case> = open.drain(..open.len().min(TOGETHER)).collect();
        let known = &*bounds;
        let next = next.into_par_iter().map(|case| split.next(case, &candidates, known, &quiet));
        let next: Vec<CaseOutcome<'_>> = next.collect();
        for (cases, found) in next {
            open.extend(cases);
            if let Some(found) = found {
                bounds.after_case(found);
            }
        }
    }
    bounds.round();
    None
}

/// The problem that all cases share.
struct Split<'g> {
    ground: &'g Ground<'g>,
    formula: &'g Formula,
    softs: Vec<(i32, u64)>,
    /// The cost of all soft literals that can be true, plus the constant cost.
    most: u64,
    propagator: Propagator,
    /// For each variable: the weight that is lost if the variable is true, and if it is false.
    lost: Vec<[u64; 2]>,
}

impl<'g> Split<'g> {
    fn new(
        ground: &'g Ground<'g>,
        formula: &'g Formula,
        softs: Vec<(i32, u64)>,
        together: u64,
    ) -> Split<'g> {
        let mut propagator = Propagator::default();
        formula.since(0).for_each(|clause| propagator.add(clause));
        propagator.retract_to(0);
        let mut lost = vec![[0, 0]; ground.clauses.variables + 1];
        let mut most = together;
        for &(literal, weight) in &softs {
            lost[literal.unsigned_abs() as usize][usize::from(literal > 0)] += weight;
            most -= if propagator.value(literal) == -1 { weight } else { 0 };
        }
        Split { ground, formula, softs, most, propagator, lost }
    }

    /// The soft literals to which the trail has assigned no value.
    fn unassigned(&self, trail: &Propagator) -> Vec<(i32, u64)> {
        let open = |soft: &&(i32, u64)| trail.value(soft.0) == 0;
        self.softs.iter().filter(open).copied().collect()
    }

    /// The weight of the soft literals that are false if these literals are true.
    fn lost_weight(&self, literals: &[i32]) -> u64 {
        let each = |&l: &i32| self.lost[l.unsigned_abs() as usize][usize::from(l < 0)];
        literals.iter().map(each).sum()
    }

    /// The bound that remains of `most` if `literal` is also assumed: 0 if it contradicts the trail.
    fn remaining_bound(&self, trail: &mut Propagator, literal: i32, most: u64) -> u64 {
        let (level, known) = (trail.level(), trail.length());
        if trail.assume(literal).is_some() {
            return 0;
        }
        let left = most - self.lost_weight(trail.since(known));
        trail.retract_to(level);
        left
    }

    /// The bits to which the trail has assigned no value. Those whose two values both lower the bound most come first.
    fn ranked(&self, trail: &mut Propagator, bits: &[i32], most: u64) -> Vec<Ranked> {
        let mut ranked: Vec<Ranked> = Vec::with_capacity(bits.len());
        for &bit in bits {
            if trail.value(bit) == 0 {
                let left = [bit, -bit].map(|literal| self.remaining_bound(trail, literal, most));
                let [one, other] = left.map(|left| u128::from(most - left + most / 1000));
                ranked.push((Reverse(one * other), bit, left));
            }
        }
        ranked.sort_unstable();
        ranked
    }

    fn best(&self, trail: &mut Propagator, bits: &[i32], most: u64) -> Option<(i32, [u64; 2])> {
        self.ranked(trail, bits, most).into_iter().next().map(|(_, bit, left)| (bit, left))
    }

    /// The bits that are examined in every case: those that lower the bound of the whole problem most.
    fn candidates(&self) -> Vec<i32> {
        let bits: Vec<i32> = self.ground.clauses.inputs().collect();
        let ranked = self.ranked(&mut self.propagator.clone(), &bits, self.most);
        ranked.into_iter().take(CANDIDATES).map(|(_, bit, _)| bit).collect()
    }

    /// The bound if, bit by bit, the value that leaves the higher bound is taken, as long as this lowers the bound.
    fn largest_cost(&self, candidates: &[i32]) -> u64 {
        let mut trail = self.propagator.clone();
        let mut most = self.most;
        while let Some((bit, [one, other])) = self.best(&mut trail, candidates, most) {
            let (literal, left) = if one >= other { (bit, one) } else { (-bit, other) };
            if left > most - most / 200 || trail.assume(literal).is_some() {
                break;
            }
            most = left;
        }
        most
    }

    /// A case that probably contains a long scan: bit by bit, the value for which slices leave the higher bound is
    /// taken, as long as this lowers the bound. The trail then holds its literals. Also returns the cost of all its
    /// soft literals.
    fn promising(&self, trail: &mut Propagator, candidates: &[i32]) -> (Case, u64) {
        let mut case = Case { literals: Vec::new(), upper: self.most, state: CaseState::New };
        let mut most = self.most;
        while let Some((bit, lefts)) = self.best(trail, candidates, most) {
            let mut sides = Vec::new();
            for (literal, left) in [bit, -bit].into_iter().zip(lefts) {
                let level = trail.level();
                if trail.assume(literal).is_none() {
                    let off = Slices::of(&self.unassigned(trail), trail).off;
                    sides.push((left - off, literal, left));
                    trail.retract_to(level);
                }
            }
            let Some((upper, literal, left)) = sides.into_iter().max() else { break };
            if upper > case.upper / WORTH.1 * WORTH.0 {
                break;
            }
            let _ = trail.assume(literal);
            case.literals.push(literal);
            (case.upper, most) = (upper, left);
        }
        (case, most)
    }

    /// Bounds a case; drops it if it cannot exceed the best scan found, otherwise searches or splits it.
    fn next<'a>(
        &self,
        case: Case,
        candidates: &[i32],
        known: &Bounds<'a>,
        limits: &'a Limits<'a>,
    ) -> CaseOutcome<'a> {
        let mut trail = self.propagator.clone();
        if case.literals.iter().any(|&literal| trail.require(literal).is_some()) {
            return (Vec::new(), None);
        }
        let most = self.most - self.lost_weight(trail.since(self.propagator.length()));
        let off = Slices::of(&self.unassigned(&trail), &mut trail).off;
        let case = Case { upper: case.upper.min(most - off), ..case };
        if case.upper <= known.lower() {
            return (Vec::new(), None);
        }
        let best = self.best(&mut trail, candidates, most);
        let is_far = case.upper > known.lower() * FAR;
        let is_worth_it = |left: &[u64; 2]| left.iter().all(|&one| one < most / WORTH.1 * WORTH.0);
        let is_split =
            |left: &[u64; 2]| case.state == CaseState::Searched || is_far && is_worth_it(left);
        if let Some((bit, left)) = best.filter(|(_, left)| is_split(left)) {
            let part = |(literal, left): (i32, u64)| {
                let literals = case.literals.iter().copied().chain([literal]).collect();
                Case { literals, upper: case.upper.min(left), state: CaseState::New }
            };
            return ([bit, -bit].into_iter().zip(left).map(part).collect(), None);
        }
        let decisions = best.is_some().then_some(self.ground.sizes.decisions);
        let (is_open, found) = self.search(&case, &mut trail, most, decisions, known, limits);
        let state = if best.is_some() { CaseState::Searched } else { CaseState::Ended };
        let left = Case { upper: found.upper(), state, ..case };
        (is_open.then_some(left).into_iter().collect(), Some(found))
    }

    /// Searches a case whose literals are on the trail and whose soft literals cost at most this much. Returns whether
    /// it remains open, and its bounds.
    fn search<'a>(
        &self,
        case: &Case,
        trail: &mut Propagator,
        most: u64,
        decisions: Option<u64>,
        known: &Bounds<'a>,
        limits: &'a Limits<'a>,
    ) -> (bool, Bounds<'a>) {
        let softs = self.unassigned(trail);
        let slices = Slices::of(&softs, trail);
        let value = |literal: i32| trail.value(literal);
        let fixed: Vec<i8> = [0].into_iter().chain(self.formula.variables().map(value)).collect();
        let mut bounds = known.of_case(limits, most);
        bounds.record_upper(case.upper.max(bounds.lower()));
        let mut objective = self.ground.objective(self.formula.under(value), &softs, &mut bounds);
        slices.take(&softs, &mut objective);
        bounds.falsified(objective.take_falsified());
        let possible = self.ground.search(objective, &fixed, decisions, &mut bounds);
        (possible && !bounds.exact(), bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::super::ground::Sizes;
    use super::super::{SIZES, search_from};
    use crate::testing::{Builder, Dice, sound};
    use crate::{Limits, bounds::Bounds, problem::Problem};
    use scanbound_model::{Assignment, Lit, ScanModel};

    /// Charts of three steps each, one of which is active; the first chart contains the others. `is_off` says that a
    /// constraint keeps the first of the three inputs off. Also returns the largest cost of a scan.
    fn charts(seed: u64, inner: usize, is_off: bool) -> (ScanModel, u64) {
        let mut dice = Dice(seed);
        let mut b = Builder::default();
        let charts: Vec<Vec<Lit>> =
            (0..=inner).map(|_| (0..3).map(|_| b.bit()).collect()).collect();
        let inputs: Vec<Lit> = (0..3).map(|_| b.bit()).collect();
        b.model.constraints.extend(is_off.then_some(!inputs[0]));
        for steps in &charts {
            let some = b.model.circuit.any(steps.iter().copied());
            let pairs =
                [(0, 1), (0, 2), (1, 2)].map(|(x, y)| b.model.circuit.and(steps[x], steps[y]));
            b.model.constraints.push(some);
            b.model.constraints.extend(pairs.map(|both| !both));
        }
        for (number, steps) in charts.iter().enumerate() {
            // The outer chart, or one that a step of the outer chart calls.
            let called = if number == 0 { Lit::TRUE } else { charts[0][dice.below(3) as usize] };
            for &step in steps {
                for _ in 0..1 + dice.below(4) {
                    let input = inputs[dice.below(3) as usize];
                    let input = if dice.one_in(2) { !input } else { input };
                    let runs = b.model.circuit.and(called, step);
                    b.charge(runs, input, 1 + dice.below(60), dice.below(20));
                }
            }
        }
        let mut most = 0;
        let states = 0..3_usize.pow(1 + inner as u32) * 8;
        for state in states.filter(|state| !is_off || state & 1 == 0) {
            let mut bits = Vec::new();
            let mut rest = state / 8;
            for _ in &charts {
                bits.extend((0..3).map(|step| u16::from(step == rest % 3)));
                rest /= 3;
            }
            bits.extend((0..3).map(|input| (state >> input & 1) as u16));
            let values = b.model.circuit.evaluate(&Assignment(bits));
            most = most.max(b.model.charges.iter().map(|charge| charge.cost(&values).0).sum());
        }
        (b.model, most)
    }

    #[test]
    fn charts_cost_what_their_most_expensive_state_does() {
        let mut by_case = 0;
        for seed in 0..60 {
            let (model, most) = charts(seed, 2 + seed as usize % 4, seed % 3 == 0);
            let group = Builder { model: model.clone() }.group();
            let problem = Problem::new(&model, &group);
            let constant: u64 = (0..model.charges.len())
                .filter(|charge| !group.charges.contains(charge))
                .map(|charge| model.charges[charge].on.0)
                .sum();
            // Also with searches that are abandoned immediately, so that cases are split.
            for decisions in [0, 5, 400_000] {
                let limits = Limits { trace: true, ..Limits::default() };
                let mut bounds = Bounds::new(&problem, &limits);
                let sizes = Sizes { smallest: 30, least: 0, decisions, ..SIZES };
                search_from(sizes, &problem, &mut bounds);
                let found = bounds.finish();
                sound(&model, &group, &found);
                assert_eq!(found.upper.0 + constant, most, "seed {seed}");
                assert_eq!(found.upper, found.lower, "seed {seed}");
                by_case += usize::from(found.trace.steps.contains(&super::Step::Cases));
            }
        }
        assert!(by_case > 100, "{by_case}");
    }

    #[test]
    fn constraints_that_contradict_each_other_leave_no_scan() {
        for seed in 0..20 {
            let (mut model, _) = charts(seed, 3, false);
            // The first constraint is that some step of the first chart is active.
            let some = model.constraints[0];
            model.constraints.push(!some);
            let group = Builder { model: model.clone() }.group();
            let problem = Problem::new(&model, &group);
            let limits = Limits::default();
            let mut bounds = Bounds::new(&problem, &limits);
            search_from(Sizes { smallest: 30, least: 0, ..SIZES }, &problem, &mut bounds);
            let found = bounds.finish();
            sound(&model, &group, &found);
            assert!(!found.feasible, "seed {seed}");
        }
    }
}
