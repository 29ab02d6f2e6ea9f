//! The settings for checking a net, and the steps of the runs that findings show.

/// One step of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// A step by the net's rule: this one transition fires.
    Fire(usize),
    /// A timer times out; an index into the places.
    RunOut(usize),
    /// The code's rule: a scan in which the relays of these transitions are on.
    Scan(Vec<usize>),
}

/// Options of the analysis.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// The largest number of states, for the net and for the code each.
    pub limit: usize,
    /// Whether the code's first scan sets the initial marks.
    pub initial_in_first_scan: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options { limit: 2_000_000, initial_in_first_scan: false }
    }
}
