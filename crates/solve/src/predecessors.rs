//! Start states that no earlier scan can leave: asks for a scan that ends in a state, then for one that ends in the
//! state in which that scan starts, and so on.
//!
//! A state that no scan leaves, and in which no run begins, never occurs. The solver names the bits that exclude it;
//! these exclude the state of an earlier scan, too. (Property directed reachability, A. R. Bradley, VMCAI 2011, to a
//! small depth.)

use super::Limits;
use super::clauses::Clauses;
use super::inductive::BitTransition;
use super::oracle::{Branching, Effort, Oracle};
use super::problem::{Item, Problem};
use rustc_hash::FxHashMap;
use scanbound_model::{Lit, ScanModel, VarId};

/// The largest number of decisions of one query.
const DECISIONS: u64 = 500_000;
/// The largest number of earlier scans that are asked for, one before the other.
const DEPTH: usize = 6;
/// The largest number of queries for one state.
const QUERIES: usize = 64;

/// Values of some bits: indices into the list of bits, each with its value.
pub type State = Vec<(usize, bool)>;

/// A solver with the clauses of one scan, and what it has excluded so far.
pub struct Predecessors<'a> {
    bits: Vec<BitTransition>,
    /// The bits' values when a run begins.
    initial: Vec<bool>,
    /// The literal of each circuit node that is the start or end of a bit.
    literals: FxHashMap<usize, i32>,
    oracle: Oracle<'a>,
    queries: usize,
}

/// The answer of one query.
enum Predecessor {
    /// The start of a scan that leaves the state.
    Scan(State),
    /// No scan leaves these values, a part of the state.
    Never(State),
    /// The query exceeded its limits.
    Unknown,
}

impl<'a> Predecessors<'a> {
    /// Prepares the questions about a model. `initial` holds the bits' values when a run begins.
    #[must_use]
    pub fn new(
        model: &ScanModel,
        bits: Vec<BitTransition>,
        initial: Vec<bool>,
        limits: &'a Limits<'a>,
    ) -> Predecessors<'a> {
        let mut nodes: Vec<usize> =
            bits.iter().flat_map(|bit| [bit.start.node(), bit.end.node()]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes.retain(|&node| node != 0);
        let guard = |&node: &usize| Lit((node as u32) << 1);
        let item = |node| Item { guard: guard(node), weight: 1, charges: Vec::new() };
        let hard = model.constraints.iter().copied().filter(|&one| one != Lit::TRUE);
        let problem = Problem {
            circuit: model.circuit.clone(),
            items: nodes.iter().map(item).collect(),
            hard: hard.collect(),
            variables: (0..model.variables.len() as u32).map(VarId).collect(),
            ..Problem::default()
        };
        let clauses = Clauses::new(&problem);
        let literals = nodes.into_iter().zip(clauses.items.iter().copied()).collect();
        let mut oracle = Oracle::new(limits, Branching::Inputs);
        clauses.clauses.iter().for_each(|clause| oracle.add(clause));
        Predecessors { bits, initial, literals, oracle, queries: 0 }
    }

    /// A part of the state that never occurs when a scan starts. `None` if the state may occur.
    pub fn excluded(&mut self, state: &[(usize, bool)]) -> Option<State> {
        self.queries = QUERIES;
        self.never(state, DEPTH)
    }

    fn never(&mut self, state: &[(usize, bool)], depth: usize) -> Option<State> {
        let differs = |&&(bit, value): &&(usize, bool)| self.initial[bit] != value;
        let not_initial = *state.iter().find(differs)?;
        while self.queries > 0 {
            self.queries -= 1;
            match self.predecessor(state) {
                Predecessor::Never(mut part) => {
                    // A run may begin in a state in which only the other bits differ.
                    if part.iter().all(|&(bit, value)| self.initial[bit] == value) {
                        part.push(not_initial);
                    }
                    self.exclude(&part);
                    return Some(part);
                }
                Predecessor::Scan(previous) if depth > 0 => {
                    // Once the earlier state is excluded, another scan may leave this one.
                    self.never(&previous, depth - 1)?;
                }
                Predecessor::Scan(_) | Predecessor::Unknown => return None,
            }
        }
        None
    }

