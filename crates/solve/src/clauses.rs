//! Converts the circuit of a problem to clauses (CNF), and a solver's model back to an assignment.

use super::clause_list::ClauseList;
use super::problem::Problem;
use scanbound_model::{Assignment, Atom, Lit, Node, VarId};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Clauses over the variables 1, 2, ...; as in DIMACS files, a literal is a variable or, negated, the negative number.
#[derive(Debug, Clone, Default)]
pub struct Clauses {
    /// The number of variables of the clauses.
    pub variables: usize,
    /// The clauses.
    pub clauses: ClauseList,
    /// For each clause, the variable that it helps to define; for a constraint, the variable of its literal (1 if the
    /// constraint is constant false).
    pub owners: Vec<i32>,
    /// The literal of the guard of each item of the problem, in the order of the items.
    pub items: Vec<i32>,
    /// The variable of each node of the circuit; 0 if it has none.
    nodes: Vec<i32>,
    /// The variables of atoms, ascending, with their atoms.
    pub atoms: Vec<(i32, Atom)>,
    /// For words whose bits are tested: the literals of their sixteen bits, least significant first.
    bits: BTreeMap<VarId, Vec<i32>>,
}

impl Clauses {
    /// The clauses of a problem. A word is a chain of thresholds, each of which implies the next lower one. If single
    /// bits of the word are tested too, comparisons connect thresholds and bits.
    #[must_use]
    pub fn new(problem: &Problem) -> Clauses {
        Clauses::with_late(problem, problem.circuit.nodes().len())
    }

    /// The clauses of a problem whose gates from `late` on were added later. The variable of each of these gates is
    /// placed after the last of its inputs, so that all variables are in the order of execution.
    #[must_use]
    pub fn with_late(problem: &Problem, late: usize) -> Clauses {
        let nodes = problem.circuit.nodes();
        let uses = uses(problem);
        let mut clauses = Clauses { nodes: vec![0; nodes.len()], ..Clauses::default() };
        for index in order(nodes, late) {
            match nodes[index] {
                Node::Atom(atom) if uses[index] != NodeUse::None => {
                    let variable = clauses.variable();
                    clauses.nodes[index] = variable;
                    clauses.atoms.push((variable, atom));
                }
                Node::And(a, b) if uses[index] == NodeUse::Gate => {
                    let inputs = inputs(nodes, &uses, a, b);
                    let inputs: Vec<i32> = inputs.into_iter().map(|l| clauses.literal(l)).collect();
                    clauses.nodes[index] = clauses.and(&inputs);
                }
                _ => {}
            }
        }
        clauses.words();
        for &lit in &problem.hard {
            let unit = (lit != Lit::FALSE).then(|| clauses.literal(lit));
            clauses.push(unit.map_or(1, i32::abs), unit);
        }
        clauses.items = problem.items.iter().map(|item| clauses.literal(item.guard)).collect();
        clauses
    }

    fn literal(&self, lit: Lit) -> i32 {
        let variable = self.nodes[lit.node()];
        if lit.is_negated() { -variable } else { variable }
    }

    /// The variables that are not outputs of gates: those of atoms, and those of words' bits.
    pub fn inputs(&self) -> impl Iterator<Item = i32> {
        let bits = self.bits.values().flatten().copied();
        self.atoms.iter().map(|&(variable, _)| variable).chain(bits)
    }

    /// The bit variables (not bits of words) that occur in most clauses, at most `most` of them, the most used first.
    pub fn most_used_bits(&self, most: usize) -> Vec<VarId> {
        let mut occurrences = vec![0usize; self.variables + 1];
        for literal in self.clauses.literals() {
            occurrences[literal.unsigned_abs() as usize] += 1;
        }
        let bits = self.atoms.iter().filter_map(|&(variable, atom)| match atom {
            Atom::Bit(bit) => Some((Reverse(occurrences[variable.unsigned_abs() as usize]), bit)),
            _ => None,
        });
        let mut bits: Vec<_> = bits.collect();
        bits.sort_unstable();
        bits.truncate(most);
        bits.into_iter().map(|(_, bit)| bit).collect()
    }

    /// The assignment of the problem's variables that corresponds to a solver's model; `holds` says whether a variable
    /// is true in it.
    pub fn assignment(&self, problem: &Problem, holds: impl Fn(i32) -> bool) -> Assignment {
        let mut assignment = problem.zeros();
        for &(variable, atom) in &self.atoms {
            let value = &mut assignment.0[atom.variable().0 as usize];
            if holds(variable) {
                match atom {
                    Atom::Bit(_) => *value = 1,
                    Atom::AtLeast(_, threshold) => *value = threshold.max(*value),
                    Atom::WordBit(..) => {}
                }
            }
        }
        for (word, bits) in &self.bits {
            let ones = bits.iter().enumerate().filter(|&(_, &bit)| holds(bit));
            assignment.0[word.0 as usize] = ones.map(|(place, _)| 1 << place).sum();
        }
        assignment
    }

    fn push(&mut self, owner: i32, clause: impl IntoIterator<Item = i32>) {
        self.owners.push(owner);
        self.clauses.push(clause);
    }

    fn variable(&mut self) -> i32 {
        self.variables += 1;
        i32::try_from(self.variables).expect("the number of variables must fit in 31 bits")
    }

    fn and(&mut self, inputs: &[i32]) -> i32 {
        let gate = self.variable();
        for &input in inputs {
            self.push(gate, [-gate, input]);
        }
        self.push(gate, inputs.iter().map(|input| -input).chain([gate]));
        gate
    }

