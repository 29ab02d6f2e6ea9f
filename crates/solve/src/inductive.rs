//! Inductive invariants over scans: sets of bits that are never all on at the start of a scan.
//!
//! All candidates hold in the initial state. A candidate is dropped if a scan that starts with all candidates true can
//! violate it. This is repeated until every scan preserves all that remain (Houdini: C. Flanagan and K. R. M. Leino,
//! FME 2001). The result does not depend on the order: it is the largest inductive subset of the candidates.

use super::Limits;
use super::clauses::Clauses;
use super::oracle::{Branching, Effort, Oracle};
use super::problem::{Item, Problem};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rustc_hash::FxHashMap;
use scanbound_model::{Assignment, Atom, Lit, Node, ScanModel, VarId, VarKind};

/// The number of scans that are evaluated at once, one in each bit of a machine word.
const LANES: usize = 64;
/// The largest number of decisions of one query, besides those for its assumptions.
const DECISIONS: u64 = 5_000_000;
/// The number of successive scans that are simulated after the one that was found.
const FOLLOWING: usize = 16;
/// The largest number of queries; after it the search is given up, and nothing is known.
const ROUNDS: usize = 3_000;

/// The literals of a bit at the start and at the end of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BitTransition {
    /// The literal that the bit is on at the start of the scan.
    pub start: Lit,
    /// The literal that the bit is on at the end of the scan.
    pub end: Lit,
}

/// The largest set of candidates such that a scan that starts with all of them true also ends with all of them true. A
/// candidate is a list of indices into `bits`; it says that these bits are never all on. The caller must know that the
/// candidates hold when a run begins. `None` if the search takes too long; then nothing is known.
#[must_use]
pub fn inductive(
    model: &ScanModel,
    bits: &[BitTransition],
    candidates: Vec<Vec<usize>>,
    limits: &Limits<'_>,
) -> Option<Vec<Vec<usize>>> {
    let mut search = InductiveSearch::new(model, bits, limits);
    let mut open: Vec<Candidate> =
        candidates.into_iter().map(|one| search.candidate(one, bits)).collect();
    for _ in 0..ROUNDS {
        if limits.reached() {
            return None;
        }
        let Some(scan) = search.violated_candidate(&open)? else {
            return Some(open.into_iter().map(|one| one.bits).collect());
        };
        let before = open.len();
        // Simulate successive scans: at the end of one, all remaining candidates hold, so another may start there.
        let mut lanes = search.variations(&scan);
        for _ in 0..FOLLOWING {
            let scans = Scans::of(model, &lanes);
            open.retain(|one| {
                let ends = one.bits.iter().map(|&bit| scans.lit(bits[bit].end));
                ends.fold(scans.possible, |all, end| all & end) == 0
            });
            search.follow(&scan, &scans, bits, &mut lanes);
        }
        if open.len() == before {
            // The solver's model violates no candidate, which must not happen.
            return None;
        }
    }
    None
}

/// A candidate: a set of bits that are perhaps never all on.
struct Candidate {
    bits: Vec<usize>,
    /// The variable that is assumed to say that the candidate's bits are not all on at the start of the scan.
    holds: i32,
    /// The variable that implies that all bits of the candidate are on at the end of the scan.
    broken: i32,
}

/// A solver with the clauses of one scan and of the candidates, and what is needed to vary a scan that it finds.
struct InductiveSearch<'a> {
    model: &'a ScanModel,
    problem: Problem,
    clauses: Clauses,
    /// The literal of each circuit node that is the start or end of a bit.
    literals: FxHashMap<usize, i32>,
    /// For each variable, whether it is the start value of a bit. Turning such a bit off violates no candidate.
    starts: Vec<bool>,
    /// For each variable, whether a constraint depends on it; such variables are not varied.
    tied: Vec<bool>,
    /// For each word, the constants with which it is compared.
    thresholds: FxHashMap<VarId, Vec<u16>>,
    oracle: Oracle<'a>,
    variables: i32,
    random: Pcg64Mcg,
}

