//! How a net is studied, and the steps of the runs that are shown.

/// One step of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// The net: a transition fires.
    Fire(usize),
    /// A timer's time is over. An index into the places.
    RunOut(usize),
    /// The code: a scan in which the relays of these transitions are on.
    Scan(Vec<usize>),
}

/// How a net is studied.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// How many states are looked at, of the net and of the code each.
    pub limit: usize,
    /// Whether the code's first scan puts the initial marks in.
    pub initial_in_first_scan: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options { limit: 2_000_000, initial_in_first_scan: false }
    }
}
