//! The reformulated objective: the soft literals that remain after cores were subtracted, with their weights in
//! picoseconds.

use crate::formula::Formula;
use crate::totalizer::Totalizer;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// A stratum ends if it has more than `DIVERSITY` times as many soft literals as different weights, or if a weight is
/// below 1/`DIVERSITY` of the stratum's first one.
const DIVERSITY: usize = 2;

/// The sort key of a soft literal: heaviest first, then by variable.
type Rank = (Reverse<u64>, u32, i32);

fn rank(literal: i32, weight: u64) -> Rank {
    (Reverse(weight), literal.unsigned_abs(), literal)
}

/// The soft literals, and the hard clauses that connect them.
///
/// It can be split into partitions of the program, which are solved independently, and joined again.
pub struct Objective {
    /// The hard clauses so far: those of the circuit, and those of relaxed cores and slices.
    pub formula: Formula,
    /// The number of the circuit's variables. Each is its own position in the order of execution.
    circuit: usize,
    /// The weight that is lost if a literal is false. Of a literal and its negation, at most one has a weight.
    weights: FxHashMap<i32, u64>,
    /// The literals with weights, sorted.
    order: BTreeSet<Rank>,
    totalizers: Vec<Totalizer>,
    /// For soft literals that are negated outputs of a totalizer: the totalizer, and the number of true inputs that the
    /// output stands for.
    counted: BTreeMap<i32, (usize, usize)>,
    /// For each soft literal that says that one member of a slice is true: its position in the order of execution.
    sliced: FxHashMap<i32, usize>,
    /// The weight that every scan loses by what was found since the last call of `take_falsified`.
    falsified: u64,
}

impl Objective {
    /// An objective without soft literals.
    pub fn new(formula: Formula, circuit: usize) -> Objective {
        Objective {
            formula,
            circuit,
            weights: FxHashMap::default(),
            order: BTreeSet::new(),
            totalizers: Vec::new(),
            counted: BTreeMap::new(),
            sliced: FxHashMap::default(),
            falsified: 0,
        }
    }

    /// The weight that every scan loses by what was found since the last call (cores, slices, literals whose negations
    /// have weights), in picoseconds. The bound falls by it.
    pub fn take_falsified(&mut self) -> u64 {
        std::mem::take(&mut self.falsified)
    }

    /// The weight that is lost if the literal is false, in picoseconds; 0 if it is no soft literal.
    pub fn weight(&self, literal: i32) -> u64 {
        self.weights.get(&literal).copied().unwrap_or(0)
    }

    /// The soft literals of at least this weight, heaviest first.
    pub fn soft_literals(&self, least: u64) -> impl Iterator<Item = (i32, u64)> {
        let all = self.order.iter().map(|&(Reverse(weight), _, literal)| (literal, weight));
        all.take_while(move |&(_, weight)| weight >= least)
    }

