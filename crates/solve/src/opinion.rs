//! The result of checking a group's maximum with a second solver.

/// The result of checking a group's maximum with Z3, where Z3 does not contradict it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Opinion {
    /// No scan costs more than the upper bound, and the best scan satisfies the constraints and costs the lower bound.
    Confirmed,
    /// The group has too many charges or circuit nodes to check.
    TooLarge,
    /// Z3 found no answer within its effort limit or the time limit, or was not asked because the limits were reached.
    RanOut,
    /// This build does not include Z3 (feature `z3`).
    NoSolver,
}

/// Whether this build includes Z3, which gives second opinions and searches small groups.
pub const HAS_Z3: bool = cfg!(feature = "z3");

/// The SAT solver of the search by subsets.
pub const SUBSET_SOLVER: &str = if HAS_Z3 { "Z3" } else { "BatSat" };

/// Does nothing: this build does not include Z3.
///
/// # Errors
/// None.
#[cfg(not(feature = "z3"))]
pub fn second_opinion(
    _: &scanbound_model::ScanModel,
    _: &scanbound_model::Group,
    _: &crate::Maximum,
    _: &crate::Limits<'_>,
) -> Result<Opinion, String> {
    Ok(Opinion::NoSolver)
}
