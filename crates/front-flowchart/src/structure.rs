//! Resolves routines, labels and groups of a list, and refuses constructs that the documents do not define.

use super::parse::{Listed, Mnemonic};
use super::source::{Instruction, MAX_GROUPS, Op, Routine, Source};
use scanbound_base::code::Code;
use scanbound_front::Faults;
use std::collections::{BTreeMap, BTreeSet};

/// Resolves the labels, groups and timers of a list. Errors are reported, and faulty parts get placeholders, such as a
/// jump that leads to itself: the result is of use only if there is no error.
pub fn source(name: &str, text: &str, list: Vec<Listed>, faults: &mut Faults<'_>) -> Source {
    let mut reader = Reader { text, labels: BTreeMap::new(), groups: BTreeMap::new(), faults };
    let routines = reader.routines(&list);
    let mut instructions = Vec::with_capacity(list.len());
    for (at, one) in list.iter().enumerate() {
        // The routines are in source order.
        let routine = routines.get(routines.partition_point(|routine| routine.body.end <= at));
        let op = reader.op(at, one, routine);
        let (line, step, text) = (one.line, one.step, one.text.clone());
        instructions.push(Instruction { op, line, step, text });
    }
    without_delay(&mut instructions);
    let mut comments = BTreeMap::new();
    for one in list.iter().filter(|one| !one.comment.is_empty()) {
        if matches!(one.word, Mnemonic::And | Mnemonic::AndNot | Mnemonic::Out | Mnemonic::OutNot) {
            comments.entry(one.operand).or_insert_with(|| one.comment.clone());
        }
    }
    let mut source = Source { name: name.to_owned(), instructions, routines, comments };
    source.routines.sort_by_key(|routine| routine.group);
    reader.conditions(&source);
    reader.check_ends(&source);
    source
}

/// Gives time 0 to all instructions of a timer that some instruction starts with time 0, since it may time out at once.
fn without_delay(instructions: &mut [Instruction]) {
    let zero: BTreeSet<u32> = instructions
        .iter()
        .filter_map(|one| match one.op {
            Op::Timer { timer, tenths: 0 } => Some(timer),
            _ => None,
        })
        .collect();
    for one in instructions {
        if let Op::Timer { timer, tenths } = &mut one.op
            && zero.contains(timer)
        {
            *tenths = 0;
        }
    }
}

struct Reader<'a, 'f> {
    /// The text of the file.
    text: &'a str,
    /// The index of the instruction at each label.
    labels: BTreeMap<u32, usize>,
    /// The index of the GN instruction of each group.
    groups: BTreeMap<u32, usize>,
    faults: &'a mut Faults<'f>,
}

impl Reader<'_, '_> {
    /// Splits the list into routines: the main routine ends at the first GN, each group at the next GN.
    fn routines(&mut self, list: &[Listed]) -> Vec<Routine> {
        let mut routines = vec![Routine { group: None, body: 0..0 }];
        for (at, one) in list.iter().enumerate() {
            if one.word == Mnemonic::Label {
                if let Some(&first) = self.labels.get(&one.operand) {
                    let message = format!(
                        "LBL{} is defined a second time: line {} defines it too",
                        one.operand, list[first].line
                    );
                    self.fault(
                        Code::LabelTwice,
                        one,
                        &message,
                        "give each label a different number",
                    );
                } else {
                    self.labels.insert(one.operand, at);
                }
            }
            if one.word == Mnemonic::Head {
                if let Some(&first) = self.groups.get(&one.operand) {
                    let message = format!(
                        "group {} begins a second time: it begins in line {} too",
                        one.operand, list[first].line
                    );
                    self.fault(
                        Code::GroupTwice,
                        one,
                        &message,
                        "give each group a different number",
                    );
                } else {
                    self.groups.insert(one.operand, at);
                }
                if one.operand as usize > MAX_GROUPS {
                    let message = format!(
                        "the group number {} is too large: group numbers are 0 to 32",
                        one.operand
                    );
                    self.fault(Code::GroupNumber, one, &message, "use a group number from 0 to 32");
                }
                routines.push(Routine { group: Some(one.operand), body: at..at });
            }
            routines.last_mut().expect("the main routine is in the list from the start").body.end =
                at + 1;
        }
        if routines.len() > MAX_GROUPS + 1
            && let Some(one) = list.get(routines[MAX_GROUPS + 1].body.start)
        {
            self.fault(Code::TooManyGroups, one, "this is the 33rd group", "use at most 32 groups");
        }
        if routines[0].body.is_empty()
            && let Some(one) = list.first()
        {
            let help = "write the main routine first, and end the main routine with a JMP back to its label";
            self.fault(Code::NoMain, one, "there is no main routine before the first group", help);
        }
        routines
    }