    fn words(&mut self) {
        let mut thresholds: BTreeMap<VarId, Vec<(u16, i32)>> = BTreeMap::new();
        let mut asked: BTreeMap<VarId, Vec<(u8, i32)>> = BTreeMap::new();
        for &(variable, atom) in &self.atoms {
            match atom {
                Atom::Bit(_) => {}
                Atom::AtLeast(word, threshold) => {
                    thresholds.entry(word).or_default().push((threshold, variable));
                }
                Atom::WordBit(word, bit) => asked.entry(word).or_default().push((bit, variable)),
            }
        }
        for chain in thresholds.values_mut() {
            chain.sort_unstable();
            for pair in chain.windows(2) {
                self.push(pair[1].1, [-pair[1].1, pair[0].1]);
            }
        }
        for (word, places) in asked {
            let mut bits: Vec<i32> = vec![0; 16];
            for (place, variable) in places {
                bits[usize::from(place)] = variable;
            }
            for bit in &mut bits {
                if *bit == 0 {
                    *bit = self.variable();
                }
            }
            for &(threshold, variable) in thresholds.get(&word).into_iter().flatten() {
                self.compare(&bits, threshold, variable);
            }
            self.bits.insert(word, bits);
        }
    }

    /// Adds clauses that define `reached`: the number with these bits is at least `threshold`, which is not 0.
    fn compare(&mut self, bits: &[i32], threshold: u16, reached: i32) {
        // From the least significant bit up: whether the bits so far are at least the threshold's bits so far. Below
        // the lowest bit of the threshold this is always true.
        let lowest = threshold.trailing_zeros() as usize;
        let mut below = bits[lowest];
        for (place, &bit) in bits.iter().enumerate().skip(lowest + 1) {
            below = if threshold >> place & 1 == 1 {
                self.and(&[bit, below])
            } else {
                -self.and(&[-bit, -below])
            };
        }
        self.push(reached, [-reached, below]);
        self.push(reached, [reached, -below]);
    }
}

/// The nodes in an order in which each node from `late` on follows the last of its inputs.
fn order(nodes: &[Node], late: usize) -> Vec<usize> {
    let mut last: Vec<usize> = Vec::with_capacity(nodes.len() - late);
    let mut behind: Vec<(usize, usize)> = Vec::with_capacity(nodes.len() - late);
    for (index, node) in nodes.iter().enumerate().skip(late) {
        let inputs = match *node {
            Node::And(a, b) => [a.node(), b.node()],
            Node::True | Node::Atom(_) => [0, 0],
        };
        let place = |node: usize| if node < late { node } else { last[node - late] };
        let input = place(inputs[0]).max(place(inputs[1]));
        last.push(input);
        behind.push((input, index));
    }
    behind.sort_unstable();
    let mut behind = behind.into_iter().peekable();
    let mut order = Vec::with_capacity(nodes.len());
    for index in 0..late {
        order.push(index);
        while let Some((_, late)) = behind.next_if(|&(input, _)| input == index) {
            order.push(late);
        }
    }
    order
}

/// How a node of the circuit is represented in the clauses.
#[derive(Clone, Copy, PartialEq, Eq)]
enum NodeUse {
    /// The node has no representation: no item and no constraint depends on it.
    None,
    /// The node is part of the only gate that uses it, and is not negated there.
    Inside,
    /// The node has a variable of its own.
    Gate,
}

fn uses(problem: &Problem) -> Vec<NodeUse> {
    let nodes = problem.circuit.nodes();
    let mut uses = vec![NodeUse::None; nodes.len()];
    let roots = problem.items.iter().map(|item| item.guard).chain(problem.hard.iter().copied());
    for root in roots {
        uses[root.node()] = NodeUse::Gate;
    }
    for index in (0..nodes.len()).rev() {
        if let (Node::And(a, b), true) = (nodes[index], uses[index] != NodeUse::None) {
            for input in [a, b] {
                let inside = uses[input.node()] == NodeUse::None && !input.is_negated();
                uses[input.node()] = if inside { NodeUse::Inside } else { NodeUse::Gate };
            }
        }
    }
    uses
}

/// The inputs of a gate and of the gates that are merged into it.
fn inputs(nodes: &[Node], uses: &[NodeUse], a: Lit, b: Lit) -> Vec<Lit> {
    let mut inputs = Vec::new();
    let mut stack = vec![b, a];
    while let Some(lit) = stack.pop() {
        match nodes[lit.node()] {
            Node::And(a, b) if uses[lit.node()] == NodeUse::Inside => stack.extend([b, a]),
            _ if inputs.contains(&lit) => {}
            _ => inputs.push(lit),
        }
    }
    inputs
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_model::Circuit;

    #[test]
    fn late_gates_stand_behind_the_last_of_their_inputs() {
        let mut circuit = Circuit::default();
        let bits: Vec<Lit> = (0..4).map(|n| circuit.atom(Atom::Bit(VarId(n)))).collect();
        let late = circuit.nodes().len();
        // Gates over the first two bits, the last two, and the first gate with the third bit: sorted by their last
        // inputs.
        let first = circuit.and(bits[0], bits[1]);
        let last = circuit.and(bits[2], bits[3]);
        let middle = circuit.and(first, bits[2]);
        let nodes = [bits[0], bits[1], first, bits[2], middle, bits[3], last];
        let wanted: Vec<usize> = [0].into_iter().chain(nodes.map(Lit::node)).collect();
        assert_eq!(order(circuit.nodes(), late), wanted);
        let all = circuit.nodes().len();
        assert_eq!(order(circuit.nodes(), all), (0..all).collect::<Vec<_>>());
    }
}
