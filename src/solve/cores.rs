//! Core-guided search: pay for what cannot hold together until the rest can, part by part of the program.
//!
//! Every guard is a wish with a weight. Wishes that cannot all hold are a *core*: one of them fails, so the
//! bound falls by the least of their weights, and is taken off each; that no further one of them fails becomes a
//! new wish of that weight (a counter's output). When all wishes that are left can hold together, the bound is
//! met. This is the OLL scheme of MaxSAT solvers, heavier wishes first.
//!
//! What is special to ladder programs: nearly all conflicts are local. So the search first looks at small parts
//! of the program by themselves, as they follow each other in the order of execution, each with a small solver
//! of its own, and leaves to larger and larger parts only what is left. A part's clauses are some of the whole's,
//! so its cores are the whole's cores. In between, `mine` takes what ties the whole together: modes and run flags.

mod mine;

use super::bounds::Bounds;
use super::clauses::Clauses;
use super::formula::Formula;
use super::oracle::Oracle;
use super::problem::Problem;
use super::totalizer::Totalizer;
use crate::model::VarId;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;

/// The smallest parts have so many variables.
const SMALLEST: usize = 100;

/// Each round's parts are so many times larger than the last round's.
const GROWTH: usize = 4;

/// So many bits are tried either way when the parts' values are taken together.
const MODES: usize = 16;

/// So many rounds go by before the search looks at the whole for what propagation shows. Until then it goes
/// down in weight step by step; after that little is left, and the parts are asked for all their wishes at once.
const FINE: usize = 2;

/// Steps beyond the assumptions that may be spent on finding out whether a core does without a wish, or
/// whether a second one of its wishes must fail. Nearly always a few settle it.
const SMALL_EFFORT: u64 = 30;

/// A step down in weight takes in wishes until there are so many times more of them than different weights,
/// or one is so many times lighter than the first.
const DIVERSITY: usize = 2;

/// Searches until the bounds meet or the limits end it.
pub fn search(problem: &Problem, bounds: &mut Bounds<'_>) {
    search_from(SMALLEST, problem, bounds);
}

/// The same with smallest parts of this size.
fn search_from(smallest: usize, problem: &Problem, bounds: &mut Bounds<'_>) {
    let clauses = Clauses::new(problem);
    let mut search = Search {
        problem,
        clauses: &clauses,
        formula: Formula::new(&clauses),
        oracle: Oracle::new(bounds.limits()),
        weights: vec![0; 2 * clauses.variables + 2],
        wishes: Vec::new(),
        counters: Vec::new(),
        counted: FxHashMap::default(),
        unpaid: Vec::new(),
        lost: 0,
        values: vec![false; clauses.variables + 1],
        modes: clauses.busiest_bits(MODES),
        contradiction: false,
        bounds,
    };
    for (item, &guard) in problem.items.iter().zip(&clauses.items) {
        search.wish(guard, item.weight);
    }
    let whole = clauses.variables + 1;
    let mut size = smallest;
    for round in 0.. {
        if search.done() {
            return;
        }
        if round == FINE {
            search.mine();
        }
        // A round just below the whole would cost as much.
        size = if size < whole / 2 { size } else { whole };
        search.round(size, whole, round < FINE);
        if size == whole {
            return;
        }
        search.combine();
        size *= GROWTH;
    }
}

struct Search<'a, 'b> {
    problem: &'a Problem,
    clauses: &'a Clauses,
    bounds: &'a mut Bounds<'b>,
    formula: Formula,
    /// Knows the part at work.
    oracle: Oracle<'b>,
    /// By literal: what is lost if it does not hold. Of a literal and its negation, one has none.
    weights: Vec<u64>,
    /// The literals of the part at work that have weights, and maybe others.
    wishes: Vec<i32>,
    counters: Vec<Totalizer>,
    /// Of a wish that is a counter's output, negated: the counter and the count.
    counted: FxHashMap<i32, (usize, usize)>,
    /// Cores that have been taken off the weights, and what of each was; their new wishes are still to come.
    unpaid: Vec<(Vec<i32>, u64)>,
    /// What all cores cost.
    lost: u64,
    /// Of the circuit's variables: the values in the last scan found for their part.
    values: Vec<bool>,
    /// The bits that most clauses ask for.
    modes: Vec<VarId>,
    /// The constraints exclude each other.
    contradiction: bool,
}

fn place(literal: i32) -> usize {
    2 * literal.unsigned_abs() as usize + usize::from(literal < 0)
}

impl Search<'_, '_> {
    fn done(&self) -> bool {
        self.contradiction || self.bounds.exact() || self.bounds.limits().reached()
    }

