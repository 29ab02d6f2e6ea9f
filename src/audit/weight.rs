//! What each free value of a scan is worth: how much less the scan would cost if it alone were another.

use crate::base::time::Picos;
use crate::scan::model::{Assignment, Atom, Lit, Node, ScanModel, Values, VarKind};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// So many other values are tried at once: one a bit.
const LANES: usize = 64;

/// One value that is tried in place of another.
struct Trial {
    /// Which of the variables asked for.
    of: usize,
    variable: usize,
    value: u16,
}

/// For each of these variables the time that the charges lose at most where it alone has another value. A bit is
/// turned over; of a word a few values are tried, since what the program holds against it is mostly 0, 1 or a sign.
pub fn weights(
    model: &ScanModel,
    assignment: &Assignment,
    charges: &[usize],
    variables: &[usize],
) -> Vec<Picos> {
    let mut trials = Vec::new();
    for (of, &variable) in variables.iter().enumerate() {
        let now = assignment.0[variable];
        let others: &[u16] = match model.variables[variable].kind {
            VarKind::Bit => &[0, 1],
            VarKind::Word => &[0, 1, 0x7FFF, 0x8000],
        };
        let others = others.iter().filter(|&&value| value != now);
        trials.extend(others.map(|&value| Trial { of, variable, value }));
    }
    lost(model, assignment, charges, &trials, variables.len())
}

/// The same of bits that are turned over: variables that are bits, or bits of those that are words.
pub fn weights_of_bits(
    model: &ScanModel,
    assignment: &Assignment,
    charges: &[usize],
    bits: &[Atom],
) -> Vec<Picos> {
    let trial = |(of, atom): (usize, &Atom)| {
        let variable = atom.variable().0 as usize;
        Trial { of, variable, value: turned(*atom, assignment.0[variable]) }
    };
    let trials: Vec<Trial> = bits.iter().enumerate().map(trial).collect();
    lost(model, assignment, charges, &trials, bits.len())
}

/// A variable's value with a bit turned over.
pub fn turned(atom: Atom, now: u16) -> u16 {
    match atom {
        Atom::WordBit(_, bit) => now ^ 1 << bit,
        Atom::Bit(_) | Atom::AtLeast(..) => u16::from(now == 0),
    }
}

/// What is lost at most by the trials of each.
fn lost(
    model: &ScanModel,
    assignment: &Assignment,
    charges: &[usize],
    trials: &[Trial],
    count: usize,
) -> Vec<Picos> {
    let values = model.circuit.evaluate(assignment);
    let readers = Readers::of(model);
    let of_some = |trials: &[Trial]| -> Vec<Picos> {
        let mut lane_of: Vec<Vec<usize>> = vec![Vec::new(); model.variables.len()];
        let mut changes = Changes::none(model, &values);
        let of_batch = |batch: &[Trial]| {
            batch.iter().enumerate().for_each(|(lane, trial)| lane_of[trial.variable].push(lane));
            changes.make(model, batch, &lane_of, &readers);
            batch.iter().for_each(|trial| lane_of[trial.variable].clear());
            losses(model, charges, &changes, batch.len())
        };
        trials.chunks(LANES).flat_map(of_batch).collect()
    };
    // Each thread's share is batches as they would be without others.
    let share = trials.len().div_ceil(rayon::current_num_threads()).next_multiple_of(LANES);
    let lost: Vec<Vec<Picos>> = trials.par_chunks(share.max(LANES)).map(of_some).collect();
    let mut worth = vec![Picos::ZERO; count];
    for (trial, lost) in trials.iter().zip(lost.concat()) {
        worth[trial.of] = worth[trial.of].max(lost);
    }
    worth
}

/// The nodes that read each node, and those that read each variable. Nearly all that turns reaches few of them.
struct Readers {
    /// Where the readers of each node begin.
    starts: Vec<u32>,
    nodes: Vec<u32>,
    of_variables: Vec<Vec<u32>>,
}

impl Readers {
    fn of(model: &ScanModel) -> Readers {
        let nodes = model.circuit.nodes();
        let mut starts = vec![0; nodes.len() + 1];
        let mut of_variables = vec![Vec::new(); model.variables.len()];
        let pairs = || {
            nodes.iter().zip(0u32..).flat_map(|(node, reader)| {
                let read = match *node {
                    Node::And(a, b) => [Some(a.node()), Some(b.node())],
                    Node::True | Node::Atom(_) => [None, None],
                };
                read.into_iter().flatten().map(move |node| (node, reader))
            })
        };
        for (node, reader) in nodes.iter().zip(0u32..) {
            if let Node::Atom(atom) = node {
                of_variables[atom.variable().0 as usize].push(reader);
            }
        }
        pairs().for_each(|(node, _)| starts[node + 1] += 1);
        for node in 0..nodes.len() {
            starts[node + 1] += starts[node];
        }
        let mut next = starts.clone();
        let mut readers = vec![0; starts[nodes.len()] as usize];
        for (node, reader) in pairs() {
            readers[next[node] as usize] = reader;
            next[node] += 1;
        }
        Readers { starts, nodes: readers, of_variables }
    }

