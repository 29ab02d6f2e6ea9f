//! What can only be settled when all files are emitted: where jumps, calls and loops lead, and what runs again.

use super::Emitter;
use super::ranges;
use scanbound_base::diagnostic::{Diagnostic, Severity};
use scanbound_front::{Faults, absent};
use scanbound_ir::{Program, Step};
use std::collections::BTreeMap;

/// Where the items that something leads to stand among the instructions, and what leads to them.
#[derive(Default)]
pub(super) struct Routes {
    stands: BTreeMap<usize, usize>,
    leads: Vec<(usize, usize)>,
    /// Calls of routines that are not there, and their names.
    pub(super) absent: Vec<(usize, String)>,
    /// Calls that may run their routine with all its coils off.
    pub(super) calls_with_coils_off: Vec<usize>,
}

impl Routes {
    /// An item stands at this instruction.
    pub(super) fn stands(&mut self, item: usize, at: usize) {
        self.stands.insert(item, at);
    }

    /// This instruction leads to an item.
    pub(super) fn leads(&mut self, at: usize, item: usize) {
        self.leads.push((at, item));
    }
}

impl Emitter<'_> {
    /// The program, if nothing is wrong with it.
    pub(crate) fn finish(mut self) -> Result<Program, Vec<Diagnostic>> {
        if !self.faults.iter().any(Faults::any_error) {
            self.connect();
            self.hold_off();
            self.loosen_edges();
            self.see_edges_once();
            self.note_nesting();
        }
        let mut found = self.resolved.project.warnings.clone();
        let faults = std::mem::take(&mut self.faults);
        found.extend(faults.into_iter().flat_map(Faults::in_order));
        if found.iter().any(|fault| fault.severity == Severity::Error) {
            return Err(found);
        }
        found.extend(self.start_ranges());
        if found.iter().any(|fault| fault.severity == Severity::Error) {
            return Err(found);
        }
        Ok(self.out.program)
    }

    /// Fills in where each instruction leads, which the frame knows of items.
    fn connect(&mut self) {
        for (at, item) in std::mem::take(&mut self.routes.leads) {
            let to = self.routes.stands[&item];
            match &mut self.out.program.instructions[at].step {
                Step::Jump { target, .. } | Step::Call { target, .. } => *target = to,
                Step::ForBegin { end, .. } => *end = to,
                _ => {}
            }
        }
        let switches = self.quirks.switches_file_register;
        for (at, name) in std::mem::take(&mut self.routes.absent) {
            let known = self.options.facts.calls.get(&name).map(|stated| {
                absent::stated_routine(
                    stated,
                    |text| ranges::written(text, self.family, switches),
                    &[],
                )
            });
            self.out.call_absent(at, &name, known);
        }
    }
}
