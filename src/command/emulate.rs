//! `scanbound emulate`: runs a MINASEC-U program on the emulated machine.

use super::output::{Target, apart};
use super::sink::Sink;
use super::{Failure, Outcome, convert, values};
use anyhow::{Context, anyhow};
use clap::{ArgGroup, Args};
use scanbound::base::time::Picos;
use scanbound::front::input::read_small;
use scanbound::measured::Figures;
use scanbound::minasec::stimulus::{Stimulus, What};
use scanbound::minasec::trace::Trace;
use scanbound::minasec::vcd::Dump;
use scanbound::minasec::{Clock, FILTER, Fraction, Machine, Observer, Settings, View};
use scanbound::timing::table::StatedClock;
use std::io;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  scanbound emulate program.asm --scans 100
  scanbound emulate program.asm --stimulus plant.csv --for 30s --trace scans.csv --vcd signals.vcd";

/// The arguments of `emulate`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("length").required(true))]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A MINASEC-U program: assembly, Intel HEX, or the program memory's bytes; - for stdin
    #[arg(value_name = "PROGRAM")]
    program: PathBuf,
    /// The inputs and switches over time: a CSV of times and changes (docs/minasec-u.md)
    #[arg(long, value_name = "FILE")]
    stimulus: Option<PathBuf>,
    /// The number of scans to run
    #[arg(long, value_name = "N", group = "length", value_parser = values::count::<u64>, allow_negative_numbers = true)]
    scans: Option<u64>,
    /// Run the scans that begin within this time
    #[arg(long = "for", value_name = "DURATION", group = "length", value_parser = values::duration, allow_hyphen_values = true)]
    duration: Option<Picos>,
    /// Write one row per scan (CSV) to this file instead of stdout
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Write every change (VCD, for GTKWave and PulseView) to a file
    #[arg(long, value_name = "FILE")]
    vcd: Option<PathBuf>,
    /// The clock: a frequency (30.3kHz), the period of a word (33us), fast or slow
    #[arg(long, value_name = "CLOCK", default_value = "fast")]
    clock: StatedClock,
    /// How far this board's clock may differ from the nominal one; the seed determines by how much
    #[arg(long, value_name = "PERCENT", default_value = "0%", allow_hyphen_values = true)]
    tolerance: Fraction,
    /// How far each period may differ from the board's; the seed determines by how much
    #[arg(long, value_name = "PERCENT", default_value = "0%", allow_hyphen_values = true)]
    jitter: Fraction,
    /// The seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = values::count::<u64>, allow_negative_numbers = true)]
    seed: u64,
    /// T0's delay, 0.1 s to 1.1 s
    #[arg(long, value_name = "DURATION", default_value = "1s", value_parser = values::duration, allow_hyphen_values = true)]
    t0: Picos,
    /// T1's delay, 1 s to 11 s
    #[arg(long, value_name = "DURATION", default_value = "1s", value_parser = values::duration, allow_hyphen_values = true)]
    t1: Picos,
    /// The count at which the counter stops: its two rotary switches
    #[arg(long, value_name = "0-99", default_value_t = 10, value_parser = values::two_digits, allow_negative_numbers = true)]
    setting: u8,
    /// The count at power-up, which the counter kept without power
    #[arg(long, value_name = "0-99", default_value_t = 0, value_parser = values::two_digits, allow_negative_numbers = true)]
    count: u8,
    /// The delay of the input filter
    #[arg(long, value_name = "DURATION", default_value_t = FILTER, value_parser = values::duration, allow_hyphen_values = true)]
    filter: Picos,
    /// The dialect [default: found from the content]
    #[arg(long, value_name = "NAME", value_parser = values::minasec())]
    dialect: Option<String>,
}

impl Arguments {
    fn settings(&self) -> Result<Settings, Failure> {
        let nominal = Clock::default();
        let (period, slow) = match &self.clock {
            StatedClock::Fast => (nominal.period, false),
            StatedClock::Slow => (nominal.period, true),
            StatedClock::Period { period, .. } => (*period, false),
        };
        let (tolerance, jitter, seed) = (self.tolerance, self.jitter, self.seed);
        let settings = Settings {
            clock: Clock { period, slow, tolerance, jitter, seed },
            t0: self.t0,
            t1: self.t1,
            setting: self.setting,
            count: self.count,
            filter: self.filter,
        };
        match settings.faults().as_slice() {
            [] => Ok(settings),
            faults => Err(anyhow!(faults.join("; ")).into()),
        }
    }

