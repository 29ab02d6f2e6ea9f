//! Inputs of every kind, changed at random and blown up: every run ends in exit code 0 to 3.
//!
//! The ordinary run tries a few. `SCANBOUND_CASES=20000 cargo test --release --test hostile` tries many, from
//! `SCANBOUND_SEED` on, every 50th of them blown up to 10 MB, and holds each to 5 s and 1 GB besides. What fails is
//! kept in `target/hostile`.

mod common {
    pub mod hostile;
}

use common::hostile::{Case, Random, case};
use std::fs;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How many cases the ordinary run tries.
const FEW: usize = 80;
/// What a run may take, where it is measured.
const SECONDS: u64 = 5;
const KILOBYTES: u64 = 1 << 20;
/// When a run is given up.
const GIVEN_UP: Duration = Duration::from_secs(60);

/// How a run ended.
struct Run {
    code: Option<i32>,
    time: Duration,
    /// The most memory that was seen, in kilobytes.
    memory: u64,
    told: String,
}

#[test]
fn hostile_inputs_end_with_a_verdict_or_a_reason() {
    let stated = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<usize>().ok());
    let many = stated("SCANBOUND_CASES");
    let (cases, seed) = (many.unwrap_or(FEW), stated("SCANBOUND_SEED").unwrap_or(1));
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../hostile");
    let next = AtomicUsize::new(0);
    let reached = AtomicUsize::new(0);
    let mut faults: Vec<(usize, String)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..std::thread::available_parallelism().map_or(1, usize::from))
            .map(|_| {
                scope.spawn(|| {
                    let mut faults = Vec::new();
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        if number >= cases {
                            return faults;
                        }
                        let mut random = Random::new((seed + number) as u64);
                        let size = many.filter(|_| number % 50 == 49).map(|_| 10 << 20);
                        let case = case(&mut random, size);
                        let directory = tempfile::tempdir().expect("a directory");
                        let run = run(&case, directory.path());
                        if case.searches && matches!(run.code, Some(0 | 1 | 3)) {
                            reached.fetch_add(1, Ordering::Relaxed);
                        }
                        if let Some(what) = fault(&run, many.is_some()) {
                            let place = keep(&case, &kept, seed + number);
                            faults.push((seed + number, format!("{what}\n  {}", place.display())));
                        }
                    }
                })
            })
            .collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("a worker ends")).collect()
    });
    faults.sort();
    let told: Vec<String> =
        faults.iter().map(|(seed, what)| format!("seed {seed}: {what}")).collect();
    assert!(told.is_empty(), "{} of {cases} cases:\n{}", told.len(), told.join("\n"));
    let reached = reached.load(Ordering::Relaxed);
    assert!(reached * 2 >= cases, "{reached} of {cases} cases got as far as the search");
}

/// What is wrong with how a run ended.
fn fault(run: &Run, measured: bool) -> Option<String> {
    if !matches!(run.code, Some(0..=3)) {
        return Some(format!("exit {:?}: {:.300}", run.code, run.told));
    }
    if measured && run.time.as_secs() >= SECONDS {
        return Some(format!("{:.1} s", run.time.as_secs_f64()));
    }
    (measured && run.memory > KILOBYTES).then(|| format!("{} MB", run.memory >> 10))
}

fn run(case: &Case, directory: &Path) -> Run {
    for (name, bytes) in &case.files {
        fs::write(directory.join(name), bytes).expect("written");
    }
    let mut told = tempfile::tempfile().expect("a new file");
    let errors = told.try_clone().expect("the file once more");
    let begun = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .args(&case.arguments)
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

/// The most memory that a process has had, in kilobytes, where the system tells it.
fn peak(status: &Path) -> u64 {
    let text = fs::read_to_string(status).unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Keeps a case to be looked at: its files and its arguments.
fn keep(case: &Case, kept: &Path, seed: usize) -> PathBuf {
    let place = kept.join(seed.to_string());
    fs::create_dir_all(&place).expect("a directory");
    for (name, bytes) in &case.files {
        fs::write(place.join(name), bytes).expect("written");
    }
    fs::write(place.join("arguments"), case.arguments.join("\n")).expect("written");
    place
}
