//! Control transfers between the items of a project: label resolution, standby programs, forbidden jumps, routines
//! without an end.

use std::collections::{BTreeMap, BTreeSet};
use std::mem::take;
use std::ops::Range;

use super::{Checker, Part, Site, Structure, Transfer, UnresolvedJump, routine};
use scanbound_base::code::Code;
use scanbound_front::absent;

impl Checker<'_, '_> {
    /// Resolves the label of each jump and call, in the same file, or in the file that the call names. A call without a
    /// program name that finds no such label in its file takes it from the only other file that has it.
    pub(super) fn connect(&mut self) {
        for UnresolvedJump { item, label, file, only, is_call } in take(&mut self.wanted) {
            let elsewhere: Vec<usize> = match self.labels[file].get(&label) {
                Some(&own) => vec![own],
                None if only => Vec::new(),
                None => self.labels.iter().filter_map(|own| own.get(&label).copied()).collect(),
            };
            match elsewhere[..] {
                [to] if is_call => _ = self.structure.parts.insert(item, Part::Call(to)),
                [to] => {
                    self.structure.parts.insert(item, Part::Jump(to));
                    let masters = [item, to].map(|at| self.structure.sites[at].master);
                    self.transfers.push(Transfer { from: item, to, masters });
                }
                [] if is_call => self.without_label(item, label, only),
                [] => {
                    let message = format!("the label P{label} does not exist in this file");
                    let help = "correct the label: a jump can only lead to a label in its own file";
                    self.fault_at(item, Code::NoLabel, message, help);
                }
                _ => {
                    let message = format!(
                        "this file does not define the label P{label}, but several other files do"
                    );
                    let help = "if several files use this label, define it in only one of them";
                    self.fault_at(item, Code::DoubleLabel, message, help);
                }
            }
        }
    }

    /// Handles a call whose label does not exist: makes it a call of a missing routine if that is allowed, otherwise
    /// reports an error. `by_file`: the call names the file in addition to the label.
    fn without_label(&mut self, item: usize, label: u32, by_file: bool) {
        let text = self.item(item).raw.operands[0].trim_matches('"');
        let name = routine(by_file.then_some(text), label);
        if self.may_lack(&name) {
            self.structure.parts.insert(item, Part::Absent(name));
            return;
        }
        let message = match by_file {
            true => format!("the program `{text}` has no label P{label}"),
            false => format!("no given file has the label P{label}"),
        };
        let help = absent::help("check the label, give all files of the project", &name);
        self.fault_at(item, Code::NoLabel, message, &help);
    }

    /// Finds the files that contain only routines: they begin with one, and no jump leads past its return. Such a
    /// program would stop the CPU if it ran by itself, so its type is standby: it runs only where it is called. If all
    /// files are like this, none is on standby, because something must run.
    pub(super) fn standby(&mut self) {
        let parts = &self.structure.parts;
        let is_routines = |items: &Range<usize>| {
            let first = items.clone().find(|&at| !self.item(at).name.starts_with("NOP"));
            let label = first.and_then(|at| parts.get(&at));
            if !matches!(label, Some(Part::Label | Part::Interrupt)) {
                return false;
            }
            let ends = |part: &Part| matches!(part, Part::Return | Part::End | Part::Stop);
            let end = parts.range(items.clone()).find(|(_, part)| ends(part));
            let Some((&end, Part::Return)) = end else { return false };
            let leads_past = |transfer: &Transfer| {
                (items.start..end).contains(&transfer.from) && transfer.to > end
            };
            let around =
                |(_, part): (&usize, &Part)| matches!(part, Part::For(next) if *next > end);
            self.structure.sites[end] == Site::default()
                && !self.transfers.iter().any(leads_past)
                && !parts.range(items.start..end).any(around)
        };
        let files = self.resolved.files.iter().enumerate();
        let found: BTreeSet<usize> =
            files.filter(|(_, items)| is_routines(items)).map(|(file, _)| file).collect();
        if found.len() < self.resolved.files.len() {
            self.structure.standby = found;
        }
    }

    /// For each program that need not run in every scan: finds the END to which it jumps when it does not run, and adds
    /// this jump to the transfers.
    pub(super) fn skip_targets(&mut self) {
        let may_be_skipped = self.resolved.may_be_skipped();
        let files = self.resolved.files.iter().zip(may_be_skipped).enumerate();
        self.structure.skip_targets = files
            .map(|(file, (items, may))| self.end_behind(file, items.start).filter(|_| may))
            .collect();
        let transfers = self.resolved.files.iter().zip(&self.structure.skip_targets);
        let transfers = transfers.filter_map(|(items, to)| {
            Some(Transfer { from: items.start, to: (*to)?, masters: [None, None] })
        });
        self.transfers.extend(transfers);
    }

