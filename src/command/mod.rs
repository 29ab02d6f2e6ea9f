//! The command line: arguments, the commands, and the exit codes (docs/exit-codes.md).

mod audit;
mod check;
mod compare;
mod convert;
mod emulate;
mod export;
mod options;
mod output;
mod progress;
mod sink;
mod tables;
mod values;

use clap::{Parser, Subcommand};
use scanbound::diagnostic::Diagnostic;

/// How long can one scan of a PLC program take, at most?
///
/// Reads programs of MELSEC (GX Works2, GX Works3 and GX Developer CSV, list text), OMRON (mnemonics, .cxt) and
/// MINASEC-U, prices them with a timing table, and proves an upper bound on the scan time; shows the scan that
/// attains it, and the reasons.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print the bound on the scan time, its parts, and the scan that attains it
    Audit(audit::Arguments),
    /// Prove that no scan takes longer than a limit, or show one that does
    Check(check::Arguments),
    /// Write the question of a group for a MaxSAT or SMT solver
    Export(export::Arguments),
    /// Hold measured scan times against the bound; the last file holds them
    Compare(compare::Arguments),
    /// Emulate a MINASEC-U that runs a program
    Emulate(emulate::Arguments),
    /// Assemble a MINASEC-U program, or take machine code apart
    Convert(convert::Arguments),
    /// List the timing tables, show one, or check one of your own
    Tables(tables::Arguments),
}

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done; for `check`: proved.
    Done,
    /// `check`: refuted; `compare`: a measurement lies above the bound.
    Refuted,
    /// `check`: undecided.
    Undecided,
}

impl Outcome {
    /// The exit code.
    pub fn code(self) -> u8 {
        match self {
            Outcome::Done => 0,
            Outcome::Refuted => 1,
            Outcome::Undecided => 3,
        }
    }
}

/// Why a command ended without a result.
#[derive(Debug)]
pub enum Failure {
    /// The input can't be taken.
    Input(Vec<Diagnostic>),
    /// The arguments or the machine's files are at fault.
    Usage(anyhow::Error),
    /// This program is at fault.
    Internal(String),
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Failure {
        Failure::Usage(error)
    }
}

impl From<Vec<Diagnostic>> for Failure {
    fn from(faults: Vec<Diagnostic>) -> Failure {
        Failure::Input(faults)
    }
}

impl From<scanbound::audit::Failure> for Failure {
    fn from(failure: scanbound::audit::Failure) -> Failure {
        match failure {
            scanbound::audit::Failure::Input(faults) => Failure::Input(faults),
            scanbound::audit::Failure::Internal(what) => Failure::Internal(what),
        }
    }
}

impl Failure {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Input(_) | Failure::Usage(_) => 2,
            Failure::Internal(_) => 70,
        }
    }

    /// Tells the user, on stderr.
    pub fn tell(&self) {
        match self {
            Failure::Input(faults) => output::tell(faults),
            Failure::Usage(error) => output::complain(&format!("{error:#}")),
            Failure::Internal(what) => output::complain(&format!(
                "internal error: {what}\nThis is a fault of scanbound and says nothing about your program. Please report it."
            )),
        }
    }
}

/// Runs the command that the arguments name. If it fails, nothing was written to stdout.
pub fn run(cli: &Cli) -> Result<Outcome, Failure> {
    match &cli.command {
        Command::Audit(arguments) => audit::run(arguments),
        Command::Check(arguments) => check::run(arguments),
        Command::Export(arguments) => export::run(arguments),
        Command::Compare(arguments) => compare::run(arguments),
        Command::Emulate(arguments) => emulate::run(arguments),
        Command::Convert(arguments) => convert::run(arguments),
        Command::Tables(arguments) => tables::run(arguments),
    }
}