    fn stimulus(&self) -> Result<Stimulus, Failure> {
        let Some(file) = &self.stimulus else { return Ok(Stimulus::default()) };
        let name = file.display().to_string();
        let bytes =
            read_small(file).with_context(|| format!("--stimulus {name} cannot be read"))?;
        Ok(Stimulus::parse(&name, &bytes)?)
    }
}

/// Writes a dump, if one is requested.
enum Watch<'a> {
    Nobody,
    Dump(Box<Dump<&'a mut Sink>>),
}

impl Observer for Watch<'_> {
    fn scan(&mut self, at: Picos, view: View) {
        if let Watch::Dump(dump) = self {
            dump.scan(at, view);
        }
    }

    fn change(&mut self, at: Picos, view: View) {
        if let Watch::Dump(dump) = self {
            dump.change(at, view);
        }
    }
}

/// Emulates.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let read: Vec<&Path> = [Some(&arguments.program), arguments.stimulus.as_ref()]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    let written = [("--trace", arguments.trace.as_deref()), ("--vcd", arguments.vcd.as_deref())];
    apart(&read, &written)?;
    let source = convert::source(&arguments.program, arguments.dialect.as_deref())?;
    let settings = arguments.settings()?;
    let stimulus = arguments.stimulus()?;
    in_range(arguments, &settings, &stimulus)?;
    let mut machine = Machine::new(source.words, &settings, &stimulus);
    let mut trace_sink = Sink::open(Target::new(arguments.trace.as_deref())?)?;
    let mut dump_sink = match arguments.vcd.as_deref() {
        Some(file) => Some(Sink::open(Target::new(Some(file))?)?),
        None => None,
    };
    let mut times = Vec::new();
    let mut dumped = Ok(());
    let traced = (|| -> io::Result<()> {
        let mut trace = Trace::new(&mut trace_sink)?;
        let mut watch = match &mut dump_sink {
            None => Watch::Nobody,
            Some(sink) => match Dump::new(sink, &stimulus, &machine) {
                Ok(dump) => Watch::Dump(Box::new(dump)),
                Err(error) => {
                    dumped = Err(error);
                    Watch::Nobody
                }
            },
        };
        let most = arguments.scans.unwrap_or(u64::MAX);
        while (times.len() as u64) < most {
            let Some(scan) = machine.scan(&mut watch) else { break };
            if arguments.duration.is_some_and(|end| scan.start >= end) {
                break;
            }
            if scan.held {
                continue;
            }
            times.push(scan.time);
            trace.scan(&scan)?;
        }
        if let Watch::Dump(dump) = watch {
            dumped = dump.finish(machine.now());
        }
        trace.finish()
    })();
    trace_sink.finish(traced)?;
    if let Some(sink) = dump_sink {
        sink.finish(dumped)?;
    }
    if arguments.trace.is_some() {
        Target::Stdout.write(&summary(&times, &machine))?;
    }
    Ok(Outcome::Done)
}

fn summary(times: &[Picos], machine: &Machine) -> String {
    let Some(figures) = Figures::of(times) else {
        return "no scan was emulated: the machine had no power\n".to_owned();
    };
    format!(
        "{} scans emulated, from {} to {}, {} in the mean; {} of machine time; the count is {}\n",
        figures.count,
        figures.least,
        figures.most,
        figures.mean,
        machine.now(),
        machine.view().count
    )
}

/// Refuses a run that is longer than times can represent.
fn in_range(
    arguments: &Arguments,
    settings: &Settings,
    stimulus: &Stimulus,
) -> Result<(), Failure> {
    let slow = stimulus.changes.iter().any(|change| change.what == What::Slow && change.on);
    let clock = Clock { slow: slow || settings.clock.slow, ..settings.clock.clone() };
    let scan = u128::from(clock.longest().0) * 256;
    let end = stimulus.changes.last().map_or(0, |change| u128::from(change.at.0));
    let scans = u128::from(arguments.scans.unwrap_or(0));
    let duration = u128::from(arguments.duration.unwrap_or(Picos::ZERO).0);
    // The stimulus may halt the machine, and the last scan runs to its end.
    if end + (scans + 2) * scan + duration > u128::from(u64::MAX / 2) {
        return Err(anyhow!("the emulation may take more than 100 days of machine time: run fewer scans, or end the stimulus earlier").into());
    }
    Ok(())
}
