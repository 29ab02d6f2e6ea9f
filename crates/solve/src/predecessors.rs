//! Start states that no earlier scan can leave: asks for a scan that ends in a state, then for one that ends in the
//! state in which that scan starts, and so on.
//!
//! A state that no scan leaves but one that starts in it, and in which no run begins, never occurs. The solver names
//! the bits that exclude it; these exclude the state of an earlier scan, too. (Property directed reachability,
//! A. R. Bradley, VMCAI 2011, to a small depth.)

use super::Limits;
use super::clauses::Clauses;
use super::oracle::{Branching, Effort, Oracle};
use super::problem::{Item, Problem};
use rustc_hash::FxHashMap;
use scanbound_model::{Lit, ScanModel, VarId};

/// The largest number of solver decisions of one query.
const DECISIONS: u64 = 500_000;
/// The most queries for one state, besides those of [`SMALLER`] and those whether the first scan of a run leaves a
/// state.
const QUERIES: usize = 128;
/// The most queries by which one excluded part of a state is made smaller. Each is much shorter than the search for
/// another scan, which a larger part makes necessary more often.
const SMALLER: usize = 512;

/// Values of some bits: indices into the list of bits, each with its value.
pub type State = Vec<(usize, bool)>;

/// Whether a scan starts in a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StartState {
    /// A scan may start in the state: a run begins with it, or a scan leaves it that starts in a state that may occur
    /// itself.
    MayOccur,
    /// No scan starts in the state: these values, which are a part of the state, occur at the start of no scan.
    Excluded(State),
    /// The search ended before this was decided: at its largest number of queries, at a query that took too long, or at
    /// the limits.
    Undecided,
}

/// A bit that keeps its value from the end of a scan to the start of the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateBit {
    /// The literal that the bit is on at the start of the scan.
    pub start: Lit,
    /// The literal that the scan leaves the bit on; in a model for lower bounds, that it certainly does.
    pub on: Lit,
    /// The literal that the scan leaves the bit off; in a model for lower bounds, that it certainly does.
    pub off: Lit,
    /// The value of the bit when a run begins with cleared memory.
    pub initial: bool,
}

/// Answers which states never occur when a scan starts: a solver with the clauses of one scan, and the parts of states
/// that were excluded so far.
pub struct Predecessors<'a> {
    bits: Vec<StateBit>,
    /// The literal of each circuit node that is the start or end of a bit.
    literals: FxHashMap<usize, i32>,
    oracle: Oracle<'a>,
    limits: &'a Limits<'a>,
    /// The number of the last variable of the solver.
    variables: i32,
    queries: usize,
}

/// The answer of a query whether a scan that starts in another state leaves a state.
enum Predecessor {
    /// A scan leaves the state; this is the state in which it starts (all bits).
    Scan(State),
    /// No scan leaves these values, which are a part of the state, unless it starts with them.
    Never(State),
    /// The query took too long.
    Unknown,
}

