//! `scanbound cpus`: on which CPUs of the family the project stays within a limit.

use super::options::ProjectOptions;
use super::project_file::ProjectFile;
use super::sheet::{Sheet, SheetOptions};
use super::values::{self, Limit};
use super::{Failure, Outcome};
use clap::Args;
use scanbound::audit::cpus::{self, CpuCheck, compare_cpus};
use scanbound::audit::verdict::{Margin, MostAssumed};
use scanbound::report::cpus::{csv, json, text};

pub const ABOUT: &str = "\
Compare the scan time on every CPU of the project's family

Audits the project by every built-in timing table of the family of its CPU, and shows them side by side: the bound, \
its share of the limit, how much of it rests on assumed times, and the verdict. The slowest CPU that is proved to keep \
to the limit is marked. The project is read once. Each bound is the one that `scanbound audit --table NAME` finds; \
--time-limit holds for each table.";

const EXAMPLES: &str = "\
Examples:
  scanbound cpus PLC/ --limit 10ms           the slowest CPU that keeps to 10 ms
  scanbound cpus PLC/ --limit watchdog --margin 20%
  scanbound cpus main.il --cpu Q26UDV        list text: --cpu tells the family
  scanbound cpus PLC/ --table my.csv         with a table of your own among them

Exit codes: 0 done (with --limit: at least one CPU is proved to keep to it), 1 no CPU is proved to keep to it, 2 bad input or usage, 70 internal error";

/// The arguments of `cpus`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The limit that no scan may exceed, such as 10ms, or each CPU's watchdog
    #[arg(long, value_name = "DURATION|watchdog", value_parser = values::limit, allow_hyphen_values = true)]
    limit: Option<Limit>,
    /// The margin that is added to the scan time before it is compared with the limit, such as 10%
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true, requires = "limit")]
    margin: Option<Margin>,
    /// The largest share of assumed times in the bound, such as 30%; above that, the limit is undecided
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true, requires = "limit")]
    max_assumed: Option<MostAssumed>,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    report: SheetOptions,
}

/// Audits the project with every table of its family, and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let file = arguments.project.is_open().then(ProjectFile::here).transpose()?;
    let project = match &file {
        Some(file) => arguments.project.completed(file),
        None => arguments.project.clone(),
    };
    let limit = arguments.limit.or_else(|| file.as_ref()?.limit);
    let condition = CpuCheck {
        limit: limit.map(|limit| match limit {
            Limit::Time(time) => cpus::Limit::Time(time),
            Limit::Watchdog => cpus::Limit::Watchdog,
        }),
        margin: arguments.margin.or_else(|| file.as_ref()?.margin).unwrap_or_default(),
        max_assumed: arguments.max_assumed.or_else(|| file.as_ref()?.max_assumed),
    };
    let place = arguments.report.place(&project.reads())?;
    let choice = project.with_request(|request| Ok(compare_cpus(request, condition)?))?;
    place.write(&Sheet {
        text: &|extent| text::render(&choice, extent),
        json: &|out| json::write(&choice, out),
        csv: &|out| csv::write(&choice, out),
        answer: text::answer(&choice),
    })?;
    let is_found = condition.limit.is_none() || choice.slowest().is_some();
    Ok(if is_found { Outcome::Done } else { Outcome::Refuted })
}
