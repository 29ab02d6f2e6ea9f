//! `scanbound audit`: the bound and its reasons.

use super::options::ProjectOptions;
use super::{Failure, Outcome};
use clap::Args;

/// The arguments of `audit`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectOptions,
}

/// Audits the project and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let target = arguments.project.target()?;
    let audit = arguments.project.audit()?;
    arguments.project.report(&audit, None, target)?;
    Ok(Outcome::Done)
}
