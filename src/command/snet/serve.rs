//! `scanbound snet serve`: an emulated C200H that runs a net's code.

use super::net::{Initial, read_sound};
use crate::command::serve::ServeOptions;
use crate::command::{Failure, Outcome};
use clap::Args;
use scanbound::audit::{Request, ready};
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::snet::translate::{c200h, listing};
use std::path::PathBuf;

pub const ABOUT: &str = "\
Emulate a C200H that runs a net's code

The net is translated as by `snet translate --to c200h`, and runs scan by scan with the times of the C200H's table. It \
answers Host Link on a pseudo-terminal (--pty) or over TCP (--hostlink), so that `snet monitor` and other hosts can be tried \
without a PLC.";

const EXAMPLES: &str = "\
Examples:
  scanbound snet serve line.snet --pty plc --set START=1
  scanbound snet monitor line.snet --port plc          in another terminal";

/// The arguments of `snet serve`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net (.snet, .pnml)
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// How the code gets the initial marks
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    initial: Initial,
    /// Assign relays and numbers to elements without one
    #[arg(long)]
    assign: bool,
    #[command(flatten)]
    serving: ServeOptions,
}

/// Serves.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    arguments.serving.asked()?;
    let diagram = read_sound(&arguments.net, arguments.assign)?;
    let list = listing(&diagram, arguments.initial == Initial::FirstScan)?;
    let name = format!("{} (its code)", arguments.net.display());
    let inputs = [Input { name, bytes: c200h(&diagram, &list).into_bytes() }];
    let facts = Facts::default();
    let request = Request {
        cpu: Some("C200H"),
        dialect: Some("omron-c200h"),
        ..Request::new(&inputs, &facts)
    };
    // Outer gates may be set by name.
    let address = |name: &str| {
        let outer = diagram.outers.iter().find(|outer| outer.head.name == name)?;
        Some(outer.head.address?.to_string())
    };
    arguments.serving.renamed(address).serve(&ready(&request)?, Some("C200H"))
}
