//! `scanbound check`: whether the project keeps to a limit.

use super::options::{ProjectOptions, ReportOptions, Reports, SearchOptions};
use super::output::{Target, say};
use super::project_file::{self, ProjectFile};
use super::values::{self, Limit};
use super::watch::WatchOptions;
use super::{Failure, Outcome};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use scanbound::audit::verdict::{Check, Margin, MostAssumed, Verdict};
use scanbound::audit::{Audit, Request, conclude, follow};
use scanbound::base::time::Picos;
use scanbound::report::projects::{self, Checked};
use scanbound::timing::table::Table;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

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
  scanbound check                            the project that scanbound.toml names (docs/pipelines.md)
  scanbound check --watch                    again whenever a file of it changes
  scanbound check PLC/ --limit watchdog --margin 20% --confirm

Exit codes: 0 proved, 1 refuted, 2 bad input or usage, 3 undecided, 70 internal error";

/// The arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The limit that no scan may pass, such as 10ms or 2min, or the CPU's watchdog [default: that of scanbound.toml]
    #[arg(long, value_name = "DURATION|watchdog", value_parser = values::limit, allow_hyphen_values = true)]
    limit: Option<Limit>,
    /// What is added to the scan before it is held against the limit, such as 10%
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    margin: Option<Margin>,
    /// How much of the time that decides may rest on assumed times, such as 30%; with more the limit is undecided
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    max_assumed: Option<MostAssumed>,
    /// Which scan refutes: one that nothing known here excludes, or only one to which a run from power-up was found
    #[arg(long, value_enum, default_value_t)]
    refute: Refute,
    /// Check every project that has a scanbound.toml here or below; the gravest exit code of all counts
    #[arg(long, conflicts_with_all = ["programs", "output", "trace_search", "watch"])]
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
    /// What the command line says, and a project file where it is silent.
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

    /// The limit, by the table that prices the program.
    fn limit_by(&self, table: &Table) -> Result<Picos, Failure> {
        match self.limit {
            Limit::Time(time) => Ok(time),
            Limit::Watchdog => table.watchdog().ok_or_else(|| {
                let name = &table.name;
                anyhow!("--limit watchdog: the table {name} does not say the CPU's watchdog time; give a time such as 200ms").into()
            }),
        }
    }

    /// Audits the project, judges and reports.
    fn run(&self, arguments: &Arguments) -> Result<Outcome, Failure> {
        let (reports, trace) = arguments.report.targets(&self.project, &arguments.search)?;
        let (audit, check) = self.judge(arguments, Some(&reports))?;
        trace.write(&audit)?;
        arguments.report.write(&audit, Some(&check), reports)?;
        Ok(outcome(&check))
    }

    /// Audits the project, with all that reports show, and judges.
    fn judge(
        &self,
        arguments: &Arguments,
        reports: Option<&Reports>,
    ) -> Result<(Audit, Check), Failure> {
        let (audit, limit) = self.project.with_request(|request| {
            let request = arguments.search.of(request);
            let followed = follow(&request)?;
            let limit = self.limit_by(&followed.table)?;
            let until = match self.max_assumed {
                None => Some(self.margin.room(limit)),
                // What a search that ends early leaves open would count as assumed.
                Some(_) => None,
            };
            let mut concluded = conclude(followed, &Request { limit: until, ..request })?;
            if let Some(reports) = reports {
                reports.draw(&mut concluded);
            }
            Ok((concluded.audit, limit))
        })?;
        let mut check = Check::new(&audit, limit, self.margin);
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

/// Checks the project that is named, the one here, or all that there are.
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

/// Exit codes, the gravest first.
const GRAVEST: [u8; 5] = [70, 2, 1, 3, 0];

/// Formats in which reports may stand one behind the other.
const IN_A_ROW: [&str; 3] = ["text", "markdown", "github"];

/// Checks one project after the other; what is wrong with one does not keep the others from being checked.
fn all(arguments: &Arguments) -> Result<Outcome, Failure> {
    let files = project_file::all(Path::new("."))?;
    let codes = match arguments.report.format_of_stdout() {
        "json" if !arguments.report.is_quiet() => document(arguments, &files)?,
        "json" => in_a_row(arguments, &files),
        name if IN_A_ROW.contains(&name) => in_a_row(arguments, &files),
        name => return Err(anyhow!(
            "--format {name} holds one project: check each by itself, or write --all with --format text, markdown, github or json"
        )
        .into()),
    };
    let gravest = GRAVEST.into_iter().find(|code| codes.contains(code));
    Ok(Outcome::Told(gravest.unwrap_or(0)))
}

fn in_a_row(arguments: &Arguments, files: &[PathBuf]) -> Vec<u8> {
    let check = |path: &PathBuf| {
        if !arguments.report.is_quiet() {
            say(&format!("{}\n", path.display()));
        }
        let checked = ProjectFile::read(path)
            .and_then(|file| Wanted::of(arguments, Some(&file)))
            .and_then(|wanted| wanted.run(arguments));
        super::code_of(checked)
    };
    files.iter().map(check).collect()
}

/// One JSON document of all projects on stdout; each is written as soon as it is checked.
fn document(arguments: &Arguments, files: &[PathBuf]) -> Result<Vec<u8>, Failure> {
    let mut codes = Vec::new();
    put(projects::begin)?;
    for path in files {
        let name = path.display().to_string();
        say(&format!("{name}\n"));
        let checked = ProjectFile::read(path)
            .and_then(|file| Wanted::of(arguments, Some(&file)))
            .and_then(|wanted| wanted.judge(arguments, None));
        let code = match &checked {
            Ok((_, check)) => outcome(check).code(),
            Err(failure) => {
                say(&failure.message());
                failure.code()
            }
        };
        let checked = match &checked {
            Ok((audit, check)) => Checked::Audited(audit, check),
            Err(Failure::Input(faults)) => Checked::Faulty(faults),
            Err(Failure::Usage(error)) => Checked::Failed(format!("{error:#}")),
            Err(Failure::Internal(what)) => Checked::Failed(format!("internal error: {what}")),
        };
        put(|out| projects::project(codes.len(), &name, code, &checked, out))?;
        codes.push(code);
    }
    put(projects::end)?;
    Ok(codes)
}

fn put(fill: impl Fn(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    Target::Stdout.fill(fill)
}
