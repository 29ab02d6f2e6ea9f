//! A Boolean circuit (an and-inverter graph over atoms) in which equal gates are shared.

use super::shared::Shared;

/// A free variable of the scan, an index into [`ScanModel::variables`](crate::ScanModel::variables).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VarId(pub u32);

/// A value for every free variable, by [`VarId`]; a bit is 0 or 1. It determines a scan of the model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assignment(pub Vec<u16>);

/// A literal: a Boolean value of the scan, which is a node of the [`Circuit`] or its negation. The number is twice the
/// node's index, plus one if negated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Lit(pub u32);

impl Lit {
    /// The constant true.
    pub const TRUE: Lit = Lit(0);
    /// The constant false.
    pub const FALSE: Lit = Lit(1);

    /// The literal of the node with this index, not negated.
    #[must_use]
    pub fn positive(node: usize) -> Lit {
        Lit(u32::try_from(node << 1).expect("the number of nodes must fit in 31 bits"))
    }

    /// The index of the literal's node.
    #[must_use]
    pub fn node(self) -> usize {
        (self.0 >> 1) as usize
    }

    /// Whether the literal is the negation of its node.
    #[must_use]
    pub fn is_negated(self) -> bool {
        self.0 & 1 == 1
    }

    /// Whether this is [`Lit::TRUE`] or [`Lit::FALSE`].
    #[must_use]
    pub fn is_constant(self) -> bool {
        self.0 < 2
    }

    /// [`Lit::TRUE`] if `value` is true, else [`Lit::FALSE`].
    #[must_use]
    pub fn constant(value: bool) -> Lit {
        if value { Lit::TRUE } else { Lit::FALSE }
    }
}

impl std::ops::Not for Lit {
    type Output = Lit;
    fn not(self) -> Lit {
        Lit(self.0 ^ 1)
    }
}

/// A test of one free variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Atom {
    /// The bit variable is 1.
    Bit(VarId),
    /// The word, unsigned, is at least this value (1 to 65535).
    AtLeast(VarId, u16),
    /// This bit (0 to 15) of the word is 1.
    WordBit(VarId, u8),
}

impl Atom {
    /// The variable that is tested.
    #[must_use]
    pub fn variable(self) -> VarId {
        match self {
            Atom::Bit(v) | Atom::AtLeast(v, _) | Atom::WordBit(v, _) => v,
        }
    }
}

/// A node of the circuit. The inputs of a gate have smaller indices than the gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Node {
    /// Node 0, the constant true.
    True,
    /// A test of a free variable.
    Atom(Atom),
    /// A conjunction; the left literal is the smaller one.
    And(Lit, Lit),
}

/// The circuit of tests of free variables and and-gates in which guards and constraints are literals. Equal gates are
/// one node.
#[derive(Debug, Clone)]
pub struct Circuit {
    nodes: Shared<Node>,
}

impl Default for Circuit {
    fn default() -> Self {
        let mut nodes = Shared::default();
        nodes.number(Node::True);
        Circuit { nodes }
    }
}

/// The value of every node of a [`Circuit`] under an [`Assignment`].
pub struct Values(Vec<bool>);

impl Values {
    /// The value of a literal.
    #[must_use]
    pub fn get(&self, lit: Lit) -> bool {
        self.0[lit.node()] != lit.is_negated()
    }
}

