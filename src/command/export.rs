//! `scanbound export`: a group's question for other solvers.

use super::options::ProjectOptions;
use super::output::{Target, apart};
use super::{Failure, Outcome, values};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use scanbound::audit::{self, Form};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  scanbound export PLC/ --group 1 --format wcnf -o group1.wcnf
  scanbound export PLC/ --group 1 --format smt2 | z3 -in";

/// The arguments of `export`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectOptions,
    /// The group, as the report numbers it
    #[arg(long, value_name = "N", value_parser = values::positive::<usize>, allow_negative_numbers = true)]
    group: usize,
    /// In which format
    #[arg(long, value_enum)]
    format: Format,
    /// Write the question to a file, whole or not at all
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    /// Weighted partial MaxSAT
    Wcnf,
    /// SMT-LIB 2 with soft assertions
    Smt2,
}

/// Follows the project and writes the group's question.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let project = arguments.project.or_here()?;
    let form = match arguments.format {
        Format::Wcnf => Form::Wcnf,
        Format::Smt2 => Form::Smt2,
    };
    apart(&project.reads(), &[("--output", arguments.output.as_deref())])?;
    let target = Target::new(arguments.output.as_deref())?;
    let followed = project.with_request(|request| Ok(audit::follow(request)?))?;
    let groups = followed.groups.len();
    let question = audit::question(&followed, arguments.group, form).ok_or_else(|| {
        let group = arguments.group;
        match groups {
            0 => anyhow!("--group {group}: there are no groups, since every scan of the program costs the same"),
            1 => anyhow!("--group {group}: there is group 1 only"),
            _ => anyhow!("--group {group}: the groups are numbered 1 to {groups}"),
        }
    })?;
    target.write(&question)?;
    Ok(Outcome::Done)
}
