//! Control flow of a program: loops, jumps, calls, the extent of routines.

use crate::{BitTarget, Cell, Program, Region, Step, WordTarget, Write};
use std::collections::{BTreeMap, BTreeSet};

/// Pairs of an instruction and its target, for each instruction for whose step `to` gives a target.
fn targets(program: &Program, to: impl Fn(&Step) -> Option<usize>) -> Vec<(usize, usize)> {
    let steps = program.instructions.iter().enumerate();
    steps.filter_map(|(at, instruction)| Some((at, to(&instruction.step)?))).collect()
}

/// All loops as pairs of the index of the `ForBegin` and that of its `ForEnd`; outer loops come before inner ones.
pub fn loops(program: &Program) -> Vec<(usize, usize)> {
    targets(program, |step| match step {
        Step::ForBegin { end, .. } => Some(*end),
        _ => None,
    })
}

/// All jumps, as pairs of the jump's index and the index of the instruction to which it leads.
pub fn jumps(program: &Program) -> Vec<(usize, usize)> {
    targets(program, |step| match step {
        Step::Jump { target, .. } => Some(*target),
        _ => None,
    })
}

/// All calls, as pairs of the call's index and the index of the routine's first instruction.
pub fn calls(program: &Program) -> Vec<(usize, usize)> {
    targets(program, |step| match step {
        Step::Call { target, .. } => Some(*target),
        _ => None,
    })
}

/// The last instruction of a routine: the first `Return` that no jump within the routine passes over. `None` if there
/// is none.
pub fn routine_end(program: &Program, entry: usize) -> Option<usize> {
    let returns = |from: usize| {
        program.instructions[from..]
            .iter()
            .position(|i| i.step == Step::Return)
            .map(|offset| from + offset)
    };
    let mut end = returns(entry)?;
    let mut at = entry;
    while at <= end {
        if let Step::Jump { target, .. } = program.instructions[at].step
            && target > end
        {
            end = returns(target)?;
        }
        at += 1;
    }
    Some(end)
}

/// For each routine, by its first instruction: the calls in it, as pairs of call and called routine. `None` if a
/// routine has no end.
fn calls_within_routines(program: &Program) -> Option<BTreeMap<usize, Vec<(usize, usize)>>> {
    // In program order.
    let calls = calls(program);
    let entries: BTreeSet<usize> = calls.iter().map(|&(_, target)| target).collect();
    let within = |&entry: &usize| {
        let end = routine_end(program, entry)?;
        let first = calls.partition_point(|&(at, _)| at < entry);
        let behind = calls.partition_point(|&(at, _)| at <= end);
        Some((entry, calls[first..behind].to_vec()))
    };
    entries.iter().map(within).collect()
}

/// A call that leads back to the routine that contains it. `None` if there is no such call, or if a routine has no
/// `Return`.
pub fn recursion(program: &Program) -> Option<usize> {
    let edges = calls_within_routines(program)?;
    let graph = petgraph::graphmap::DiGraphMap::<usize, usize>::from_edges(
        edges.iter().flat_map(|(&from, to)| to.iter().map(move |&(at, target)| (from, target, at))),
    );
    let circle = petgraph::algo::tarjan_scc(&graph).into_iter().find(|part| {
        part.len() > 1 || part.iter().any(|&entry| graph.contains_edge(entry, entry))
    })?;
    let first = circle.iter().copied().min()?;
    edges[&first].iter().find(|(_, target)| circle.contains(target)).map(|&(at, _)| at)
}

/// A call that is nested more than `most` calls deep. `None` if there is none, or if a routine has no `Return`. The
/// program must not be recursive.
pub fn nested_beyond(program: &Program, most: usize) -> Option<usize> {
    let within = calls_within_routines(program)?;
    // Round by round, the routines that are reached by one more nested call. Routines still reached after the last
    // round are nested too deeply.
    let mut reached: BTreeSet<usize> = within.keys().copied().collect();
    for round in 1..=most {
        let next: Vec<(usize, usize)> =
            reached.iter().filter_map(|entry| within.get(entry)).flatten().copied().collect();
        if round == most {
            return next.first().map(|&(at, _)| at);
        }
        reached = next.into_iter().map(|(_, target)| target).collect();
    }
    None
}

