//! `scanbound audit`: the bound and its reasons.

use super::options::{ProjectOptions, ReportOptions};
use super::output::Target;
use super::{Failure, Outcome};
use anyhow::Context;
use clap::Args;
use scanbound::audit;
use std::path::{Path, PathBuf};

/// The arguments of `audit`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    report: ReportOptions,
    /// Write, for each group, SMT-LIB 2 files that prove its bound (unsatisfiable) and its scan (satisfiable)
    #[arg(long, value_name = "DIRECTORY")]
    certificate: Option<PathBuf>,
}

/// Audits the project and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let target = arguments.report.target()?;
    let concluded = arguments.project.with_request(|request| {
        let followed = audit::follow(request)?;
        Ok(audit::conclude(followed, request)?)
    })?;
    if let Some(directory) = &arguments.certificate {
        certify(&concluded, directory)?;
    }
    arguments.report.write(&concluded.audit, None, target)?;
    Ok(Outcome::Done)
}

fn certify(concluded: &audit::Concluded, directory: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(directory)
        .with_context(|| format!("the directory {} cannot be made", directory.display()))?;
    for file in audit::certificates(concluded) {
        Target::new(Some(&directory.join(file.name)))?.write(&file.text)?;
    }
    Ok(())
}
