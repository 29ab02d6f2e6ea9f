//! The last stage, when all files are lowered: resolves the targets of jumps, calls and loops, and changes what depends
//! on the whole program.

use super::state::Lowering;
use super::{devices, ranges};
use scanbound_base::diagnostic::{Diagnostic, Severity};
use scanbound_front::{Faults, absent};
use scanbound_ir::{Program, Step};

impl Lowering<'_> {
    /// Finishes the program.
    ///
    /// # Errors
    ///
    /// If any diagnostic is an error: the diagnostics of all files, warnings included, of each file at most 50 errors
    /// and 50 warnings. Errors in the facts are reported only if the files have none.
    pub(crate) fn finish(mut self) -> Result<Program, Vec<Diagnostic>> {
        if !self.faults.iter().any(Faults::any_error) {
            self.connect();
            self.allow_coils_off();
            self.widen_edges();
            self.limit_edges_to_one_contact();
            self.note_nesting();
        }
        let mut found = self.resolved.project.warnings.clone();
        let faults = std::mem::take(&mut self.faults);
        found.extend(faults.into_iter().flat_map(Faults::in_order));
        if found.iter().any(|fault| fault.severity == Severity::Error) {
            return Err(found);
        }
        found.extend(self.start_ranges());
        found.extend(devices::faults(self.options, &self.modes.devices));
        if found.iter().any(|fault| fault.severity == Severity::Error) {
            return Err(found);
        }
        Ok(self.out.program)
    }

    /// Sets the target of each jump, call and loop to the instruction at which its item begins, and gives each call of
    /// a missing routine the time and the writes that the facts state.
    fn connect(&mut self) {
        for (at, item) in std::mem::take(&mut self.targets.leads) {
            let to = self.targets.stands[&item];
            match &mut self.out.program.instructions[at].step {
                Step::Jump { target, .. } | Step::Call { target, .. } => *target = to,
                Step::ForBegin { end, .. } => *end = to,
                _ => {}
            }
        }
        let switches = self.modes.switches_file_register;
        for (at, name) in std::mem::take(&mut self.targets.absent) {
            self.note_missing_routine(at, &name);
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
