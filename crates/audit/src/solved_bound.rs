//! The bound of an audit that is asked something else besides what was asked.

use scanbound_base::time::Picos;
use std::fmt;

/// What such an audit found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SolvedBound {
    /// No scan takes longer then.
    pub upper: Picos,
    /// The time limit ended that audit: how low its bound was by then hangs on how fast the machine is, and on what else it
    /// does. Otherwise every run that is asked the same finds this bound.
    pub cut: bool,
}

impl fmt::Display for SolvedBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.upper, self.note())
    }
}

impl SolvedBound {
    /// What is to be said behind it.
    #[must_use]
    pub fn note(&self) -> &'static str {
        if self.cut { " or less (the time limit ended that audit)" } else { "" }
    }
}
