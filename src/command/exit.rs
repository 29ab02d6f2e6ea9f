//! Runs commands to their exit codes, and says why one failed.

use super::outcome::{Failure, Outcome};
use super::output;
use std::panic::{UnwindSafe, catch_unwind};

/// Runs a command and returns its exit code. If it failed, the reason is written to stderr. A panic is an internal
/// error.
pub fn code(command: impl FnOnce() -> Result<Outcome, Failure> + UnwindSafe) -> u8 {
    code_of(ended(command))
}

/// The exit code of a command's result.
pub(super) fn code_of(end: Result<Outcome, Failure>) -> u8 {
    match end {
        Ok(outcome) => outcome.code(),
        Err(failure) => {
            output::say(&failure.message());
            failure.code()
        }
    }
}

pub(super) fn ended(
    command: impl FnOnce() -> Result<Outcome, Failure> + UnwindSafe,
) -> Result<Outcome, Failure> {
    catch_unwind(command).unwrap_or_else(|panic| {
        let what = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let what = what.or_else(|| panic.downcast_ref::<String>().cloned());
        Err(Failure::Internal(what.unwrap_or_else(|| "a panic".to_owned())))
    })
}
