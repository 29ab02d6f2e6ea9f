//! Inputs of every kind, changed at random and blown up: every run ends in exit code 0 to 3.
//!
//! The ordinary run tries a few. `SCANBOUND_CASES=20000 cargo test --release --test random hostile::` tries many, from
//! `SCANBOUND_SEED` on, every 50th of them blown up to 10 MB, and holds each to 5 s and 1 GB besides. What fails is
//! kept in `target/hostile`.

use crate::measured::{Run, run};
use common::hostile::{Case, Random, case};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// How many cases the ordinary run tries.
const FEW: usize = 80;
/// What a run may take, where it is measured.
const SECONDS: u64 = 5;
const KILOBYTES: u64 = 1 << 20;

#[test]
#[expect(clippy::print_stdout, reason = "how many were searched is told")]
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
                        let run = run(&case.files, &case.arguments, directory.path());
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
    let reached = reached.load(Ordering::Relaxed);
    println!("{reached} of {cases} cases got as far as the search");
    assert!(told.is_empty(), "{} of {cases} cases:\n{}", told.len(), told.join("\n"));
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
