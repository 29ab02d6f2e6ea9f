//! A flowchart program as read from a file, with resolved labels, groups and timers.

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The dialect's name.
pub const NAME: &str = "flowchart";

/// The largest number of groups of a program.
pub const MAX_GROUPS: usize = 32;

/// What an instruction does. A jump target is an index into [`Source::instructions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Op {
    /// `AND n`, `AND NOT n`: part of the condition for the next CJP or WAIT.
    And {
        /// The number of the input or output that is tested.
        bit: u32,
        /// Whether the test requires that the input or output is off.
        negated: bool,
    },
    /// `TIM n #t`: starts the timer if it was not started; the condition is whether it has timed out, which stops it.
    Timer {
        /// The number of the timer.
        timer: u32,
        /// The time of the timer in tenths of a second; 0 if any TIM of this timer has the time 0.
        tenths: u32,
    },
    /// `OUT n`, `OUT NOT n`: turns an output on or off.
    Out {
        /// The number of the output.
        bit: u32,
        /// Whether the output is turned on. Otherwise it is turned off.
        on: bool,
    },
    /// `CNR TIM n`: resets the timer with this number, or stops it and keeps its remaining time: the documents allow
    /// both.
    ResetTimer(u32),
    /// `JMP L`: jumps to the instruction with this index.
    Jump(usize),
    /// `CJP L`: jumps to the instruction with this index if the condition holds.
    JumpIf(usize),
    /// `WAIT`: continues if the condition is true. Otherwise the routine's turn ends, and its next turn begins here.
    Wait,
    /// `LBL n`: the target of jumps.
    Label(u32),
    /// `GJ`: each started group runs in the order of the numbers, until it waits or ends.
    Groups,
    /// `GS n`: starts the group with this number at its head. Whether it restarts a running group is not documented.
    Start(u32),
    /// `GOFF n`: stops the group with this number.
    Stop(u32),
    /// `GN n`: the head of the group with this number.
    Head(u32),
    /// `GE n`: the end of the group with this number. The group stops, and its turn ends.
    End(u32),
}

impl Op {
    /// Whether the instruction is a test, which is part of a condition: AND, AND NOT or TIM.
    #[must_use]
    pub fn is_test(self) -> bool {
        matches!(self, Op::And { .. } | Op::Timer { .. })
    }

    /// Whether the instruction uses the condition that the tests before it compute: CJP or WAIT.
    #[must_use]
    pub fn uses_condition(self) -> bool {
        matches!(self, Op::JumpIf(_) | Op::Wait)
    }

    /// Whether control never continues from the instruction to the next one: JMP or GE.
    #[must_use]
    pub fn leaves(self) -> bool {
        matches!(self, Op::Jump(_) | Op::End(_))
    }
}

/// One instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instruction {
    /// The operation of the instruction.
    pub op: Op,
    /// The line of the instruction in the file, from 1.
    pub line: u32,
    /// The address of the instruction, if the list has one.
    pub step: Option<u32>,
    /// The instruction in one notation, with single blanks (`GOFF 1` also for `G OFF 1`).
    pub text: String,
}

/// The main routine or a group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Routine {
    /// The group's number; `None` for the main routine.
    pub group: Option<u32>,
    /// The range of the routine's instructions in [`Source::instructions`].
    pub body: Range<usize>,
}

/// A parsed program, with all references resolved.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The file's name as the user gave it.
    pub name: String,
    /// All instructions in source order.
    pub instructions: Vec<Instruction>,
    /// The main routine, then the groups by number.
    pub routines: Vec<Routine>,
    /// The comments after semicolons, by the number of the input or output that the instruction on that line names.
    pub comments: BTreeMap<u32, String>,
}

impl Source {
    /// The index of the first instruction of the condition of the CJP or WAIT at index `asks`: its first test, or
    /// `asks` if it has none.
    #[must_use]
    pub fn condition(&self, asks: usize) -> usize {
        let tests = self.instructions[..asks].iter().rev();
        asks - tests.take_while(|one| one.op.is_test()).count()
    }

    /// The positions of a routine between passes, as instruction indices: its head, then the conditions of its WAITs,
    /// and in the main routine the targets of jumps back (which may be the head again).
    #[must_use]
    pub fn positions(&self, routine: &Routine) -> Vec<usize> {
        let mut places = vec![routine.body.start];
        for at in routine.body.clone() {
            match self.instructions[at].op {
                Op::Wait => places.push(self.condition(at)),
                Op::Jump(to) | Op::JumpIf(to) if routine.group.is_none() && to <= at => {
                    places.push(to);
                }
                _ => {}
            }
        }
        places.sort_unstable();
        places.dedup();
        places
    }

    /// The groups by number.
    pub fn groups(&self) -> impl Iterator<Item = (u32, &Routine)> {
        self.routines.iter().filter_map(|routine| routine.group.map(|group| (group, routine)))
    }

    /// The numbers of all outputs that an OUT instruction sets.
    #[must_use]
    pub fn outputs(&self) -> BTreeSet<u32> {
        let outputs = self.instructions.iter().filter_map(|one| match one.op {
            Op::Out { bit, .. } => Some(bit),
            _ => None,
        });
        outputs.collect()
    }

    /// The numbers of all inputs: what is tested but not set by an OUT instruction.
    #[must_use]
    pub fn inputs(&self) -> BTreeSet<u32> {
        let outputs = self.outputs();
        let tested = self.instructions.iter().filter_map(|one| match one.op {
            Op::And { bit, .. } if !outputs.contains(&bit) => Some(bit),
            _ => None,
        });
        tested.collect()
    }

    /// The shortest time above 0 of a timer, in tenths of a second. `None` if no timer has such a time.
    #[must_use]
    pub fn shortest_timer(&self) -> Option<u32> {
        let times = self.instructions.iter().filter_map(|one| match one.op {
            Op::Timer { tenths, .. } if tenths > 0 => Some(tenths),
            _ => None,
        });
        times.min()
    }

    /// The inner loops of the main routine: jumps back to a place other than its head, as pairs of the target's index
    /// and the jump's index.
    #[must_use]
    pub fn inner_loops(&self) -> Vec<(usize, usize)> {
        let Some(main) = self.routines.first() else { return Vec::new() };
        let back = |at: usize| match self.instructions[at].op {
            Op::Jump(to) | Op::JumpIf(to) if to <= at && to != main.body.start => Some((to, at)),
            _ => None,
        };
        main.body.clone().filter_map(back).collect()
    }
}

impl Source {
    /// Warnings about the program: one for each inner loop of the main routine.
    #[must_use]
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let loops = self.inner_loops().into_iter().map(|(to, at)| {
            let (from, jump) = (&self.instructions[to], &self.instructions[at]);
            let (line, text) = (jump.line, jump.text.clone());
            let message =
                format!("the main routine can repeat the loop from line {} to here", from.line);
            let help = "scanbound counts each iteration as a pass of its own: no action is needed if this is meant";
            Diagnostic::line(Code::InnerLoop, &self.name, line, text, message, help).warning()
        });
        loops.collect()
    }
}
