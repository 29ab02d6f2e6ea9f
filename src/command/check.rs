//! `scanbound check`: whether the project stays within a limit.

use super::options::{ProjectOptions, ReportOptions, Reports, SearchOptions};
use super::output::say;
use super::project_file::{self, ProjectFile};
use super::values::{self, Limit};
use super::watch::WatchOptions;
use super::{Failure, Outcome};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use scanbound::audit::verdict::{Check, Margin, MostAssumed, Verdict};
use scanbound::audit::{Audit, Followed, Request, conclude, follow};
use scanbound::base::time::Picos;
use scanbound::report::format::{Checked, Project};
use std::path::Path;

/// Which scan refutes the limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Refute {
    /// One that nothing known excludes
    #[default]
    Admissible,
    /// One to which a run from power-up was found
    Reached,
}

const EXAMPLES: &str = "\
Examples:
  scanbound check PLC/ --limit 10ms
  scanbound check                            the project that scanbound.toml names (docs/pipelines.md)
  scanbound check --watch                    again whenever a file of it changes
  scanbound check PLC/ --limit watchdog --margin 20% --confirm

Exit codes: 0 proved, 1 refuted, 2 bad input or usage, 3 undecided, 70 internal error";

/// The arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The limit that no scan may exceed, such as 10ms or 2min, or the CPU's watchdog [default: that of scanbound.toml]
    #[arg(long, value_name = "DURATION|watchdog", value_parser = values::limit, allow_hyphen_values = true)]
    limit: Option<Limit>,
    /// The margin that is added to the scan time before it is compared with the limit, such as 10%
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    margin: Option<Margin>,
    /// The largest share of assumed times in the deciding time, such as 30%; above that, the limit is undecided
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    max_assumed: Option<MostAssumed>,
    /// Which scan refutes the limit: one that nothing known excludes, or only one to which a run from power-up was
    /// found
    #[arg(long, value_enum, default_value_t)]
    refute: Refute,
    /// Check every project that has a scanbound.toml here or below; the most serious exit code counts
    #[arg(long, conflicts_with_all = ["programs", "trace_search", "watch"])]
    all: bool,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    report: ReportOptions,
    #[command(flatten)]
    watch: WatchOptions,
}

/// What is checked.
struct Wanted {
    project: ProjectOptions,
    limit: Limit,
    margin: Margin,
    max_assumed: Option<MostAssumed>,
}

impl Wanted {
    /// The settings of the command line, completed by those of a project file.
    fn of(arguments: &Arguments, file: Option<&ProjectFile>) -> Result<Wanted, Failure> {
        let limit = arguments.limit.or_else(|| file?.limit);
        let margin = arguments.margin.or_else(|| file?.margin);
        Ok(Wanted {
            project: match file {
                Some(file) => arguments.project.completed(file),
                None => arguments.project.clone(),
            },
            limit: limit.ok_or_else(|| {
                let unread = if file.is_none() { project_file::unread() } else { "" };
                anyhow!(
                    "no limit is given: --limit 10ms, or limit = \"10ms\" in scanbound.toml{unread}"
                )
            })?,
            margin: margin.unwrap_or_default(),
            max_assumed: arguments.max_assumed.or_else(|| file?.max_assumed),
        })
    }

    /// Checks an audit against the limit.
    fn check(&self, audit: &Audit) -> Result<Check, Failure> {
        match self.limit {
            Limit::Time(limit) => Ok(Check::new(audit, limit, self.margin)),
            Limit::Watchdog => Check::of_watchdog(audit, self.margin).ok_or_else(|| {
                let name = &audit.table.name;
                anyhow!("--limit watchdog: the table {name} does not give the CPU's watchdog time; give a time such as 200ms").into()
            }),
        }
    }

    /// The limit at which the search may end, if nothing but the limit matters.
    fn decided_at(&self, followed: &Followed) -> Option<Picos> {
        // Whatever a search that ends early leaves open would count as assumed.
        let limit = match self.limit {
            _ if self.max_assumed.is_some() => None,
            Limit::Time(limit) => Some(limit),
            Limit::Watchdog if followed.program.scan_control.sets_watchdog() => None,
            Limit::Watchdog => followed.table.watchdog(),
        };
        limit.map(|limit| self.margin.room(limit))
    }

