//! What is known from sequential function charts.

use super::{AreaId, Cell};

/// What the charts say about the state at the start of a scan.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Charts {
    /// How many of the program's invariants, from the first on, say which steps and actions exclude each other.
    pub exclusions: usize,
    /// The bits that say which steps are active and which actions are on.
    pub active: Vec<Cell>,
    /// The areas of all cells in which charts keep their state. With every level of trust (`--trust`), it is assumed
    /// that only the program writes them.
    pub areas: Vec<AreaId>,
}
