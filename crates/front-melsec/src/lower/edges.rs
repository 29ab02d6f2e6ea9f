//! Edge instructions of the FX and FX5, where an edge belongs to a device and a scan, not to each execution of an
//! instruction. The memory of an instruction is over-approximated by any value in three cases: the instruction runs
//! repeatedly in a scan; a pulse contact's device changes during the scan; or the contact is not executed in every
//! scan. For M2800 to M3071 of the FX, only the first pulse contact after each coil detects the edge (FX programming
//! manual: LDP, LDF and similar).

use super::state::{EdgeInstruction, Lowering};
use crate::memory::{Family, area};
use scanbound_front::builder::{always, fired};
use scanbound_ir::flow;
use scanbound_ir::{BitSource, BitTarget, Cell, Logic, Program, Region, Step, Write};
use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};

/// The relays of the FX whose edge only one pulse contact detects. Smaller CPUs do not have them.
const SINGLE: RangeInclusive<u32> = 2800..=3071;

impl Lowering<'_> {
    /// A new hidden bit for the instruction that will be added next, which acts on an edge. `is_contact`: it is a pulse
    /// contact.
    pub(super) fn edge_memory(&mut self, is_contact: bool) -> Cell {
        let memory = self.memory();
        if matches!(self.family, Family::Fx | Family::Fx5) {
            self.edges.at.push(EdgeInstruction {
                at: self.out.program.instructions.len(),
                memory,
                is_contact,
            });
        }
        memory
    }

    /// Records the pulse contact that will be added next, if its device `value` is a relay of which only one contact
    /// can detect the edge (FX, M2800 to M3071).
    pub(super) fn note_single(&mut self, value: &Logic) {
        if let (Logic::Bit(scanbound_ir::BitSource::Cell(cell)), Family::Fx) = (value, self.family)
            && cell.area == const { area("M") }
            && SINGLE.contains(&cell.index)
        {
            let at = self.out.program.instructions.len();
            self.edges.single.entry(*cell).or_default().push(at);
        }
    }

    /// For each relay that [`Lowering::note_single`] recorded: lets at most one of the pulse contacts between two coils
    /// detect the edge. Contacts that may run several times in a scan are not restricted.
    pub(super) fn limit_edges_to_one_contact(&mut self) {
        if self.edges.single.is_empty() {
            return;
        }
        let again = repeated_instructions(&self.out.program);
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
                self.limit_to_one_contact(relay, &coils, &contacts);
            }
        }
    }

    /// Restricts these contacts, which follow the same coil of `relay`, with a hidden bit that records that the edge
    /// was detected. It is cleared at the start of the scan and at each coil.
    fn limit_to_one_contact(&mut self, relay: Cell, coils: &[usize], contacts: &[usize]) {
        let seen = self.memory();
        let name = format!("edge of {} was detected", self.out.program.cell_name(relay));
        self.out.program.names.insert(seen, name);
        let set = |value| Write::Bit(BitTarget::Cell(seen), Logic::Const(value));
        for (place, &at) in contacts.iter().enumerate() {
            let others = Logic::cell(seen).not();
            // The manual does not say whether a later contact detects an edge if the first one is not executed.
            let may_see = if place == 0 { Logic::Const(true) } else { self.free_bit() };
            let one = &mut self.out.program.instructions[at];
            one.effects.push(fired(set(true)));
            if let (Step::Logic { value, .. }, true) = (&mut one.step, place > 0) {
                let edge = std::mem::replace(value, Logic::Const(false));
                *value = Logic::All(vec![edge, others, may_see]);
                let what = "only the first pulse contact after a coil detects an edge of M2800 to M3071: this contact may or may not detect the edge if no contact before it did";
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

    /// Lets the hidden bits of the FX and FX5 have any value where an instruction may run several times in a scan, or
    /// where a pulse contact may see several values of its device or may not be executed in every scan.
    pub(super) fn widen_edges(&mut self) {
        if self.edges.at.is_empty() {
            return;
        }
        let again = repeated_instructions(&self.out.program);
        let steady = SteadyDevices::of(&self.out.program, &again);
        let mut edges = std::mem::take(&mut self.edges.at);
        edges.retain(|edge| {
            let is_steady = !edge.is_contact || steady.sees_once(edge.at, edge.memory);
            again[edge.at] || !is_steady
        });
        for edge in edges {
            // Usually the contact remembers what it saw last.
            let unusual = self.choice();
            self.out.program.timekeeping.unusual.insert(unusual);
            let unusual = Logic::Bit(BitSource::Free(unusual));
            let free = Logic::All(vec![unusual.clone(), self.free_bit()]);
            for effect in &mut self.out.program.instructions[edge.at].effects {
                match &mut effect.write {
                    Write::Bit(BitTarget::Cell(cell), value) if *cell == edge.memory => {
                        let own = std::mem::replace(value, Logic::Const(false));
                        let own = Logic::All(vec![own, unusual.clone().not()]);
                        *value = Logic::Any(vec![own, free.clone()]);
                    }
                    _ => {}
                }
            }
            if again[edge.at] {
                let what = "this instruction may be executed more than once in a scan: a later execution may or may not detect the same edge again";
                self.out.program.approximate(edge.at, what);
            }
        }
    }
}

/// Finds the pulse contacts that see only one value of their device in every scan. Such a contact remembers this value,
/// whenever in the scan the CPU compares it. Only if others write the device between two scans may the CPU compare with
/// another value (docs/melsec.md).
struct SteadyDevices<'p> {
    program: &'p Program,
    /// For each instruction: whether it may run several times in a scan.
    again: &'p [bool],
    /// Each instruction with each region that it writes.
    written: Vec<(usize, Region)>,
    /// The first instruction in the main programs that may make control skip later ones (a jump, stop or return); the
    /// number of all instructions if there is none.
    straight_until: usize,
}

impl<'p> SteadyDevices<'p> {
    fn of(program: &'p Program, again: &'p [bool]) -> SteadyDevices<'p> {
        let leaves = |at: &usize| {
            let step = &program.instructions[*at].step;
            matches!(
                step,
                Step::Jump { .. } | Step::Stop { .. } | Step::Return | Step::Unbounded { .. }
            )
        };
        let mut mains = program.mains.iter().cloned().flatten();
        let straight_until = mains.find(leaves).unwrap_or(program.instructions.len());
        let all = 0..program.instructions.len();
        let written =
            all.flat_map(|at| flow::written(program, at).into_iter().map(move |one| (at, one)));
        SteadyDevices { program, again, written: written.collect(), straight_until }
    }

    /// Whether the contact at this instruction is executed in every scan and sees one value of its device there: at
    /// most one instruction writes the device, before the contact and once in a scan.
    fn sees_once(&self, at: usize, memory: Cell) -> bool {
        let program = self.program;
        let main = program.mains.iter().find(|main| main.contains(&at));
        let is_behind_end = |main: &Range<usize>| {
            let before = &program.instructions[main.start..at];
            before.iter().any(|one| matches!(one.step, Step::End))
        };
        if at > self.straight_until || main.is_none_or(is_behind_end) {
            return false;
        }
        let effects = program.instructions[at].effects.iter();
        let mut device = effects.filter_map(|effect| match &effect.write {
            Write::Bit(BitTarget::Cell(cell), Logic::Bit(BitSource::Cell(device)))
                if *cell == memory =>
            {
                Some(*device)
            }
            _ => None,
        });
        let Some(device) = device.next_back() else { return false };
        let is_volatile = program.volatile.iter().any(|region| region.contains(device));
        let writes = self.written.iter().filter(|(_, region)| region.contains(device));
        let mut writers: Vec<usize> = writes.map(|(writer, _)| *writer).collect();
        writers.dedup();
        let is_before = |writer: usize| {
            let is_main = program.mains.iter().any(|main| main.contains(&writer));
            is_main && writer < at && !self.again[writer]
        };
        !is_volatile
            && match writers[..] {
                [] => true,
                [writer] => is_before(writer),
                _ => false,
            }
    }
}

/// For each instruction: whether it may run several times in a scan. These are the instructions in loops, in interrupt
/// programs, and in routines that are called at two places or from such code.
fn repeated_instructions(program: &Program) -> Vec<bool> {
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