    fn of_node(&self, node: usize) -> &[u32] {
        &self.nodes[self.starts[node] as usize..self.starts[node + 1] as usize]
    }
}

/// What every node is as things are, and in which lanes it is another.
struct Changes<'a> {
    values: &'a Values,
    turned: Vec<u64>,
    /// The nodes that are another in any lane.
    any: Vec<usize>,
}

impl<'a> Changes<'a> {
    fn none(model: &ScanModel, values: &'a Values) -> Changes<'a> {
        Changes { values, turned: vec![0; model.circuit.nodes().len()], any: Vec::new() }
    }

    /// Those of a batch, and no others.
    fn make(
        &mut self,
        model: &ScanModel,
        batch: &[Trial],
        lane_of: &[Vec<usize>],
        readers: &Readers,
    ) {
        self.any.drain(..).for_each(|index| self.turned[index] = 0);
        let nodes = model.circuit.nodes();
        // A node comes behind what it reads.
        let mut open: BTreeSet<u32> =
            batch.iter().flat_map(|trial| &readers.of_variables[trial.variable]).copied().collect();
        while let Some(index) = open.pop_first() {
            let index = index as usize;
            let now = || self.values.get(Lit::positive(index));
            let turned = match nodes[index] {
                Node::True => 0,
                Node::Atom(atom) => {
                    let is = |word: u16| match atom {
                        Atom::Bit(_) => word != 0,
                        Atom::AtLeast(_, threshold) => word >= threshold,
                        Atom::WordBit(_, bit) => word >> bit & 1 == 1,
                    };
                    let lanes = lane_of[atom.variable().0 as usize].iter();
                    let turns = lanes.filter(|&&lane| is(batch[lane].value) != now());
                    turns.fold(0, |all, &lane| all | 1 << lane)
                }
                Node::And(a, b) => (self.lanes(a) & self.lanes(b)) ^ every(now()),
            };
            if turned != 0 {
                self.turned[index] = turned;
                self.any.push(index);
                open.extend(readers.of_node(index));
            }
        }
    }

    /// What it is in every lane.
    fn lanes(&self, lit: Lit) -> u64 {
        every(self.values.get(lit)) ^ self.turned[lit.node()]
    }

    fn lane(&self, lit: Lit, lane: usize) -> bool {
        self.lanes(lit) >> lane & 1 == 1
    }
}

/// The same in every lane.
fn every(value: bool) -> u64 {
    if value { u64::MAX } else { 0 }
}

/// How much less the charges cost in each lane.
fn losses(model: &ScanModel, charges: &[usize], changes: &Changes<'_>, lanes: usize) -> Vec<Picos> {
    let mut more = vec![Picos::ZERO; lanes];
    let mut less = vec![Picos::ZERO; lanes];
    for &index in charges {
        let charge = &model.charges[index];
        let turned = charge.literals().fold(0, |all, lit| all | changes.turned[lit.node()]);
        if turned == 0 {
            continue;
        }
        let now = charge.cost(changes.values);
        for lane in (0..lanes).filter(|lane| turned >> lane & 1 == 1) {
            let then = charge.cost_by(|lit| changes.lane(lit, lane));
            less[lane] += now.checked_sub(then).unwrap_or_default();
            more[lane] += then.checked_sub(now).unwrap_or_default();
        }
    }
    less.iter().zip(more).map(|(less, more)| less.checked_sub(more).unwrap_or_default()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{AreaId, Cell};
    use crate::scan::model::{Charge, Origin, VarId, Variable};

    #[test]
    fn a_value_is_worth_what_the_scan_loses_without_it() {
        let mut model = ScanModel::default();
        for index in 0..70 {
            model.variables.push(Variable {
                kind: if index == 69 { VarKind::Word } else { VarKind::Bit },
                origin: Origin::Start(Cell { area: AreaId(0), index }),
                name: format!("X{index}"),
            });
        }
        let bits: Vec<Lit> = (0..69).map(|v| model.circuit.atom(Atom::Bit(VarId(v)))).collect();
        let word = model.circuit.atom(Atom::AtLeast(VarId(69), 10));
        let both = model.circuit.and(bits[0], bits[1]);
        let last = model.circuit.and(bits[68], word);
        for (fires, on, off) in [(both, 50, 2), (!bits[1], 10, 0), (last, 7, 0)] {
            model.charges.push(Charge {
                instruction: 0,
                frames: Vec::new(),
                reached: Lit::TRUE,
                fires,
                on: Picos(on),
                off: Picos(off),
                counted: None,
            });
        }
        let mut values = vec![1; 70];
        values[69] = 12;
        let all: Vec<usize> = (0..70).collect();
        let found = weights(&model, &Assignment(values), &[0, 1, 2], &all);
        // Without X1 the second charge runs in place of the first.
        assert_eq!((found[0], found[1]), (Picos(48), Picos(38)));
        assert!(found[2..68].iter().all(|&worth| worth == Picos::ZERO));
        assert_eq!((found[68], found[69]), (Picos(7), Picos(7)));
    }
}
