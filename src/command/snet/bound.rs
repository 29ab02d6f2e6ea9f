//! `scanbound snet bound`.

use super::draw::MarksDrawing;
use super::net::{Initial, read_sound};
use crate::command::options::{ProjectOptions, ReportOptions, SearchOptions};
use crate::command::output::apart;
use crate::command::{Failure, Outcome};
use clap::{Args, ValueEnum};
use scanbound::audit::{self, Request};
use scanbound::front::Input;
use scanbound::snet::Diagram;
use scanbound::snet::knowledge::relays;
use scanbound::snet::translate::{c200h, cx, listing, melsec};
use std::path::PathBuf;

pub const ABOUT: &str = "\
Bound the scan time of a net's code, using the net's exclusions: boxes that are never marked together

Without programs, the code that `snet translate` generates is audited. With programs, all of them are audited: the net's code \
and the code that uses its boxes. An exclusion of the net is used only if every scan of the code from power-up on preserves \
it, and only for relays that nothing but the program writes (--trust all, or [internal] in --facts). The report lists what \
was used, and why the rest was not.";

const EXAMPLES: &str = "\
Examples:
  scanbound snet bound line.snet --trust all
  scanbound snet bound line.snet line.il work.il --cpu C200H --trust all --draw worst.svg
  scanbound snet bound line.snet --to cx --cpu CJ2M --initial first-scan --trust all --format json

`scanbound audit line.il work.il --net line.snet` gives the same result for programs.";

/// The arguments of `snet bound`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A net, with its addresses
    #[arg(value_name = "NET")]
    net: PathBuf,
    /// The PLC for which code is generated, if no program is named
    #[arg(long, value_enum, value_name = "TARGET", default_value_t)]
    to: To,
    /// How the generated code gets the initial marks
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    initial: Initial,
    /// Assign free relays, and free timer and counter numbers, to elements without one
    #[arg(long)]
    assign: bool,
    /// Draw the net with the marks at the start of the longest scan (.svg .dot)
    #[arg(long, value_name = "FILE")]
    draw: Option<PathBuf>,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    report: ReportOptions,
}

/// The kinds of code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum To {
    /// The C200H's list
    #[default]
    C200h,
    /// CX-Programmer's mnemonics for CS, CJ and CP; --cpu names one
    Cx,
    /// A list for MELSEC-Q and L; --cpu names one
    Melsec,
}

/// Audits the code.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    apart(&[&arguments.net], &[("--draw", arguments.draw.as_deref())])?;
    let net = read_sound(&arguments.net, arguments.assign)?;
    let drawing = arguments.draw.as_deref().map(MarksDrawing::new).transpose()?;
    let project = &arguments.project;
    let (reports, trace) = arguments.report.targets(project, &arguments.search)?;
    let relays = relays(&net);
    let work = |request: &Request<'_>| {
        let request = Request { net: Some(&relays), ..arguments.search.of(request) };
        let followed = audit::follow(&request)?;
        let mut concluded = audit::conclude(followed, &request)?;
        audit::net_bound(&mut concluded, &request)?;
        reports.draw(&mut concluded);
        Ok(concluded.audit)
    };
    let audit = if project.is_open() {
        let (code, cpu) = own_code(arguments, &net)?;
        project.with_code(code, cpu, work)
    } else {
        project.with_request(work)
    };
    let audit = match audit {
        Ok(audit) => audit,
        Err(failure) => return Err(reports.refused(project, failure)?),
    };
    trace.write(&audit)?;
    if let Some(drawing) = drawing {
        drawing.write(&net, &audit)?;
    }
    arguments.report.write(&audit, None, reports)?;
    Ok(Outcome::Done)
}

/// The code generated from the net, and the CPU that it is for unless another is named.
fn own_code(
    arguments: &Arguments,
    net: &Diagram,
) -> Result<(Input, Option<&'static str>), Failure> {
    let list = listing(net, arguments.initial == Initial::FirstScan)?;
    let (text, suffix, cpu) = match arguments.to {
        To::C200h => (c200h(net, &list), "il", Some("C200H")),
        To::Cx => (cx(net, &list)?, "cx", None),
        To::Melsec => (melsec(net, &list)?, "txt", None),
    };
    let name = arguments.net.with_extension(suffix).display().to_string();
    Ok((Input { name, bytes: text.into_bytes() }, cpu))
}
