//! The reasons for over-approximation, and their texts.

use std::fmt;
use std::sync::Arc;

/// A place where the model allows more behaviour than the PLC has.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Approximation {
    /// The instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// Why the bound assumes more at this instruction than can happen.
    pub what: Approximated,
}

/// Why an instruction is over-approximated. The `Display` text is one sentence.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Approximated {
    /// A reason of one dialect, in the front's words.
    Dialect(Arc<str>),
    /// The number of iterations or units is read from a word whose value is unknown.
    UnknownCount {
        /// The word as the source writes it.
        word: Arc<str>,
        /// The largest number of iterations or units that is assumed.
        most: i64,
        /// Whether a stated range of the word would lower the assumed number.
        can_be_stated: bool,
    },
    /// The block operations of the program have more cells than the limit (see [`crate::cell_budget`]).
    BlocksTooLarge,
    /// What this instruction reads may change at any moment ([`Program::volatile`](crate::Program::volatile)), mostly
    /// because an interrupt routine writes it.
    Interrupted,
    /// The instruction is in an interrupt routine, so everything that it reads is unknown.
    ReadByInterrupt,
    /// An interrupt routine is charged this many times and not followed.
    InterruptSummary(u32),
    /// A loop is charged this many times and not followed, because its number of iterations is unknown or too large.
    LoopSummary(u32),
    /// A loop is charged this many times and not followed, because nested loops have too many iterations together.
    NestedSummary(u32),
    /// A routine is called too often to be followed.
    RoutineSummary,
    /// No part of the program is followed: everything is charged at its larger time.
    WholeSummary(SummaryReason),
    /// To follow the number of iterations of a loop would make the model too large.
    CostlyCount,
    /// To follow the values that the instruction reads would make the model too large.
    CostlyRead,
}

/// Why no part of a program is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SummaryReason {
    /// The scan would execute too many instructions.
    TooManyInstructions,
    /// A model of the program's computed values would be too large.
    ValuesTooComplex,
    /// The time limit was reached.
    TimeLimit,
}

impl Approximated {
    /// Whether the instruction is over-approximated because a loop is not followed.
    #[must_use]
    pub fn is_loop_summary(&self) -> bool {
        matches!(self, Approximated::LoopSummary(_) | Approximated::NestedSummary(_))
    }
}

impl From<&str> for Approximated {
    fn from(text: &str) -> Approximated {
        Approximated::Dialect(text.into())
    }
}

impl From<String> for Approximated {
    fn from(text: String) -> Approximated {
        Approximated::Dialect(text.into())
    }
}

impl fmt::Display for Approximated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Approximated::Dialect(text) => text,
            Approximated::UnknownCount { word, most, can_be_stated } => {
                write!(
                    f,
                    "the number of iterations or units, from {word}, is unknown: the largest possible number, {most}, is assumed"
                )?;
                if *can_be_stated { "; state its range to lower the bound" } else { "" }
            }
            Approximated::BlocksTooLarge => {
                "the block operations of the program write too many devices to follow each: any values are assumed for everything that this instruction writes"
            }
            Approximated::Interrupted => {
                "an interrupt routine may write what this instruction reads: any values are assumed for everything that this instruction reads"
            }
            Approximated::ReadByInterrupt => {
                "an interrupt may occur at any moment: any values are assumed for everything that its routine reads"
            }
            Approximated::InterruptSummary(times) => {
                return write!(
                    f,
                    "the interrupt routine is charged {times} times, every instruction at its larger time"
                );
            }
            Approximated::LoopSummary(times) => {
                return write!(
                    f,
                    "the loop is charged {times} times, every instruction at its larger time, and everything that it writes may have any value"
                );
            }
            Approximated::NestedSummary(times) => {
                f.write_str(
                    "if each iteration were followed, the scan would have too many instructions: ",
                )?;
                return Approximated::LoopSummary(*times).fmt(f);
            }
            Approximated::RoutineSummary => {
                "this routine and the routines that it calls run too often to follow each run: each call is charged with every instruction at its larger time, and everything that it writes may have any value"
            }
            Approximated::WholeSummary(why) => {
                f.write_str(match why {
                    SummaryReason::TooManyInstructions => {
                        "loops and calls lead to too many executions"
                    }
                    SummaryReason::ValuesTooComplex => {
                        "the program's computed values are too complex to follow"
                    }
                    SummaryReason::TimeLimit => {
                        "the time limit or the user ended the analysis of the scan early"
                    }
                })?;
                ": everything that can run from here on is charged at its larger time, without mutual exclusion"
            }
            Approximated::CostlyCount => {
                "the computation of the number of iterations is too complex to follow: any number within the loop's limits is assumed possible"
            }
            Approximated::CostlyRead => {
                "the computation of the value that this instruction reads is too complex to follow: any value is assumed for it"
            }
        };
        f.write_str(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_is_told_with_what_would_help() {
        let count = |can_be_stated| {
            Approximated::UnknownCount { word: "D5".into(), most: 9, can_be_stated }.to_string()
        };
        assert_eq!(
            count(false),
            "the number of iterations or units, from D5, is unknown: the largest possible number, 9, is assumed"
        );
        assert_eq!(count(true), count(false) + "; state its range to lower the bound");
    }

    #[test]
    fn a_loop_among_loops_is_told_as_a_loop() {
        let (one, nested) = (Approximated::LoopSummary(7), Approximated::NestedSummary(7));
        assert!(nested.to_string().ends_with(&one.to_string()) && nested.is_loop_summary());
    }
}