impl<'a> Predecessors<'a> {
    /// Prepares the questions about a model.
    #[must_use]
    pub fn new(model: &ScanModel, bits: Vec<StateBit>, limits: &'a Limits<'a>) -> Predecessors<'a> {
        let ends = |bit: &StateBit| [bit.start, bit.on, bit.off].map(Lit::node);
        let mut nodes: Vec<usize> = bits.iter().flat_map(ends).collect();
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
        let variables =
            i32::try_from(clauses.variables).expect("the number of variables must fit in 31 bits");
        Predecessors { bits, literals, oracle, limits, variables, queries: 0 }
    }

    /// Whether a scan of a run that begins with the initial values starts in this state (values of some bits), by the
    /// model.
    pub fn occurs(&mut self, state: &[(usize, bool)]) -> StartState {
        self.queries = QUERIES;
        self.search(state)
    }

    fn search(&mut self, state: &[(usize, bool)]) -> StartState {
        // States whose predecessors are searched, each left by a scan that starts in the next one.
        let mut chain: Vec<State> = vec![state.to_vec()];
        while let Some(state) = chain.last().cloned() {
            if self.may_begin(&state) || matches!(self.left_by_first(&state), Some(true)) {
                return StartState::MayOccur;
            }
            if self.queries == 0 {
                return StartState::Undecided;
            }
            self.queries -= 1;
            let part = match self.predecessor(&state) {
                Predecessor::Never(core) => self.exclude(core, &state),
                Predecessor::Scan(previous) => match self.inductive_part(&state, &previous) {
                    Some(part) => part,
                    None => {
                        chain.push(previous);
                        continue;
                    }
                },
                Predecessor::Unknown => return StartState::Undecided,
            };
            // Once a state is excluded, another scan may leave the state before it in the chain.
            chain.pop();
            if chain.is_empty() {
                return StartState::Excluded(part);
            }
        }
        StartState::Undecided
    }

    /// Whether a scan that starts with the initial values leaves the state. `None` if that is not decided.
    fn left_by_first(&mut self, state: &[(usize, bool)]) -> Option<bool> {
        if self.limits.reached() {
            return None;
        }
        let starts: Vec<(Lit, bool)> =
            self.bits.iter().map(|bit| (bit.start, bit.initial)).collect();
        let ends = state.iter().map(|&(bit, value)| {
            let bit = self.bits[bit];
            (if value { bit.on } else { bit.off }, true)
        });
        let mut assumed = Vec::new();
        for (lit, value) in starts.into_iter().chain(ends.collect::<Vec<_>>()) {
            match if value { lit } else { !lit } {
                Lit::TRUE => {}
                Lit::FALSE => return Some(false),
                lit => assumed.push(self.literal(lit)),
            }
        }
        self.oracle.ask(&assumed, Effort::decisions(DECISIONS + assumed.len() as u64))
    }

    /// A part of a state that no scan leaves unless it starts with it, and with which no run begins; it is also
    /// excluded. `previous` is the start of a scan that leaves the state. `None` if there is no such part, or the
    /// queries are used up.
    fn inductive_part(&mut self, state: &[(usize, bool)], previous: &State) -> Option<State> {
        let is_in = |previous: &State, &(bit, value): &(usize, bool)| previous[bit].1 == value;
        let mut part: State = state.to_vec();
        part.retain(|one| is_in(previous, one));
        while self.queries > 0 && !self.may_begin(&part) {
            self.queries -= 1;
            match self.predecessor(&part) {
                Predecessor::Never(core) => return Some(self.exclude(core, &part)),
                Predecessor::Scan(previous) => part.retain(|one| is_in(&previous, one)),
                Predecessor::Unknown => return None,
            }
        }
        None
    }

    /// Whether a run begins with these values.
    fn may_begin(&self, part: &[(usize, bool)]) -> bool {
        part.iter().all(|&(bit, value)| self.bits[bit].initial == value)
    }

    /// A part of `part` that is excluded too: leaves out values that are not needed for that, with at most [`SMALLER`]
    /// queries.
    fn smaller(&mut self, mut part: State) -> State {
        // The bits of words are the last ones: a part that holds for many values of a word is wanted most.
        let mut at = part.len();
        for _ in 0..SMALLER {
            at = at.min(part.len());
            if at == 0 || part.len() < 2 {
                break;
            }
            at -= 1;
            let mut less = part.clone();
            less.remove(at);
            match (!self.may_begin(&less)).then(|| self.predecessor(&less)) {
                Some(Predecessor::Never(core)) if !self.may_begin(&core) => {
                    part.retain(|one| core.contains(one));
                }
                Some(Predecessor::Never(_)) => part = less,
                _ => {}
            }
        }
        part
    }

    /// Asks for a scan that leaves the state and starts in another one.
    fn predecessor(&mut self, state: &[(usize, bool)]) -> Predecessor {
        // The solver looks at the clock only in long queries, and these are mostly short.
        if self.limits.reached() {
            return Predecessor::Unknown;
        }
        let mut assumed = Vec::new();
        for &(bit, value) in state {
            match if value { self.bits[bit].on } else { self.bits[bit].off } {
                Lit::TRUE => {}
                Lit::FALSE => return Predecessor::Never(vec![(bit, value)]),
                end => assumed.push((self.literal(end), (bit, value))),
            }
        }
        self.variables += 1;
        let another = self.variables;
        let mut differs = self.differs_at_start(state);
        differs.push(-another);
        self.oracle.add(&differs);
        let literals: Vec<i32> = assumed.iter().map(|one| one.0).chain([another]).collect();
        let effort = Effort::decisions(DECISIONS + literals.len() as u64);
        let answer = match self.oracle.ask(&literals, effort) {
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
                // The solver may name an assumption or its negation. Several bits may have the same end.
                let core = self.oracle.core();
                let same = |literal: i32| core.iter().any(|one| one.abs() == literal.abs());
                let mut seen = Vec::new();
                let mut is_new = |literal: i32| {
                    let is_new = !seen.contains(&literal);
                    seen.push(literal);
                    is_new
                };
                let named = assumed.iter().filter(|one| same(one.0) && is_new(one.0));
                Predecessor::Never(named.map(|one| one.1).collect())
            }
        };
        self.oracle.add(&[-another]);
        answer
    }

    /// Excludes a part of the state `state`, which no scan leaves. If a run may begin with this part, first adds a
    /// value of `state` with which no run begins. Returns the part that was excluded, from which unnecessary values
    /// were removed.
    fn exclude(&mut self, mut part: State, state: &[(usize, bool)]) -> State {
        if self.may_begin(&part) {
            let differs = |&&(bit, value): &&(usize, bool)| self.bits[bit].initial != value;
            part.extend(state.iter().find(differs));
        }
        let part = self.smaller(part);
        let clause = self.differs_at_start(&part);
        self.oracle.add(&clause);
        part
    }

    /// The clause that a scan does not start with these values.
    fn differs_at_start(&self, state: &[(usize, bool)]) -> Vec<i32> {
        let other = |&(bit, value): &(usize, bool)| {
            let start = self.literal(self.bits[bit].start);
            if value { -start } else { start }
        };
        state.iter().map(other).collect()
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
    use scanbound_model::Circuit;

    fn asked<'a>(
        bits: u32,
        ends: impl Fn(&mut Circuit, &[Lit], Lit) -> Vec<Lit>,
        initial: &[bool],
        limits: &'a Limits<'a>,
    ) -> Predecessors<'a> {
        let (model, bits) = model(bits, ends);
        let state = bits.iter().zip(initial).map(|(bit, &initial)| StateBit {
            start: bit.start,
            on: bit.end,
            off: !bit.end,
            initial,
        });
        Predecessors::new(&model, state.collect(), limits)
    }

    #[test]
    fn memories_of_one_input_are_never_different() {
        let limits = Limits::default();
        let ends = |circuit: &mut Circuit, bits: &[Lit], free| {
            vec![free, free, circuit.and(bits[0], free)]
        };
        let mut asked = asked(3, ends, &[false; 3], &limits);
        let StartState::Excluded(mut part) = asked.occurs(&[(0, true), (1, false), (2, false)])
        else {
            panic!("it is impossible");
        };
        part.sort_unstable();
        assert_eq!(part, [(0, true), (1, false)]);
        assert_eq!(asked.occurs(&[(0, true), (1, true)]), StartState::MayOccur);
        // Bit 2 follows one scan behind.
        assert_eq!(asked.occurs(&[(0, true), (1, true), (2, true)]), StartState::MayOccur);
        assert!(matches!(asked.occurs(&[(0, false), (2, true)]), StartState::Excluded(_)));
    }

    #[test]
    fn a_state_that_only_an_impossible_one_leaves_is_impossible() {
        // 0 and 1 alternate, 2 comes on only if both are on.
        let ends = |circuit: &mut Circuit, bits: &[Lit], free: Lit| {
            vec![free, !free, circuit.and(bits[0], bits[1])]
        };
        let limits = Limits::default();
        let mut begins_off = asked(3, ends, &[false; 3], &limits);
        assert_eq!(begins_off.occurs(&[(2, true)]), StartState::Excluded(vec![(2, true)]));
        // A run begins with both off.
        assert_eq!(begins_off.occurs(&[(0, false), (1, false), (2, false)]), StartState::MayOccur);
        let mut begins_on = asked(3, ends, &[true, true, false], &limits);
        assert_eq!(begins_on.occurs(&[(2, true)]), StartState::MayOccur);
    }

    #[test]
    fn a_state_that_only_itself_leads_to_is_impossible() {
        // 0 stays as it is, 1 comes on with the input, 2 comes on with 1 and stays.
        let ends = |circuit: &mut Circuit, bits: &[Lit], free| {
            vec![bits[0], free, circuit.or(bits[1], bits[2])]
        };
        let limits = Limits::default();
        let mut begins_off = asked(3, ends, &[false; 3], &limits);
        assert_eq!(
            begins_off.occurs(&[(0, true), (1, true)]),
            StartState::Excluded(vec![(0, true)])
        );
        assert_eq!(begins_off.occurs(&[(1, false), (2, true)]), StartState::MayOccur);
        let mut begins_on = asked(3, ends, &[true, false, false], &limits);
        assert_eq!(begins_on.occurs(&[(0, true), (1, true)]), StartState::MayOccur);
        assert_eq!(begins_on.occurs(&[(0, false)]), StartState::Excluded(vec![(0, false)]));
    }

    #[test]
    fn states_are_followed_over_many_scans_unless_the_time_is_over() {
        // A bit walks from 0 to 9; the last one stays with it.
        let ends = |_: &mut Circuit, bits: &[Lit], free| {
            std::iter::once(free).chain(bits[..9].iter().copied()).collect()
        };
        let limits = Limits::default();
        let mut walking = asked(10, ends, &[false; 10], &limits);
        assert_eq!(walking.occurs(&[(9, true)]), StartState::MayOccur);
        let never = |_: &mut Circuit, bits: &[Lit], _| {
            std::iter::once(Lit::FALSE).chain(bits[..9].iter().copied()).collect()
        };
        let mut still = asked(10, never, &[false; 10], &limits);
        assert!(matches!(still.occurs(&[(9, true)]), StartState::Excluded(_)));
        let late = Limits { deadline: Some(std::time::Instant::now()), ..Limits::default() };
        let mut late = asked(10, ends, &[false; 10], &late);
        assert_eq!(late.occurs(&[(9, true)]), StartState::Undecided);
    }
}