impl<'a> InductiveSearch<'a> {
    fn new(
        model: &'a ScanModel,
        bits: &[BitTransition],
        limits: &'a Limits<'a>,
    ) -> InductiveSearch<'a> {
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
        let mut starts = vec![false; model.variables.len()];
        for bit in bits {
            if let Node::Atom(atom) = model.circuit.node(bit.start) {
                starts[atom.variable().0 as usize] = true;
            }
        }
        let mut thresholds: FxHashMap<VarId, Vec<u16>> = FxHashMap::default();
        for node in model.circuit.nodes() {
            if let Node::Atom(Atom::AtLeast(word, threshold)) = *node {
                thresholds.entry(word).or_default().push(threshold);
            }
        }
        let tied = tied(model);
        let mut oracle = Oracle::new(limits, Branching::Inputs);
        clauses.clauses.iter().for_each(|clause| oracle.add(clause));
        let variables =
            i32::try_from(clauses.variables).expect("the number of variables must fit in 31 bits");
        let random = Pcg64Mcg::seed_from_u64(1);
        InductiveSearch {
            model,
            problem,
            clauses,
            literals,
            starts,
            tied,
            thresholds,
            oracle,
            variables,
            random,
        }
    }

    fn fresh(&mut self) -> i32 {
        self.variables += 1;
        self.variables
    }

    /// Adds the clause that says: if the variable is true, the literal is true.
    fn implies(&mut self, variable: i32, lit: Lit) {
        match lit {
            Lit::TRUE => {}
            Lit::FALSE => self.oracle.add(&[-variable]),
            lit => {
                let own = self.literals[&lit.node()];
                self.oracle.add(&[-variable, if lit.is_negated() { -own } else { own }]);
            }
        }
    }

    /// Adds the variables and clauses of a candidate with these bits to the solver.
    fn candidate(&mut self, bits: Vec<usize>, transitions: &[BitTransition]) -> Candidate {
        let (holds, broken) = (self.fresh(), self.fresh());
        let start = |&bit: &usize| {
            let start = transitions[bit].start;
            let own = self.literals[&start.node()];
            if start.is_negated() { own } else { -own }
        };
        let clause: Vec<i32> = bits.iter().map(start).chain([-holds]).collect();
        self.oracle.add(&clause);
        for &bit in &bits {
            self.implies(broken, transitions[bit].end);
        }
        Candidate { bits, holds, broken }
    }

    /// A scan that starts with all of these candidates true and violates one of them, if there is one. The outer `None`
    /// means that the query took too long.
    fn violated_candidate(&mut self, open: &[Candidate]) -> Option<Option<Assignment>> {
        let round = self.fresh();
        let one: Vec<i32> = open.iter().map(|one| one.broken).chain([-round]).collect();
        self.oracle.add(&one);
        let assumed: Vec<i32> = open.iter().map(|one| one.holds).chain([round]).collect();
        let found =
            self.oracle.ask(&assumed, Effort::decisions(DECISIONS + assumed.len() as u64))?;
        let holds = |variable| self.oracle.holds(variable);
        let scan = found.then(|| self.clauses.assignment(&self.problem, holds));
        self.oracle.add(&[-round]);
        Some(scan)
    }

    /// Lanes with this scan in the first lane. The other lanes have variations of it that start with the same
    /// candidates true.
    fn variations(&mut self, scan: &Assignment) -> Vec<Lane> {
        let places = 0..scan.0.len();
        places.map(|place| self.varied(scan, place, self.starts[place])).collect()
    }

    /// Replaces the lanes by the starts of the next scans: each bit has the value that it has at the end of `scans`;
    /// the other variables have values similar to those of the scan `scan`.
    fn follow(
        &mut self,
        scan: &Assignment,
        scans: &Scans,
        bits: &[BitTransition],
        lanes: &mut [Lane],
    ) {
        for (place, lane) in lanes.iter_mut().enumerate() {
            if !self.starts[place] {
                *lane = self.varied(scan, place, false);
            }
        }
        for bit in bits {
            let Node::Atom(atom) = self.model.circuit.node(bit.start) else { continue };
            // An impossible scan has no successor, so its start is used again.
            let end = scans.lit(bit.end);
            match (&mut lanes[atom.variable().0 as usize], atom) {
                (Lane::Bit(values), _) => {
                    *values = *values & !scans.possible | end & scans.possible
                }
                (lane, Atom::WordBit(_, place)) => {
                    for (at, word) in lane.words().iter_mut().enumerate() {
                        if scans.possible >> at & 1 == 1 {
                            *word = *word & !(1 << place) | ((end >> at & 1) as u16) << place;
                        }
                    }
                }
                (Lane::Word(_) | Lane::Words(_), _) => {}
            }
        }
    }

    /// The values of a variable: that of the scan in the first lane, random variations in the others. With `down`, bits
    /// are only turned off.
    fn varied(&mut self, scan: &Assignment, place: usize, down: bool) -> Lane {
        let InductiveSearch { model, tied, thresholds, random, .. } = self;
        let value = scan.0[place];
        let kind = model.variables[place].kind;
        let mut some = || u64::from(random.next_u32()) << 32 | u64::from(random.next_u32());
        let changed = if tied[place] { 0 } else { some() & some() & !1 };
        let on = if value == 0 { 0 } else { u64::MAX };
        match (kind, thresholds.get(&VarId(place as u32))) {
            (VarKind::Bit, _) if down => Lane::Bit(on & !changed),
            (VarKind::Bit, _) => Lane::Bit(on ^ changed),
            (VarKind::Word, _) if down => {
                let changed = !tied[place];
                let mut off = |lane: usize| if changed && lane > 0 { some() & some() } else { 0 };
                Lane::Words(std::array::from_fn(|lane| value & !(off(lane) as u16)).into())
            }
            (VarKind::Word, Some(of)) if changed & 2 != 0 => {
                let mut values = [value; LANES];
                for (lane, own) in values.iter_mut().enumerate() {
                    if changed >> lane & 1 == 1 {
                        let random = some();
                        *own =
                            of[(random >> 1) as usize % of.len()].wrapping_sub((random & 1) as u16);
                    }
                }
                Lane::Words(Box::new(values))
            }
            (VarKind::Word, _) => Lane::Word(value),
        }
    }
}

