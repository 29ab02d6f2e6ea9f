//! `scanbound snet verify`.

use super::net::{Initial, read_sound};
use crate::command::output::{Target, apart};
use crate::command::{Failure, Outcome};
use anyhow::Context;
use clap::Args;
use scanbound::front::input::read_small;
use scanbound::snet::translate::listing;
use scanbound::snet::verify::verify;
use std::fmt::Write as _;
use std::path::PathBuf;

pub const ABOUT: &str = "\
Check code against a net: whether every relay, timer and counter gets the same values as in the code generated from the net

The code is a list of the C200H, of CX-Programmer or of MELSEC-Q and L. Each value is compared as a function of the relays when the scan starts, \
so code that is written differently may be equivalent. For each difference: the line, and relay values with which the results differ.";

const EXAMPLES: &str = "\
Examples:
  scanbound snet verify line.snet line.il
  scanbound snet verify line.snet read-back.cx --initial first-scan

Exit codes: 0 the code is equivalent to the net's code, 1 it is not, 2 bad usage or input, 70 internal error";

/// The arguments of `snet verify`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net, with its addresses
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// Code: a list of the C200H, mnemonics of CX-Programmer, or a list of MELSEC-Q and L
    #[arg(value_name = "CODE")]
    code: PathBuf,
    /// How the code gets the initial marks
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    initial: Initial,
    /// Assign relays and numbers to elements without one, as translate does
    #[arg(long)]
    assign: bool,
    /// The output file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Compares the code with the net's.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    apart(&[&arguments.net, &arguments.code], &[("--output", arguments.output.as_deref())])?;
    let target = Target::new(arguments.output.as_deref())?;
    let diagram = read_sound(&arguments.net, arguments.assign)?;
    let list = listing(&diagram, arguments.initial == Initial::FirstScan)?;
    let name = arguments.code.display().to_string();
    let bytes = read_small(&arguments.code).with_context(|| format!("{name} cannot be read"))?;
    let input = scanbound::front::Input { name: name.clone(), bytes };
    let code = scanbound::front::decoded(&input, &[]).map_err(|fault| vec![fault])?.into_owned();
    let differences = verify(&diagram, &list, &name, &code)?;
    let mut text = String::new();
    for one in &differences {
        let place = one.line.map_or_else(|| name.clone(), |line| format!("{name}:{line}"));
        let shown = if one.text.is_empty() { String::new() } else { format!("    {}\n", one.text) };
        let _ = write!(text, "{place}: {}\n{shown}", one.message);
        if !one.values.is_empty() {
            let value = |(name, is_on): &(String, bool)| {
                format!("{name} {}", if *is_on { "on" } else { "off" })
            };
            let values: Vec<String> = one.values.iter().map(value).collect();
            let _ = writeln!(text, "    with {}", values.join(", "));
        }
    }
    if differences.is_empty() {
        let _ = writeln!(
            text,
            "in every scan, {name} does the same as the code generated from {}",
            diagram.file
        );
    }
    target.write(&text)?;
    Ok(if differences.is_empty() { Outcome::Done } else { Outcome::Refuted })
}
