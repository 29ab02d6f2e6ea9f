//! Times whole audits, from reading to report, of programs of growing size.
//!
//! `cargo bench --bench audit` writes the tables of docs/performance.md anew that are between marks of this program's.
//!
//! `cargo bench --bench audit -- DIRECTORY [LARGEST]` prints rows only, and leaves the programs in the directory, where
//! `tests/peers.py` can set RC2 on the same questions; `LARGEST` is the largest size of a pool (6000).
//!
//! Linux only: processor seconds are read from /proc.
#![allow(clippy::print_stdout)]

#[path = "common/page.rs"]
mod page;
#[path = "common/plant.rs"]
mod plant;
#[path = "common/pools.rs"]
mod pools;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// The size of the largest pools.
const ALL: u32 = 20_000;

/// The size of the pools that are audited in too short a time.
const SHORT: u32 = 6000;

fn main() {
    let (flags, arguments): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|argument| argument == "--bench");
    if let Some(directory) = arguments.first() {
        let largest = arguments.get(1).and_then(|text| text.parse().ok()).unwrap_or(6000);
        all(Path::new(directory), largest);
    } else if !flags.is_empty() {
        // Not as a test: tests change nothing.
        let directory = tempfile::tempdir().expect("a directory can be made");
        let (whole, short) = all(directory.path(), ALL);
        page::rewrite("performance.md", &[("whole audits", &whole), ("short of time", &short)]);
    }
}

/// Audits everything, in the directory: the rows of whole audits, and those of audits that are short of time.
fn all(directory: &Path, largest: u32) -> (Vec<String>, Vec<String>) {
    let (mut whole, mut short) = (Vec::new(), Vec::new());
    std::fs::create_dir_all(directory).expect("the directory can be made");
    for (size, seeds) in [(600, 5), (2000, 5), (SHORT, 3), (ALL, 1)] {
        for seed in (1..=seeds).filter(|_| size <= largest) {
            let (text, table) = pools::pools(size, seed);
            let name = format!("pools-{size}-{seed}");
            let program = write(directory, &format!("{name}.il"), &text);
            let table = write(directory, &format!("{name}.csv"), &table);
            let table = table.to_string_lossy();
            let options = ["--cpu", "Q26UDV", "--table", &table];
            whole.push(told(&Audited::run(&program, "300s", &options).row(&name)));
            if size == SHORT {
                let audited = Audited::run(&program, "500ms", &options);
                short.push(told(&audited.short_row(&name)));
            }
        }
    }
    for stations in [1, 2, 4, 8, 16, 25, 32, 64] {
        let name = format!("plant-{stations}");
        let project = directory.join(&name);
        std::fs::create_dir_all(&project).expect("the directory can be made");
        for (station, text) in plant::plant(stations, 1).iter().enumerate() {
            write(&project, &format!("station{station:03}.il"), text);
        }
        let audited = Audited::run(&project, "300s", &["--cpu", "Q26UDV"]);
        whole.push(told(&audited.row(&name)));
    }
    (whole, short)
}

/// Prints a row while the others are still measured.
fn told(row: &str) -> String {
    println!("{row}");
    row.to_owned()
}

fn write(directory: &Path, name: &str, text: &str) -> PathBuf {
    let path = directory.join(name);
    std::fs::write(&path, text).expect("the file can be written");
    path
}

/// What an audit took and found.
struct Audited {
    processor: f64,
    wall: f64,
    instructions: u64,
    upper: u64,
    lower: u64,
}

impl Audited {
    fn run(program: &Path, limit: &str, options: &[&str]) -> Audited {
        let (processor, begin) = (children_seconds(), Instant::now());
        let audit = Command::new(env!("CARGO_BIN_EXE_scanbound"))
            .args(["audit", "--format", "json", "--time-limit", limit])
            .args(options)
            .arg(program)
            .output()
            .expect("scanbound runs");
        let (wall, processor) = (begin.elapsed().as_secs_f64(), children_seconds() - processor);
        let report = String::from_utf8_lossy(&audit.stdout);
        let number = |key: &str| {
            let after = report.split_once(&format!("\"{key}\":")).map_or("", |(_, after)| after);
            let digits = after.trim_start().chars().take_while(char::is_ascii_digit);
            digits.collect::<String>().parse::<u64>().unwrap_or(0)
        };
        let (instructions, upper, lower) =
            (number("instructions"), number("upper_ps"), number("lower_ps"));
        Audited { processor, wall, instructions, upper, lower }
    }

    /// How far the bounds are apart, in percent.
    fn gap(&self) -> f64 {
        (self.upper - self.lower) as f64 * 100.0 / self.upper.max(1) as f64
    }

    fn row(&self, name: &str) -> String {
        let exact = match self.upper == self.lower {
            true => "exact".to_owned(),
            false => format!("gap {:.2} %", self.gap()),
        };
        let Audited { processor, wall, instructions, .. } = self;
        format!("| {name} | {instructions} | {processor:.2} | {wall:.2} | {exact} |")
    }

    fn short_row(&self, name: &str) -> String {
        let ms = |ps: u64| ps as f64 / 1e9;
        let (upper, lower, gap) = (ms(self.upper), ms(self.lower), self.gap());
        format!("| {name} | {upper:.3} ms | {lower:.3} ms | {gap:.1} % |")
    }
}

/// The processor time that finished children took, in user mode.
fn children_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name in brackets come the third field and so on; the sixteenth counts hundredths of seconds.
    let rest = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks = rest.split_whitespace().nth(13).and_then(|ticks| ticks.parse::<f64>().ok());
    ticks.unwrap_or(0.0) / 100.0
}