/// For each variable of a model, whether a constraint depends on it.
fn tied(model: &ScanModel) -> Vec<bool> {
    let nodes = model.circuit.nodes();
    let mut reached = vec![false; nodes.len()];
    model.constraints.iter().for_each(|one| reached[one.node()] = true);
    let mut tied = vec![false; model.variables.len()];
    for (at, node) in nodes.iter().enumerate().rev() {
        match *node {
            _ if !reached[at] => {}
            Node::True => {}
            Node::Atom(atom) => tied[atom.variable().0 as usize] = true,
            Node::And(a, b) => (reached[a.node()], reached[b.node()]) = (true, true),
        }
    }
    tied
}

/// The values of one variable in all lanes: the 64 scans that are evaluated at once.
enum Lane {
    Bit(u64),
    /// A word with the same value in all lanes.
    Word(u16),
    Words(Box<[u16; LANES]>),
}

impl Lane {
    /// Gives each lane its own copy of the word, so that each can be changed separately.
    fn words(&mut self) -> &mut [u16] {
        if let Lane::Word(value) = *self {
            *self = Lane::Words(Box::new([value; LANES]));
        }
        match self {
            Lane::Words(words) => &mut words[..],
            Lane::Bit(_) | Lane::Word(_) => &mut [],
        }
    }

    fn of(&self, atom: Atom) -> u64 {
        let holds = |value: u16| match atom {
            Atom::Bit(_) => value != 0,
            Atom::AtLeast(_, threshold) => value >= threshold,
            Atom::WordBit(_, bit) => value >> bit & 1 == 1,
        };
        match self {
            Lane::Bit(values) => *values,
            Lane::Word(value) => {
                if holds(*value) {
                    u64::MAX
                } else {
                    0
                }
            }
            Lane::Words(values) => {
                let lanes = values.iter().enumerate();
                lanes.fold(0, |all, (lane, &value)| all | u64::from(holds(value)) << lane)
            }
        }
    }
}

/// The values of all circuit nodes in all lanes, one bit for each lane.
struct Scans {
    nodes: Vec<u64>,
    /// The lanes whose scans satisfy the constraints.
    possible: u64,
}

