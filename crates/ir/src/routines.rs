//! Interrupt routines, and routines whose code is missing.

use scanbound_base::time::Picos;

/// A routine that may interrupt the scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interrupt {
    /// The label or task name of the routine, as facts files name it.
    pub name: String,
    /// The index of the routine's first instruction.
    pub entry: usize,
    /// The number of runs of the routine that one scan is charged.
    pub times: u32,
    /// Whether the user stated how often the routine interrupts a scan.
    pub stated: bool,
}

/// A routine, body or pragma whose code is not in the project, or in a language that cannot be read. An instruction
/// stands for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingRoutine {
    /// The name, normalised by [`scanbound_base::facts::normalized`].
    pub name: String,
    /// The index of the instruction that stands for the routine: it takes the routine's time and writes what the
    /// routine may write.
    pub entry: usize,
    /// The longest time of one execution of the routine, as the user states it; 0 if not `stated`.
    pub time: Picos,
    /// Whether the user stated the time. If not, nothing is known of the routine, so the result is not a bound.
    pub stated: bool,
    /// Whether the routine's declaration is present. If so, the routine also writes its parameters and its own
    /// variables.
    pub declared: bool,
}
