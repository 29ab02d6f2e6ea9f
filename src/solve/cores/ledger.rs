//! What is paid and what is still wished for, in picoseconds.

use crate::solve::formula::Formula;
use crate::solve::totalizer::Totalizer;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// A step down in weight takes in wishes until there are so many times more of them than different weights,
/// or one is so many times lighter than the first.
const DIVERSITY: usize = 2;

/// A wish's place among the others: the heaviest first, then by variable.
type Rank = (Reverse<u64>, u32, i32);

fn rank(literal: i32, weight: u64) -> Rank {
    (Reverse(weight), literal.unsigned_abs(), literal)
}

/// The wishes, literals that are worth something if they hold, and the clauses that tie them together.
///
/// It can be split into parts of the program, which are worked on independently, and joined again.
pub struct Ledger {
    /// The clauses so far.
    pub formula: Formula,
    /// So many variables are the circuit's, and their own homes.
    circuit: usize,
    /// What is lost if a literal does not hold. Of a literal and its negation, one has no weight.
    weights: FxHashMap<i32, u64>,
    /// The literals that have weights.
    order: BTreeSet<Rank>,
    counters: Vec<Totalizer>,
    /// Of a wish that is a counter's output, negated: the counter and the count.
    counted: BTreeMap<i32, (usize, usize)>,
    /// What was lost since this was last asked.
    lost: u64,
}

impl Ledger {
    /// No wishes yet.
    pub fn new(formula: Formula, circuit: usize) -> Ledger {
        Ledger {
            formula,
            circuit,
            weights: FxHashMap::default(),
            order: BTreeSet::new(),
            counters: Vec::new(),
            counted: BTreeMap::new(),
            lost: 0,
        }
    }

    /// What was lost since this was last asked: the bound falls by it.
    pub fn take_lost(&mut self) -> u64 {
        std::mem::take(&mut self.lost)
    }

    /// What is lost if the literal does not hold.
    pub fn weight(&self, literal: i32) -> u64 {
        self.weights.get(&literal).copied().unwrap_or(0)
    }

    /// The wishes of at least this weight, the heaviest first.
    pub fn wishes(&self, least: u64) -> impl Iterator<Item = (i32, u64)> {
        let wishes = self.order.iter().map(|&(Reverse(weight), _, literal)| (literal, weight));
        wishes.take_while(move |&(_, weight)| weight >= least)
    }

    /// The next step down in weight: the least weight of the wishes that are looked at then. `None` if no wish is
    /// lighter than `least`.
    pub fn lighter(&self, least: u64) -> Option<u64> {
        let below = (Reverse(least.checked_sub(1)?), 0, i32::MIN);
        let weights = || self.order.range(below..).map(|&(Reverse(weight), ..)| weight);
        let first = weights().next()?;
        let (mut wishes, mut different, mut last) = (0, 0, None);
        for weight in weights() {
            wishes += 1;
            different += usize::from(last != Some(weight));
            last = Some(weight);
            if wishes > DIVERSITY * different || weight < first / DIVERSITY as u64 {
                break;
            }
        }
        last
    }

    fn set_weight(&mut self, literal: i32, weight: u64) {
        let old = match weight {
            0 => self.weights.remove(&literal),
            _ => self.weights.insert(literal, weight),
        };
        if let Some(old) = old {
            self.order.remove(&rank(literal, old));
        }
        if weight > 0 {
            self.order.insert(rank(literal, weight));
        }
    }

    /// A literal is worth so much more if it holds.
    pub fn wish(&mut self, literal: i32, weight: u64) {
        let opposite = self.weight(-literal);
        let against = opposite.min(weight);
        if against > 0 {
            // One of the two fails.
            self.set_weight(-literal, opposite - against);
            self.lost += against;
        }
        if weight > against {
            self.set_weight(literal, self.weight(literal) + weight - against);
        }
    }

    /// A wish that holds in every scan that is still of interest.
    pub fn grant(&mut self, literal: i32) {
        self.set_weight(literal, 0);
        self.formula.add(self.home(literal), &[literal]);
    }

