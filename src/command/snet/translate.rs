//! `scanbound snet translate`.

use super::net::{Initial, read_sound};
use crate::command::output::{Target, apart};
use crate::command::{Failure, Outcome};
use clap::{Args, ValueEnum};
use scanbound::snet::translate::{assignment, c200h, cx, gates, listing, melsec, plcopen};
use std::path::PathBuf;

pub const ABOUT: &str = "\
Generate code from a net: emergency stops, transitions, boxes, timers and counters, in this order

Initial marks and arbiters are left out; with `--initial first-scan` the first scan sets the marks. `snet check` lists where \
such code behaves differently from the net.";

const EXAMPLES: &str = "\
Examples:
  scanbound snet translate line.snet --to c200h                 gates, addresses and the list, as on paper
  scanbound snet translate line.snet --to c200h --only code -o line.il
  scanbound snet translate line.snet --to cx -o line.cx         CX-Programmer, for CS, CJ and CP
  scanbound snet translate line.snet --to melsec --assign       addresses for what has none
  scanbound snet translate line.snet --to plcopen -o line.xml   a sequential function chart";

/// The arguments of `snet translate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// The kind of code
    #[arg(long, value_enum, value_name = "TARGET")]
    to: To,
    /// How the code gets the initial marks
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    initial: Initial,
    /// Assign relays and numbers to elements without one
    #[arg(long)]
    assign: bool,
    /// Print only this part of the c200h output
    #[arg(long, value_enum, value_name = "PART")]
    only: Option<Part>,
    /// The output file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// The kinds of code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum To {
    /// The C200H's list, with the lists of gates and addresses
    C200h,
    /// CX-Programmer's mnemonics for CS, CJ and CP
    Cx,
    /// A list for MELSEC-Q and L
    Melsec,
    /// A sequential function chart, PLCopen XML
    Plcopen,
}

/// A part of the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// The list of instructions
    Code,
    /// The gates of each transition
    Gates,
    /// The address of each element
    Addresses,
}

/// Translates.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    apart(&[&arguments.net], &[("--output", arguments.output.as_deref())])?;
    let target = Target::new(arguments.output.as_deref())?;
    let diagram = read_sound(&arguments.net, arguments.assign)?;
    if arguments.to == To::Plcopen {
        target.write(&plcopen(&diagram)?)?;
        return Ok(Outcome::Done);
    }
    let list = listing(&diagram, arguments.initial == Initial::FirstScan)?;
    let text = match (arguments.to, arguments.only) {
        (To::Cx, _) => cx(&diagram, &list)?,
        (To::Melsec, _) => melsec(&diagram, &list)?,
        (_, Some(Part::Code)) => c200h(&diagram, &list),
        (_, Some(Part::Gates)) => gates(&diagram),
        (_, Some(Part::Addresses)) => assignment(&diagram),
        (_, None) => format!(
            "{}\n{}\nNAME: {:<40}PAGE 1\n{}",
            gates(&diagram),
            assignment(&diagram),
            diagram.name,
            c200h(&diagram, &list)
        ),
    };
    target.write(&text)?;
    Ok(Outcome::Done)
}
