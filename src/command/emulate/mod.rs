//! `scanbound emulate`: runs a program scan by scan and shows what its devices and variables do.

mod machine;
mod program;
mod run_options;

use super::options::ProjectOptions;
use super::output::apart;
use super::{Failure, Outcome};
use anyhow::anyhow;
use clap::Args;
use machine::MachineOptions;
use run_options::RunOptions;
use scanbound::front::minasec::Source;
use scanbound::front::read;

pub const ABOUT: &str = "\
Runs a program from power-up, scan by scan, and shows what its devices and variables do and how long each scan takes by \
the timing table.

What comes from outside is what the stimulus sets, and 0 before. Where controllers differ, the program runs as the \
standard prefers. The run ends where the program's path depends on the result of an instruction that is not modelled. \
A MINASEC-U is emulated clock by clock.";

const EXAMPLES: &str = "\
Examples:
  scanbound emulate line.il --cpu Q26UDV --stimulus inputs.csv --scans 100
  scanbound emulate samples/sfc/line.st --for 10s --watch Fill.X --watch Valve
  scanbound emulate program.asm --stimulus plant.csv --for 30s --trace scans.csv --vcd signals.vcd";

/// The arguments of `emulate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    run: RunOptions,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    machine: MachineOptions,
}

/// Emulates.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let project = arguments.project.or_here()?;
    let run = &arguments.run;
    let mut read_files = project.reads();
    read_files.extend(run.stimulus.as_deref());
    apart(&read_files, &[("--trace", run.trace.as_deref()), ("--vcd", run.vcd.as_deref())])?;
    project.with_request(|request| {
        if let Some(source) = read(request.inputs, request.dialect)?.downcast::<Source>() {
            if !run.watch.is_empty() {
                let help = "--watch is for other programs: a MINASEC-U's trace has all devices";
                return Err(anyhow!(help).into());
            }
            return machine::run(&arguments.machine, run, source.words, request.clock);
        }
        if arguments.machine.is_given() {
            let help = "--tolerance, --jitter, --seed, --t0, --t1, --setting, --count and --filter are for a MINASEC-U, and this is another program";
            return Err(anyhow!(help).into());
        }
        program::run(run, request)
    })
}
