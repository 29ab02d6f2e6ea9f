//! `scanbound snet check`.

use super::net::{Initial, read_sound};
use crate::command::output::{Target, apart};
use crate::command::values::format_or_suffix;
use crate::command::{Failure, Outcome};
use clap::{Args, ValueEnum};
use scanbound::report::netcheck::{Study, json, text};
use scanbound::snet::check::{Options, check};
use std::path::PathBuf;

pub const ABOUT: &str = "\
Check a net: deadlocks, transitions that never fire, and differences between the net and its code

By the net's rule, transitions fire one after another. By the code's rule, all transitions are tested with the marks at the \
start of the scan, and all that can fire do so together. Each finding comes with the shortest run that shows it.";

const EXAMPLES: &str = "\
Examples:
  scanbound snet check line.snet
  scanbound snet check line.snet --initial first-scan --format json

Exit codes: 0 sound, 1 something was found, 2 bad usage or input, 70 internal error";

/// The arguments of `snet check`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// How the code gets the initial marks
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    initial: Initial,
    /// The largest number of markings that are explored
    #[arg(long, value_name = "COUNT", default_value_t = Options::default().limit)]
    markings: usize,
    /// The output format
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<Format>,
    /// The output file; its suffix names the format
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// A format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    #[value(alias = "txt")]
    Text,
    Json,
}

/// Checks the net.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    apart(&[&arguments.net], &[("--output", arguments.output.as_deref())])?;
    let format = format_or_suffix(arguments.format, arguments.output.as_deref())?;
    let target = Target::new(arguments.output.as_deref())?;
    let diagram = read_sound(&arguments.net, false)?;
    let options = Options {
        limit: arguments.markings,
        initial_in_first_scan: arguments.initial == Initial::FirstScan,
    };
    let found = check(&diagram, options);
    let study = Study { diagram: &diagram, check: &found };
    match format {
        Format::Text => target.write(&text::render(&study))?,
        Format::Json => target.fill(|out| json::write(&study, out))?,
    }
    Ok(if found.is_sound() { Outcome::Done } else { Outcome::Refuted })
}
