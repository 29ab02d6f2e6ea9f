//! `scanbound snet draw`.

use super::net::read;
use crate::command::output::{Target, apart};
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
    /// The output file; its suffix names the format (.svg .dot)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// A format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    Svg,
    Dot,
}

impl Format {
    /// The requested format, otherwise the one that a file's suffix names.
    pub(super) fn of(file: &Path, asked: Option<Format>) -> Format {
        let suffix = file.extension().and_then(|suffix| suffix.to_str());
        asked.unwrap_or(match suffix {
            Some("dot" | "gv") => Format::Dot,
            _ => Format::Svg,
        })
    }
}

/// A net in this format, with the marks and notes of a view.
pub(super) fn picture(diagram: &Diagram, view: &View, format: Format) -> String {
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
    let file = arguments.output.as_deref().unwrap_or(Path::new(""));
    let format = Format::of(file, arguments.format);
    target.write(&picture(&diagram, &View::initial(&diagram), format))?;
    Ok(Outcome::Done)
}

/// Draws a net with the marks at the start of an audit's longest scan.
pub(in crate::command) fn draw_marks(
    net: &Diagram,
    audit: &Audit,
    file: &Path,
    drawing: Target,
) -> Result<(), Failure> {
    let Some(found) = &audit.net else { return Ok(()) };
    let view = View::marked(net, &found.places);
    let picture = picture(net, &view, Format::of(file, None));
    drawing.write(&picture)
}
