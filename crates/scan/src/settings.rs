//! The purpose, the parameters, the size limits and the errors of a symbolic execution.

use scanbound_base::time::Times;
use scanbound_ir::meaning::Knowledge;
use std::collections::BTreeSet;

/// Why the symbolic execution of a scan gave no model. Each `instruction` is an index into the program's instructions.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ScanError {
    /// Calls and loops lead to more instruction executions in one scan than the limit.
    #[error("because of calls and loops, one scan executes more than {most} instructions")]
    TooManyExecutions {
        /// The largest permitted number of instruction executions.
        most: usize,
        /// The instruction at which the limit was exceeded.
        instruction: usize,
    },
    /// Calls and loops execute an instruction so often that its time overflows.
    #[error(
        "calls and loops execute this instruction so often that its number of executions or its time is too large"
    )]
    CostOverflow {
        /// The instruction whose number of executions or cost overflows.
        instruction: usize,
    },
    /// The whole model exceeds [`SizeLimits::in_all`], or a query on words was given up because it exceeded
    /// [`SizeLimits::per_execution`]. It may fit if everything that the costly instructions read is replaced by any
    /// values ([`scan_model_fitted`](crate::size_limits::scan_model_fitted)).
    #[error("the program's computed values are too complex to follow")]
    TooLarge {
        /// The instruction at which the whole model exceeded its limit. If only single executions were too large, the
        /// costly instruction with the smallest index (0 if there is none).
        instruction: usize,
        /// The instructions of which one execution exceeded [`SizeLimits::per_execution`].
        costly: BTreeSet<usize>,
    },
    /// The caller stopped the symbolic execution: [`SizeLimits::is_over`] returned true.
    #[error("the analysis of the scan was stopped before its end")]
    Stopped {
        /// The instruction that was executed last.
        instruction: usize,
    },
    /// An instruction reads a result of the rung that does not exist, or that depends on the path: a stack with too few
    /// results or of unknown depth, or a slot that not every path saved. The front accepted something that is not a
    /// rung.
    #[error(
        "this instruction reads a result of the rung that does not exist, or that depends on the path by which control came here"
    )]
    NoResult {
        /// The instruction that reads the result.
        instruction: usize,
    },
}

/// What a model is for. The two purposes differ where it is unknown whether something can happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Upper bounds: the model includes everything that may happen, and more where the analysis does not know better.
    UpperBound,
    /// Lower bounds: the model leaves out what is not certain to happen on a PLC, such as an iteration of a loop that
    /// manuals leave open, and records where operation errors may end the scan.
    LowerBound,
}

/// Size limits of a scan's model. A size is a number of circuit nodes plus the number of steps of queries on words
/// (which take time even if they add no nodes).
pub struct SizeLimits<'a> {
    /// The largest size that one execution of one instruction may add. An instruction that adds more is costly; its
    /// queries beyond this size are given up, and [`ScanError::TooLarge`] then reports it at the end.
    pub per_execution: usize,
    /// The largest size of the whole model.
    pub in_all: usize,
    /// Called once in 256 executed instructions; the execution stops with [`ScanError::Stopped`] if it returns true.
    pub is_over: &'a dyn Fn() -> bool,
}

impl Default for SizeLimits<'_> {
    /// No limits.
    fn default() -> Self {
        SizeLimits { per_execution: usize::MAX, in_all: usize::MAX, is_over: &|| false }
    }
}

/// The parameters of a symbolic execution, besides the program.
#[derive(Clone, Copy)]
pub(super) struct ScanSettings<'p> {
    /// The times of each instruction, by its index.
    pub(super) times: &'p [Times],
    /// What real runs showed about the results of operations (choices with a known operation).
    pub(super) knowledge: &'p Knowledge,
    pub(super) purpose: Purpose,
    /// The size limits of the model.
    pub(super) limits: &'p SizeLimits<'p>,
}

impl<'p> ScanSettings<'p> {
    /// Parameters for upper bounds, without results of real runs.
    pub(super) fn of_upper_bounds(
        times: &'p [Times],
        limits: &'p SizeLimits<'p>,
    ) -> ScanSettings<'p> {
        static NOTHING: Knowledge = Knowledge::new();
        ScanSettings { times, knowledge: &NOTHING, purpose: Purpose::UpperBound, limits }
    }
}
