//! `scanbound snet`: S-nets for sequence control, and the PLCs that run their code.

mod bound;
mod check;
mod convert;
mod draw;
mod monitor;
mod serve;
mod simulate;
mod terminal;
mod translate;
mod verify;

use super::output::Target;
use super::{Failure, Outcome};
use anyhow::Context;
use clap::{Args, Subcommand, ValueEnum};
use scanbound::audit::Audit;
use scanbound::front::input::aside;
use scanbound::report::snet::View;
use scanbound::snet::faults::faults;
use scanbound::snet::translate::assign;
use scanbound::snet::{Diagram, pnml, text};
use std::path::Path;

/// The arguments of `snet`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
enum Command {
    /// Convert a net between .snet and PNML
    Convert(convert::Arguments),
    /// Draw a net, as SVG or for Graphviz
    Draw(draw::Arguments),
    /// Simulate a net: step by step on the terminal, or by a stimulus
    Simulate(simulate::Arguments),
    /// Emulate a C200H that runs a net's code, and answers Host Link
    Serve(Box<serve::Arguments>),
    /// Watch a C200H run a net's code, over Host Link on a serial line
    Monitor(monitor::Arguments),
    /// Check a net: deadlocks, transitions that never fire, differences between the net and its code
    Check(check::Arguments),
    /// Generate code from a net: the C200H's list, CX-Programmer, MELSEC, PLCopen XML
    Translate(translate::Arguments),
    /// Bound the scan time of a net's code, using what the net knows about its boxes
    Bound(Box<bound::Arguments>),
    /// Check code against a net
    Verify(verify::Arguments),
}

/// How the code gets the initial marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Initial {
    /// Not at all: the operator sets them
    #[default]
    LeftOut,
    /// The PLC's first scan sets them
    FirstScan,
}

/// Does it.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    match &arguments.command {
        Command::Convert(arguments) => convert::run(arguments),
        Command::Draw(arguments) => draw::run(arguments),
        Command::Simulate(arguments) => simulate::run(arguments),
        Command::Serve(arguments) => serve::run(arguments),
        Command::Monitor(arguments) => monitor::run(arguments),
        Command::Check(arguments) => check::run(arguments),
        Command::Translate(arguments) => translate::run(arguments),
        Command::Bound(arguments) => bound::run(arguments),
        Command::Verify(arguments) => verify::run(arguments),
    }
}

/// Reads a net from a file.
fn read(file: &Path) -> Result<Diagram, Failure> {
    let name = file.display().to_string();
    let bytes = aside(file).with_context(|| format!("{name} cannot be read"))?;
    let input = scanbound::front::Input { name: name.clone(), bytes };
    let text = scanbound::front::decoded(&input, &[]).map_err(|fault| vec![fault])?.into_owned();
    let is_pnml = pnml::is_pnml(&text);
    Ok(if is_pnml { pnml::read(&name, &text)? } else { text::read(&name, &text)? })
}

/// Reads a net from a file and refuses one that is not valid. Assigns relays to elements without one, if requested.
pub(super) fn read_sound(file: &Path, assigns: bool) -> Result<Diagram, Failure> {
    let mut diagram = read(file)?;
    let found = faults(&diagram);
    if !found.is_empty() {
        return Err(found.into());
    }
    if assigns {
        assign(&mut diagram);
    }
    Ok(diagram)
}

/// Draws a net with the marks at the start of an audit's longest scan.
pub(super) fn draw_marks(
    net: &Diagram,
    audit: &Audit,
    file: &Path,
    drawing: Target,
) -> Result<(), Failure> {
    let Some(found) = &audit.net else { return Ok(()) };
    let view = View::marked(net, &found.places);
    let picture = draw::picture(net, &view, draw::Format::of(file, None));
    drawing.write(&picture)
}
