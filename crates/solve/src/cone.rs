//! Copies parts of a circuit into another.

use rustc_hash::FxHashMap;
use scanbound_model::{Circuit, Lit, Node};

/// Copies parts of a circuit into another.
pub struct Cone<'a> {
    source: &'a Circuit,
    known: Known,
}

/// What nodes of the source are in the copy. There are many groups of a few nodes, and one that has most of the circuit.
enum Known {
    /// By node: those that are copied.
    Few(FxHashMap<usize, Lit>),
    /// By node; [`UNKNOWN`] where one is not copied.
    Many(Vec<Lit>),
}

const UNKNOWN: Lit = Lit(u32::MAX);

/// Where more than one in so many nodes of a circuit is copied, each has a place in a list.
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
