//! The result of a search.

use super::trace::Trace;
use scanbound_base::time::Picos;
use scanbound_model::GroupAssignment;

/// The search that found the maximum, or that ran last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Engine {
    /// The search by subsets, with Z3 (with BatSat in a build without Z3).
    Subsets,
    /// The core-guided search, with BatSat.
    Cores,
}

/// The result of searching a group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Maximum {
    /// The upper bound: no scan costs more.
    pub upper: Picos,
    /// The lower bound: the cost under `best`.
    pub lower: Picos,
    /// The best assignment found, for the group's variables.
    pub best: GroupAssignment,
    /// Whether `best` satisfies the group's constraints. It does, unless the search ended before it found an assignment
    /// that does, or none exists; then `best` and `lower` are 0.
    pub feasible: bool,
    /// The number of queries to a solver.
    pub calls: u64,
    /// The search that found the result.
    pub engine: Engine,
    /// The steps of the search, if requested.
    pub trace: Trace,
}
