//! How a command ends: with a result, or with a failure and its exit code.

use scanbound::base::diagnostic::Diagnostic;
use scanbound::report::format::Checked;

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done; for `check`: proved.
    Done,
    /// `check`: refuted. `compare`: a measurement exceeds the bound. `diff`: the bound grew by more than is allowed.
    /// `cpus`: no CPU stays within the limit. `doctor`: something prevents a bound.
    Refuted,
    /// `check`: undecided.
    Undecided,
    /// The most serious exit code of several projects. The user has already been told.
    Told(u8),
}

impl Outcome {
    /// The exit code.
    pub fn code(self) -> u8 {
        match self {
            Outcome::Done => 0,
            Outcome::Refuted => 1,
            Outcome::Undecided => 3,
            Outcome::Told(code) => code,
        }
    }
}

/// Why a command ended without a result.
#[derive(Debug)]
pub enum Failure {
    /// The input cannot be analysed.
    Input(Vec<Diagnostic>),
    /// Wrong arguments, or files that cannot be read or written.
    Usage(anyhow::Error),
    /// A fault of this program.
    Internal(String),
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Failure {
        Failure::Usage(error)
    }
}

impl From<Vec<Diagnostic>> for Failure {
    fn from(faults: Vec<Diagnostic>) -> Failure {
        Failure::Input(faults)
    }
}

impl From<scanbound::audit::Failure> for Failure {
    fn from(failure: scanbound::audit::Failure) -> Failure {
        match failure {
            scanbound::audit::Failure::Input(faults) => Failure::Input(faults),
            scanbound::audit::Failure::Internal(what) => Failure::Internal(what),
        }
    }
}

impl Failure {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Input(_) | Failure::Usage(_) => 2,
            Failure::Internal(_) => 70,
        }
    }

    /// A copy of this failure, to report it a second time.
    pub fn again(&self) -> Failure {
        match self {
            Failure::Input(faults) => Failure::Input(faults.clone()),
            Failure::Usage(error) => Failure::Usage(anyhow::anyhow!("{error:#}")),
            Failure::Internal(what) => Failure::Internal(what.clone()),
        }
    }

    /// The result of a project whose check failed in this way.
    pub fn checked(&self) -> Checked<'_> {
        match self {
            Failure::Input(faults) => Checked::Faulty(faults),
            Failure::Usage(error) => Checked::Failed(format!("{error:#}")),
            Failure::Internal(what) => Checked::Failed(format!("internal error: {what}")),
        }
    }
}