    /// Reports each transfer that jumps back, into a loop, or into or out of a master control region or step ladder
    /// state.
    pub(super) fn check_jumps(&mut self) {
        let begins = self.structure.parts.iter();
        let loops: Vec<(usize, usize)> = begins
            .filter_map(|(&begin, part)| match part {
                Part::For(end) => Some((begin, *end)),
                _ => None,
            })
            .collect();
        for n in 0..self.transfers.len() {
            let Transfer { from, to, masters } = self.transfers[n];
            let is_into = |&(begin, end): &(usize, usize)| {
                let within = |at: usize| (begin + 1..=end).contains(&at);
                within(to) && !within(from)
            };
            if to < from {
                let line = self.item(to).raw.line;
                let message = format!(
                    "this jumps back to line {line}: scanbound cannot find how often the jump repeats"
                );
                let help = "use FOR and NEXT with a known count";
                self.fault_at(from, Code::JumpBack, message, help);
            } else if loops.iter().any(is_into) {
                let message = "this jumps into a loop of FOR and NEXT".to_owned();
                let help = "jump to the FOR, or to a label after the NEXT";
                self.fault_at(from, Code::JumpIntoLoop, message, help);
            } else if masters[0] != masters[1] {
                let message =
                    "this jumps into or out of a master control region (MC to MCR) or a step ladder state (STL)".to_owned();
                let help = "put the label in the same region or state as the jump";
                self.fault_at(from, Code::JumpAcrossMasterControl, message, help);
            }
        }
    }
    /// Reports each called routine and each interrupt program that no return instruction follows, or whose jumps may
    /// skip every return instruction.
    pub(super) fn check_routines(&mut self) {
        let extents = Extents::new(&self.structure, &self.transfers);
        let mut calls: BTreeMap<usize, usize> = BTreeMap::new();
        let mut interrupts = Vec::new();
        for (&at, part) in &self.structure.parts {
            match part {
                // Only one of the calls of a routine without an end is reported.
                Part::Call(to) => _ = calls.entry(*to).or_insert(at),
                Part::Interrupt => interrupts.push(at),
                _ => {}
            }
        }
        for (routine, at) in calls.into_iter().filter(|(routine, _)| !extents.ends(*routine)) {
            let label = &self.item(routine).raw.text;
            let message =
                format!("the subroutine at {label} has no RET at its end, or a jump skips its RET");
            self.fault_at(
                at,
                Code::NoReturn,
                message,
                "end the subroutine with RET, and let no jump skip the RET",
            );
        }
        for entry in interrupts.into_iter().filter(|entry| !extents.ends(*entry)) {
            let message =
                "the interrupt program has no IRET at its end, or a jump skips its IRET".to_owned();
            self.fault_at(
                entry,
                Code::NoReturn,
                message,
                "end it with IRET, and let no jump skip the IRET",
            );
        }
    }
}

/// Finds out whether routines end with a return instruction.
struct Extents {
    /// The items that are return instructions, in ascending order.
    returns: Vec<usize>,
    /// All transfers, as pairs of the item that jumps and its target, in ascending order.
    transfers: Vec<(usize, usize)>,
}

impl Extents {
    fn new(structure: &Structure, transfers: &[Transfer]) -> Extents {
        let parts = structure.parts.iter();
        let returns = parts.filter(|(_, part)| **part == Part::Return).map(|(&at, _)| at).collect();
        let mut transfers: Vec<(usize, usize)> =
            transfers.iter().map(|transfer| (transfer.from, transfer.to)).collect();
        transfers.sort_unstable();
        Extents { returns, transfers }
    }

    /// The first return instruction at or after an item. `None` if there is none.
    fn return_from(&self, at: usize) -> Option<usize> {
        self.returns.get(self.returns.partition_point(|&end| end < at)).copied()
    }

    /// Whether a routine has a return instruction that its jumps cannot skip.
    fn ends(&self, entry: usize) -> bool {
        let Some(mut end) = self.return_from(entry) else { return false };
        let first = self.transfers.partition_point(|&(from, _)| from <= entry);
        for &(from, to) in &self.transfers[first..] {
            if from > end {
                break;
            }
            if to > end {
                match self.return_from(to) {
                    Some(next) => end = next,
                    None => return false,
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_routine_ends_at_the_first_return_that_no_jump_leads_past() {
        let ends = |returns: &[usize], transfers: &[(usize, usize)], entry| {
            Extents { returns: returns.to_vec(), transfers: transfers.to_vec() }.ends(entry)
        };
        assert!(ends(&[5], &[], 2) && !ends(&[5], &[], 6));
        assert!(ends(&[5, 9], &[(3, 7)], 2) && !ends(&[5], &[(3, 7)], 2));
        // A jump after the return belongs to another routine.
        assert!(ends(&[5], &[(6, 7)], 2));
        // A jump past the first return reaches a jump past the second one.
        assert!(!ends(&[5, 9], &[(3, 7), (8, 11)], 2));
    }
}
