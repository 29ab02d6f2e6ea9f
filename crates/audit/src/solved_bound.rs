//! The bound of an additional audit with other settings.

use scanbound_base::time::Picos;
use std::fmt;

/// The upper bound that an additional audit with changed facts or settings gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SolvedBound {
    /// The upper bound: no scan takes longer if the additional audit's facts and settings are right.
    pub upper: Picos,
    /// Whether the time limit ended the additional audit, so that its bound depends on machine speed and load.
    /// Otherwise every run with the same input finds the same bound.
    pub cut: bool,
}

impl fmt::Display for SolvedBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.upper, self.note())
    }
}

impl SolvedBound {
    /// The note that follows the bound in a report: empty unless the time limit ended the audit.
    #[must_use]
    pub fn note(&self) -> &'static str {
        if self.cut { " or less (the audit that found this bound ended early)" } else { "" }
    }
}
