//! A group's question in normal form: a constant and a sum of weighted guards over a circuit of its own.

use super::cone::Cone;
use rustc_hash::{FxHashMap, FxHashSet};
use scanbound_base::time::Picos;
use scanbound_model::{Assignment, Circuit, Group, Lit, Node, ScanModel, VarId};

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

/// What a charge adds to the sum where a guard is true.
struct Term {
    guard: Lit,
    weight: u64,
    /// The charge, an index into `ScanModel::charges`.
    charge: usize,
}

/// The item of a node of the circuit, and that of its negation.
type NodeSum = [Item; 2];

impl Problem {
    /// The normal form of a group.
    ///
    /// A charge with times `on` and `off` costs `off` where it is reached and `on - off` more where it fires;
    /// with `on < off`, it costs `on` where it is reached and `off - on` more where it is reached and does not
    /// fire. Counted units that are not handled are taken off. Equal guards are one item. Of a guard and its negation one
    /// is always true, so the lesser weight goes to the constant.
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
                terms.push(Term { guard: !missing, weight: more, charge: index });
            }
            terms.push(Term { guard: reached, weight: on.min(off), charge: index });
            if on > off {
                terms.push(Term { guard: fires, weight: on - off, charge: index });
            } else if off > on {
                let idle = problem.circuit.and(reached, !fires);
                terms.push(Term { guard: idle, weight: off - on, charge: index });
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

    /// Makes items of terms, one of those with equal guards; `cancel` says whether what a guard and its negation have in
    /// common goes to the constant.
    fn collect(&mut self, terms: Vec<Term>, cancel: bool) {
        let mut place: FxHashMap<usize, usize> = FxHashMap::default();
        let mut sums: Vec<NodeSum> = Vec::new();
        for Term { guard, weight, charge } in terms {
            if guard == Lit::FALSE || weight == 0 {
                continue;
            }
            if guard == Lit::TRUE {
                self.constant = sum(self.constant, weight);
                continue;
            }
            let at = *place.entry(guard.node()).or_insert_with(|| {
                let positive = if guard.is_negated() { !guard } else { guard };
                sums.push([positive, !positive].map(|guard| Item {
                    guard,
                    weight: 0,
                    charges: Vec::new(),
                }));
                sums.len() - 1
            });
            let item = &mut sums[at][usize::from(guard.is_negated())];
            item.weight = sum(item.weight, weight);
            if item.charges.last() != Some(&charge) {
                item.charges.push(charge);
            }
        }
        for both in sums {
            let least = if cancel { both[0].weight.min(both[1].weight) } else { 0 };
            self.constant = sum(self.constant, least);
            for item in both {
                let weight = item.weight - least;
                if weight > 0 {
                    self.items.push(Item { weight, ..item });
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
