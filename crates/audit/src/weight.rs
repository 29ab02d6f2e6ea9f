//! How much each free value of a scan is worth: how much shorter the scan would be if only this value were different.

use rayon::prelude::*;
use scanbound_base::time::Picos;
use scanbound_model::{Assignment, Atom, Lit, Node, ScanModel, Values, VarKind};
use std::collections::BTreeSet;

/// The number of changed values (trials) that are evaluated at once, one per bit of a machine word. Each is a lane.
const LANES: usize = 64;

/// A value that is tried for a variable in place of the one that it has.
struct Trial {
    /// The variable, as an index into the list of requested variables.
    of: usize,
    variable: usize,
    value: u16,
}

/// For each of these variables, the most time that the charges lose together if only this variable has another value; 0
/// if they lose none. A bit is inverted. For a word a few values are tried, since programs mostly compare words with 0,
/// 1 or their sign.
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

/// As [`weights`], for inverted bits: variables that are bits, or single bits of variables that are words.
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

/// The value of a variable with one bit inverted. For a bit, or a comparison with a threshold: 1 if the value is 0,
/// otherwise 0.
pub fn turned(atom: Atom, now: u16) -> u16 {
    match atom {
        Atom::WordBit(_, bit) => now ^ 1 << bit,
        Atom::Bit(_) | Atom::AtLeast(..) => u16::from(now == 0),
    }
}

/// For each variable, the largest time that the charges lose in any of its trials.
fn lost(
    model: &ScanModel,
    assignment: &Assignment,
    charges: &[usize],
    trials: &[Trial],
    count: usize,
) -> Vec<Picos> {
    let values = model.circuit.evaluate(assignment);
    let readers = Readers::of(model, charges);
    let of_some = |trials: &[Trial]| -> Vec<Picos> {
        let mut lane_of: Vec<Vec<usize>> = vec![Vec::new(); model.variables.len()];
        let mut changes = Changes::none(model, &values);
        let of_batch = |batch: &[Trial]| {
            batch.iter().enumerate().for_each(|(lane, trial)| lane_of[trial.variable].push(lane));
            changes.make(model, batch, &lane_of, &readers);
            batch.iter().for_each(|trial| lane_of[trial.variable].clear());
            losses(model, &readers.charges_of(&changes), &changes, batch.len())
        };
        trials.chunks(LANES).flat_map(of_batch).collect()
    };
    // The size of the batches must not depend on the number of threads.
    let share = trials.len().div_ceil(rayon::current_num_threads()).next_multiple_of(LANES);
    let lost: Vec<Vec<Picos>> = trials.par_chunks(share.max(LANES)).map(of_some).collect();
    let mut worth = vec![Picos::ZERO; count];
    for (trial, lost) in trials.iter().zip(lost.concat()) {
        worth[trial.of] = worth[trial.of].max(lost);
    }
    worth
}

/// Several lists of numbers, stored in one array.
struct Lists {
    /// Where each list begins, and where the last one ends.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// Builds `count` lists from pairs of a list's index and an item.
    fn of<I: Iterator<Item = (usize, u32)>>(count: usize, pairs: impl Fn() -> I) -> Lists {
        let mut starts = vec![0; count + 1];
        pairs().for_each(|(list, _)| starts[list + 1] += 1);
        for list in 0..count {
            starts[list + 1] += starts[list];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts[count] as usize];
        for (list, item) in pairs() {
            items[next[list] as usize] = item;
            next[list] += 1;
        }
        Lists { starts, items }
    }

    fn get(&self, list: usize) -> &[u32] {
        &self.items[self.starts[list] as usize..self.starts[list + 1] as usize]
    }
}

/// The users of each node and each variable. A changed value nearly always affects only few of them.
struct Readers<'a> {
    /// For each node, the nodes that use it.
    nodes: Lists,
    /// For each node, the charges that use it, as indices into the list of charges.
    charges: Lists,
    /// For each variable, the nodes that use it.
    of_variables: Vec<Vec<u32>>,
    all: &'a [usize],
}

impl<'a> Readers<'a> {
    fn of(model: &ScanModel, all: &'a [usize]) -> Readers<'a> {
        let nodes = model.circuit.nodes();
        let mut of_variables = vec![Vec::new(); model.variables.len()];
        for (node, reader) in nodes.iter().zip(0u32..) {
            if let Node::Atom(atom) = node {
                of_variables[atom.variable().0 as usize].push(reader);
            }
        }
        let reading_nodes = || {
            nodes.iter().zip(0u32..).flat_map(|(node, reader)| {
                let read = match *node {
                    Node::And(a, b) => [Some(a.node()), Some(b.node())],
                    Node::True | Node::Atom(_) => [None, None],
                };
                read.into_iter().flatten().map(move |node| (node, reader))
            })
        };
        let reading_charges = || {
            all.iter().zip(0u32..).flat_map(|(&charge, place)| {
                model.charges[charge].literals().map(move |lit| (lit.node(), place))
            })
        };
        Readers {
            nodes: Lists::of(nodes.len(), reading_nodes),
            charges: Lists::of(nodes.len(), reading_charges),
            of_variables,
            all,
        }
    }

    /// The charges that use a node whose value changed.
    fn charges_of(&self, changes: &Changes<'_>) -> Vec<usize> {
        let read = changes.any.iter().flat_map(|&node| self.charges.get(node));
        let mut places: Vec<u32> = read.copied().collect();
        places.sort_unstable();
        places.dedup();
        places.into_iter().map(|place| self.all[place as usize]).collect()
    }
}

/// The value of each node, and the lanes in which it differs from the original value.
struct Changes<'a> {
    values: &'a Values,
    turned: Vec<u64>,
    /// The nodes whose value differs from the original in some lane.
    any: Vec<usize>,
}

impl<'a> Changes<'a> {
    fn none(model: &ScanModel, values: &'a Values) -> Changes<'a> {
        Changes { values, turned: vec![0; model.circuit.nodes().len()], any: Vec::new() }
    }

    /// Applies the changed values of these trials, one in each lane, and undoes all earlier ones.
    fn make(
        &mut self,
        model: &ScanModel,
        batch: &[Trial],
        lane_of: &[Vec<usize>],
        readers: &Readers<'_>,
    ) {
        self.any.drain(..).for_each(|index| self.turned[index] = 0);
        let nodes = model.circuit.nodes();
        // A node follows the nodes that it uses.
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
                open.extend(readers.nodes.get(index));
            }
        }
    }

    /// The value of a literal in each lane (one bit for each).
    fn lanes(&self, lit: Lit) -> u64 {
        every(self.values.get(lit)) ^ self.turned[lit.node()]
    }

    fn lane(&self, lit: Lit, lane: usize) -> bool {
        self.lanes(lit) >> lane & 1 == 1
    }
}

/// One bit for each lane, all equal to `value`.
fn every(value: bool) -> u64 {
    if value { u64::MAX } else { 0 }
}

/// For each lane, the time that the charges lose together; 0 if they gain.
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
    use scanbound_ir::{AreaId, Cell};
    use scanbound_model::{Charge, Origin, VarId, Variable};

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
        // Without X1, the second charge runs instead of the first.
        assert_eq!((found[0], found[1]), (Picos(48), Picos(38)));
        assert!(found[2..68].iter().all(|&worth| worth == Picos::ZERO));
        assert_eq!((found[68], found[69]), (Picos(7), Picos(7)));
    }
}
