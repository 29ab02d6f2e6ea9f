//! Small programs whose right bound was worked out by hand: the release command must give it, in text and JSON alike.

mod charts;
mod constant_scans;
mod controllers;
mod drawings;
mod drawn_charts;
mod melsec;
mod names;
mod reports;
mod settings;
mod start_states;
mod text;
mod timers;
mod values;
mod watchdogs;
mod xml;

use crate::command;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;

/// The directory of one case's inputs.
fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cases").join(name)
}

/// What a run of the command gave.
struct Run {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Run {
    fn of(output: &Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// The report on stdout. Panics with both streams where it is not JSON.
    fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|fault| panic!("{fault}\n{}\n{}", self.stdout, self.stderr))
    }
}

/// Runs the command in a directory. Arguments are separated by blanks.
fn run(arguments: &str, directory: &Path) -> Run {
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    Run::of(&command::scanbound(&arguments, directory))
}

/// Runs the command in the directory of the case. Arguments are separated by blanks.
fn scanbound(case_name: &str, arguments: &str) -> Run {
    run(arguments, &case(case_name))
}

/// The JSON report of `scanbound audit ARGUMENTS`, which must succeed.
fn audit(case_name: &str, arguments: &str) -> Value {
    let run = scanbound(case_name, &format!("audit {arguments} --format json"));
    assert_eq!(run.code, Some(0), "audit {arguments}\n{}{}", run.stdout, run.stderr);
    run.json()
}

/// `scan.upper_ps` of a report in nanoseconds, rounded up: the bounds of cases are given in them.
fn upper_ns(report: &Value) -> u64 {
    report["scan"]["upper_ps"].as_u64().expect("upper_ps").div_ceil(1000)
}

/// `scan.lower_ps` of a report in nanoseconds, rounded down.
fn lower_ns(report: &Value) -> u64 {
    report["scan"]["lower_ps"].as_u64().expect("lower_ps") / 1000
}