    /// Goes through all parts of a size, weight by weight if `fine`.
    fn round(&mut self, size: usize, whole: usize, fine: bool) {
        let parts = whole.div_ceil(size);
        let mut wishes = vec![Vec::new(); parts];
        for literal in self.all_wishes() {
            wishes[self.formula.home(literal) / size].push(literal);
        }
        let clauses = self.formula.parts(size, parts);
        for (part, (wishes, clauses)) in wishes.into_iter().zip(clauses).enumerate() {
            self.start_apart();
            self.formula.teach(&clauses, &mut self.oracle);
            self.wishes = wishes;
            self.part(part * size..((part + 1) * size).min(whole), parts == 1, fine);
            if self.done() {
                return;
            }
        }
    }

    /// Pays for cores of one part until all its wishes can hold together.
    fn part(&mut self, homes: std::ops::Range<usize>, whole: bool, fine: bool) {
        let heaviest = self.wanted(0).first().map_or(0, |&wish| self.weight(wish));
        let mut least = if fine { heaviest } else { 1 };
        loop {
            self.bounds.count();
            let wanted = self.wanted(least);
            match self.oracle.ask(&wanted, u64::MAX) {
                None => return,
                Some(false) => {
                    let core = self.oracle.core();
                    self.contradiction = core.is_empty();
                    if self.contradiction {
                        return;
                    }
                    let core = self.minimised(core);
                    self.pay(core);
                }
                Some(true) => {
                    if whole {
                        self.found();
                    }
                    if self.unpaid.is_empty() {
                        let Some(next) = self.lighter(least) else { break };
                        least = next;
                    }
                    for (core, weight) in std::mem::take(&mut self.unpaid) {
                        self.relax(&core, weight, SMALL_EFFORT);
                    }
                }
            }
            if self.done() {
                return;
            }
        }
        for home in homes {
            // The circuit's variables are their own homes.
            let variable = i32::try_from(home).expect("variables are counted in 31 bits");
            self.values[home] = self.oracle.holds(variable);
        }
    }

    /// Takes the parts' best values together: seldom the best of the whole, but a scan. Modes that the parts
    /// disagree on are tried either way.
    fn combine(&mut self) {
        let values = &self.values;
        let holds = |literal: i32| values[literal.unsigned_abs() as usize] == (literal > 0);
        let mut best = self.clauses.assignment(self.problem, holds);
        let mut most = self.problem.cost(&best);
        for &mode in &self.modes {
            let value = &mut best.0[mode.0 as usize];
            *value ^= 1;
            let cost = self.problem.cost(&best);
            if cost > most {
                most = cost;
            } else {
                best.0[mode.0 as usize] ^= 1;
            }
        }
        self.bounds.found(best);
    }

    /// Begins with a solver that knows nothing.
    fn start_apart(&mut self) {
        self.oracle = Oracle::new(self.bounds.limits());
        self.wishes = Vec::new();
    }

    /// All literals that have weights.
    fn all_wishes(&self) -> impl Iterator<Item = i32> {
        let literals = self.formula.variables().flat_map(|variable| [variable, -variable]);
        literals.filter(|&literal| self.weight(literal) > 0)
    }

    fn weight(&self, literal: i32) -> u64 {
        self.weights.get(place(literal)).copied().unwrap_or(0)
    }

    /// That a literal holds is worth so much more.
    fn wish(&mut self, literal: i32, weight: u64) {
        let against = self.weight(-literal).min(weight);
        if against > 0 {
            // One of the two fails.
            self.weights[place(-literal)] -= against;
            self.lose(against);
        }
        if weight > against {
            if self.weights.len() <= place(-literal).max(place(literal)) {
                self.weights.resize(place(literal).max(place(-literal)) + 1, 0);
            }
            self.weights[place(literal)] += weight - against;
            self.wishes.push(literal);
        }
    }

    fn lose(&mut self, weight: u64) {
        self.lost += weight;
        self.bounds.proved(self.problem.naive() - self.lost);
    }

    /// The wishes of at least this weight, the heaviest first.
    fn wanted(&mut self, least: u64) -> Vec<i32> {
        let weights = &self.weights;
        let weight = |literal: i32| weights[place(literal)];
        self.wishes.retain(|&literal| weight(literal) > 0);
        self.wishes.sort_unstable_by_key(|&l| (Reverse(weight(l)), l.unsigned_abs(), l));
        self.wishes.dedup();
        self.wishes.iter().copied().take_while(|&literal| weight(literal) >= least).collect()
    }

