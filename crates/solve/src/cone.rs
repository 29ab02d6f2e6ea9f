//! Copies parts of a circuit into another circuit.

use rustc_hash::FxHashMap;
use scanbound_model::{Circuit, Lit, Node};

/// Copies parts of one source circuit into another circuit, each node once.
pub struct Cone<'a> {
    source: &'a Circuit,
    known: Copied,
}

/// The nodes that have been copied, each with the literal of its copy. Many groups have only a few nodes, one has most
/// of the circuit.
enum Copied {
    /// A hash map by node.
    Few(FxHashMap<usize, Lit>),
    /// An array by node; [`UNKNOWN`] for nodes that are not copied.
    Many(Vec<Lit>),
}

const UNKNOWN: Lit = Lit(u32::MAX);

/// [`Copied::Many`] is used once more than one in this many nodes has been copied.
const MANY: usize = 32;

impl Copied {
    fn get(&self, node: usize) -> Option<Lit> {
        match self {
            Copied::Few(known) => known.get(&node).copied(),
            Copied::Many(known) => Some(known[node]).filter(|&copied| copied != UNKNOWN),
        }
    }

    /// Stores the copy of a node; `nodes` is the size of the source circuit.
    fn store(&mut self, node: usize, copied: Lit, nodes: usize) {
        match self {
            Copied::Many(known) => known[node] = copied,
            Copied::Few(known) => {
                known.insert(node, copied);
                if known.len() > nodes / MANY {
                    let mut many = vec![UNKNOWN; nodes];
                    known.iter().for_each(|(&node, &copied)| many[node] = copied);
                    *self = Copied::Many(many);
                }
            }
        }
    }
}

impl<'a> Cone<'a> {
    /// Prepares copying from a circuit.
    pub fn new(source: &'a Circuit) -> Cone<'a> {
        Cone { source, known: Copied::Few(FxHashMap::default()) }
    }

    /// Copies a literal and everything on which it depends, each gate once. Returns the literal of the copy.
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
                        // The left input first, so that the copy's numbering follows the order of execution.
                        stack.extend(right.is_none().then_some(b.node()));
                        stack.extend(left.is_none().then_some(a.node()));
                        continue;
                    }
                },
            };
            self.known.store(node, copied, self.source.nodes().len());
            stack.pop();
        }
        self.get(lit).expect("the literal's node was just copied")
    }

    fn get(&self, lit: Lit) -> Option<Lit> {
        self.known.get(lit.node()).map(|copied| if lit.is_negated() { !copied } else { copied })
    }
}