    fn predecessor(&mut self, state: &[(usize, bool)]) -> Predecessor {
        let mut assumed = Vec::new();
        for &(bit, value) in state {
            let end = if value { self.bits[bit].end } else { !self.bits[bit].end };
            match end {
                Lit::TRUE => {}
                Lit::FALSE => return Predecessor::Never(vec![(bit, value)]),
                end => assumed.push((self.literal(end), (bit, value))),
            }
        }
        let literals: Vec<i32> = assumed.iter().map(|one| one.0).collect();
        match self.oracle.ask(&literals, Effort::decisions(DECISIONS + literals.len() as u64)) {
            None => Predecessor::Unknown,
            Some(true) => {
                let start = |bit: usize| match self.bits[bit].start {
                    Lit::TRUE => true,
                    Lit::FALSE => false,
                    start => self.oracle.holds(self.literal(start)),
                };
                Predecessor::Scan((0..self.bits.len()).map(|bit| (bit, start(bit))).collect())
            }
            Some(false) => {
                let core = self.oracle.core();
                let mut part: State = Vec::new();
                for literal in core {
                    // The solver may name an assumption or its negation.
                    let same = |one: &&(i32, (usize, bool))| one.0 == literal;
                    let other = |one: &&(i32, (usize, bool))| one.0 == -literal;
                    let found = assumed.iter().find(same).or_else(|| assumed.iter().find(other));
                    part.extend(found.map(|one| one.1));
                }
                Predecessor::Never(self.contradiction(&assumed).unwrap_or(part))
            }
        }
    }

    /// Two bits of a state that have the same function or opposite ones, but not such values.
    fn contradiction(&self, assumed: &[(i32, (usize, bool))]) -> Option<State> {
        let mut seen: FxHashMap<i32, (usize, bool)> = FxHashMap::default();
        assumed.iter().find_map(|&(literal, one)| {
            seen.insert(literal, one);
            seen.get(&-literal).map(|&other| vec![other, one])
        })
    }

    fn exclude(&mut self, part: &[(usize, bool)]) {
        let mut clause = Vec::new();
        for &(bit, value) in part {
            let start = if value { !self.bits[bit].start } else { self.bits[bit].start };
            match start {
                Lit::TRUE => return,
                Lit::FALSE => {}
                start => clause.push(self.literal(start)),
            }
        }
        self.oracle.add(&clause);
    }

    fn literal(&self, lit: Lit) -> i32 {
        let own = self.literals[&lit.node()];
        if lit.is_negated() { -own } else { own }
    }
}

#[cfg(test)]
mod tests {
    use super::super::inductive::tests::model;
    use super::*;

    #[test]
    fn memories_of_one_input_are_never_different() {
        let (model, bits) =
            model(3, |circuit, bits, free| vec![free, free, circuit.and(bits[0], free)]);
        let limits = Limits::default();
        let mut asked = Predecessors::new(&model, bits, vec![false; 3], &limits);
        let mut part = asked.excluded(&[(0, true), (1, false), (2, false)]).expect("impossible");
        part.sort_unstable();
        assert_eq!(part, [(0, true), (1, false)]);
        assert_eq!(asked.excluded(&[(0, true), (1, true)]), None);
        // Bit 2 follows one scan behind.
        assert_eq!(asked.excluded(&[(0, true), (1, true), (2, true)]), None);
        assert!(asked.excluded(&[(0, false), (2, true)]).is_some());
    }

    #[test]
    fn a_state_that_only_an_impossible_one_leaves_is_impossible() {
        // 0 and 1 alternate, 2 comes on only if both are on.
        let (model, bits) =
            model(3, |circuit, bits, free| vec![free, !free, circuit.and(bits[0], bits[1])]);
        let limits = Limits::default();
        let mut asked = Predecessors::new(&model, bits.clone(), vec![false; 3], &limits);
        assert_eq!(asked.excluded(&[(2, true)]), Some(vec![(2, true)]));
        // A run begins with both off.
        assert_eq!(asked.excluded(&[(0, false), (1, false), (2, false)]), None);
        let mut begins_on = Predecessors::new(&model, bits, vec![true, true, false], &limits);
        assert_eq!(begins_on.excluded(&[(2, true)]), None);
    }
}
