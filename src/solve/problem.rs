//! A group's question in normal form: a constant and a sum of weighted guards over a circuit of its own.

use crate::base::time::Picos;
use crate::scan::model::Group;
use crate::scan::model::{Assignment, Circuit, Lit, Node, ScanModel, VarId};
use rustc_hash::{FxHashMap, FxHashSet};

/// A guard and what it adds to the sum when it is true.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// The guard, in the problem's circuit; never constant.
    pub guard: Lit,
    /// What it adds, in picoseconds; never zero.
    pub weight: u64,
    /// The charges it stands for, indices into `ScanModel::charges`, ascending.
    pub charges: Vec<usize>,
}

/// Find an assignment that makes every `hard` literal true and the sum of the weights of the true guards
/// largest. The group's maximum is that sum and the constant.
#[derive(Debug, Clone, Default)]
pub struct Problem {
    /// What the group's guards and constraints depend on, and nothing else, over variables of its own: `variables`
    /// says which each is in the model.
    pub circuit: Circuit,
    /// What every assignment costs, in picoseconds.
    pub constant: u64,
    /// What is taken off again: items hold counted units also where none is handled.
    pub deducted: u64,
    /// Distinct guards, none the negation of another, in order of their first charge.
    pub items: Vec<Item>,
    /// What must hold; never constant true.
    pub hard: Vec<Lit>,
    /// The model's variables that these are, ascending.
    pub variables: Vec<VarId>,
}

impl Problem {
    /// The normal form of a group.
    ///
    /// A charge with times `on` and `off` costs `off` where it is reached and `on - off` more where it fires;
    /// with `on < off`, it costs `on` where it is reached and `off - on` more where it is reached and does not
    /// fire. Counted units that are not handled are taken off. Equal guards are one item. Of a guard and its negation one is always true, so the lesser weight
    /// goes to the constant.
    #[must_use]
    pub fn new(model: &ScanModel, group: &Group) -> Problem {
        Problem::build(model, group, true)
    }

    /// The same with an item for every guard, also for one that is the negation of another.
    #[must_use]
    pub fn with_negations(model: &ScanModel, group: &Group) -> Problem {
        Problem::build(model, group, false)
    }

    fn build(model: &ScanModel, group: &Group, cancel: bool) -> Problem {
        let mut problem = Problem::default();
        let mut cone = Cone::new(&model.circuit);
        let mut terms = Vec::new();
        for &index in &group.charges {
            let charge = &model.charges[index];
            let reached = cone.copy(&mut problem.circuit, charge.reached);
            // What decides nothing belongs to other groups: a search's values for it would overwrite theirs.
            let fires = match charge.fires_matters() {
                true => cone.copy(&mut problem.circuit, charge.fires),
                false => Lit::FALSE,
            };
            let (Picos(base), units) = charge.fired();
            let (mut on, Picos(off)) = (base, charge.off);
            for &(handled, Picos(more)) in units {
                // Charged with all its units where it fires, so that charges that exclude each other do so once, and
                // not by every unit; what is missing is taken off again.
                let handled = cone.copy(&mut problem.circuit, handled);
                let missing = problem.circuit.and(fires, !handled);
                on = sum(on, more);
                problem.deducted = sum(problem.deducted, more);
                terms.push((!missing, more, index));
            }
            terms.push((reached, on.min(off), index));
            if on > off {
                terms.push((fires, on - off, index));
            } else if off > on {
                let idle = problem.circuit.and(reached, !fires);
                terms.push((idle, off - on, index));
            }
        }
        let mut known = FxHashSet::default();
        for &index in &group.constraints {
            let lit = cone.copy(&mut problem.circuit, model.constraints[index]);
            if lit != Lit::TRUE && known.insert(lit) {
                problem.hard.push(lit);
            }
        }
        problem.collect(terms, cancel);
        problem.number();
        problem
    }

    /// Numbers the variables from 0, in the model's order: what a search keeps of them is as small as the group.
    fn number(&mut self) {
        let atoms = self.circuit.nodes().iter().filter_map(|node| match node {
            Node::Atom(atom) => Some(atom.variable()),
            _ => None,
        });
        let mut variables: Vec<VarId> = atoms.collect();
        variables.sort_unstable();
        variables.dedup();
        let numbers: FxHashMap<VarId, VarId> =
            variables.iter().copied().zip((0..).map(VarId)).collect();
        self.circuit.renumber(|variable| numbers[&variable]);
        self.variables = variables;
    }

    /// The model's variable that one of this problem's is.
    #[must_use]
    pub fn variable(&self, own: VarId) -> VarId {
        self.variables[own.0 as usize]
    }

    /// What an assignment of the model's variables says of this problem's.
    #[must_use]
    pub fn own(&self, all: &Assignment) -> Assignment {
        Assignment(self.variables.iter().map(|variable| all.0[variable.0 as usize]).collect())
    }

