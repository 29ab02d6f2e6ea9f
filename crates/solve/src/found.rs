//! What a search found out.

use super::trace::Trace;
use scanbound_base::time::Picos;
use scanbound_model::Portion;

/// What found the maximum out, or went furthest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Engine {
    /// The search by subsets, on Z3 (in a build without Z3: on BatSat).
    Subsets,
    /// The core-guided search, on BatSat.
    Cores,
}

/// What was found out about a group's maximum.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Maximum {
    /// No scan costs more.
    pub upper: Picos,
    /// The assignment below costs this.
    pub lower: Picos,
    /// Values of the group's variables.
    pub best: Portion,
    /// Whether these keep the group's constraints. They do unless the search ended before any that do were found (or
    /// there are none): then all are 0 and so is `lower`.
    pub kept: bool,
    /// Questions put to a solver.
    pub calls: u64,
    /// What found it out.
    pub engine: Engine,
    /// How, if the limits ask for it.
    pub trace: Trace,
}
