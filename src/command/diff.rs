//! `scanbound diff`: the differences between two versions of a project, and what each change costs.

use super::options::{ProjectOptions, ReportOptions, SearchOptions};
use super::{Failure, Outcome, project_file};
use anyhow::anyhow;
use clap::Args;
use scanbound::audit::difference::Difference;
use scanbound::audit::verdict::Margin;
use scanbound::base::code::Code;
use scanbound::report::diff::text::answer;
use scanbound::report::format::Detail;

const EXAMPLES: &str = "\
Examples:
  scanbound diff old/ new/ --fail-above 5%   exit code 1 where the bound grows by more
  scanbound diff old.il new.il --cpu Q26UDV -o changes.md -o changes.json

scanbound.toml is not read: state what both versions need in options (--cpu, --facts).

Exit codes: 0 done, 1 the bound grew by more than --fail-above, 2 bad input or usage, 70 internal error";

const VERSIONS: &str =
    "The two versions, each a file or a directory that stands for the programs in it";

/// The arguments of `diff`: two versions, each a file or a directory.
#[derive(Debug, Args)]
#[command(
    after_help = EXAMPLES,
    override_usage = "scanbound diff [OPTIONS] OLD NEW",
    mut_arg("programs", |programs| programs.value_names(["OLD", "NEW"]).help(VERSIONS))
)]
pub struct Arguments {
    /// End with exit code 1 if the bound grows by more than this, such as 5%
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    fail_above: Option<Margin>,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    report: ReportOptions,
}

/// Audits both versions with the same options, compares and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let Some((old, new)) = arguments.project.two() else {
        return Err(anyhow!(
            "give two versions, each a file or a directory: scanbound diff OLD NEW"
        )
        .into());
    };
    let (reports, trace) = arguments.report.targets(&arguments.project, &arguments.search)?;
    let audit = |version: &ProjectOptions| version.audit(&arguments.search).map_err(unread);
    let (old, new) = (audit(&old)?, audit(&new)?);
    trace.write(&new)?;
    let allowed = arguments.fail_above.map(Margin::millionths);
    let found = Difference::of(&old, &new, allowed);
    let answer = |_| format!("{}\n", answer(&found));
    arguments.report.fill(reports, Detail::Usual, answer, |format, extent, out| {
        (format.diff)(&found, extent, out)
    })?;
    Ok(if found.is_above() { Outcome::Refuted } else { Outcome::Done })
}

/// The failure, with a note about the project file if its CPU would have been needed.
fn unread(mut failure: Failure) -> Failure {
    if let Failure::Input(faults) = &mut failure {
        let lacking = faults.iter_mut().filter(|fault| fault.code == Code::NoTable);
        lacking.for_each(|fault| fault.help += project_file::unread());
    }
    failure
}
