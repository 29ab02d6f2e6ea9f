//! What scan after scan keeps: sets of bits that are never all on, as an inductive fixpoint.
//!
//! All candidates hold in the state in which runs begin. Those that a scan can break which starts where all of them hold
//! are dropped, until a scan that starts where all that are left hold keeps them all (Houdini: C. Flanagan and K. R. M.
//! Leino, FME 2001). What is left does not depend on the order: it is the largest inductive set of candidates.

use super::Limits;
use super::clauses::Clauses;
use super::oracle::{Branching, Effort, Oracle};
use super::problem::{Item, Problem};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rustc_hash::FxHashMap;
use scanbound_model::{Assignment, Atom, Lit, Node, ScanModel, VarId, VarKind};

/// So many scans are evaluated at once: a bit each of a machine word.
const LANES: usize = 64;
/// So many decisions one question may take, besides those for what it assumes.
const DECISIONS: u64 = 5_000_000;
/// So many scans are followed from the one that was found on.
const FOLLOWING: usize = 16;
/// So many questions are asked before the search is given up.
const ROUNDS: usize = 3_000;

/// A bit when a scan starts and when it ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kept {
    /// Its value when the scan starts.
    pub start: Lit,
    /// Its value when it ends.
    pub end: Lit,
}

/// Those of the candidates that every scan keeps which starts where they all hold: each is a list of indices into `bits`
/// of which not all are ever on. `None` if the limits end the search: nothing is known of any then.
#[must_use]
pub fn inductive(
    model: &ScanModel,
    bits: &[Kept],
    candidates: Vec<Vec<usize>>,
    limits: &Limits<'_>,
) -> Option<Vec<Vec<usize>>> {
    let mut search = Search::new(model, bits, limits);
    let mut open: Vec<Candidate> =
        candidates.into_iter().map(|one| search.candidate(one, bits)).collect();
    for _ in 0..ROUNDS {
        if limits.reached() {
            return None;
        }
        let Some(scan) = search.broken(&open)? else {
            return Some(open.into_iter().map(|one| one.bits).collect());
        };
        let before = open.len();
        // Further scans may follow: where one ends all candidates hold that are left then.
        let mut lanes = search.like(&scan);
        for _ in 0..FOLLOWING {
            let scans = Scans::of(model, &lanes);
            open.retain(|one| {
                let ends = one.bits.iter().map(|&bit| scans.lit(bits[bit].end));
                ends.fold(scans.possible, |all, end| all & end) == 0
            });
            search.follow(&scan, &scans, bits, &mut lanes);
        }
        if open.len() == before {
            // What the solver found is no scan that breaks one of them, which is never so.
            return None;
        }
    }
    None
}

/// Some bits that may never be all on.
struct Candidate {
    bits: Vec<usize>,
    /// While this variable is assumed, they are not all on when the scan starts.
    holds: i32,
    /// Where this one is true, they are all on when it ends.
    broken: i32,
}

/// A solver that knows what one scan makes of the bits.
struct Search<'a> {
    model: &'a ScanModel,
    problem: Problem,
    clauses: Clauses,
    /// The clauses' literal of each node that is a bit's start or end.
    literals: FxHashMap<usize, i32>,
    /// The variables that are a bit's start: to turn one off breaks no candidate.
    starts: Vec<bool>,
    /// The variables that constraints speak of.
    tied: Vec<bool>,
    /// What words are compared with.
    thresholds: FxHashMap<VarId, Vec<u16>>,
    oracle: Oracle<'a>,
    variables: i32,
    random: Pcg64Mcg,
}

