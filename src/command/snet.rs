//! `scanbound snet`: S-nets for sequence control, and the PLCs that run their code.

mod bound;
mod check;
mod convert;
mod draw;
mod monitor;
mod net;
mod serve;
mod simulate;
mod terminal;
mod translate;
mod verify;

pub(super) use draw::MarksDrawing;
pub(super) use net::read_sound;

use super::{Failure, Outcome};
use clap::{Args, Subcommand};

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
    #[command(long_about = convert::ABOUT)]
    Convert(convert::Arguments),
    /// Draw a net, as SVG or for Graphviz
    Draw(draw::Arguments),
    /// Simulate a net: step by step on the terminal, or by a stimulus
    #[command(long_about = simulate::ABOUT)]
    Simulate(simulate::Arguments),
    /// Emulate a C200H that runs a net's code, and answers Host Link
    #[command(long_about = serve::ABOUT)]
    Serve(Box<serve::Arguments>),
    /// Watch a C200H run a net's code, over Host Link on a serial line
    #[command(long_about = monitor::ABOUT)]
    Monitor(monitor::Arguments),
    /// Check a net: deadlocks, transitions that never fire, differences between the net and its code
    #[command(long_about = check::ABOUT)]
    Check(check::Arguments),
    /// Generate code from a net: the C200H's list, CX-Programmer, MELSEC, PLCopen XML
    #[command(long_about = translate::ABOUT)]
    Translate(translate::Arguments),
    /// Bound the scan time of a net's code, using what the net knows about its boxes
    #[command(long_about = bound::ABOUT)]
    Bound(Box<bound::Arguments>),
    /// Check code against a net
    #[command(long_about = verify::ABOUT)]
    Verify(verify::Arguments),
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
