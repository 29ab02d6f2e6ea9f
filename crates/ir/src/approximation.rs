//! What was over-approximated, and the words for it.

use std::fmt;
use std::sync::Arc;

/// Something that is over-approximated: modelled with more behaviour than the PLC has.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Approximation {
    /// The instruction, an index into `Program::instructions`.
    pub instruction: usize,
    /// What was done.
    pub what: Approximated,
}

/// What was done where something is over-approximated. Its text is one sentence.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Approximated {
    /// Something that only its dialect has, in the front's words.
    Dialect(Arc<str>),
    /// A count stands in a word of which nothing is known.
    UnknownCount {
        /// The word, as the source has it.
        word: Arc<str>,
        /// The most that is taken.
        most: i64,
        /// Whether a stated range of the word would help.
        can_be_stated: bool,
    },
    /// Blocks of cells take too much to follow them.
    NoRoom,
    /// An interrupt may write what is read.
    Interrupted,
    /// An interrupt routine reads.
    ReadByInterrupt,
    /// An interrupt routine is charged so often, and not followed.
    InterruptSummary(u32),
    /// A loop's count says nothing, or it is too long to be followed: it is charged so often, and not followed.
    LoopSummary(u32),
    /// The same where loops in loops are too long together.
    NestedSummary(u32),
    /// A routine is called too often to be followed.
    RoutineSummary,
    /// Nothing of a program is followed.
    WholeSummary(Unfollowed),
    /// A loop's count takes too much to follow.
    CostlyCount,
    /// What an instruction reads takes too much to follow.
    CostlyRead,
}

/// Why nothing of a program is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Unfollowed {
    /// It executes too many instructions.
    TooMany,
    /// Its values take too much.
    TooDear,
    /// The time was over.
    NoTime,
}

impl Approximated {
    /// Whether it is a loop's that is not followed.
    #[must_use]
    pub fn is_loop_summary(&self) -> bool {
        matches!(self, Approximated::LoopSummary(_) | Approximated::NestedSummary(_))
    }
}

impl From<&str> for Approximated {
    fn from(told: &str) -> Approximated {
        Approximated::Dialect(told.into())
    }
}

impl From<String> for Approximated {
    fn from(told: String) -> Approximated {
        Approximated::Dialect(told.into())
    }
}

impl fmt::Display for Approximated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = match self {
            Approximated::Dialect(told) => told,
            Approximated::UnknownCount { word, most, can_be_stated } => {
                write!(f, "the count {word} is not known: taken as up to {most}")?;
                if *can_be_stated { "; state its range to lower this" } else { "" }
            }
            Approximated::NoRoom => {
                "the program's blocks take too much to follow them all: what this writes is taken as any value"
            }
            Approximated::Interrupted => {
                "an interrupt may write what is read here: taken as any value"
            }
            Approximated::ReadByInterrupt => {
                "an interrupt may come at any moment: all that it reads is taken as any value"
            }
            Approximated::InterruptSummary(times) => {
                return write!(f, "the interrupt routine is charged {times} times at its dearest");
            }
            Approximated::LoopSummary(times) => {
                return write!(
                    f,
                    "the loop is charged {times} times at its dearest, and what it writes is taken as any value"
                );
            }
            Approximated::NestedSummary(times) => {
                f.write_str(
                    "followed iteration by iteration the scan has too many instructions: ",
                )?;
                return Approximated::LoopSummary(*times).fmt(f);
            }
            Approximated::RoutineSummary => {
                "the routine and all that it calls run more often than can be followed: each call of it is charged at its dearest, and what it writes is taken as any value"
            }
            Approximated::WholeSummary(why) => {
                f.write_str(match why {
                    Unfollowed::TooMany => "loops and calls multiply to more than can be followed",
                    Unfollowed::TooDear => {
                        "the values that the program works out take too much to follow"
                    }
                    Unfollowed::NoTime => "the time was over before the scan was followed",
                })?;
                ": all that can run from here is charged at its dearer time, whatever excludes it"
            }
            Approximated::CostlyCount => {
                "the count takes too much to follow: any number of iterations that the loop allows is taken"
            }
            Approximated::CostlyRead => {
                "what is read here takes too much to follow: taken as any value"
            }
        };
        f.write_str(told)
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
        assert_eq!(count(false), "the count D5 is not known: taken as up to 9");
        assert_eq!(count(true), count(false) + "; state its range to lower this");
    }

    #[test]
    fn a_loop_among_loops_is_told_as_a_loop() {
        let (one, nested) = (Approximated::LoopSummary(7), Approximated::NestedSummary(7));
        assert!(nested.to_string().ends_with(&one.to_string()) && nested.is_loop_summary());
    }
}
