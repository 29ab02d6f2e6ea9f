//! Where control goes between the items of a project: labels, programs at rest, jumps that lead where none may, routines
//! that do not end.

use std::collections::{BTreeMap, BTreeSet};
use std::mem::take;
use std::ops::Range;

use super::{Frame, Leap, Part, Site, Walk, Wanted, routine};
use scanbound_base::code::Code;
use scanbound_front::absent;

impl Walk<'_, '_> {
    /// Finds the label of every jump and call: in the own file, else, for calls, in the one other file that has it.
    pub(super) fn connect(&mut self) {
        for Wanted { item, label, file, only, is_call } in take(&mut self.wanted) {
            let elsewhere: Vec<usize> = match self.labels[file].get(&label) {
                Some(&own) => vec![own],
                None if only => Vec::new(),
                None => self.labels.iter().filter_map(|own| own.get(&label).copied()).collect(),
            };
            match elsewhere[..] {
                [to] if is_call => _ = self.frame.parts.insert(item, Part::Call(to)),
                [to] => {
                    self.frame.parts.insert(item, Part::Jump(to));
                    let masters = [item, to].map(|at| self.frame.sites[at].master);
                    self.leaps.push(Leap { from: item, to, masters });
                }
                [] if is_call => self.without_label(item, label, only),
                [] => {
                    let message = format!("the label P{label} does not stand in this program");
                    let help = "check the label, or give all files of the project";
                    self.fault_at(item, Code::NoLabel, message, help);
                }
                _ => {
                    let message = format!("the label P{label} stands in several other files");
                    let help = "a label that files share must stand in one of them only";
                    self.fault_at(item, Code::DoubleLabel, message, help);
                }
            }
        }
    }

    /// A call of a label that stands in no file where it may; `by_file`: in the one that the call names.
    fn without_label(&mut self, item: usize, label: u32, by_file: bool) {
        let text = self.item(item).raw.operands[0].trim_matches('"');
        let name = routine(by_file.then_some(text), label);
        if self.may_lack(&name) {
            self.frame.parts.insert(item, Part::Absent(name));
            return;
        }
        let message = format!("the label P{label} does not stand in this program");
        let help = absent::help("check the label, give all files of the project", &name);
        self.fault_at(item, Code::NoLabel, message, &help);
    }

    /// Which files hold routines alone: they begin with one, and nothing leads past its return. Run by itself, such a
    /// program would stop the CPU there, as no call led to it; so it is on standby, and runs only where it is called.
    /// Where all files are so, none is: something must run.
    pub(super) fn standby(&mut self) {
        let parts = &self.frame.parts;
        let is_routines = |items: &Range<usize>| {
            let first = items.clone().find(|&at| !self.item(at).name.starts_with("NOP"));
            let label = first.and_then(|at| parts.get(&at));
            if !matches!(label, Some(Part::Label | Part::Interrupt)) {
                return false;
            }
            let ends = |part: &Part| matches!(part, Part::Return | Part::End | Part::Stop);
            let end = parts.range(items.clone()).find(|(_, part)| ends(part));
            let Some((&end, Part::Return)) = end else { return false };
            let leads_past = |leap: &Leap| (items.start..end).contains(&leap.from) && leap.to > end;
            let around =
                |(_, part): (&usize, &Part)| matches!(part, Part::For(next) if *next > end);
            self.frame.sites[end] == Site::default()
                && !self.leaps.iter().any(leads_past)
                && !parts.range(items.start..end).any(around)
        };
        let files = self.resolved.files.iter().enumerate();
        let found: BTreeSet<usize> =
            files.filter(|(_, items)| is_routines(items)).map(|(file, _)| file).collect();
        if found.len() < self.resolved.files.len() {
            self.frame.standby = found;
        }
    }

    /// Where programs go that need not run in every scan.
    pub(super) fn rests(&mut self) {
        let may_rest = self.resolved.may_rest();
        let files = self.resolved.files.iter().zip(may_rest).enumerate();
        self.frame.rests = files
            .map(|(file, (items, may))| self.end_behind(file, items.start).filter(|_| may))
            .collect();
        let leaps = self.resolved.files.iter().zip(&self.frame.rests);
        let leaps = leaps.filter_map(|(items, to)| {
            Some(Leap { from: items.start, to: (*to)?, masters: [None, None] })
        });
        self.leaps.extend(leaps);
    }

