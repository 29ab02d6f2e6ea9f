//! Emulates a MINASEC-U clock by clock.

use super::run_options::RunOptions;
use crate::command::output::Target;
use crate::command::sink::Sink;
use crate::command::{Failure, Outcome, values};
use anyhow::anyhow;
use clap::Args;
use scanbound::base::time::Picos;
use scanbound::front::minasec::{WORDS, Word};
use scanbound::measured::Figures;
use scanbound::minasec::stimulus::{Stimulus, What};
use scanbound::minasec::trace::Trace;
use scanbound::minasec::vcd::Dump;
use scanbound::minasec::{Clock, Fraction, Machine, Observer, Settings, View};
use scanbound::simulation::Length;
use scanbound::timing::table::StatedClock;
use std::io;

/// The board of a MINASEC-U.
#[derive(Debug, Args)]
#[command(next_help_heading = "MINASEC-U")]
pub struct MachineOptions {
    /// How far this board's clock may differ from the nominal one; the seed determines by how much
    /// [default: 0%]
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    tolerance: Option<Fraction>,
    /// How far each period may differ from the board's; the seed determines by how much
    /// [default: 0%]
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    jitter: Option<Fraction>,
    /// The seed of the random numbers [default: 0]
    #[arg(long, value_name = "N", value_parser = values::count::<u64>, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// T0's delay, 0.1 s to 1.1 s [default: 1s]
    #[arg(long, value_name = "DURATION", value_parser = values::duration, allow_hyphen_values = true)]
    t0: Option<Picos>,
    /// T1's delay, 1 s to 11 s [default: 1s]
    #[arg(long, value_name = "DURATION", value_parser = values::duration, allow_hyphen_values = true)]
    t1: Option<Picos>,
    /// The count at which the counter stops: its two rotary switches [default: 10]
    #[arg(long, value_name = "0-99", value_parser = values::two_digits, allow_negative_numbers = true)]
    setting: Option<u8>,
    /// The count at power-up, which the counter kept without power [default: 0]
    #[arg(long, value_name = "0-99", value_parser = values::two_digits, allow_negative_numbers = true)]
    count: Option<u8>,
    /// The delay of the input filter [default: 10ms]
    #[arg(long, value_name = "DURATION", value_parser = values::duration, allow_hyphen_values = true)]
    filter: Option<Picos>,
}

impl MachineOptions {
    /// Whether one of the options is given.
    pub(super) fn is_given(&self) -> bool {
        let MachineOptions { tolerance, jitter, seed, t0, t1, setting, count, filter } = self;
        tolerance.is_some()
            || jitter.is_some()
            || seed.is_some()
            || [t0, t1, filter].iter().any(|time| time.is_some())
            || setting.is_some()
            || count.is_some()
    }

    fn settings(&self, clock: Option<&StatedClock>) -> Result<Settings, Failure> {
        let nominal = Settings::default();
        let (period, slow) = match clock {
            None | Some(StatedClock::Fast) => (nominal.clock.period, false),
            Some(StatedClock::Slow) => (nominal.clock.period, true),
            Some(StatedClock::Period { period, .. }) => (*period, false),
        };
        let clock = Clock {
            period,
            slow,
            tolerance: self.tolerance.unwrap_or(nominal.clock.tolerance),
            jitter: self.jitter.unwrap_or(nominal.clock.jitter),
            seed: self.seed.unwrap_or(nominal.clock.seed),
        };
        let settings = Settings {
            clock,
            t0: self.t0.unwrap_or(nominal.t0),
            t1: self.t1.unwrap_or(nominal.t1),
            setting: self.setting.unwrap_or(nominal.setting),
            count: self.count.unwrap_or(nominal.count),
            filter: self.filter.unwrap_or(nominal.filter),
        };
        match settings.faults().as_slice() {
            [] => Ok(settings),
            faults => Err(anyhow!(faults.join("; ")).into()),
        }
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

/// Emulates the machine.
pub fn run(
    machine: &MachineOptions,
    arguments: &RunOptions,
    words: [Word; WORDS],
    clock: Option<&StatedClock>,
) -> Result<Outcome, Failure> {
    let settings = machine.settings(clock)?;
    let stimulus = match arguments.read_stimulus()? {
        Some((name, bytes)) => Stimulus::parse(&name, &bytes)?,
        None => Stimulus::default(),
    };
    let Length { scans, end } = arguments.length();
    in_range(scans, end, &settings, &stimulus)?;
    let mut machine = Machine::new(words, &settings, &stimulus);
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
        while (times.len() as u64) < scans {
            let Some(scan) = machine.scan(&mut watch) else { break };
            if end.is_some_and(|end| scan.start >= end) {
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
    scans: u64,
    end: Option<Picos>,
    settings: &Settings,
    stimulus: &Stimulus,
) -> Result<(), Failure> {
    let slow = stimulus.changes.iter().any(|change| change.what == What::Slow && change.on);
    let clock = Clock { slow: slow || settings.clock.slow, ..settings.clock.clone() };
    let scan = u128::from(clock.longest().0) * 256;
    let last = stimulus.changes.last().map_or(0, |change| u128::from(change.at.0));
    // A run for a time ends with the time, whatever number of scans it makes.
    let scans = if end.is_none() { u128::from(scans) } else { 0 };
    let duration = u128::from(end.unwrap_or(Picos::ZERO).0);
    // The stimulus may halt the machine, and the last scan runs to its end.
    if last + (scans + 2) * scan + duration > u128::from(u64::MAX / 2) {
        return Err(anyhow!("the emulation may take more than 100 days of machine time: run fewer scans, or end the stimulus earlier").into());
    }
    Ok(())
}
