//! Interrupt routines, and called routines whose source is missing.

use scanbound_base::time::Picos;

/// A routine that may interrupt the scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interrupt {
    /// The label at which it begins.
    pub name: String,
    /// The index of its first instruction.
    pub entry: usize,
    /// How many runs of it are counted in one scan.
    pub times: u32,
    /// Whether the user stated this number.
    pub stated: bool,
}

/// A routine that is called but whose source is not in the project. A substitute routine at the end of the program is
/// called in its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingRoutine {
    /// The name, normalised by [`scanbound_base::facts::normalized`].
    pub name: String,
    /// The instruction of the substitute, which takes the routine's time and writes what the routine may write.
    pub entry: usize,
    /// The time of one execution.
    pub time: Picos,
    /// Whether the user stated the time. If not, nothing is known of the routine, and the result is not a bound.
    pub stated: bool,
    /// Whether its declaration is present. If so, it writes its parameters and its own variables, whatever else is
    /// stated.
    pub declared: bool,
}