    pub(super) fn check_leaps(&mut self) {
        let begins = self.frame.parts.iter();
        let loops: Vec<(usize, usize)> = begins
            .filter_map(|(&begin, part)| match part {
                Part::For(end) => Some((begin, *end)),
                _ => None,
            })
            .collect();
        for n in 0..self.leaps.len() {
            let Leap { from, to, masters } = self.leaps[n];
            let is_into = |&(begin, end): &(usize, usize)| {
                let within = |at: usize| (begin + 1..=end).contains(&at);
                within(to) && !within(from)
            };
            if to < from {
                let line = self.item(to).raw.line;
                let message = format!(
                    "this jumps back to line {line}: the scan has no bound that can be found here"
                );
                let help = "use FOR and NEXT with a known count";
                self.fault_at(from, Code::JumpBack, message, help);
            } else if loops.iter().any(is_into) {
                let message = "this jumps into a loop of FOR and NEXT".to_owned();
                let help = "jump to the FOR, or behind the NEXT";
                self.fault_at(from, Code::JumpIntoLoop, message, help);
            } else if masters[0] != masters[1] {
                let message = "this jumps into or out of a master control (MC to MCR)".to_owned();
                let help = "put the label into the same master control as the jump";
                self.fault_at(from, Code::JumpAcrossMasterControl, message, help);
            }
        }
    }
    /// Each routine that is called, and each interrupt program, must end.
    pub(super) fn check_routines(&mut self) {
        let extents = Extents::new(&self.frame, &self.leaps);
        let mut calls: BTreeMap<usize, usize> = BTreeMap::new();
        let mut interrupts = Vec::new();
        for (&at, part) in &self.frame.parts {
            match part {
                // Of all the calls of a routine that does not end, one is told.
                Part::Call(to) => _ = calls.entry(*to).or_insert(at),
                Part::Interrupt => interrupts.push(at),
                _ => {}
            }
        }
        for (routine, at) in calls.into_iter().filter(|(routine, _)| !extents.ends(*routine)) {
            let label = &self.item(routine).raw.text;
            let message = format!("the subroutine at {label} has no RET");
            self.fault_at(at, Code::NoReturn, message, "end it with RET");
        }
        for entry in interrupts.into_iter().filter(|entry| !extents.ends(*entry)) {
            let message = "the interrupt program has no IRET".to_owned();
            self.fault_at(entry, Code::NoReturn, message, "end it with IRET");
        }
    }
}

/// What tells how far routines reach.
struct Extents {
    /// The returns.
    returns: Vec<usize>,
    /// What leads on, and whereto.
    leaps: Vec<(usize, usize)>,
}

impl Extents {
    fn new(frame: &Frame, leaps: &[Leap]) -> Extents {
        let parts = frame.parts.iter();
        let returns = parts.filter(|(_, part)| **part == Part::Return).map(|(&at, _)| at).collect();
        let mut leaps: Vec<(usize, usize)> =
            leaps.iter().map(|leap| (leap.from, leap.to)).collect();
        leaps.sort_unstable();
        Extents { returns, leaps }
    }

    /// The first return from an item on.
    fn return_from(&self, at: usize) -> Option<usize> {
        self.returns.get(self.returns.partition_point(|&end| end < at)).copied()
    }

    /// Whether a routine has a return that no jump within it leads past.
    fn ends(&self, entry: usize) -> bool {
        let Some(mut end) = self.return_from(entry) else { return false };
        let first = self.leaps.partition_point(|&(from, _)| from <= entry);
        for &(from, to) in &self.leaps[first..] {
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
        let ends = |returns: &[usize], leaps: &[(usize, usize)], entry| {
            Extents { returns: returns.to_vec(), leaps: leaps.to_vec() }.ends(entry)
        };
        assert!(ends(&[5], &[], 2) && !ends(&[5], &[], 6));
        assert!(ends(&[5, 9], &[(3, 7)], 2) && !ends(&[5], &[(3, 7)], 2));
        // A jump behind the return belongs to another routine.
        assert!(ends(&[5], &[(6, 7)], 2));
        // A jump past one return leads to a jump past the next.
        assert!(!ends(&[5, 9], &[(3, 7), (8, 11)], 2));
    }
}
