//! `scanbound snet convert`.

use super::net::read;
use crate::command::output::{Target, apart};
use crate::command::{Failure, Outcome};
use clap::{Args, ValueEnum};
use scanbound::snet::{pnml, text};
use std::path::PathBuf;

pub const ABOUT: &str = "\
Convert a net between .snet and PNML, the file format of other tools for Petri nets

In PNML, boxes and outer gates are places of a place/transition net; gates are read and inhibitor arcs, and each place to \
which a transition leads inhibits it, since it holds one mark. Properties that place/transition nets do not have are saved \
in toolspecific elements, so that a net is unchanged after conversion back. Nets of other tools are converted to boxes and \
transitions.";

const EXAMPLES: &str = "\
Examples:
  scanbound snet convert line.snet -o line.pnml
  scanbound snet convert line.pnml > line.snet";

/// The arguments of `snet convert`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net (.snet, .pnml)
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// The target format [default: by the suffix of the output, otherwise the other format]
    #[arg(long, value_enum, value_name = "FORM")]
    to: Option<NetFormat>,
    /// The output file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// The file formats of nets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum NetFormat {
    Snet,
    Pnml,
}

/// Converts.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    apart(&[&arguments.net], &[("--output", arguments.output.as_deref())])?;
    let target = Target::new(arguments.output.as_deref())?;
    let diagram = read(&arguments.net)?;
    let suffix = |file: &std::path::Path| file.extension()?.to_str().map(str::to_ascii_lowercase);
    let written = arguments.output.as_deref().and_then(suffix);
    let form =
        arguments.to.unwrap_or(match (written.as_deref(), suffix(&arguments.net).as_deref()) {
            (Some("snet"), _) => NetFormat::Snet,
            (Some("pnml" | "xml"), _) | (_, Some("snet")) => NetFormat::Pnml,
            _ => NetFormat::Snet,
        });
    target.write(&match form {
        NetFormat::Snet => text::write(&diagram),
        NetFormat::Pnml => pnml::write(&diagram),
    })?;
    Ok(Outcome::Done)
}
