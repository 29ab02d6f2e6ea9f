//! What charts among a program's routines tell.

use super::Cell;

/// What charts tell of the state in which a scan starts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Charts {
    /// So many of the first invariants say which of their states exclude each other.
    pub apart: usize,
    /// The bits that say which steps are active and which actions are on.
    pub active: Vec<Cell>,
}