    fn collect(&mut self, terms: Vec<(Lit, u64, usize)>, cancel: bool) {
        // Per node: the weights of the node and of its negation, and the charges of each.
        let mut place: FxHashMap<usize, usize> = FxHashMap::default();
        let mut sums: Vec<(usize, [u64; 2], [Vec<usize>; 2])> = Vec::new();
        for (guard, weight, charge) in terms {
            if guard == Lit::FALSE || weight == 0 {
                continue;
            }
            if guard == Lit::TRUE {
                self.constant = sum(self.constant, weight);
                continue;
            }
            let at = *place.entry(guard.node()).or_insert_with(|| {
                sums.push((guard.node(), [0; 2], [Vec::new(), Vec::new()]));
                sums.len() - 1
            });
            let side = usize::from(guard.is_negated());
            sums[at].1[side] = sum(sums[at].1[side], weight);
            if sums[at].2[side].last() != Some(&charge) {
                sums[at].2[side].push(charge);
            }
        }
        for (node, weights, charges) in sums {
            let least = if cancel { weights[0].min(weights[1]) } else { 0 };
            self.constant = sum(self.constant, least);
            for (side, charges) in charges.into_iter().enumerate() {
                let weight = weights[side] - least;
                if weight > 0 {
                    let node =
                        u32::try_from(node).expect("a circuit's nodes are counted in 32 bits");
                    let guard = Lit(2 * node + u32::from(side == 1));
                    self.items.push(Item { guard, weight, charges });
                }
            }
        }
    }

    /// The constant and all weights: the bound before any search.
    #[must_use]
    pub fn naive(&self) -> u64 {
        self.total(self.items.iter().map(|item| item.weight))
    }

    /// What items of these weights cost together.
    #[must_use]
    pub fn total(&self, weights: impl Iterator<Item = u64>) -> u64 {
        // The items of an assignment are never less than what is taken off, though some of them may be.
        weights.fold(self.constant, sum).saturating_sub(self.deducted)
    }

    /// What an assignment of this problem's variables costs, or `None` if it breaks a constraint.
    #[must_use]
    pub fn cost(&self, assignment: &Assignment) -> Option<u64> {
        let values = self.circuit.evaluate(assignment);
        let holds = self.hard.iter().all(|&lit| values.get(lit));
        let held = self.items.iter().filter(|item| values.get(item.guard));
        holds.then(|| self.total(held.map(|item| item.weight)))
    }

    /// The assignment that is 0 everywhere.
    #[must_use]
    pub fn zeros(&self) -> Assignment {
        Assignment(vec![0; self.variables.len()])
    }
}

/// A checked sum of picoseconds: a bound that wraps around would be too low.
fn sum(a: u64, b: u64) -> u64 {
    (Picos(a) + Picos(b)).0
}

/// Copies parts of a circuit into another.
pub struct Cone<'a> {
    source: &'a Circuit,
    known: Known,
}

/// What nodes are in a copy: there are many small groups, and one that has most of the circuit.
enum Known {
    Few(FxHashMap<usize, Lit>),
    /// By node; [`UNKNOWN`] what is not copied.
    Many(Vec<Lit>),
}

const UNKNOWN: Lit = Lit(u32::MAX);

/// Where more than one in so many nodes of a circuit is copied, each has its place.
const MANY: usize = 32;

impl Known {
    fn get(&self, node: usize) -> Option<Lit> {
        match self {
            Known::Few(known) => known.get(&node).copied(),
            Known::Many(known) => Some(known[node]).filter(|&copied| copied != UNKNOWN),
        }
    }

    /// Notes what a node of a circuit of so many is.
    fn put(&mut self, node: usize, copied: Lit, nodes: usize) {
        match self {
            Known::Many(known) => known[node] = copied,
            Known::Few(known) => {
                known.insert(node, copied);
                if known.len() > nodes / MANY {
                    let mut many = vec![UNKNOWN; nodes];
                    known.iter().for_each(|(&node, &copied)| many[node] = copied);
                    *self = Known::Many(many);
                }
            }
        }
    }
}

impl<'a> Cone<'a> {
    /// Of a circuit; nothing is copied yet.
    pub fn new(source: &'a Circuit) -> Cone<'a> {
        Cone { source, known: Known::Few(FxHashMap::default()) }
    }

    /// Copies a literal and all that it depends on, each gate once; what it is there.
    pub fn copy(&mut self, into: &mut Circuit, lit: Lit) -> Lit {
        let mut stack = vec![lit.node()];
        while let Some(&node) = stack.last() {
            if self.known.get(node).is_some() {
                stack.pop();
                continue;
            }
            let copied = match self.source.nodes()[node] {
                Node::True => Lit::TRUE,
                Node::Atom(atom) => into.atom(atom),
                Node::And(a, b) => match (self.get(a), self.get(b)) {
                    (Some(a), Some(b)) => into.and(a, b),
                    (left, right) => {
                        // The left input first: the copy's numbering then follows the order of execution.
                        stack.extend(right.is_none().then_some(b.node()));
                        stack.extend(left.is_none().then_some(a.node()));
                        continue;
                    }
                },
            };
            self.known.put(node, copied, self.source.nodes().len());
            stack.pop();
        }
        self.get(lit).expect("the literal's node was just copied")
    }

    fn get(&self, lit: Lit) -> Option<Lit> {
        self.known.get(lit.node()).map(|copied| if lit.is_negated() { !copied } else { copied })
    }
}
