//! Boolean functions of relays in a shared circuit, and their comparison with a SAT solver.

use batsat::{BasicSolver, Lit, SolverInterface, lbool};
use std::collections::BTreeMap;

/// The index of a function.
pub(super) type Function = usize;

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Node {
    /// A relay at the start of the scan, or another variable.
    Value(String),
    Not(Function),
    And(Function, Function),
    Or(Function, Function),
}

/// Functions; equal ones are stored once.
#[derive(Debug, Default)]
pub(super) struct Circuit {
    nodes: Vec<Node>,
    known: BTreeMap<Node, Function>,
}

impl Circuit {
    fn add(&mut self, node: Node) -> Function {
        if let Some(&known) = self.known.get(&node) {
            return known;
        }
        self.nodes.push(node.clone());
        self.known.insert(node, self.nodes.len() - 1);
        self.nodes.len() - 1
    }

    pub(super) fn value(&mut self, name: &str) -> Function {
        self.add(Node::Value(name.to_owned()))
    }

    pub(super) fn not(&mut self, of: Function) -> Function {
        self.add(Node::Not(of))
    }

    pub(super) fn and(&mut self, one: Function, other: Function) -> Function {
        self.add(Node::And(one.min(other), one.max(other)))
    }

    pub(super) fn or(&mut self, one: Function, other: Function) -> Function {
        self.add(Node::Or(one.min(other), one.max(other)))
    }

    /// Values for which two functions differ; `None` if they are equal.
    pub(super) fn difference(&self, one: Function, other: Function) -> Option<Vec<(String, bool)>> {
        if one == other {
            return None;
        }
        let mut solver = BasicSolver::default();
        let variables: Vec<_> = (0..=one.max(other)).map(|_| solver.new_var_default()).collect();
        let lit = |at: Function, is_true: bool| Lit::new(variables[at], is_true);
        let mut clause = |lits: &[Lit]| {
            solver.add_clause_reuse(&mut lits.to_vec());
        };
        for (at, node) in self.nodes[..=one.max(other)].iter().enumerate() {
            match *node {
                Node::Value(_) => {}
                Node::Not(of) => {
                    clause(&[lit(at, true), lit(of, true)]);
                    clause(&[lit(at, false), lit(of, false)]);
                }
                Node::And(a, b) => {
                    clause(&[lit(at, false), lit(a, true)]);
                    clause(&[lit(at, false), lit(b, true)]);
                    clause(&[lit(at, true), lit(a, false), lit(b, false)]);
                }
                Node::Or(a, b) => {
                    clause(&[lit(at, true), lit(a, false)]);
                    clause(&[lit(at, true), lit(b, false)]);
                    clause(&[lit(at, false), lit(a, true), lit(b, true)]);
                }
            }
        }
        clause(&[lit(one, true), lit(other, true)]);
        clause(&[lit(one, false), lit(other, false)]);
        if solver.solve_limited(&[]) != lbool::TRUE {
            return None;
        }
        let mut found = Vec::new();
        for (at, node) in self.nodes[..=one.max(other)].iter().enumerate() {
            if let Node::Value(name) = node
                && (self.reads(one, at) || self.reads(other, at))
            {
                found.push((name.clone(), solver.value_var(variables[at]) == lbool::TRUE));
            }
        }
        Some(found)
    }

    /// Whether a function depends on a variable.
    fn reads(&self, function: Function, value: Function) -> bool {
        let mut open = vec![function];
        let mut seen = vec![false; function + 1];
        while let Some(at) = open.pop() {
            if at == value {
                return true;
            }
            if std::mem::replace(&mut seen[at], true) {
                continue;
            }
            match self.nodes[at] {
                Node::Value(_) => {}
                Node::Not(of) => open.push(of),
                Node::And(a, b) | Node::Or(a, b) => open.extend([a, b]),
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_the_same_or_differ_somewhere() {
        let mut circuit = Circuit::default();
        let [a, b, c] = ["a", "b", "c"].map(|name| circuit.value(name));
        let (ab, ac) = (circuit.and(a, b), circuit.and(c, a));
        let (one, bc) = (circuit.or(ab, ac), circuit.or(b, c));
        let other = circuit.and(a, bc);
        assert_eq!(circuit.difference(one, other), None);
        let not = circuit.not(other);
        assert!(circuit.difference(one, not).is_some());
        let found = circuit.difference(ab, other).expect("c without b");
        let value = |name: &str| found.iter().find(|(own, _)| own == name).map(|(_, value)| *value);
        assert_eq!((value("a"), value("b"), value("c")), (Some(true), Some(false), Some(true)));
    }
}
