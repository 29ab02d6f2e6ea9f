//! Why there is no audit.

use scanbound_base::diagnostic::Diagnostic;

/// Why there is no audit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// The input cannot be analysed. All faults that were found.
    Input(Vec<Diagnostic>),
    /// An internal error: the analysis and the interpreter disagree.
    Internal(String),
}

impl From<Vec<Diagnostic>> for Failure {
    fn from(faults: Vec<Diagnostic>) -> Failure {
        Failure::Input(faults)
    }
}

impl From<Diagnostic> for Failure {
    fn from(fault: Diagnostic) -> Failure {
        Failure::Input(vec![fault])
    }
}