    /// The next lower weight from which wishes are wanted.
    fn lighter(&self, least: u64) -> Option<u64> {
        let rest = self.wishes.iter().map(|&wish| self.weight(wish)).filter(|&w| w < least);
        let mut next = None;
        let (mut wishes, mut kinds) = (0, 0);
        let mut first = 0;
        for weight in rest {
            wishes += 1;
            if next != Some(weight) {
                kinds += 1;
            }
            if next.is_none() {
                first = weight;
            }
            next = Some(weight);
            if wishes > DIVERSITY * kinds || weight < first / DIVERSITY as u64 {
                break;
            }
        }
        next
    }

    /// A model of the whole. A wish that is worth more than the bounds are apart holds in every better one.
    fn found(&mut self) {
        let oracle = &self.oracle;
        self.bounds.found(self.clauses.assignment(self.problem, |literal| oracle.holds(literal)));
        let gap = self.problem.naive() - self.lost - self.bounds.lower();
        for wish in self.wanted(gap + 1) {
            self.weights[place(wish)] = 0;
            self.formula.add(wish, vec![wish], &mut self.oracle);
        }
    }

    /// As few of a core's wishes as a small effort shows to exclude each other.
    fn minimised(&mut self, mut core: Vec<i32>) -> Vec<i32> {
        // The lightest are tried first: without them the core costs more.
        core.sort_unstable_by_key(|&l| (Reverse(self.weight(l)), l.unsigned_abs(), l));
        let mut at = core.len();
        while at > 0 && core.len() > 1 {
            at -= 1;
            let mut rest = core.clone();
            rest.remove(at);
            if self.oracle.ask(&rest, rest.len() as u64 + SMALL_EFFORT) == Some(false) {
                let smaller = self.oracle.core();
                core.retain(|literal| smaller.contains(literal));
                at = at.min(core.len());
            }
        }
        core
    }

    /// Takes a core's least weight off its wishes.
    fn pay(&mut self, core: Vec<i32>) {
        let weight = core.iter().map(|&literal| self.weight(literal)).min().unwrap_or(0);
        for &literal in &core {
            self.weights[place(literal)] -= weight;
        }
        self.lose(weight);
        self.unpaid.push((core, weight));
    }

    /// The new wishes of a core that was paid. `effort` steps may be spent on finding out how many of the old
    /// ones must fail.
    fn relax(&mut self, core: &[i32], weight: u64, effort: u64) {
        for literal in core {
            if let Some(&(counter, count)) = self.counted.get(literal) {
                self.wish_at_most(counter, count, weight);
            }
        }
        let failed: Vec<i32> = core.iter().map(|literal| -literal).collect();
        self.formula.add(core[0], failed.clone(), &mut self.oracle);
        if core.len() == 1 {
            return;
        }
        let counter = self.counters.len();
        self.counters.push(Totalizer::new(&failed, self.formula.home(core[0])));
        // At least one fails; perhaps it is easy to see that more do.
        let mut fails = 1;
        while effort > 0 && fails < core.len() {
            let more = self.output(counter, fails + 1);
            if self.oracle.ask(&[-more], effort) != Some(false) {
                break;
            }
            self.formula.add(more, vec![more], &mut self.oracle);
            self.lose(weight);
            fails += 1;
        }
        self.wish_at_most(counter, fails, weight);
    }

    /// That no more than `count` of a counter's inputs are true is worth so much.
    fn wish_at_most(&mut self, counter: usize, count: usize, weight: u64) {
        if count < self.counters[counter].size() {
            let more = self.output(counter, count + 1);
            self.counted.insert(-more, (counter, count + 1));
            self.wish(-more, weight);
        }
    }

    fn output(&mut self, counter: usize, count: usize) -> i32 {
        self.counters[counter].output(count, &mut self.formula, &mut self.oracle)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Builder, brute, random};
    use super::super::{Limits, Maximum};
    use super::*;
    use crate::solve::testing::sound;

    #[test]
    fn small_parts_change_nothing() {
        for seed in 1000..1060 {
            let model = random(seed, 10 + seed % 30);
            let group = Builder { model: model.clone() }.group();
            let problem = Problem::new(&model, &group);
            let truth = brute(&model, &group).unwrap();
            for smallest in [1, 3, 10] {
                let limits = Limits::default();
                let mut bounds = Bounds::new(&problem, &limits);
                search_from(smallest, &problem, &mut bounds);
                let found: Maximum = bounds.finish();
                sound(&model, &group, &found);
                assert_eq!((found.lower, found.upper), (truth, truth), "seed {seed}");
            }
        }
    }
}
