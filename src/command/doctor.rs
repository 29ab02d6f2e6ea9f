//! `scanbound doctor`: everything that prevents a bound, in one list.

use super::options::ProjectOptions;
use super::sheet::{Sheet, SheetOptions};
use super::{Failure, Outcome};
use clap::Args;
use scanbound::audit::doctor::diagnose;
use scanbound::report::doctor::{csv, json, text};

pub const ABOUT: &str = "\
List everything that prevents a bound, and what to do about it

Looks at every file, does not stop at the first fault, and says in one list what is read, what is refused and why, which \
instructions are not known or have no time, which routines are not there, what is stated wrongly, what the bound needs \
and nobody states, and what was left out. Nothing is searched: it takes no longer than reading the files.";

const EXAMPLES: &str = "\
Examples:
  scanbound doctor PLC/                      a directory of exported files, as it is
  scanbound doctor PLC/ --facts plant.toml   with what you state
  scanbound doctor PLC/ --strict-times       with all assumed times refused
  scanbound doctor PLC/ -o list.csv          the list for a spreadsheet

Exit codes: 0 nothing stands in the way of a bound, 1 something does: the list says what, 2 bad usage,
70 internal error";

/// The arguments of `doctor`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    report: SheetOptions,
}

/// Examines the project and lists the findings.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let project = arguments.project.or_here()?;
    let place = arguments.report.place(&project.reads())?;
    let found = project.with_what_can_be_read(|request, noticed| Ok(diagnose(request, noticed)))?;
    place.write(&Sheet {
        text: &|extent| text::render(&found, extent),
        json: &|out| json::write(&found, out),
        csv: &|out| csv::write(&found, out),
        answer: text::answer(&found),
    })?;
    Ok(if found.is_sound() { Outcome::Done } else { Outcome::Refuted })
}