    /// Audits the project, checks and reports.
    fn run(&self, arguments: &Arguments) -> Result<Outcome, Failure> {
        let (reports, trace) = arguments.report.targets(&self.project, &arguments.search)?;
        let (audit, check) = match self.judge(arguments, Some(&reports)) {
            Ok(judged) => judged,
            Err(failure) => return Err(reports.refused(&self.project, failure)?),
        };
        trace.write(&audit)?;
        arguments.report.write(&audit, Some(&check), reports)?;
        Ok(outcome(&check))
    }

    /// Audits the project with everything that reports show, and checks.
    fn judge(
        &self,
        arguments: &Arguments,
        reports: Option<&Reports>,
    ) -> Result<(Audit, Check), Failure> {
        let audit = self.project.with_request(|request| {
            let request = arguments.search.of(request);
            let followed = follow(&request)?;
            let until = self.decided_at(&followed);
            let mut concluded = conclude(followed, &Request { limit: until, ..request })?;
            if let Some(reports) = reports {
                reports.draw(&mut concluded);
            }
            Ok(concluded.audit)
        })?;
        let mut check = self.check(&audit)?;
        if arguments.refute == Refute::Reached {
            check = check.if_reached(&audit);
        }
        if let Some(most) = self.max_assumed {
            check = check.if_assumed_at_most(&audit, most);
        }
        Ok((audit, check))
    }
}

fn outcome(check: &Check) -> Outcome {
    match check.verdict {
        Verdict::Proved => Outcome::Done,
        Verdict::Refuted => Outcome::Refuted,
        Verdict::Undecided(_) => Outcome::Undecided,
    }
}

/// Checks the named project, the one here, or all projects.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    if arguments.all {
        return all(arguments);
    }
    let written = arguments.report.writes(&arguments.search);
    arguments.watch.run(
        || arguments.project.watched(),
        &written,
        || {
            let file = arguments.project.is_open().then(ProjectFile::here).transpose()?;
            Wanted::of(arguments, file.as_ref())?.run(arguments)
        },
    )
}

/// Exit codes, the most serious first.
const GRAVEST: [u8; 5] = [70, 2, 1, 3, 0];

/// Checks one project after the other. A fault in one does not prevent the others from being checked. Each document
/// contains all of them.
fn all(arguments: &Arguments) -> Result<Outcome, Failure> {
    let files = project_file::all(Path::new("."))?;
    let projects: Vec<(String, Result<Wanted, Failure>)> = files
        .iter()
        .map(|path| {
            let wanted =
                ProjectFile::read(path).and_then(|file| Wanted::of(arguments, Some(&file)));
            (path.display().to_string(), wanted)
        })
        .collect();
    let read =
        projects.iter().filter_map(|(_, wanted)| Some(wanted.as_ref().ok()?.project.reads()));
    let mut documents = arguments.report.documents(&read.flatten().collect::<Vec<_>>())?;
    let mut codes = Vec::new();
    for (file, wanted) in &projects {
        let wanted = wanted.as_ref().map_err(Failure::again);
        let checked = wanted.and_then(|wanted| wanted.judge(arguments, None));
        let code = match &checked {
            Ok((_, check)) => outcome(check).code(),
            Err(failure) => failure.code(),
        };
        let told = match &checked {
            Ok((audit, check)) => {
                arguments.report.tell(&documents, file, audit, check);
                Checked::Audited(audit, check)
            }
            Err(failure) => {
                say(&format!("{file}\n{}", failure.message()));
                failure.checked()
            }
        };
        documents.add(&Project { file, exit_code: code, checked: told })?;
        codes.push(code);
    }
    documents.end()?;
    let gravest = GRAVEST.into_iter().find(|code| codes.contains(code));
    Ok(Outcome::Told(gravest.unwrap_or(0)))
}
