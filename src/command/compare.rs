//! `scanbound compare`: compares measured scan times with the bound.

use super::options::{ProjectOptions, ReportOptions, SearchOptions};
use super::{Failure, Outcome};
use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};
use scanbound::base::column::{UNITS, Unit};
use scanbound::front::Input;
use scanbound::front::input::read_one;
use scanbound::measured::{Bounds, Comparison, Decimal, Edge, Selection, Threshold, capture};
use scanbound::report::compare;
use scanbound::report::format::Detail;

const EXAMPLES: &str = "\
Examples:
  scanbound compare PLC/ scans.csv           a column of scan times, such as scan_ms
  scanbound compare PLC/ capture.vcd --signal Y0 --edge both

Exit codes: 0 no scan above the bound, 1 at least one scan is above the bound, 2 bad input or usage, 70 internal error";

/// The arguments of `compare`. The last file holds the measurements.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The column of scan times, or with --pulses of time stamps [default: found by its name]
    #[arg(long, value_name = "NAME", conflicts_with = "signal")]
    column: Option<String>,
    /// The column holds the time stamps of one pulse per scan
    #[arg(long, conflicts_with = "signal")]
    pulses: bool,
    /// The column's unit, if its name does not give it: s, ms, us, ns or ps
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    unit: Option<Unit>,
    /// A captured signal whose edges begin the scans
    #[arg(long, value_name = "NAME")]
    signal: Option<String>,
    /// Which edges of the signal begin a scan
    #[arg(long, value_enum, default_value = "rising")]
    edge: EdgeName,
    /// Where an analog signal changes: a level (2.5), or two between which it stays (0.8..2.0)
    #[arg(long, value_name = "LEVEL", requires = "signal", value_parser = threshold, allow_hyphen_values = true)]
    threshold: Option<Threshold>,
    /// Ignore intervals that contain a time at which this signal is off [default: running, in the emulator's dumps]
    #[arg(long = "while", value_name = "NAME", requires = "signal")]
    during: Option<String>,
    /// The decimal separator, if the file does not show it
    #[arg(long, value_enum)]
    decimal: Option<DecimalName>,
    /// Suggest the clock, or the scale of the table, that fits the measurements
    #[arg(long)]
    fit: bool,
    #[command(flatten)]
    project: ProjectOptions,
    #[command(flatten)]
    search: SearchOptions,
    #[command(flatten)]
    report: ReportOptions,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum DecimalName {
    /// 8,448.5
    Point,
    /// 8.448,5
    Comma,
}

fn threshold(text: &str) -> Result<Threshold, String> {
    Threshold::parse(text).ok_or_else(|| "give a level such as 2.5, or two: 0.8..2.0".to_owned())
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum EdgeName {
    /// From 0 to 1
    Rising,
    /// From 1 to 0
    Falling,
    /// Both: the program inverts the signal in each scan
    Both,
}

fn unit(text: &str) -> Result<Unit, String> {
    let known = || format!("give one of {}", UNITS.map(|unit| unit.name).join(", "));
    Unit::from_name(text).ok_or_else(known)
}

/// Audits the project, reads the measurements, compares and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let Some((project, measured)) = arguments.project.split_last() else {
        return Err(
            anyhow!("give the program's files, followed by the file of measurements").into()
        );
    };
    let (reports, trace) = arguments.report.targets(&arguments.project, &arguments.search)?;
    let Input { name, bytes } = read_one(&measured).with_context(|| {
        format!("{}, the file of measurements, cannot be read", measured.display())
    })?;
    let selection = Selection {
        column: arguments.column.as_deref(),
        pulses: arguments.pulses,
        unit: arguments.unit,
        signal: arguments.signal.as_deref(),
        edge: match arguments.edge {
            EdgeName::Rising => Edge::Rising,
            EdgeName::Falling => Edge::Falling,
            EdgeName::Both => Edge::Both,
        },
        threshold: arguments.threshold,
        decimal: arguments.decimal.map(|name| match name {
            DecimalName::Point => Decimal::Point,
            DecimalName::Comma => Decimal::Comma,
        }),
        during: arguments.during.as_deref(),
    };
    let measurements = capture::read(&name, &bytes, &selection)?;
    drop(bytes);
    let audit = project.audit(&arguments.search)?;
    trace.write(&audit)?;
    if let Some(first) = audit.unbounded.first() {
        let file = first.to.of(&audit.files);
        let line = first.to.line;
        let what = match first.certain {
            true => "a scan can stay for ever in",
            false => "no condition was found that is sure to end",
        };
        return Err(anyhow!("the scan has no bound: {what} the loop that begins in line {line} of {file} (scanbound audit shows it)").into());
    }
    let bounds = Bounds::of(&audit);
    let Some(found) = Comparison::new(audit.files, bounds, measurements, arguments.fit) else {
        return Err(Failure::Internal("measurements without a scan".to_owned()));
    };
    let answer = |_| format!("{}\n", compare::text::answer(&found));
    arguments
        .report
        .fill(reports, Detail::Usual, answer, |format, _, out| (format.compare)(&found, out))?;
    Ok(if found.above.is_some() { Outcome::Refuted } else { Outcome::Done })
}
