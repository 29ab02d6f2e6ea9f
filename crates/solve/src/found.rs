//! The result of a search.

use super::trace::Trace;
use scanbound_base::time::Picos;
use scanbound_model::GroupAssignment;

/// The search that ran last on a group, and so found its result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Engine {
    /// The search by subsets, with Z3 (with BatSat in a build without Z3).
    Subsets,
    /// The core-guided search, with BatSat.
    Cores,
}

/// The result of searching a group. The maximum is known exactly if `feasible` and the bounds are equal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Maximum {
    /// The upper bound: in no scan do the group's charges take more.
    pub upper: Picos,
    /// The lower bound: the time of the group's charges under `best`; 0 if not `feasible`.
    pub lower: Picos,
    /// The best assignment found, for the variables on which the group's time and constraints depend.
    pub best: GroupAssignment,
    /// Whether `best` satisfies the group's constraints. It does, unless the search ended before it found an assignment
    /// that does, or none exists; then all values in `best`, and `lower`, are 0.
    pub feasible: bool,
    /// The number of queries to a solver.
    pub calls: u64,
    /// The search that ran last.
    pub engine: Engine,
    /// The steps of the search; empty if not requested.
    pub trace: Trace,
}