impl Scans {
    fn of(model: &ScanModel, lanes: &[Lane]) -> Scans {
        let mut scans = Scans { nodes: Vec::new(), possible: u64::MAX };
        for node in model.circuit.nodes() {
            let values = match *node {
                Node::True => u64::MAX,
                Node::Atom(atom) => lanes[atom.variable().0 as usize].of(atom),
                Node::And(a, b) => scans.lit(a) & scans.lit(b),
            };
            scans.nodes.push(values);
        }
        let constraints = model.constraints.iter().map(|&one| scans.lit(one));
        scans.possible = constraints.fold(u64::MAX, |all, one| all & one);
        scans
    }

    fn lit(&self, lit: Lit) -> u64 {
        let values = self.nodes[lit.node()];
        if lit.is_negated() { !values } else { values }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use scanbound_ir::{AreaId, Cell};
    use scanbound_model::{Circuit, Origin, Variable};

    /// A model of bits whose values at the end of a scan are these functions of their start values and of one free bit,
    /// the last one.
    pub(crate) fn model(
        bits: u32,
        ends: impl Fn(&mut Circuit, &[Lit], Lit) -> Vec<Lit>,
    ) -> (ScanModel, Vec<BitTransition>) {
        let mut model = ScanModel::default();
        for index in 0..=bits {
            let origin = Origin::Start(Cell { area: AreaId(0), index });
            model.variables.push(Variable { kind: VarKind::Bit, origin, name: String::new() });
        }
        let all: Vec<Lit> =
            (0..=bits).map(|index| model.circuit.atom(Atom::Bit(VarId(index)))).collect();
        let (starts, free) = (&all[..bits as usize], all[bits as usize]);
        let ends = ends(&mut model.circuit, starts, free);
        let transitions =
            starts.iter().zip(ends).map(|(&start, end)| BitTransition { start, end }).collect();
        (model, transitions)
    }

    fn pairs(bits: usize) -> Vec<Vec<usize>> {
        (0..bits).flat_map(|a| (0..a).map(move |b| vec![b, a])).collect()
    }

    #[test]
    fn steps_of_a_ring_are_never_both_on_and_all_pairs_are_needed_for_that() {
        // A ring counter: each step passes its token to the next if the free bit is on.
        let ring = |circuit: &mut Circuit, steps: &[Lit], go: Lit| -> Vec<Lit> {
            let before = |step: usize| steps[(step + steps.len() - 1) % steps.len()];
            (0..steps.len()).map(|step| circuit.ite(go, before(step), steps[step])).collect()
        };
        let (model, bits) = model(5, ring);
        let limits = Limits::default();
        let found = inductive(&model, &bits, pairs(5), &limits).expect("in time");
        assert_eq!(found.len(), 10);
        let fewer: Vec<Vec<usize>> = pairs(5).into_iter().filter(|pair| *pair != [0, 3]).collect();
        let found = inductive(&model, &bits, fewer, &limits).expect("in time");
        // The mutual exclusion of steps 0 and 3 is needed to prove that of the other steps at the same distance.
        assert!(found.len() == 5 && !found.contains(&vec![1, 4]), "{found:?}");
    }

    #[test]
    fn what_one_scan_can_break_is_dropped_and_what_rests_on_it() {
        // Bit 0 follows the free bit, bit 1 its negation, bit 2 is 0 AND 1, bit 3 holds itself or is set by 2.
        let ends = |circuit: &mut Circuit, bits: &[Lit], free: Lit| {
            let both = circuit.and(bits[0], bits[1]);
            let held_or_set = circuit.or(bits[3], bits[2]);
            vec![free, !free, both, held_or_set]
        };
        let (model, bits) = model(4, ends);
        let limits = Limits::default();
        let units: Vec<Vec<usize>> = (0..4).map(|bit| vec![bit]).collect();
        let found = |candidates| inductive(&model, &bits, candidates, &limits).expect("in time");
        // Without the pair, bit 2 may be on; with it neither bit 2 nor bit 3 is ever on.
        assert_eq!(found(units.clone()), [[0usize; 1]; 0]);
        let with: Vec<Vec<usize>> = units.into_iter().chain([vec![0, 1]]).collect();
        assert_eq!(found(with), [vec![2], vec![3], vec![0, 1]]);
    }

    #[test]
    fn limits_end_the_search_with_nothing() {
        let (model, bits) = model(2, |_, bits, _| bits.to_vec());
        let limits = Limits { cancelled: &|| true, ..Limits::default() };
        assert_eq!(inductive(&model, &bits, pairs(2), &limits), None);
    }
}
