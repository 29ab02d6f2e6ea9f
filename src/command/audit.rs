//! `scanbound audit`: the bound and its reasons.

use super::options::{ProjectOptions, ReportOptions, SearchOptions, WhatIfOptions};
use super::output::Target;
use super::snet;
use super::watch::WatchOptions;
use super::{Failure, Outcome, values};
use anyhow::Context;
use clap::Args;
use scanbound::audit::response::Given;
use scanbound::audit::{self, Request};
use scanbound::base::time::Picos;
use scanbound::snet::knowledge::relays;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  scanbound audit PLC/                       a directory of exported CSV files
  scanbound audit main.il --cpu Q26UDV       list text, which does not name its CPU
  scanbound audit PLC/ --facts plant.toml    with what the program does not say
  scanbound audit PLC/ --what-if             what it would be if counts were stated
  scanbound audit PLC/ --trace-search        how the bound was found, question by question
  scanbound audit PLC/ --format json -o bound.json
  scanbound audit line.il --net line.snet --trust all --draw worst.svg
  scanbound audit PLC/ --watch               again whenever a file changes
  unzip -p plc.zip MAIN.csv | scanbound audit -";

/// The arguments of `audit`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Add the worst-case response time from an input's edge to an output's
    #[arg(long)]
    response: bool,
    /// The longest delay from an input terminal to the scan, in place of the table's
    #[arg(long, value_name = "DURATION", requires = "response", value_parser = values::delay, allow_hyphen_values = true)]
    input_delay: Option<Picos>,
    /// The longest delay from the scan to an output terminal, in place of the table's
    #[arg(long, value_name = "DURATION", requires = "response", value_parser = values::delay, allow_hyphen_values = true)]
    output_delay: Option<Picos>,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    what_if: WhatIfOptions,
    #[command(flatten)]
    report: ReportOptions,
    #[command(flatten)]
    watch: WatchOptions,
    /// The net from which the program was generated (.snet, .pnml): its knowledge about relays is checked on the code
    /// (--trust all)
    #[arg(long, value_name = "NET")]
    net: Option<PathBuf>,
    /// Draw the net with the marks at the start of the longest scan (.svg .dot)
    #[arg(long, value_name = "FILE", requires = "net")]
    draw: Option<PathBuf>,
    /// Write SMT-LIB 2 files that prove each group's bound and its scan, and what these rest on; README.txt lists them
    #[arg(long, value_name = "DIRECTORY")]
    certificate: Option<PathBuf>,
}

/// Audits the project and reports, and again whenever its files change if that is requested.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let mut written = arguments.report.writes(&arguments.search);
    written.extend(arguments.certificate.clone());
    written.extend(arguments.draw.clone());
    let watched =
        || [arguments.project.watched(), arguments.net.iter().cloned().collect()].concat();
    arguments.watch.run(watched, &written, || once(arguments))
}

fn once(arguments: &Arguments) -> Result<Outcome, Failure> {
    let project = arguments.project.or_here()?;
    let read = |file| snet::read_sound(file, false);
    let net = arguments.net.as_deref().map(read).transpose()?;
    let relays = net.as_ref().map(relays);
    let drawing = arguments.draw.as_deref().map(snet::MarksDrawing::new).transpose()?;
    let (reports, trace) = arguments.report.targets(&project, &arguments.search)?;
    let concluded = project.with_request(|request| {
        let given = Given { input: arguments.input_delay, output: arguments.output_delay };
        let response = arguments.response.then_some(given);
        let request = Request { response, net: relays.as_ref(), ..arguments.search.of(request) };
        let mut concluded = audit::concluded(&request)?;
        audit::coactivity(&mut concluded, &request)?;
        audit::tasks(&mut concluded, &request)?;
        audit::net_bound(&mut concluded, &request)?;
        if let Some(most) = arguments.what_if.most() {
            audit::what_if(&mut concluded, &request, most)?;
        }
        reports.draw(&mut concluded);
        Ok(concluded)
    });
    let concluded = match concluded {
        Ok(concluded) => concluded,
        Err(failure) => return Err(reports.refused(&project, failure)?),
    };
    trace.write(&concluded.audit)?;
    if let (Some(drawing), Some(net)) = (drawing, &net) {
        drawing.write(net, &concluded.audit)?;
    }
    if let Some(directory) = &arguments.certificate {
        certify(&concluded, directory)?;
    }
    arguments.report.write(&concluded.audit, None, reports)?;
    if !arguments.watch.watch {
        // The process ends here. Freeing the memory piece by piece would take longer.
        std::mem::forget(concluded);
    }
    Ok(Outcome::Done)
}

fn certify(concluded: &audit::Concluded, directory: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(directory).with_context(|| {
        format!("--certificate {}: this directory cannot be created", directory.display())
    })?;
    for file in audit::certificates(concluded) {
        Target::new(Some(&directory.join(file.name)))?.write(&file.text)?;
    }
    Ok(())
}
