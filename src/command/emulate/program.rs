//! Runs any other program by a table's times.

use super::run_options::RunOptions;
use crate::command::output::{Target, say, tell};
use crate::command::sink::Sink;
use crate::command::{Failure, Outcome};
use anyhow::anyhow;
use scanbound::audit::{Ready, Request, ready};
use scanbound::measured::Figures;
use scanbound::program::Program;
use scanbound::simulation::recording::{End, Recording};
use scanbound::simulation::signals::Signals;
use scanbound::simulation::{simulate, stimulus, vcd};

/// Runs the program of a request.
pub fn run(arguments: &RunOptions, request: &Request<'_>) -> Result<Outcome, Failure> {
    let Ready { program, table, prices, warnings } = ready(request)?;
    tell(&warnings);
    let signals = Signals::of(&program);
    let named = |name: &String| {
        let signal = signals.named(name);
        signal.ok_or_else(|| anyhow!("--watch {name}: the program has no such device or variable"))
    };
    let watched = arguments.watch.iter().map(named).collect::<Result<Vec<_>, _>>()?;
    let changes = match arguments.read_stimulus()? {
        Some((name, bytes)) => stimulus(&signals, &name, &bytes)?,
        None => Vec::new(),
    };
    let times = prices.times();
    let costs = (&times[..], prices.overhead_sum());
    let recording = simulate(&program, costs, &signals, &watched, &changes, arguments.length());
    if let Some(file) = &arguments.trace {
        let mut sink = Sink::open(Target::new(Some(file))?)?;
        let written = recording.write_csv(&mut sink);
        sink.finish(written)?;
    }
    if let Some(file) = &arguments.vcd {
        let mut sink = Sink::open(Target::new(Some(file))?)?;
        let written = vcd::write(&recording, &mut sink);
        sink.finish(written)?;
    }
    let summary = summary(&recording, &table.name);
    match &arguments.trace {
        None => Target::Stdout.write(&(recording.text() + &summary))?,
        Some(file) if file.as_os_str() == "-" => say(&summary),
        Some(_) => Target::Stdout.write(&summary)?,
    }
    if let Some(end) = recording.end {
        say(&format!("the run ends in scan {}{}\n", recording.scans.len() + 1, why(&program, end)));
    }
    Ok(Outcome::Done)
}

fn summary(recording: &Recording, table: &str) -> String {
    let times: Vec<_> = recording.scans.iter().map(|scan| scan.time).collect();
    let (Some(figures), Some((longest, _))) = (Figures::of(&times), recording.longest()) else {
        return "no scan was emulated\n".to_owned();
    };
    let Figures { count, least, most, mean, .. } = figures;
    format!(
        "{count} scans emulated by table {table}, from {least} to {most}, {mean} in the mean; the longest is scan {longest}\n"
    )
}

/// Where and why a run ended early.
fn why(program: &Program, end: End) -> String {
    let (End::Unknown(at) | End::Error(at) | End::Endless(at)) = end;
    let instruction = program.instructions.get(at);
    let place = instruction.map_or_else(String::new, |one| {
        format!(" at `{}` ({})", one.text, program.location_text(one.place))
    });
    let why = match end {
        End::Unknown(_) => "the program's path depends on its result, which is not modelled",
        End::Error(_) => "an operation error stops the CPU",
        End::Endless(_) => "the scan does not end",
    };
    format!("{place}: {why}")
}
