//! The problem of a group in normal form: maximise a constant plus a sum of weighted guards over a separate circuit.

use super::cone::Cone;
use rustc_hash::{FxHashMap, FxHashSet};
use scanbound_base::time::Picos;
use scanbound_model::{Assignment, Circuit, Group, Lit, Node, ScanModel, VarId};

/// A guard and its weight: the time that charges take if it is true. The search methods decide which items can be true
/// together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// The guard, a literal of the problem's circuit; never constant.
    pub guard: Lit,
    /// What a true guard adds to the cost, in picoseconds; never zero.
    pub weight: u64,
    /// The charges that the item represents, indices into `ScanModel::charges`, ascending.
    pub charges: Vec<usize>,
}

/// The problem of a group: find an assignment that makes every `hard` literal true and maximises the sum of the weights
/// of true guards. The group's maximum is this sum plus `constant` minus `deducted`, in picoseconds.
#[derive(Debug, Clone, Default)]
pub struct Problem {
    /// The part of the model's circuit on which the group's guards and constraints depend, over the problem's own
    /// variables; `variables` maps them to the model's.
    pub circuit: Circuit,
    /// The part of the cost that every assignment has, in picoseconds.
    pub constant: u64,
    /// The cost that is subtracted from the sum, because items of counted units are also true where no unit is
    /// processed.
    pub deducted: u64,
    /// Distinct guards, in the order of their first charges. None is the negation of another, except in a problem made
    /// by [`Problem::with_negations`].
    pub items: Vec<Item>,
    /// The constraints, literals that are true in every scan; never constant true.
    pub hard: Vec<Lit>,
    /// For each of the problem's variables, ascending: the variable of the model for which it stands.
    pub variables: Vec<VarId>,
}

/// What a charge adds to the sum if a guard is true.
struct Term {
    guard: Lit,
    weight: u64,
    /// The charge, an index into `ScanModel::charges`.
    charge: usize,
}

/// The item of a node of the circuit, and the item of the node's negation.
type NodeSum = [Item; 2];

impl Problem {
    /// The normal form of a group.
    ///
    /// A charge with times `on` and `off` costs `off` if it is reached and `on - off` more if it fires. If `on < off`,
    /// it costs `on` if it is reached and `off - on` more if it is reached and does not fire. Counted units that are
    /// not processed are subtracted. Equal guards become one item. Of a guard and its negation one is always true, so
    /// the smaller weight goes to the constant.
    #[must_use]
    pub fn new(model: &ScanModel, group: &Group) -> Problem {
        Problem::build(model, group, true)
    }

    /// As [`Problem::new`], but a guard and its negation are both items, with their full weights.
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
            // Guards that do not affect the cost may belong to other groups; a search would overwrite their values.
            let fires = match charge.fires_matters() {
                true => cone.copy(&mut problem.circuit, charge.fires),
                false => Lit::FALSE,
            };
            let (Picos(base), units) = charge.cost_if_fired();
            let (mut on, Picos(off)) = (base, charge.off);
            for &(handled, Picos(more)) in units {
                // The charge has all its units whenever it fires, so that mutually exclusive charges exclude each other
                // once and not for every unit. What is missing is subtracted.
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

    /// Renumbers the variables from 0 in the model's order, so that search results are as small as the group.
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

    /// The model's variable for one of this problem's variables.
    #[must_use]
    pub fn variable(&self, own: VarId) -> VarId {
        self.variables[own.0 as usize]
    }

    /// The values of this problem's variables in an assignment of the model's variables.
    #[must_use]
    pub fn restricted(&self, all: &Assignment) -> Assignment {
        Assignment(self.variables.iter().map(|variable| all.0[variable.0 as usize]).collect())
    }

    /// Combines terms with equal guards to items. `cancel` says whether the common weight of a guard and its negation
    /// goes to the constant.
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

    /// The cost if all items were true, in picoseconds: the bound before any search.
    #[must_use]
    pub fn naive(&self) -> u64 {
        self.total(self.items.iter().map(|item| item.weight))
    }

    /// The cost if items with these weights are true, in picoseconds; 0 if they weigh less than what is deducted.
    #[must_use]
    pub fn total(&self, weights: impl Iterator<Item = u64>) -> u64 {
        // Under any assignment, the true items weigh at least what is subtracted; an arbitrary subset of them may weigh
        // less.
        weights.fold(self.constant, sum).saturating_sub(self.deducted)
    }

    /// The cost under an assignment of this problem's variables, in picoseconds; `None` if it violates a constraint.
    #[must_use]
    pub fn cost(&self, assignment: &Assignment) -> Option<u64> {
        let values = self.circuit.evaluate(assignment);
        let holds = self.hard.iter().all(|&lit| values.get(lit));
        let true_items = self.items.iter().filter(|item| values.get(item.guard));
        holds.then(|| self.total(true_items.map(|item| item.weight)))
    }

    /// The assignment with all variables 0.
    #[must_use]
    pub fn zeros(&self) -> Assignment {
        Assignment(vec![0; self.variables.len()])
    }
}

/// A checked sum of picoseconds: a bound that wraps around would be too low.
fn sum(a: u64, b: u64) -> u64 {
    (Picos(a) + Picos(b)).0
}
