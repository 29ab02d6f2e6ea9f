//! Edges on the FX and FX5 belong to a device and a scan, not to each execution of an instruction: what an edge
//! remembers from one execution to the next within a scan is taken as any value.

use super::Emitter;
use crate::front::melsec::memory::Family;
use crate::program::flow;
use crate::program::{BitTarget, Cell, Program, Write};
use std::collections::BTreeMap;

/// An instruction that acts at an edge.
pub(super) struct Edge {
    /// Its index.
    at: usize,
    /// What it remembers.
    memory: Cell,
    /// A contact: its device may rise and fall several times in a scan, also beside other contacts.
    is_contact: bool,
}

/// What remembers bits from one execution of an instruction to the next.
#[derive(Default)]
pub(super) struct Edges {
    /// How many such bits there are.
    pub count: u32,
    /// Instructions of the FX and FX5 that act at edges.
    pub at: Vec<Edge>,
}

impl Emitter<'_> {
    /// The memory of the instruction about to be added, which acts at an edge.
    pub(super) fn edge_memory(&mut self, is_contact: bool) -> Cell {
        let memory = self.memory();
        if matches!(self.family, Family::Fx | Family::Fx5) {
            self.edges.at.push(Edge {
                at: self.out.program.instructions.len(),
                memory,
                is_contact,
            });
        }
        memory
    }

    /// Lets edges of the FX and FX5 remember any value, where they may be executed again in the same scan.
    pub(super) fn loosen_edges(&mut self) {
        if self.edges.at.is_empty() {
            return;
        }
        let again = run_again(&self.out.program);
        for edge in std::mem::take(&mut self.edges.at) {
            if !again[edge.at] && !edge.is_contact {
                continue;
            }
            let free = self.free_bit();
            for effect in &mut self.out.program.instructions[edge.at].effects {
                match &mut effect.write {
                    Write::Bit(BitTarget::Cell(cell), value) if *cell == edge.memory => {
                        *value = free.clone();
                    }
                    _ => {}
                }
            }
            if again[edge.at] {
                let what = "an edge belongs to the scan, not to each execution: it is taken to occur again or not";
                self.out.program.approximate(edge.at, what);
            }
        }
    }
}

/// Which instructions may run more than once in a scan: in loops, interrupts, and routines that are called at two
/// places or from what runs more than once itself.
fn run_again(program: &Program) -> Vec<bool> {
    let mut again = vec![false; program.instructions.len()];
    for (begin, end) in flow::loops(program) {
        again[begin..=end].fill(true);
    }
    let extent = |entry| flow::extent(program, entry).map(|end| entry..=end);
    for interrupt in &program.interrupts {
        if let Some(range) = extent(interrupt.entry) {
            again[range].fill(true);
        }
    }
    let calls = flow::calls(program);
    let mut times: BTreeMap<usize, usize> = BTreeMap::new();
    calls.iter().for_each(|&(_, target)| *times.entry(target).or_default() += 1);
    loop {
        let mut grows = false;
        for &(at, target) in &calls {
            let is_called_again = again[at] || times[&target] > 1;
            if is_called_again
                && !again[target]
                && let Some(range) = extent(target)
            {
                again[range].fill(true);
                grows = true;
            }
        }
        if !grows {
            return again;
        }
    }
}
