//! The maximum of one group: the most that its charges can cost in one scan.

use crate::model::{Assignment, ScanModel, VarId};
use crate::time::Picos;
use std::time::Instant;

/// Charges that hang together by free variables. Groups share no variable.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Group {
    /// Indices into `ScanModel::charges`, ascending; none is constant.
    pub charges: Vec<usize>,
    /// The free variables they depend on, through guards or constraints, ascending.
    pub variables: Vec<VarId>,
    /// Indices into `ScanModel::constraints` that concern these variables.
    pub constraints: Vec<usize>,
}

/// Which search to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The one that suits the group.
    #[default]
    Auto,
    /// The paper's: take away what conflicts, one at a time, bounded by T_MAX.
    Subsets,
    /// Core-guided search.
    Cores,
}

/// What was found out about a group's maximum.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Maximum {
    /// No scan costs more.
    pub upper: Picos,
    /// The assignment below costs this.
    pub lower: Picos,
    /// Values of all variables of the model; 0 outside the group.
    pub best: Assignment,
    /// Questions put to a solver.
    pub calls: u64,
}

/// What a search may use and whom it tells.
pub struct Limits<'a> {
    /// When to stop with what is proved.
    pub deadline: Option<Instant>,
    /// Asked now and then; true stops the search as the deadline does.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Told of every better bound: upper and lower.
    pub progress: &'a (dyn Fn(Picos, Picos) + Sync),
}

/// The group's maximum. The bounds are valid however early the search ends.
#[must_use]
pub fn maximum(
    _model: &ScanModel,
    _group: &Group,
    _method: Method,
    _limits: &Limits<'_>,
) -> Maximum {
    todo!("the search")
}