    /// The weight at which the stratum below `least` ends: that of its lightest soft literals. `None` if no soft
    /// literal is lighter than `least`.
    pub fn next_stratum(&self, least: u64) -> Option<u64> {
        let below = (Reverse(least.checked_sub(1)?), 0, i32::MIN);
        let weights = || self.order.range(below..).map(|&(Reverse(weight), ..)| weight);
        let first = weights().next()?;
        let (mut literals, mut different, mut last) = (0, 0, None);
        for weight in weights() {
            literals += 1;
            different += usize::from(last != Some(weight));
            last = Some(weight);
            if literals > DIVERSITY * different || weight < first / DIVERSITY as u64 {
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

    /// Adds weight to a soft literal. The common weight of a literal and its negation cancels out, because one of them
    /// is always false.
    pub fn add_soft(&mut self, literal: i32, weight: u64) {
        let opposite = self.weight(-literal);
        let against = opposite.min(weight);
        if against > 0 {
            self.set_weight(-literal, opposite - against);
            self.falsified += against;
        }
        if weight > against {
            self.set_weight(literal, self.weight(literal) + weight - against);
        }
    }

    /// Hardens a soft literal, which is true in every scan still of interest: makes it a clause.
    pub fn harden(&mut self, literal: i32) {
        self.set_weight(literal, 0);
        self.formula.add(self.position(literal), &[literal]);
    }

    /// Subtracts a core's weight (the smallest of its literals' weights) from each of its literals. Returns the weight.
    pub fn subtract_core(&mut self, core: &[i32]) -> u64 {
        let weight = core.iter().map(|&literal| self.weight(literal)).min().unwrap_or(0);
        for &literal in core {
            self.set_weight(literal, self.weight(literal) - weight);
        }
        self.falsified += weight;
        weight
    }

    /// Subtracts this weight from mutually exclusive soft literals, and adds a soft literal of this weight that says
    /// that one of them is true. Returns the new literal.
    pub fn slice(&mut self, members: &[i32], weight: u64) -> i32 {
        let position = members.iter().map(|&literal| self.position(literal)).max().unwrap_or(1);
        for &literal in members {
            self.set_weight(literal, self.weight(literal) - weight);
            self.falsified += weight;
        }
        self.falsified -= weight;
        let any = self.formula.new_variable();
        for &literal in members {
            self.formula.define(position, any, &[-literal, any]);
        }
        let clause: Vec<i32> = members.iter().copied().chain([-any]).collect();
        self.formula.define(position, any, &clause);
        self.sliced.insert(any, position);
        self.set_weight(any, weight);
        any
    }

    /// Relaxes a core whose `weight` was subtracted: adds the soft literal that no second literal of the core is false.
    /// `forced` may show that such a literal cannot be true; then the next one, for one more false literal, takes its
    /// place. Returns the soft literals to which weight was added.
    pub fn relax(
        &mut self,
        core: &[i32],
        weight: u64,
        mut forced: impl FnMut(&Formula, i32) -> bool,
    ) -> Vec<i32> {
        let mut grown = Vec::new();
        for literal in core {
            if let Some(&(totalizer, count)) = self.counted.get(literal) {
                grown.extend(self.add_at_most(totalizer, count, weight));
            }
        }
        let position = self.position(core[0]);
        let negated: Vec<i32> = core.iter().map(|literal| -literal).collect();
        self.formula.add(position, &negated);
        if core.len() == 1 {
            return grown;
        }
        let totalizer = self.totalizers.len();
        self.totalizers.push(Totalizer::new(&negated, position));
        // At least one literal is false; maybe it is easy to show that more are.
        let mut false_ones = 1;
        while false_ones < core.len() {
            let more = self.totalizers[totalizer].output(false_ones + 1, &mut self.formula);
            if !forced(&self.formula, -more) {
                break;
            }
            self.formula.add(position, &[more]);
            self.falsified += weight;
            false_ones += 1;
        }
        grown.extend(self.add_at_most(totalizer, false_ones, weight));
        grown
    }

    /// Adds the soft literal that at most `count` inputs of a totalizer are true, and returns it; `None` if it has no
    /// more inputs.
    fn add_at_most(&mut self, totalizer: usize, count: usize, weight: u64) -> Option<i32> {
        if count >= self.totalizers[totalizer].size() {
            return None;
        }
        let more = self.totalizers[totalizer].output(count + 1, &mut self.formula);
        self.counted.insert(-more, (totalizer, count + 1));
        self.add_soft(-more, weight);
        Some(-more)
    }

    /// The position of a soft literal in the order of execution; it decides to which partition the literal belongs.
    fn position(&self, literal: i32) -> usize {
        let variable = literal.unsigned_abs() as usize;
        if variable <= self.circuit {
            return variable;
        }
        match self.sliced.get(&literal) {
            Some(&position) => position,
            None => self.totalizers[self.counted[&literal].0].position(),
        }
    }

    /// Splits the objective into partitions of `size` positions. No soft literal and no clause remains here.
    pub fn split(&mut self, size: usize, partitions: usize) -> Vec<Objective> {
        let formulas = self.formula.split(size, partitions);
        let mut split: Vec<Objective> =
            formulas.into_iter().map(|formula| Objective::new(formula, self.circuit)).collect();
        for part in &mut split {
            part.sliced.clone_from(&self.sliced);
        }
        for &(Reverse(weight), _, literal) in &self.order {
            split[self.position(literal) / size].set_weight(literal, weight);
        }
        // For each totalizer, its partition and its index there.
        let mut places = Vec::with_capacity(self.totalizers.len());
        for totalizer in std::mem::take(&mut self.totalizers) {
            let partition = totalizer.position() / size;
            places.push((partition, split[partition].totalizers.len()));
            split[partition].totalizers.push(totalizer);
        }
        for (literal, (totalizer, count)) in std::mem::take(&mut self.counted) {
            let (partition, totalizer) = places[totalizer];
            split[partition].counted.insert(literal, (totalizer, count));
        }
        self.weights.clear();
        self.order.clear();
        split
    }

    /// Takes back all soft literals and clauses of the partitions, which must be in their order. Variables that they
    /// added are renumbered.
    pub fn join(&mut self, partitions: impl IntoIterator<Item = Objective>) {
        let shared = self.formula.variable_count();
        let mut order = Vec::new();
        for partition in partitions {
            let renumber = self.formula.renumber(shared);
            self.formula.join(partition.formula, &renumber);
            self.falsified += partition.falsified;
            order.extend(
                partition
                    .order
                    .into_iter()
                    .map(|(Reverse(weight), _, literal)| rank(renumber.of(literal), weight)),
            );
            let before = self.totalizers.len();
            self.totalizers.extend(partition.totalizers.into_iter().map(|mut totalizer| {
                totalizer.renumber(&renumber);
                totalizer
            }));
            for (literal, (totalizer, count)) in partition.counted {
                self.counted.insert(renumber.of(literal), (before + totalizer, count));
            }
        }
        self.weights =
            order.iter().map(|&(Reverse(weight), _, literal)| (literal, weight)).collect();
        self.order = order.into_iter().collect();
    }
}
