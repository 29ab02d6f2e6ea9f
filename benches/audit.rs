//! Times whole audits, from reading to report, of programs of growing size: `cargo bench --bench audit -- DIRECTORY [LARGEST]`.
//!
//! Writes the programs to the directory, where `tests/peers.py` can set RC2 on the same questions, and prints a
//! row of the tables in docs/performance.md for each: processor seconds and wall seconds of the audit, and
//! whether its bound is exact. Linux only: processor seconds are read from /proc.
#![allow(clippy::print_stdout)]

#[path = "common/plant.rs"]
mod plant;
#[path = "common/pools.rs"]
mod pools;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let Some(directory) = arguments.first().map(PathBuf::from) else {
        println!("usage: cargo bench --bench audit -- DIRECTORY [LARGEST]");
        return;
    };
    let largest = arguments.get(1).and_then(|text| text.parse().ok()).unwrap_or(6000);
    std::fs::create_dir_all(&directory).expect("the directory can be made");
    for (size, seeds) in [(600, 5), (2000, 5), (6000, 3), (20_000, 1)] {
        for seed in (1..=seeds).filter(|_| size <= largest) {
            let (text, table) = pools::pools(size, seed);
            let name = format!("pools-{size}-{seed}");
            let program = write(&directory, &format!("{name}.il"), &text);
            let table = write(&directory, &format!("{name}.csv"), &table);
            let table = table.to_string_lossy();
            audit(&name, &program, &["--cpu", "Q26UDV", "--table", &table]);
        }
    }
    for stations in [1, 2, 4, 8, 16, 25, 32, 64] {
        let name = format!("plant-{stations}");
        let project = directory.join(&name);
        std::fs::create_dir_all(&project).expect("the directory can be made");
        for (station, text) in plant::plant(stations, 1).iter().enumerate() {
            write(&project, &format!("station{station:03}.il"), text);
        }
        audit(&name, &project, &["--cpu", "Q26UDV"]);
    }
}

fn write(directory: &Path, name: &str, text: &str) -> PathBuf {
    let path = directory.join(name);
    std::fs::write(&path, text).expect("the file can be written");
    path
}

fn audit(name: &str, program: &Path, options: &[&str]) {
    let (processor, begin) = (children_seconds(), Instant::now());
    let audit = Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .args(["audit", "--format", "json", "--time-limit", "300s"])
        .args(options)
        .arg(program)
        .output()
        .expect("scanbound runs");
    let (wall, processor) = (begin.elapsed().as_secs_f64(), children_seconds() - processor);
    let report = String::from_utf8_lossy(&audit.stdout);
    let number = |key: &str| {
        let after = report.split_once(&format!("\"{key}\":")).map_or("", |(_, after)| after);
        let digits: String = after.trim_start().chars().take_while(char::is_ascii_digit).collect();
        digits.parse::<u64>().unwrap_or(0)
    };
    let (upper, lower) = (number("upper_ps"), number("lower_ps"));
    let gap = (upper - lower) as f64 * 100.0 / upper.max(1) as f64;
    let exact = if upper == lower { "exact".to_owned() } else { format!("gap {gap:.2} %") };
    let instructions = number("instructions");
    println!("| {name} | {instructions} | {processor:.2} | {wall:.2} | {exact} |");
}

/// The processor time that finished children took, in user mode.
fn children_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name in brackets come the third field and so on; the sixteenth counts hundredths of seconds.
    let rest = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks = rest.split_whitespace().nth(13).and_then(|ticks| ticks.parse::<f64>().ok());
    ticks.unwrap_or(0.0) / 100.0
}
