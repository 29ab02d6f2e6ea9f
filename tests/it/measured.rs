//! Runs the binary on given files, and returns its exit status, time and memory.

use crate::command::binary;
use std::fs;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// The time after which a run is stopped.
const GIVEN_UP: Duration = Duration::from_secs(60);

/// How a run ended.
pub struct Run {
    pub code: Option<i32>,
    pub time: Duration,
    /// The largest observed memory use, in kilobytes.
    pub memory: u64,
    pub told: String,
}

/// Runs the binary in a directory into which the files are written.
pub fn run(files: &[(String, Vec<u8>)], arguments: &[String], directory: &Path) -> Run {
    for (name, bytes) in files {
        fs::write(directory.join(name), bytes).expect("written");
    }
    let mut told = tempfile::tempfile().expect("a new file");
    let errors = told.try_clone().expect("the file once more");
    let begun = Instant::now();
    let mut child = binary()
        .args(arguments)
        .current_dir(directory)
        .stdout(Stdio::null())
        .stderr(errors)
        .spawn()
        .expect("the program starts");
    let status = PathBuf::from(format!("/proc/{}/status", child.id()));
    let mut memory = 0;
    let code = loop {
        memory = memory.max(peak(&status));
        match child.try_wait().expect("it can be waited for") {
            Some(status) => break status.code(),
            None if begun.elapsed() > GIVEN_UP => {
                child.kill().expect("it can be ended");
                child.wait().expect("it ends");
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(3)),
        }
    };
    let time = begun.elapsed();
    let mut text = Vec::new();
    told.seek(SeekFrom::Start(0)).expect("its beginning");
    told.read_to_end(&mut text).expect("what was told");
    Run { code, time, memory, told: String::from_utf8_lossy(&text).into_owned() }
}

/// The largest memory use of a process, in kilobytes, if the system reports it.
fn peak(status: &Path) -> u64 {
    let text = fs::read_to_string(status).unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
