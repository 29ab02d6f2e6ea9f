//! The options of a run: what is set from outside, how long it goes on, and what is written.

use crate::command::{Failure, values};
use anyhow::Context;
use clap::Args;
use scanbound::base::time::Picos;
use scanbound::front::input::read_small;
use scanbound::simulation::Length;
use std::path::PathBuf;

/// The number of scans, if neither a number nor a time is given.
const SCANS: u64 = 10;

/// The options of a run.
#[derive(Debug, Args)]
pub struct RunOptions {
    /// What is set from outside: a CSV of times, and of values of devices or variables (docs/measuring.md)
    #[arg(long, value_name = "FILE")]
    pub(super) stimulus: Option<PathBuf>,
    /// The number of scans to run [default: 10]
    #[arg(long, value_name = "N", conflicts_with = "duration", value_parser = values::count::<u64>, allow_negative_numbers = true)]
    scans: Option<u64>,
    /// Run the scans that begin within this time
    #[arg(long = "for", value_name = "DURATION", value_parser = values::duration, allow_hyphen_values = true)]
    duration: Option<Picos>,
    /// Show this device or variable, instead of all that change; may be repeated
    #[arg(long, value_name = "NAME")]
    pub(super) watch: Vec<String>,
    /// Write one row per scan (CSV) to this file
    #[arg(long, value_name = "FILE")]
    pub(super) trace: Option<PathBuf>,
    /// Write every change (VCD, for GTKWave and PulseView) to a file
    #[arg(long, value_name = "FILE")]
    pub(super) vcd: Option<PathBuf>,
}

impl RunOptions {
    /// How long the run goes on.
    pub fn length(&self) -> Length {
        let scans = match self.duration {
            Some(_) => u64::MAX,
            None => self.scans.unwrap_or(SCANS),
        };
        Length { scans, end: self.duration }
    }

    /// The name and the content of the stimulus, if there is one.
    pub fn read_stimulus(&self) -> Result<Option<(String, Vec<u8>)>, Failure> {
        let Some(file) = &self.stimulus else { return Ok(None) };
        let name = file.display().to_string();
        let bytes =
            read_small(file).with_context(|| format!("--stimulus {name} cannot be read"))?;
        Ok(Some((name, bytes)))
    }
}