impl<'a> Search<'a> {
    fn new(model: &'a ScanModel, bits: &[Kept], limits: &'a Limits<'a>) -> Search<'a> {
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
        let variables = i32::try_from(clauses.variables).expect("variables are counted in 31 bits");
        let random = Pcg64Mcg::seed_from_u64(1);
        Search {
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

    /// A literal is true where this variable is.
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

    /// Tells the solver of a candidate.
    fn candidate(&mut self, bits: Vec<usize>, kept: &[Kept]) -> Candidate {
        let (holds, broken) = (self.fresh(), self.fresh());
        let start = |&bit: &usize| {
            let start = kept[bit].start;
            let own = self.literals[&start.node()];
            if start.is_negated() { own } else { -own }
        };
        let clause: Vec<i32> = bits.iter().map(start).chain([-holds]).collect();
        self.oracle.add(&clause);
        for &bit in &bits {
            self.implies(broken, kept[bit].end);
        }
        Candidate { bits, holds, broken }
    }

    /// A scan that starts where all of these hold and breaks one of them, if there is one. Ends with `None` if that takes too
    /// much.
    fn broken(&mut self, open: &[Candidate]) -> Option<Option<Assignment>> {
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

    /// A scan, the first lane, and others that start where the same candidates hold.
    fn like(&mut self, scan: &Assignment) -> Vec<Lane> {
        let places = 0..scan.0.len();
        places.map(|place| self.varied(scan, place, self.starts[place])).collect()
    }

    /// The scans after these: they start with what the bits held at the end, and all else is much as in the first one.
    fn follow(&mut self, scan: &Assignment, scans: &Scans, bits: &[Kept], lanes: &mut [Lane]) {
        for (place, lane) in lanes.iter_mut().enumerate() {
            if !self.starts[place] {
                *lane = self.varied(scan, place, false);
            }
        }
        for bit in bits {
            let Node::Atom(atom) = self.model.circuit.node(bit.start) else { continue };
            // What was no scan is followed by none: its start is taken again.
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

    /// A variable's value in a scan, and others in the lanes behind the first; only off where it is on if `down`.
    fn varied(&mut self, scan: &Assignment, place: usize, down: bool) -> Lane {
        let Search { model, tied, thresholds, random, .. } = self;
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

/// The variables that a model's constraints speak of.
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

/// A variable's values in some scans.
enum Lane {
    Bit(u64),
    /// The same in all.
    Word(u16),
    Words(Box<[u16; LANES]>),
}

impl Lane {
    /// The words of a word's lane, each of which may be changed.
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

/// The values of all nodes in some scans.
struct Scans {
    nodes: Vec<u64>,
    /// Those that keep the constraints.
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
        let kept = model.constraints.iter().map(|&one| scans.lit(one));
        scans.possible = kept.fold(u64::MAX, |all, one| all & one);
        scans
    }

    fn lit(&self, lit: Lit) -> u64 {
        let values = self.nodes[lit.node()];
        if lit.is_negated() { !values } else { values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_ir::{AreaId, Cell};
    use scanbound_model::{Circuit, Origin, Variable};

    /// A model of bits that hold from scan to scan what these functions make of them and of one free bit, the last.
    fn model(
        bits: u32,
        ends: impl Fn(&mut Circuit, &[Lit], Lit) -> Vec<Lit>,
    ) -> (ScanModel, Vec<Kept>) {
        let mut model = ScanModel::default();
        for index in 0..=bits {
            let origin = Origin::Start(Cell { area: AreaId(0), index });
            model.variables.push(Variable { kind: VarKind::Bit, origin, name: String::new() });
        }
        let all: Vec<Lit> =
            (0..=bits).map(|index| model.circuit.atom(Atom::Bit(VarId(index)))).collect();
        let (starts, free) = (&all[..bits as usize], all[bits as usize]);
        let ends = ends(&mut model.circuit, starts, free);
        let kept = starts.iter().zip(ends).map(|(&start, end)| Kept { start, end }).collect();
        (model, kept)
    }

    fn pairs(bits: usize) -> Vec<Vec<usize>> {
        (0..bits).flat_map(|a| (0..a).map(move |b| vec![b, a])).collect()
    }

    #[test]
    fn steps_of_a_ring_are_never_both_on_and_all_pairs_are_needed_for_that() {
        // Each step hands on to the next where the free bit is on.
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
        // That steps 0 and 3 exclude each other is what any two steps that far apart rest on.
        assert!(found.len() == 5 && !found.contains(&vec![1, 4]), "{found:?}");
    }

    #[test]
    fn what_one_scan_can_break_is_dropped_and_what_rests_on_it() {
        // Bit 0 follows the free bit, 1 its negation, 2 is 0 and 1 together, 3 keeps itself or takes 2.
        let ends = |circuit: &mut Circuit, bits: &[Lit], free: Lit| {
            let both = circuit.and(bits[0], bits[1]);
            let kept = circuit.or(bits[3], bits[2]);
            vec![free, !free, both, kept]
        };
        let (model, bits) = model(4, ends);
        let limits = Limits::default();
        let units: Vec<Vec<usize>> = (0..4).map(|bit| vec![bit]).collect();
        let found = |candidates| inductive(&model, &bits, candidates, &limits).expect("in time");
        // Without the pair, 2 may come on; with it neither it nor 3 ever does.
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
