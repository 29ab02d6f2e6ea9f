//! `scanbound export`: writes the problem of a group for other solvers.

use super::options::ProjectOptions;
use super::output::{Target, apart};
use super::{Failure, Outcome, values};
use anyhow::anyhow;
use clap::{Args, ValueEnum};
use scanbound::audit::{self, QuestionFormat};
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
    /// The group, as numbered in the report
    #[arg(long, value_name = "N", value_parser = values::positive::<usize>, allow_negative_numbers = true)]
    group: usize,
    /// The file format; without it and without a file, `wcnf`
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Write the problem to this file, which appears only when it is complete; without --format, its suffix names the
    /// format
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

/// Follows the project and writes the group's problem.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let project = arguments.project.or_here()?;
    let form = match values::format_or_suffix(arguments.format, arguments.output.as_deref())? {
        Format::Wcnf => QuestionFormat::Wcnf,
        Format::Smt2 => QuestionFormat::Smt2,
    };
    apart(&project.reads(), &[("--output", arguments.output.as_deref())])?;
    let target = Target::new(arguments.output.as_deref())?;
    let followed = project.with_request(|request| Ok(audit::follow(request)?))?;
    let groups = followed.groups.len();
    let question = audit::question(&followed, arguments.group, form).ok_or_else(|| {
        let group = arguments.group;
        match groups {
            0 => anyhow!("--group {group}: there are no groups, because every scan of the program takes the same time"),
            1 => anyhow!("--group {group}: there is only group 1"),
            _ => anyhow!("--group {group}: the groups are numbered 1 to {groups}"),
        }
    })?;
    target.write(&question)?;
    Ok(Outcome::Done)
}
