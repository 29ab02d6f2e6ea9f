//! `scanbound facts`: writes a facts file with suggestions of what to state.

use super::options::{ProjectOptions, WhatIfOptions};
use super::output::{Target, apart, is_there};
use super::{Failure, Outcome};
use anyhow::anyhow;
use clap::Args;
use scanbound::audit::{self, Request, offer};
use scanbound::report::facts;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  scanbound facts PLC/ -o plant.toml         what to state of a project, commented out
  scanbound facts PLC/ --facts plant.toml    what is still worth stating, on stdout

A file that is there already is never written over: it may hold what you stated.";

/// The arguments of `facts`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    what_if: WhatIfOptions,
    /// Write the facts to a new file, which appears only when it is complete
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Audits the project, accepting calls to routines without code, and writes what is worth stating.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let project = arguments.project.or_here_without_facts()?;
    apart(&project.reads(), &[("--output", arguments.output.as_deref())])?;
    if let Some(file) = arguments.output.as_deref().filter(|file| is_there(file)) {
        let name = file.display();
        return Err(anyhow!(
            "--output {name} exists, and the facts in it would be lost: name a new file, or omit --output to write to stdout"
        )
        .into());
    }
    let target = Target::new(arguments.output.as_deref())?;
    let text = project.with_request(|request| {
        let request = Request { incomplete: true, ..*request };
        let mut concluded = audit::concluded(&request)?;
        if let Some(most) = arguments.what_if.most() {
            audit::what_if_offered(&mut concluded, &request, most)?;
        }
        let offers = offer::offers(&concluded, &request);
        Ok(facts::file(&concluded.audit, &offers, &concluded.followed.program.missing_routines))
    })?;
    target.write(&text)?;
    Ok(Outcome::Done)
}