impl Circuit {
    /// All nodes; the inputs of a gate come before the gate.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        self.nodes.all()
    }

    /// The node of a literal, without the negation.
    #[must_use]
    pub fn node(&self, lit: Lit) -> Node {
        self.nodes.all()[lit.node()]
    }

    /// The literal of an atom. A word is always at least 0, so `AtLeast(_, 0)` gives [`Lit::TRUE`].
    pub fn atom(&mut self, atom: Atom) -> Lit {
        if let Atom::AtLeast(_, 0) = atom {
            return Lit::TRUE;
        }
        self.intern(Node::Atom(atom))
    }

    /// The conjunction of `a` and `b`. It is simplified if constants, equal literals or complementary literals show the
    /// result, also if they show it only together with the inputs of `a` or `b`.
    pub fn and(&mut self, a: Lit, b: Lit) -> Lit {
        if a == Lit::FALSE || b == Lit::FALSE || a == !b {
            return Lit::FALSE;
        }
        if a == Lit::TRUE || a == b {
            return b;
        }
        if b == Lit::TRUE {
            return a;
        }
        // Absorption and contradiction with one level of inputs: a and (a and c), a and (!a and c), a and !(a and c).
        for (x, y) in [(a, b), (b, a)] {
            if let Node::And(p, q) = self.node(y) {
                match (y.is_negated(), x == p || x == q, x == !p || x == !q) {
                    (false, true, _) => return y,
                    (false, _, true) => return Lit::FALSE,
                    (true, _, true) => return x,
                    (true, true, _) => {
                        let rest = if x == p { q } else { p };
                        return self.and(x, !rest);
                    }
                    _ => {}
                }
            }
        }
        // !(p and q) and !(p and !q) is !p. So the guard after two paths have joined is the guard before they
        // separated.
        if let (true, true, Node::And(p, q), Node::And(r, s)) =
            (a.is_negated(), b.is_negated(), self.node(a), self.node(b))
        {
            match () {
                () if (p == r && q == !s) || (p == s && q == !r) => return !p,
                () if (q == r && p == !s) || (q == s && p == !r) => return !q,
                () => {}
            }
        }
        self.order_and(a, b)
    }

    /// The conjunction of two literals, simplified if both are thresholds of one word and one implies or excludes the
    /// other.
    fn order_and(&mut self, a: Lit, b: Lit) -> Lit {
        if let (Node::Atom(Atom::AtLeast(v, s)), Node::Atom(Atom::AtLeast(w, t))) =
            (self.node(a), self.node(b))
            && v == w
        {
            let (weak, strong) = if s < t { (a, b) } else { (b, a) };
            match (weak.is_negated(), strong.is_negated()) {
                (false, false) => return strong,
                (true, true) => return weak,
                (true, false) => return Lit::FALSE,
                (false, true) => {}
            }
        }
        self.intern(Node::And(a.min(b), a.max(b)))
    }

    /// The disjunction of `a` and `b`.
    pub fn or(&mut self, a: Lit, b: Lit) -> Lit {
        !self.and(!a, !b)
    }

    /// If-then-else: `then` if `condition`, else `other`.
    pub fn ite(&mut self, condition: Lit, then: Lit, other: Lit) -> Lit {
        match (condition, then, other) {
            (Lit::TRUE, ..) => then,
            (Lit::FALSE, ..) => other,
            _ if then == other => then,
            _ => {
                let a = self.and(condition, then);
                let b = self.and(!condition, other);
                self.or(a, b)
            }
        }
    }

    /// The exclusive or of `a` and `b`.
    pub fn xor(&mut self, a: Lit, b: Lit) -> Lit {
        self.ite(a, !b, b)
    }

    /// The conjunction of all literals.
    pub fn all(&mut self, lits: impl IntoIterator<Item = Lit>) -> Lit {
        lits.into_iter().fold(Lit::TRUE, |a, b| self.and(a, b))
    }

    /// The disjunction of all literals.
    pub fn any(&mut self, lits: impl IntoIterator<Item = Lit>) -> Lit {
        lits.into_iter().fold(Lit::FALSE, |a, b| self.or(a, b))
    }

    /// The value of every node under an assignment, which must have a value for every variable that is tested.
    #[must_use]
    pub fn evaluate(&self, assignment: &Assignment) -> Values {
        let mut values: Vec<bool> = Vec::with_capacity(self.nodes().len());
        for node in self.nodes() {
            let value = match *node {
                Node::True => true,
                Node::Atom(atom) => {
                    let word = assignment.0[atom.variable().0 as usize];
                    match atom {
                        Atom::Bit(_) => word != 0,
                        Atom::AtLeast(_, threshold) => word >= threshold,
                        Atom::WordBit(_, bit) => word >> bit & 1 == 1,
                    }
                }
                Node::And(a, b) => {
                    values[a.node()] != a.is_negated() && values[b.node()] != b.is_negated()
                }
            };
            values.push(value);
        }
        Values(values)
    }

    /// Renumbers the variables of the atoms. Different variables must get different numbers.
    pub fn renumber(&mut self, number: impl Fn(VarId) -> VarId) {
        self.nodes.change(|node| {
            if let Node::Atom(Atom::Bit(v) | Atom::AtLeast(v, _) | Atom::WordBit(v, _)) = node {
                *v = number(*v);
            }
        });
    }

    fn intern(&mut self, node: Node) -> Lit {
        Lit(self.nodes.number(node) << 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bit(c: &mut Circuit, v: u32) -> Lit {
        c.atom(Atom::Bit(VarId(v)))
    }

    #[test]
    fn equal_gates_are_one() {
        let mut c = Circuit::default();
        let (a, b) = (bit(&mut c, 0), bit(&mut c, 1));
        assert_eq!(c.and(a, b), c.and(b, a));
        assert_eq!(c.and(a, !a), Lit::FALSE);
        let ab = c.and(a, b);
        assert_eq!(c.and(a, ab), ab);
        assert_eq!(c.and(!a, ab), Lit::FALSE);
        assert_eq!(c.and(!a, !ab), !a);
        assert_eq!(c.and(a, !ab), c.and(a, !b));
    }

    #[test]
    fn thresholds_of_one_word_imply_each_other() {
        let mut c = Circuit::default();
        let (low, high) = (c.atom(Atom::AtLeast(VarId(0), 3)), c.atom(Atom::AtLeast(VarId(0), 7)));
        assert_eq!(c.and(low, high), high);
        assert_eq!(c.and(!low, high), Lit::FALSE);
        assert_eq!(c.and(!low, !high), !low);
        assert!(!c.and(low, !high).is_constant());
    }

    #[test]
    fn simplification_keeps_the_truth_table() {
        // Functions of three bits, built in two layers, agree with direct evaluation.
        let mut c = Circuit::default();
        let bits: Vec<Lit> = (0..3).map(|v| bit(&mut c, v)).collect();
        for &p in &bits {
            for &q in &bits {
                for &r in &bits {
                    for signs in 0..16u32 {
                        let flip = |l: Lit, k: u32| if signs >> k & 1 == 1 { !l } else { l };
                        let inner = c.and(flip(p, 0), flip(q, 1));
                        let outer = c.ite(flip(r, 2), flip(inner, 3), p);
                        for v in 0..8u16 {
                            let a = Assignment((0..3).map(|i| v >> i & 1).collect());
                            let values = c.evaluate(&a);
                            let get =
                                |l: Lit| (v >> (c.node_variable(l)) & 1 == 1) != l.is_negated();
                            let want_inner = get(flip(p, 0)) && get(flip(q, 1));
                            let want = if get(flip(r, 2)) {
                                want_inner != (signs >> 3 & 1 == 1)
                            } else {
                                get(p)
                            };
                            assert_eq!(values.get(outer), want);
                        }
                    }
                }
            }
        }
    }

    impl Circuit {
        fn node_variable(&self, lit: Lit) -> u32 {
            match self.node(lit) {
                Node::Atom(a) => a.variable().0,
                _ => unreachable!(),
            }
        }
    }
}