    /// Takes the least weight of a core's wishes off each of them, and answers with it.
    pub fn pay(&mut self, core: &[i32]) -> u64 {
        let weight = core.iter().map(|&literal| self.weight(literal)).min().unwrap_or(0);
        for &literal in core {
            self.set_weight(literal, self.weight(literal) - weight);
        }
        self.lost += weight;
        weight
    }

    /// Adds the new wishes of a core for which `weight` was paid: that no further of the old ones fails. `forced` may
    /// know that a literal cannot hold, which tells that more of them must fail. The answer is the literals whose
    /// weight grew.
    pub fn relax(
        &mut self,
        core: &[i32],
        weight: u64,
        mut forced: impl FnMut(&Formula, i32) -> bool,
    ) -> Vec<i32> {
        let mut grown = Vec::new();
        for literal in core {
            if let Some(&(counter, count)) = self.counted.get(literal) {
                grown.extend(self.wish_at_most(counter, count, weight));
            }
        }
        let home = self.home(core[0]);
        let failed: Vec<i32> = core.iter().map(|literal| -literal).collect();
        self.formula.add(home, &failed);
        if core.len() == 1 {
            return grown;
        }
        let counter = self.counters.len();
        self.counters.push(Totalizer::new(&failed, home));
        // At least one fails; perhaps it is easy to see that more do.
        let mut fails = 1;
        while fails < core.len() {
            let more = self.counters[counter].output(fails + 1, &mut self.formula);
            if !forced(&self.formula, -more) {
                break;
            }
            self.formula.add(home, &[more]);
            self.lost += weight;
            fails += 1;
        }
        grown.extend(self.wish_at_most(counter, fails, weight));
        grown
    }

    /// That no more than `count` of a counter's inputs are true is worth so much more. The answer is the literal that
    /// says so; `None` if there are no more inputs.
    fn wish_at_most(&mut self, counter: usize, count: usize, weight: u64) -> Option<i32> {
        if count >= self.counters[counter].size() {
            return None;
        }
        let more = self.counters[counter].output(count + 1, &mut self.formula);
        self.counted.insert(-more, (counter, count + 1));
        self.wish(-more, weight);
        Some(-more)
    }

    /// Where in the circuit a wish belongs.
    fn home(&self, literal: i32) -> usize {
        let variable = literal.unsigned_abs() as usize;
        if variable <= self.circuit {
            return variable;
        }
        self.counters[self.counted[&literal].0].home()
    }

    /// The ledgers of the parts of the program, each of `size` homes; no wish and no clause stays here.
    pub fn split(&mut self, size: usize, parts: usize) -> Vec<Ledger> {
        let formulas = self.formula.split(size, parts);
        let mut split: Vec<Ledger> =
            formulas.into_iter().map(|formula| Ledger::new(formula, self.circuit)).collect();
        for &(Reverse(weight), _, literal) in &self.order {
            split[self.home(literal) / size].set_weight(literal, weight);
        }
        // Where each counter went.
        let mut places = Vec::with_capacity(self.counters.len());
        for counter in std::mem::take(&mut self.counters) {
            let part = counter.home() / size;
            places.push((part, split[part].counters.len()));
            split[part].counters.push(counter);
        }
        for (literal, (counter, count)) in std::mem::take(&mut self.counted) {
            let (part, counter) = places[counter];
            split[part].counted.insert(literal, (counter, count));
        }
        self.weights.clear();
        self.order.clear();
        split
    }

    /// Takes the parts back in their order.
    pub fn join(&mut self, parts: impl IntoIterator<Item = Ledger>) {
        let shared = self.formula.variable_count();
        let mut order = Vec::new();
        for part in parts {
            let renumber = self.formula.renumber(shared);
            self.formula.join(&part.formula, &renumber);
            self.lost += part.lost;
            order.extend(
                part.order
                    .into_iter()
                    .map(|(Reverse(weight), _, literal)| rank(renumber.of(literal), weight)),
            );
            let before = self.counters.len();
            self.counters.extend(part.counters.into_iter().map(|mut counter| {
                counter.renumber(&renumber);
                counter
            }));
            for (literal, (counter, count)) in part.counted {
                self.counted.insert(renumber.of(literal), (before + counter, count));
            }
        }
        self.weights =
            order.iter().map(|&(Reverse(weight), _, literal)| (literal, weight)).collect();
        self.order = order.into_iter().collect();
    }
}
