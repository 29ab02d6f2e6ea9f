//! Divides the charges of a scan into groups that share no free variable, and converts assignments into witnesses.

use crate::{Assignment, Atom, Group, Lit, Node, Origin, ScanModel, VarId};
use petgraph::unionfind::UnionFind;
use scanbound_base::time::Picos;
use scanbound_ir::{ChoiceKey, Witness};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// The groups, sorted by the sum of their charges' larger times, largest first. Charges with a constant time, and
/// constraints on which no charge depends, are in no group. Reports and exports number the groups in this order.
///
/// Two charges are in one group if their guards share a variable, directly, through other guards, or through a
/// constraint. Therefore the maxima of the groups and the constant times add up to the maximum of the scan.
#[must_use]
pub fn groups(model: &ScanModel) -> Vec<Group> {
    let mut sets = Sets::of(model);
    let mut found: BTreeMap<usize, usize> = BTreeMap::new();
    let mut groups: Vec<Group> = Vec::new();
    for (index, charge) in model.charges.iter().enumerate() {
        let Some(guard) = charge.guards().next() else { continue };
        let set = sets.find(guard);
        let group = *found.entry(set).or_insert_with(|| {
            groups.push(Group::default());
            groups.len() - 1
        });
        groups[group].charges.push(index);
    }
    for (index, &constraint) in model.constraints.iter().enumerate() {
        if let Some(&group) = found.get(&sets.find(constraint)) {
            groups[group].constraints.push(index);
        }
    }
    for (variable, node) in sets.variables.clone() {
        if let Some(&group) = found.get(&sets.find(Lit(node << 1))) {
            groups[group].variables.push(variable);
        }
    }
    let naive = |group: &Group| {
        group.charges.iter().map(|&c| model.charges[c].largest_cost()).sum::<Picos>()
    };
    groups.sort_by_cached_key(|group| (Reverse(naive(group)), group.charges[0]));
    groups
}

/// The constraints that are in none of these groups, as one group without charges; `None` if there are none. A scan
/// must satisfy these constraints, too.
#[must_use]
pub fn unused_constraints(model: &ScanModel, groups: &[Group]) -> Option<Group> {
    let mut used = vec![false; model.constraints.len()];
    groups
        .iter()
        .flat_map(|group| &group.constraints)
        .for_each(|&constraint| used[constraint] = true);
    let constraints: Vec<usize> = (0..used.len()).filter(|&constraint| !used[constraint]).collect();
    if constraints.is_empty() {
        return None;
    }
    let nodes = model.circuit.nodes();
    let mut needed = vec![false; nodes.len()];
    constraints.iter().for_each(|&constraint| needed[model.constraints[constraint].node()] = true);
    let mut variables = BTreeSet::new();
    for index in (0..nodes.len()).rev().filter(|&index| index > 0) {
        match nodes[index] {
            Node::And(a, b) if needed[index] => {
                [a, b].iter().for_each(|input| needed[input.node()] = true)
            }
            Node::Atom(atom) if needed[index] => {
                variables.insert(atom.variable());
            }
            _ => {}
        }
    }
    Some(Group { charges: Vec::new(), variables: variables.into_iter().collect(), constraints })
}

/// A union-find structure of circuit nodes: nodes that guards or constraints connect are in one set.
struct Sets {
    joined: UnionFind<usize>,
    variables: BTreeMap<VarId, u32>,
}

impl Sets {
    fn of(model: &ScanModel) -> Sets {
        let nodes = model.circuit.nodes();
        let mut joined = UnionFind::new(nodes.len());
        let mut needed = vec![false; nodes.len()];
        for charge in &model.charges {
            let mut before: Option<Lit> = None;
            for guard in charge.guards() {
                needed[guard.node()] = true;
                if let Some(before) = before.replace(guard) {
                    joined.union(before.node(), guard.node());
                }
            }
        }
        for constraint in &model.constraints {
            needed[constraint.node()] = true;
        }
        let mut variables: BTreeMap<VarId, u32> = BTreeMap::new();
        for index in (0..nodes.len()).rev().filter(|&index| index > 0) {
            if !needed[index] {
                continue;
            }
            match nodes[index] {
                Node::True => {}
                Node::And(a, b) => {
                    for input in [a.node(), b.node()] {
                        needed[input] = true;
                        joined.union(index, input);
                    }
                }
                Node::Atom(atom @ (Atom::Bit(_) | Atom::AtLeast(..) | Atom::WordBit(..))) => {
                    let node = u32::try_from(index).expect("circuit indices fit 32 bits");
                    let first = *variables.entry(atom.variable()).or_insert(node);
                    joined.union(index, first as usize);
                }
            }
        }
        Sets { joined, variables }
    }

    fn find(&mut self, lit: Lit) -> usize {
        self.joined.find_mut(lit.node())
    }
}

/// The scan that corresponds to an assignment of the model's variables, as start values of cells and values of choices.
#[must_use]
pub fn witness(model: &ScanModel, assignment: &Assignment) -> Witness {
    let values = model.circuit.evaluate(assignment);
    let happened = model.havocs.executed(|lit| values.get(lit));
    let mut witness = Witness { resolutions: model.resolutions.clone(), ..Witness::default() };
    for (variable, &value) in model.variables.iter().zip(&assignment.0) {
        match &variable.origin {
            Origin::Start(cell) => {
                witness.start.insert(*cell, value);
            }
            Origin::Choice(key) => {
                witness.choices.insert(key.clone(), value);
            }
            &Origin::Havocked { cell, since, until } => {
                if let Some(last) = happened.newest(cell, since, until) {
                    let key = ChoiceKey {
                        frames: last.frames.clone(),
                        choice: last.choice,
                        cell: Some(cell),
                    };
                    witness.choices.insert(key, value);
                }
            }
        }
    }
    witness
}
