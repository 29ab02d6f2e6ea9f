//! Why there is no audit.

use scanbound_base::diagnostic::Diagnostic;

/// Why there is no audit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// The input cannot be analysed, or the time limit ended the audit before it had a result. Holds all faults that
    /// were found.
    Input(Vec<Diagnostic>),
    /// An internal error: the analysis and the interpreter disagree. Holds the message.
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
