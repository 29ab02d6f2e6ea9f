//! What a second solver makes of a group's maximum.

/// What Z3 makes of a group's maximum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Opinion {
    /// Nothing costs a picosecond more than the upper bound, and the best scan is one and costs the lower bound.
    Confirmed,
    /// The group is too large to ask.
    TooLarge,
    /// Z3 came to no answer within its budget or the time limit.
    RanOut,
    /// This build has no Z3 (feature `z3`).
    NoSolver,
}

/// Whether this build has Z3, which gives second opinions and searches small groups.
pub const HAS_Z3: bool = cfg!(feature = "z3");

/// The solver behind the search by subsets.
pub const SUBSET_SOLVER: &str = if HAS_Z3 { "Z3" } else { "BatSat" };

/// Asks nobody: this build has no Z3.
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
