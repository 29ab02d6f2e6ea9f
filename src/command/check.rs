//! `scanbound check`: whether the project keeps to a limit.

use super::options::{ProjectOptions, ReportOptions};
use super::{Failure, Outcome, values};
use clap::Args;
use scanbound::time::Picos;
use scanbound::verdict::{Check, Margin, Verdict};

/// The arguments of `check`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The limit that no scan may pass, such as 10ms
    #[arg(long, value_name = "DURATION", value_parser = values::duration, allow_hyphen_values = true)]
    limit: Picos,
    /// What is added to the scan before it is held against the limit, such as 10%
    #[arg(long, value_name = "PERCENT", default_value = "0%", allow_hyphen_values = true)]
    margin: Margin,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    report: ReportOptions,
}

/// Audits the project, judges and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let target = arguments.report.target()?;
    let audit = arguments.project.audit_until(arguments.margin.room(arguments.limit))?;
    let check = Check::new(&audit, arguments.limit, arguments.margin);
    arguments.report.write(&audit, Some(&check), target)?;
    Ok(match check.verdict {
        Verdict::Proved => Outcome::Done,
        Verdict::Refuted => Outcome::Refuted,
        Verdict::Undecided(_) => Outcome::Undecided,
    })
}
