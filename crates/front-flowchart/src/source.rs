//! A flowchart program as read from a file, with all that it names found.

use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The dialect's name.
pub const NAME: &str = "flowchart";

/// Most groups that a program may have.
pub const MOST_GROUPS: usize = 32;

/// What an instruction does. Jumps name their target by its index into [`Source::instructions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Op {
    /// `AND n`, `AND NOT n`: joins the condition that the next CJP or WAIT asks for.
    And {
        /// The input or output.
        bit: u32,
        /// Whether it has to be off.
        negated: bool,
    },
    /// `TIM n #t`: starts the timer unless it runs; the condition is whether it has run out.
    Timer {
        /// Its number.
        timer: u32,
        /// Its time in tenths of a second; 0 where any TIM of this timer has none.
        tenths: u32,
    },
    /// `OUT n`, `OUT NOT n`: turns an output on or off.
    Out {
        /// The output.
        bit: u32,
        /// To what.
        on: bool,
    },
    /// `CNR TIM n`: resets the timer.
    ResetTimer(u32),
    /// `JMP L`.
    Jump(usize),
    /// `CJP L`: jumps if the condition holds.
    JumpIf(usize),
    /// `WAIT`: goes on if the condition holds, else the routine's turn ends and its next begins here.
    Wait,
    /// `LBL n`.
    Label(u32),
    /// `GJ`: every started group takes its turn.
    Groups,
    /// `GS n`: starts a group.
    Start(u32),
    /// `GOFF n`: stops a group.
    Stop(u32),
    /// `GN n`: a group's head.
    Head(u32),
    /// `GE n`: a group's end.
    End(u32),
}

impl Op {
    /// Whether it is part of a condition.
    #[must_use]
    pub fn is_test(self) -> bool {
        matches!(self, Op::And { .. } | Op::Timer { .. })
    }

    /// Whether it asks for the condition.
    #[must_use]
    pub fn asks(self) -> bool {
        matches!(self, Op::JumpIf(_) | Op::Wait)
    }

    /// Whether control never goes on behind it.
    #[must_use]
    pub fn leaves(self) -> bool {
        matches!(self, Op::Jump(_) | Op::End(_))
    }
}

/// One instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instruction {
    /// What it does.
    pub op: Op,
    /// Its line, from 1.
    pub line: u32,
    /// Its address, where the list gives it.
    pub step: Option<u32>,
    /// As the list has it, blanks made one.
    pub text: String,
}

/// The main routine or a group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Routine {
    /// The group's number; `None` for the main routine.
    pub group: Option<u32>,
    /// Its instructions.
    pub body: Range<usize>,
}

/// A program as read from a file, with all that it names found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The file's name as the user gave it.
    pub name: String,
    /// All instructions.
    pub instructions: Vec<Instruction>,
    /// The main routine, then the groups by number.
    pub routines: Vec<Routine>,
    /// What the list says of inputs and outputs behind a semicolon, by their number.
    pub comments: BTreeMap<u32, String>,
}

impl Source {
    /// Where the condition of a CJP or WAIT begins: its first test, or itself.
    #[must_use]
    pub fn condition(&self, asks: usize) -> usize {
        let tests = self.instructions[..asks].iter().rev();
        asks - tests.take_while(|one| one.op.is_test()).count()
    }

    /// Where a routine can stand between passes: its head; behind it, in order, the beginnings of the
    /// conditions of its WAITs and, in the main routine, what jumps back go to. All are indices of
    /// instructions; a jump's target in the main routine may be the head.
    #[must_use]
    pub fn stands(&self, routine: &Routine) -> Vec<usize> {
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

    /// The outputs: what an OUT sets.
    #[must_use]
    pub fn outputs(&self) -> BTreeSet<u32> {
        let outputs = self.instructions.iter().filter_map(|one| match one.op {
            Op::Out { bit, .. } => Some(bit),
            _ => None,
        });
        outputs.collect()
    }

    /// The inputs: what is tested and no OUT sets.
    #[must_use]
    pub fn inputs(&self) -> BTreeSet<u32> {
        let outputs = self.outputs();
        let tested = self.instructions.iter().filter_map(|one| match one.op {
            Op::And { bit, .. } if !outputs.contains(&bit) => Some(bit),
            _ => None,
        });
        tested.collect()
    }

    /// The shortest time that a timer is set to, in tenths of a second; none of 0.
    #[must_use]
    pub fn shortest_timer(&self) -> Option<u32> {
        let times = self.instructions.iter().filter_map(|one| match one.op {
            Op::Timer { tenths, .. } if tenths > 0 => Some(tenths),
            _ => None,
        });
        times.min()
    }

    /// The inner loops of the main routine: jumps back to another place than its head, as indices of the
    /// target and the jump.
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
    /// What is worth knowing of the program although it can be taken.
    #[must_use]
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let loops = self.inner_loops().into_iter().map(|(to, at)| {
            let (from, jump) = (&self.instructions[to], &self.instructions[at]);
            let (line, text) = (jump.line, jump.text.clone());
            let message =
                format!("the main routine can stay in the loop from line {} to here", from.line);
            let help = "each iteration of it counts as a pass of its own";
            Diagnostic::line(Code::InnerLoop, &self.name, line, text, message, help).warning()
        });
        loops.collect()
    }
}