    fn op(&mut self, at: usize, one: &Listed, routine: Option<&Routine>) -> Op {
        let n = one.operand;
        let group = routine.and_then(|routine| routine.group);
        match one.word {
            Mnemonic::And | Mnemonic::AndNot => {
                Op::And { bit: n, negated: one.word == Mnemonic::AndNot }
            }
            Mnemonic::Out | Mnemonic::OutNot => Op::Out { bit: n, on: one.word == Mnemonic::Out },
            Mnemonic::Timer => {
                if one.time.is_none() {
                    self.fault(
                        Code::NoTime,
                        one,
                        "the timer has no time",
                        "write TIM n #t, t in tenths of a second; #t may be on the next line",
                    );
                }
                Op::Timer { timer: n, tenths: one.time.unwrap_or(1) }
            }
            Mnemonic::ResetTimer => Op::ResetTimer(n),
            Mnemonic::Jump | Mnemonic::JumpIf => {
                let target = self.target(one, routine).unwrap_or(at);
                if one.word == Mnemonic::Jump { Op::Jump(target) } else { Op::JumpIf(target) }
            }
            Mnemonic::Wait => Op::Wait,
            Mnemonic::Label => Op::Label(n),
            Mnemonic::Groups => {
                if group.is_some() {
                    let help = "use GJ only in the main routine";
                    self.fault(
                        Code::JumpInGroup,
                        one,
                        "GJ is in a group, where it is not defined",
                        help,
                    );
                }
                Op::Groups
            }
            Mnemonic::Start | Mnemonic::Stop => {
                if group == Some(n) {
                    let message = format!("group {n} can neither start nor stop itself");
                    self.fault(Code::OwnGroup, one, &message, "end the group with GE");
                } else if !self.groups.contains_key(&n) {
                    let message = format!("no GN begins group {n}");
                    self.fault(
                        Code::NoGroup,
                        one,
                        &message,
                        "begin a group with GN and its number",
                    );
                }
                if one.word == Mnemonic::Start { Op::Start(n) } else { Op::Stop(n) }
            }
            Mnemonic::Head => Op::Head(n),
            Mnemonic::End => {
                if group != Some(n) {
                    let message = match group {
                        Some(own) => format!("this GE {n} ends group {n}, but is in group {own}"),
                        None => "GE is not in a group".to_owned(),
                    };
                    self.fault(
                        Code::WrongEnd,
                        one,
                        &message,
                        "end each group with GE and its own number",
                    );
                }
                Op::End(n)
            }
        }
    }

    /// The index of the label to which the jump `one` in `routine` leads. Reports an error and returns `None` if there
    /// is no such label, or if it is in another routine.
    fn target(&mut self, one: &Listed, routine: Option<&Routine>) -> Option<usize> {
        let n = one.operand;
        let Some(&target) = self.labels.get(&n) else {
            let message = format!("LBL{n} does not exist");
            self.fault(
                Code::NoLabel,
                one,
                &message,
                "write LBL with this number directly before the instruction to which the jump leads",
            );
            return None;
        };
        if routine.is_some_and(|routine| routine.body.contains(&target)) {
            return Some(target);
        }
        let message = format!("LBL{n} is in another routine");
        let help = "jump within the main routine or within one group; use GS, GOFF and GE to start, stop and end groups";
        self.fault(Code::JumpOut, one, &message, help);
        None
    }

    /// Reports an error for each CJP or WAIT without a condition directly before it, for each test that no CJP or WAIT
    /// uses, and for a condition that combines a timer with other tests.
    fn conditions(&mut self, source: &Source) {
        let list = &source.instructions;
        let mut found = Vec::new();
        for (at, one) in list.iter().enumerate() {
            let next = list.get(at + 1).map(|next| next.op);
            if one.op.uses_condition() && source.condition(at) == at {
                found.push((
                    Code::NoCondition,
                    one,
                    "this instruction has no condition",
                    "put AND, AND NOT or TIM before the instruction, or use JMP to jump without a condition",
                ));
            }
            if one.op.is_test() && !next.is_some_and(|next| next.is_test() || next.uses_condition())
            {
                found.push((
                    Code::UnusedCondition,
                    one,
                    "no CJP or WAIT uses this condition",
                    "put CJP or WAIT directly after the condition: no other instructions use conditions",
                ));
            }
            let timer = |op: Op| matches!(op, Op::Timer { .. });
            if one.op.is_test()
                && next.is_some_and(|next| next.is_test() && (timer(next) || timer(one.op)))
            {
                found.push((
                    Code::MixedCondition,
                    one,
                    "a condition combines a timer with other tests, which is not defined",
                    "use one CJP or WAIT for the timer and a second CJP or WAIT for the other tests",
                ));
            }
        }
        for (code, one, message, help) in found {
            self.faults.error_in_line(code, one.line, &one.text, message, help);
        }
    }

    /// Reports an error for each routine whose last instruction is not a JMP or GE, so that it would continue into the
    /// next one.
    fn check_ends(&mut self, source: &Source) {
        for routine in source.routines.iter().filter(|routine| !routine.body.is_empty()) {
            let last = &source.instructions[routine.body.end - 1];
            if !last.op.leaves() {
                let (message, help) = match routine.group {
                    None => (
                        "the main routine does not end with an unconditional jump",
                        "end the main routine with a JMP back to its label",
                    ),
                    Some(_) => (
                        "the group does not end with GE or an unconditional jump",
                        "end the group with GE or with a JMP",
                    ),
                };
                self.faults.error_in_line(Code::NoEnd, last.line, &last.text, message, help);
            }
        }
    }

    fn fault(&mut self, code: Code, one: &Listed, message: &str, help: &str) {
        let [from, to] = [one.at.start as usize, one.at.end as usize];
        let begin = self.text[..from].rfind('\n').map_or(0, |at| at + 1);
        let line = self.text[begin..].lines().next().unwrap_or_default();
        self.faults.error_at(code, one.line, line, &self.text[from..to], (message, help));
    }
}
