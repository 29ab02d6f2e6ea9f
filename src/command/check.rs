//! `scanbound check`: whether the project keeps to a limit.

use super::options::{ProjectOptions, ReportOptions, SearchOptions};
use super::{Failure, Outcome, values};
use clap::{Args, ValueEnum};
use scanbound::audit::verdict::{Check, Margin, MostAssumed, Verdict};
use scanbound::base::time::Picos;

/// Which scan refutes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Refute {
    /// One that nothing known here excludes
    #[default]
    Admissible,
    /// One to which a run from power-up was found
    Reached,
}

const EXAMPLES: &str = "\
Examples:
  scanbound check PLC/ --limit 10ms
  scanbound check PLC/ --limit 10ms --margin 20% --confirm

Exit codes: 0 proved, 1 refuted, 2 bad input or usage, 3 undecided, 70 internal error";

/// The arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The limit that no scan may pass, such as 10ms
    #[arg(long, value_name = "DURATION", value_parser = values::duration, allow_hyphen_values = true)]
    limit: Picos,
    /// What is added to the scan before it is held against the limit, such as 10%
    #[arg(long, value_name = "PERCENT", default_value = "0%", allow_hyphen_values = true)]
    margin: Margin,
    /// How much of the time that decides may rest on assumed times, such as 30%; with more the limit is undecided
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    max_assumed: Option<MostAssumed>,
    /// Which scan refutes: one that nothing known here excludes, or only one to which a run from power-up was found
    #[arg(long, value_enum, default_value_t)]
    refute: Refute,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    report: ReportOptions,
}

/// Audits the project, judges and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let (target, trace) = arguments.report.targets(&arguments.project, &arguments.search)?;
    let room = arguments.margin.room(arguments.limit);
    let audit = match arguments.max_assumed {
        None => arguments.project.audit_until(room, &arguments.search)?,
        // What a search that ends early leaves open would count as assumed.
        Some(_) => arguments.project.audit(&arguments.search)?,
    };
    trace.write(&audit)?;
    let mut check = Check::new(&audit, arguments.limit, arguments.margin);
    if arguments.refute == Refute::Reached {
        check = check.if_reached(&audit);
    }
    if let Some(most) = arguments.max_assumed {
        check = check.if_assumed_at_most(&audit, most);
    }
    arguments.report.write(&audit, Some(&check), target)?;
    Ok(match check.verdict {
        Verdict::Proved => Outcome::Done,
        Verdict::Refuted => Outcome::Refuted,
        Verdict::Undecided(_) => Outcome::Undecided,
    })
}
