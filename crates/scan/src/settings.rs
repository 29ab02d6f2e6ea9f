//! The purpose, the parameters, the size limits and the errors of a symbolic execution.

use scanbound_base::time::Times;
use scanbound_ir::meaning::Knowledge;
use std::collections::BTreeSet;

/// Why a scan has no model.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ScanError {
    /// Calls and loops lead to more executed instructions than the limit.
    #[error("because of calls and loops, one scan executes more than {most} instructions")]
    TooManyExecutions {
        /// The largest permitted number of executed instructions.
        most: usize,
        /// The instruction at which the limit was exceeded.
        instruction: usize,
    },
    /// Calls and loops execute an instruction so often that its time overflows.
    #[error("calls and loops execute this instruction more often than can be counted")]
    CostOverflow {
        /// The instruction whose number of executions or cost overflows.
        instruction: usize,
    },
    /// The model exceeds its size limits. It may fit if the inputs of costly instructions are replaced by any values.
    #[error("the program's computed values are too complex")]
    TooLarge {
        /// The instruction at which the model exceeded its limit; or the first costly one, if only single executions
        /// were too large.
        instruction: usize,
        /// The instructions of which one execution exceeded the limit for one execution.
        costly: BTreeSet<usize>,
    },
    /// The caller stopped the symbolic execution.
    #[error("the analysis of the scan was stopped before its end")]
    Stopped {
        /// The instruction that would have been executed next.
        instruction: usize,
    },
    /// An instruction reads a result from a stack whose depth depends on the path: the front accepted something that is
    /// not a rung.
    #[error("the rung's result depends on the path by which control came here")]
    NoResult {
        /// The instruction that reads the result.
        instruction: usize,
    },
}

/// The purpose of a model. The two differ where it is unknown whether something can happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Upper bounds: the model includes everything that may happen.
    UpperBound,
    /// Lower bounds: the model includes only scans that a PLC can certainly execute.
    LowerBound,
}

/// Size limits of a scan's model. The size counts the nodes of the circuit, and the steps of queries on words, which
/// take time even if they add no nodes.
pub struct SizeLimits<'a> {
    /// The largest size that one execution of one instruction may add. Larger ones are reported in
    /// [`ScanError::TooLarge`].
    pub per_execution: usize,
    /// The largest number of circuit nodes of the whole model.
    pub in_all: usize,
    /// Called every few hundred instructions; the execution stops if it returns true.
    pub is_over: &'a dyn Fn() -> bool,
}

impl Default for SizeLimits<'_> {
    /// No limits.
    fn default() -> Self {
        SizeLimits { per_execution: usize::MAX, in_all: usize::MAX, is_over: &|| false }
    }
}

/// The parameters of a symbolic execution.
#[derive(Clone, Copy)]
pub(super) struct ScanSettings<'p> {
    /// The times of each instruction.
    pub(super) times: &'p [Times],
    /// The observed results of exact choices.
    pub(super) knowledge: &'p Knowledge,
    pub(super) purpose: Purpose,
    /// The size limits of the model.
    pub(super) limits: &'p SizeLimits<'p>,
}

impl<'p> ScanSettings<'p> {
    /// Parameters for upper bounds, without observations.
    pub(super) fn of_upper_bounds(
        times: &'p [Times],
        limits: &'p SizeLimits<'p>,
    ) -> ScanSettings<'p> {
        static NOTHING: Knowledge = Knowledge::new();
        ScanSettings { times, knowledge: &NOTHING, purpose: Purpose::UpperBound, limits }
    }
}
