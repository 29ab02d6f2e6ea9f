//! `scanbound snet draw`.

use super::net::read;
use crate::command::output::{Target, apart};
use crate::command::values::format_or_suffix;
use crate::command::{Failure, Outcome};
use clap::{Args, ValueEnum};
use scanbound::audit::Audit;
use scanbound::report::snet::{View, dot, svg};
use scanbound::snet::Diagram;
use scanbound::snet::picture::sheets;
use std::path::{Path, PathBuf};

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
    /// The format of the drawing
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<Format>,
    /// The output file; its suffix names the format
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// A format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Svg,
    #[value(alias = "gv")]
    Dot,
}

/// A net in this format, with the marks and notes of a view.
fn picture(diagram: &Diagram, view: &View, format: Format) -> String {
    match format {
        Format::Svg => svg::render(diagram, &sheets(diagram), view),
        Format::Dot => dot::render(diagram, view),
    }
}

/// Draws.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    apart(&[&arguments.net], &[("--output", arguments.output.as_deref())])?;
    let target = Target::new(arguments.output.as_deref())?;
    let diagram = read(&arguments.net)?;
    let format = format_or_suffix(arguments.format, arguments.output.as_deref())?;
    target.write(&picture(&diagram, &View::initial(&diagram), format))?;
    Ok(Outcome::Done)
}

/// A picture of the net with the marks at the start of an audit's longest scan.
pub(in crate::command) struct MarksDrawing {
    target: Target,
    format: Format,
}

impl MarksDrawing {
    /// The picture that goes to a file, in the format of its suffix.
    pub(in crate::command) fn new(file: &Path) -> Result<MarksDrawing, Failure> {
        let format = format_or_suffix(None, Some(file))?;
        Ok(MarksDrawing { target: Target::new(Some(file))?, format })
    }

    /// Writes it, if the audit found how the net affects the scan.
    pub(in crate::command) fn write(self, net: &Diagram, audit: &Audit) -> Result<(), Failure> {
        let Some(found) = &audit.net else { return Ok(()) };
        let view = View::marked(net, &found.places);
        self.target.write(&picture(net, &view, self.format))
    }
}
