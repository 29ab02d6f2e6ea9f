//! What can only be settled when all files are read: labels, jumps' limits, routines' ends.

use super::Emitter;
use super::ranges::Counts;
use crate::base::code::Code;
use crate::base::diagnostic::{Diagnostic, Severity};
use crate::program::flow;
use crate::program::{Program, Step};
use std::collections::BTreeMap;

impl Emitter<'_> {
    /// The program, if nothing is wrong with it, and the words whose stated range it counts by.
    pub(in crate::front::melsec) fn finish(mut self) -> Result<(Program, Counts), Vec<Diagnostic>> {
        self.resolve();
        self.program.interrupts = std::mem::take(&mut self.routines.interrupts);
        if !self.has_faults() {
            self.check_jumps();
        }
        if !self.has_faults() {
            self.check_calls();
        }
        if !self.has_faults() {
            self.hold_off();
            self.loosen_edges();
        }
        let mut found = self.project.warnings.clone();
        let faults = std::mem::take(&mut self.faults);
        found.extend(faults.into_iter().flat_map(crate::front::Faults::into_diagnostics));
        if found.iter().any(|fault| fault.severity == Severity::Error) {
            return Err(found);
        }
        found.extend(self.start_ranges());
        if found.iter().any(|fault| fault.severity == Severity::Error) {
            return Err(found);
        }
        Ok((self.program, self.stated.counts))
    }

    fn has_faults(&self) -> bool {
        self.faults.iter().any(crate::front::Faults::any_error)
    }

    fn fault_at(&mut self, at: usize, code: Code, message: String, help: &str) {
        let instruction = &self.program.instructions[at];
        let file = instruction.place.file as usize;
        let name = &self.project.files[file].name;
        let found =
            Diagnostic::line(code, name, instruction.place.line, &*instruction.text, message, help)
                .at_step(instruction.place.step);
        self.faults[file].push(found);
    }

    /// Finds the instruction of every label that is jumped to or called: in the own file, else, for calls,
    /// in the one other file that has it.
    fn resolve(&mut self) {
        for fixup in std::mem::take(&mut self.routines.fixups) {
            let own = self.routines.labels[fixup.file].get(&fixup.label).copied();
            let elsewhere: Vec<usize> = if own.is_some() || fixup.only {
                Vec::new()
            } else {
                self.routines
                    .labels
                    .iter()
                    .filter_map(|labels| labels.get(&fixup.label).copied())
                    .collect()
            };
            let label = format!("P{}", fixup.label);
            match (own, &elsewhere[..]) {
                (Some(at), _) | (None, &[at]) => {
                    match &mut self.program.instructions[fixup.instruction].step {
                        Step::Jump { target, .. } | Step::Call { target, .. } => *target = at,
                        _ => {}
                    }
                }
                (None, []) => {
                    let message = format!("the label {label} does not stand in this program");
                    self.fault_at(
                        fixup.instruction,
                        Code::NoLabel,
                        message,
                        "check the label, or give all files of the project",
                    );
                }
                (None, _) => {
                    let message = format!("the label {label} stands in several other files");
                    self.fault_at(
                        fixup.instruction,
                        Code::DoubleLabel,
                        message,
                        "a label that files share must stand in one of them only",
                    );
                }
            }
        }
    }

    fn check_jumps(&mut self) {
        let loops: Vec<(usize, usize)> = flow::loops(&self.program);
        let jumps: Vec<(usize, usize)> = flow::jumps(&self.program);
        for (at, target) in jumps {
            if target <= at {
                let line = self.program.instructions[target].place.line;
                let message = format!(
                    "this jumps back to line {line}: the scan has no bound that can be found here"
                );
                self.fault_at(at, Code::JumpBack, message, "use FOR and NEXT with a known count");
            } else if loops.iter().any(|&(begin, end)| {
                (begin + 1..=end).contains(&target) && !(begin..=end).contains(&at)
            }) {
                self.fault_at(
                    at,
                    Code::JumpIntoLoop,
                    "this jumps into a loop of FOR and NEXT".to_owned(),
                    "jump to the FOR, or behind the NEXT",
                );
            } else if self.masters.of[at] != self.masters.of[target]
                && self.program.instructions[target].step != Step::End
            {
                let message = "this jumps into or out of a master control (MC to MCR)".to_owned();
                self.fault_at(
                    at,
                    Code::JumpAcrossMasterControl,
                    message,
                    "put the label into the same master control as the jump",
                );
            }
        }
    }

    fn check_calls(&mut self) {
        // Of all the calls of a routine that does not end, one is told.
        let calls: BTreeMap<usize, usize> =
            flow::calls(&self.program).into_iter().rev().map(|(at, target)| (target, at)).collect();
        for (target, at) in calls {
            if flow::extent(&self.program, target).is_none() {
                let label = self.program.instructions[target].text.clone();
                self.fault_at(
                    at,
                    Code::NoReturn,
                    format!("the subroutine at {label} has no RET"),
                    "end it with RET",
                );
            }
        }
        for at in 0..self.program.interrupts.len() {
            let entry = self.program.interrupts[at].entry;
            if flow::extent(&self.program, entry).is_none() {
                self.fault_at(
                    entry,
                    Code::NoReturn,
                    "the interrupt program has no IRET".to_owned(),
                    "end it with IRET",
                );
            }
        }
    }
}
