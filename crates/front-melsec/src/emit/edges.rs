//! Edges on the FX and FX5 belong to a device and a scan, not to each execution of an instruction: what an edge
//! remembers from one execution to the next within a scan is taken as any value. Of M2800 to M3071 of the FX an edge is
//! seen once behind each coil, by the first pulse contact (FX programming manual: LDP, LDF and kin).

use super::Emitter;
use crate::memory::{Family, area};
use scanbound_front::builder::{always, fired};
use scanbound_ir::flow;
use scanbound_ir::{BitTarget, Cell, Logic, Program, Step, Write};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// The relays of the FX of which one pulse contact alone sees an edge. CPUs with fewer relays do not have them.
const SINGLE: RangeInclusive<u32> = 2800..=3071;

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
    /// Pulse contacts of relays of which one contact alone sees an edge, by the relay.
    pub single: BTreeMap<Cell, Vec<usize>>,
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

    /// Notes a pulse contact that is about to be added where it reads a relay of which one contact alone sees an edge.
    pub(super) fn note_single(&mut self, value: &Logic) {
        if let (Logic::Bit(scanbound_ir::BitSource::Cell(cell)), Family::Fx) = (value, self.family)
            && cell.area == const { area("M") }
            && SINGLE.contains(&cell.index)
        {
            let at = self.out.program.instructions.len();
            self.edges.single.entry(*cell).or_default().push(at);
        }
    }

    /// Lets one pulse contact alone see an edge of such a relay behind each of its coils. Contacts that may run again in the
    /// same scan are left as they are.
    pub(super) fn see_edges_once(&mut self) {
        if self.edges.single.is_empty() {
            return;
        }
        let again = run_again(&self.out.program);
        for (relay, contacts) in std::mem::take(&mut self.edges.single) {
            let all = 0..self.out.program.instructions.len();
            let writes = |&at: &usize| {
                flow::written(&self.out.program, at).iter().any(|region| region.contains(relay))
            };
            let coils: Vec<usize> = all.filter(writes).collect();
            let mut behind: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
            for at in contacts.into_iter().filter(|&at| !again[at]) {
                behind.entry(coils.partition_point(|&coil| coil < at)).or_default().push(at);
            }
            for contacts in behind.into_values().filter(|contacts| contacts.len() > 1) {
                self.see_once(relay, &coils, &contacts);
            }
        }
    }

    /// Lets one of these contacts alone see an edge: a hidden bit says that one has. It is cleared when the scan begins and
    /// wherever a coil is carried out.
    fn see_once(&mut self, relay: Cell, coils: &[usize], contacts: &[usize]) {
        let seen = self.memory();
        let name = format!("edge of {} was seen", self.out.program.cell_name(relay));
        self.out.program.names.insert(seen, name);
        let set = |value| Write::Bit(BitTarget::Cell(seen), Logic::Const(value));
        for (place, &at) in contacts.iter().enumerate() {
            let others = Logic::cell(seen).not();
            // What becomes of an edge that the first one does not see is not told.
            let may_see = if place == 0 { Logic::Const(true) } else { self.free_bit() };
            let one = &mut self.out.program.instructions[at];
            one.effects.push(fired(set(true)));
            if let (Step::Logic { value, .. }, true) = (&mut one.step, place > 0) {
                let edge = std::mem::replace(value, Logic::Const(false));
                *value = Logic::All(vec![edge, others, may_see]);
                let what = "of M2800 to M3071 the first pulse contact behind a coil alone sees an edge: this one is taken to see it where no other did, or not";
                self.out.program.approximate(at, what);
            }
        }
        let begin = self.out.program.mains.first().map(|main| main.start);
        for &at in coils {
            self.out.program.instructions[at].effects.push(always(set(false)));
        }
        if let Some(first) = begin.and_then(|at| self.out.program.instructions.get_mut(at)) {
            first.effects.insert(0, always(set(false)));
        }
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
    let extent = |entry| flow::routine_end(program, entry).map(|end| entry..=end);
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
