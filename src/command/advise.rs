//! `scanbound advise`: which one additional statement would lower the bound most.

use super::options::ProjectOptions;
use super::sheet::{Sheet, SheetOptions};
use super::values::{self, Most};
use super::{Failure, Outcome};
use clap::Args;
use scanbound::audit::advise::{AdviceSettings, advise};
use scanbound::audit::{Request, conclude, follow};
use scanbound::report::advice::{csv, json, text};
use scanbound::report::format::Extent;
use std::time::{Duration, Instant};

pub const ABOUT: &str = "\
List the facts and interlocks that would lower the bound most

Looks at the longest scan found for facts worth stating: unknown counts and indices; pairs of inputs or relays that are \
both on in it and enable different rungs; devices that may be written only by the program; the type of the base unit. Then \
it audits the project again with each of these facts alone, and lists them with the bound that was found, the lowest first. Nothing is estimated: each bound is the one that \
`scanbound audit --facts` finds with that line in the facts file. Whether a line is true only you know.";

const EXAMPLES: &str = "\
Examples:
  scanbound advise PLC/                      what to look into first
  scanbound advise PLC/ --facts plant.toml   what is still worth stating
  scanbound advise PLC/ --most 5,50          counts of at most 5 and of at most 50
  scanbound advise PLC/ --budget 10min --top 30

--time-limit holds for each of the audits, --budget for all together: an audit that is at work when it is over ends
with what is proved by then. The first audit has half of it at most.

Exit codes: 0 done, 2 bad input or usage, 70 internal error";

/// The arguments of `advise`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The limit that is assumed for each unknown count
    #[arg(long, value_name = "COUNTS", default_value = "20", value_parser = values::most)]
    most: Most,
    /// How long all audits together may take
    #[arg(long, value_name = "DURATION", default_value = "2min", value_parser = values::span, allow_hyphen_values = true)]
    budget: Duration,
    /// How many statements the text shows
    #[arg(long, value_name = "N", default_value_t = Extent::default().top, value_parser = values::count::<usize>, allow_negative_numbers = true)]
    top: usize,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    report: SheetOptions,
}

/// Audits the project, then again with each statement, and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let project = arguments.project.or_here()?;
    let place = arguments.report.place(&project.reads())?;
    let Most(most) = &arguments.most;
    let (start, budget) = (Instant::now(), arguments.budget);
    let advice = project.with_request(|request| {
        // The first audit must leave time for the others.
        let own = request.time_limit.map_or(budget / 2, |limit| limit.min(budget / 2));
        let first = Request { time_limit: Some(own), ..*request };
        let concluded = conclude(follow(&first)?, &first)?;
        let left = budget.saturating_sub(start.elapsed());
        Ok(advise(&concluded, request, AdviceSettings { most, budget: Some(left) })?)
    })?;
    let top = arguments.top;
    place.write(&Sheet {
        text: &|extent| text::render(&advice, Extent { top, ..extent }),
        json: &|out| json::write(&advice, out),
        csv: &|out| csv::write(&advice, out),
        answer: text::answer(&advice),
    })?;
    Ok(Outcome::Done)
}
