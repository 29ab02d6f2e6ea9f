//! What a scan is followed for, within which limits, and why it cannot be.

use scanbound_base::time::Times;
use scanbound_ir::meaning::Knowledge;
use std::collections::BTreeSet;

/// Why a program has no scan model.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ScanError {
    /// Calls and loops multiply to more executions than can be followed.
    #[error("calls and loops make more than {most} executed instructions in one scan")]
    TooLong {
        /// The limit.
        most: usize,
        /// The instruction at which it was passed.
        instruction: usize,
    },
    /// Calls and loops multiply so that no number can tell how long an instruction runs.
    #[error("calls and loops make this run more often than can be counted")]
    TooOften {
        /// The instruction.
        instruction: usize,
    },
    /// The model grows beyond its limits of size. It may fit if the values that costly instructions read are not
    /// followed.
    #[error("the values that the program works out take too much to follow")]
    Grown {
        /// The instruction at which the model passed its limit; the first of the costly ones if only these did.
        instruction: usize,
        /// The instructions of which one execution passed the limit for one.
        costly: BTreeSet<usize>,
    },
    /// It was ended from outside.
    #[error("ended before the scan was followed to its end")]
    Ended {
        /// The instruction at which it was.
        instruction: usize,
    },
    /// A result is used that differs in depth by the path taken: the front end let through what is no rung.
    #[error("the rung's result depends on the path by which control came here")]
    NoResult {
        /// The instruction.
        instruction: usize,
    },
}

/// What a model is for. Where it is not known whether something can happen, the two differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To bound scans from above: the model has all that may happen.
    UpperBound,
    /// To find scans that a PLC makes: the model has only what is known to happen.
    LowerBound,
}

/// How large the model of a scan may get: nodes of its circuit, and steps of the questions to words (which values can
/// this word have?), which take time but leave no nodes.
pub struct SizeLimits<'a> {
    /// What one execution of one instruction may add; those that would add more are told in [`ScanError::Grown`].
    pub per_execution: usize,
    /// What the whole model may take.
    pub in_all: usize,
    /// Asked every few hundred instructions; true ends the execution.
    pub is_over: &'a dyn Fn() -> bool,
}

impl Default for SizeLimits<'_> {
    /// No limit.
    fn default() -> Self {
        SizeLimits { per_execution: usize::MAX, in_all: usize::MAX, is_over: &|| false }
    }
}

/// By what a scan is followed.
#[derive(Clone, Copy)]
pub(super) struct Settings<'p> {
    /// What each instruction costs.
    pub(super) times: &'p [Times],
    /// What was learned of exact choices.
    pub(super) knowledge: &'p Knowledge,
    pub(super) purpose: Purpose,
    /// How large the model may get.
    pub(super) limits: &'p SizeLimits<'p>,
}

impl<'p> Settings<'p> {
    /// Those of a model of upper bounds, without anything learned.
    pub(super) fn of_upper_bounds(times: &'p [Times], limits: &'p SizeLimits<'p>) -> Settings<'p> {
        static NOTHING: Knowledge = Knowledge::new();
        Settings { times, knowledge: &NOTHING, purpose: Purpose::UpperBound, limits }
    }
}
