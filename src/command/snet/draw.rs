//! `scanbound snet draw`.

use super::read;
use crate::command::output::{Target, apart};
use crate::command::{Failure, Outcome};
use clap::{Args, ValueEnum};
use scanbound::report::snet::{View, dot, svg};
use scanbound::snet::picture::sheets;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  scanbound snet draw line.snet -o line.svg
  scanbound snet draw line.snet --format dot | dot -Tpdf -o line.pdf

A page whose elements all say where they are (at X,Y) is drawn so; any other is laid out.";

/// The arguments of `snet draw`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net (.snet, .pnml)
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// How it is drawn
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<Format>,
    /// Where it is written; a suffix names the format (.svg .dot)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// A format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Svg,
    Dot,
}

/// Draws.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    apart(&[&arguments.net], &[("--output", arguments.output.as_deref())])?;
    let target = Target::new(arguments.output.as_deref())?;
    let diagram = read(&arguments.net)?;
    let suffix = arguments.output.as_ref().and_then(|file| file.extension()?.to_str());
    let format = arguments.format.unwrap_or(match suffix {
        Some("dot" | "gv") => Format::Dot,
        _ => Format::Svg,
    });
    let view = View::initial(&diagram);
    target.write(&match format {
        Format::Svg => svg::render(&diagram, &sheets(&diagram), &view),
        Format::Dot => dot::render(&diagram, &view),
    })?;
    Ok(Outcome::Done)
}
