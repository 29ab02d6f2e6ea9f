//! Routines beside the scan's own: those that interrupt it, and those that are not in the project.

use scanbound_base::time::Picos;

/// A routine that may interrupt the scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interrupt {
    /// Its label.
    pub name: String,
    /// Its first instruction.
    pub entry: usize,
    /// How often it is counted in a scan.
    pub times: u32,
    /// Whether the user stated that number.
    pub stated: bool,
}

/// A routine that a call asks for and that is not in the project. What is known of it stands behind the programs, and is
/// called in its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Absent {
    /// Its name, as [`scanbound_base::facts::plain`] has names.
    pub name: String,
    /// The instruction that takes its time and writes what it may write.
    pub entry: usize,
    /// What it takes.
    pub time: Picos,
    /// Whether the user stated that; else nothing is known of it, and what is found with it is no bound.
    pub stated: bool,
    /// Whether its declaration is there: it writes what it is handed and what it holds itself, whatever else is stated.
    pub declared: bool,
}