/// An upper limit of the number of instructions executed from `from` to `to` (inclusive): each loop runs its largest
/// number of iterations, calls are followed, jumps are not taken, and a loop summary counts as one. The program must
/// not be recursive.
pub fn unrolled(program: &Program, from: usize, to: usize) -> u64 {
    let mut known = BTreeMap::new();
    unrolled_between(program, from, to, &mut known)
}

fn unrolled_between(
    program: &Program,
    from: usize,
    to: usize,
    known: &mut BTreeMap<usize, u64>,
) -> u64 {
    let mut total = 0u64;
    let mut at = from;
    while at <= to {
        total = total.saturating_add(1);
        match &program.instructions[at].step {
            &Step::ForBegin { most, end, .. } => {
                let body = unrolled_between(program, at + 1, end, known);
                total = total.saturating_add(body.saturating_mul(u64::from(most)));
                at = end;
            }
            Step::Summary(summary) => at = summary.end,
            &Step::Call { target, .. } => {
                let size = match (known.get(&target), routine_end(program, target)) {
                    (Some(&size), _) => size,
                    (None, Some(end)) => unrolled_between(program, target, end, known),
                    (None, None) => 0,
                };
                known.insert(target, size);
                total = total.saturating_add(size);
            }
            _ => {}
        }
        at += 1;
    }
    total
}

/// The cells that an instruction may write: by its effects, or as a loop summary.
pub fn written(program: &Program, at: usize) -> Vec<Region> {
    let instruction = &program.instructions[at];
    let mut regions = Vec::new();
    instruction.effects.iter().for_each(|effect| regions.extend(written_by(&effect.write)));
    if let Step::Summary(summary) = &instruction.step {
        regions.extend(&summary.havocs);
    }
    regions
}

/// Whether any instruction of the program may write a cell of this region.
#[must_use]
pub fn may_write(program: &Program, region: Region) -> bool {
    let mut all = (0..program.instructions.len()).flat_map(|at| written(program, at));
    all.any(|one| overlap(one, region))
}

/// The cells that a write may change.
pub fn written_by(write: &Write) -> Vec<Region> {
    let one = |first| Region::Range { first, count: 1 };
    match write {
        Write::Bit(BitTarget::Cell(cell) | BitTarget::WordBit(cell, _), _) => vec![one(*cell)],
        Write::Words(targets, _) => {
            let regions = targets.iter().filter_map(|target| match *target {
                WordTarget::Cell(cell) => Some(one(cell)),
                WordTarget::Bits { first, count } => {
                    Some(Region::Range { first, count: u32::from(count) })
                }
                WordTarget::Discard => None,
            });
            regions.collect()
        }
        Write::Havoc(region, _) => vec![*region],
    }
}

/// Whether two regions have cells in common.
#[must_use]
pub fn overlap(one: Region, other: Region) -> bool {
    match (one, other) {
        (Region::Everything, _) | (_, Region::Everything) => true,
        (Region::Area(area), Region::Area(other)) => area == other,
        (Region::Area(area), Region::Range { first, .. })
        | (Region::Range { first, .. }, Region::Area(area)) => area == first.area,
        (Region::Range { first, .. }, Region::Range { first: second, .. }) => {
            first.area == second.area && (one.contains(second) || other.contains(first))
        }
    }
}

/// Whether any instruction may write the cell.
#[must_use]
pub fn is_written(program: &Program, cell: Cell) -> bool {
    let written = (0..program.instructions.len()).flat_map(|at| written(program, at));
    written.into_iter().any(|region| region.contains(cell))
}
