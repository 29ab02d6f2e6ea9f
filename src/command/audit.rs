//! `scanbound audit`: the bound and its reasons.

use super::options::{ProjectOptions, ReportOptions, SearchOptions};
use super::output::Target;
use super::{Failure, Outcome, values};
use anyhow::{Context, anyhow};
use clap::Args;
use scanbound::audit::response::Response;
use scanbound::audit::{self, Audit};
use scanbound::base::code::Code;
use scanbound::base::diagnostic::Diagnostic;
use scanbound::base::time::Picos;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  scanbound audit PLC/                       a directory of exported CSV files
  scanbound audit main.il --cpu Q26UDV       list text, which does not name its CPU
  scanbound audit PLC/ --facts plant.toml    with what the program does not say
  scanbound audit PLC/ --trace-search        how the bound was found, question by question
  scanbound audit PLC/ --format json -o bound.json";

/// The arguments of `audit`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Add the worst time from an input's edge to an output's
    #[arg(long)]
    response: bool,
    /// The longest time from an input terminal to the scan, in place of the table's
    #[arg(long, value_name = "DURATION", requires = "response", value_parser = values::delay, allow_hyphen_values = true)]
    input_delay: Option<Picos>,
    /// The longest time from the scan to an output terminal, in place of the table's
    #[arg(long, value_name = "DURATION", requires = "response", value_parser = values::delay, allow_hyphen_values = true)]
    output_delay: Option<Picos>,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    report: ReportOptions,
    /// Write, for each group, SMT-LIB 2 files that prove its bound (unsatisfiable) and its scan (satisfiable)
    #[arg(long, value_name = "DIRECTORY")]
    certificate: Option<PathBuf>,
}

/// Audits the project and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let (target, trace) = arguments.report.targets(&arguments.project, &arguments.search)?;
    let mut concluded = arguments.project.with_request(|request| {
        let request = arguments.search.of(request);
        let followed = audit::follow(&request)?;
        Ok(audit::conclude(followed, &request)?)
    })?;
    trace.write(&concluded.audit)?;
    if let Some(directory) = &arguments.certificate {
        certify(&concluded, directory)?;
    }
    let audit = &mut concluded.audit;
    if arguments.response {
        if !audit.path.is_empty() {
            return Err(anyhow!("no response time is known for a program of which not every pass asks for every input").into());
        }
        let response = Response::of(audit, arguments.input_delay, arguments.output_delay);
        audit.response = Some(response.map_err(|sides| unknown(audit, &sides))?);
    }
    arguments.report.write(audit, None, target)?;
    // The process ends here, and all of its memory with it: taking it apart piece by piece takes longer.
    std::mem::forget(concluded);
    Ok(Outcome::Done)
}

fn unknown(audit: &Audit, sides: &[&str]) -> Failure {
    let fault = |side: &&str| {
        Diagnostic::file(
            Code::NoDelay,
            &audit.table.name,
            format!("the table does not say how long an {side} takes (@{side}-delay)"),
            format!(
                "give it with --{side}-delay, such as --{side}-delay 10ms: the module's manual has it"
            ),
        )
    };
    Failure::Input(sides.iter().map(fault).collect())
}

fn certify(concluded: &audit::Concluded, directory: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(directory).with_context(|| {
        format!("--certificate {}: this directory cannot be made", directory.display())
    })?;
    for file in audit::certificates(concluded) {
        Target::new(Some(&directory.join(file.name)))?.write(&file.text)?;
    }
    Ok(())
}
