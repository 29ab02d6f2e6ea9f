//! Compares, for every sample, what adding up the table gives with the bound and with the longest scan found, and
//! emulated MINASEC-U captures with their bound.
//!
//! `cargo bench --bench evaluation` writes the tables of docs/evaluation.md anew. Linux only: peak memory is read from
//! /proc.
#![allow(clippy::print_stdout)]

#[path = "common/page.rs"]
mod page;

use scanbound::audit::{Request, ready};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::input::{Ignore, gather};
use scanbound::timing::table::Table;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Each sample: its path below `samples`, and the options with which it is audited.
const SAMPLES: &[(&str, &[&str])] = &[
    ("paper/program.il", &["--table", "samples/paper/table.csv"]),
    ("transfer-line/line.il", &["--cpu", "Q26UDV", "--facts", "samples/transfer-line/facts.toml"]),
    ("filler", &[]),
    ("drives/drives.il", &["--cpu", "FX3U"]),
    ("recipes", &["--facts", "samples/recipes/facts.toml"]),
    ("sorter/sorter.il", &["--cpu", "CJ2M"]),
    ("sorter/sorter.cxt", &[]),
    ("snet/self-holding.il", &["--cpu", "C200H"]),
    ("snet/carousel-work.il", &["--cpu", "C200H"]),
    ("snet/robot-work.il", &["--cpu", "C200H"]),
    ("sfc/line.st", &[]),
    ("sfc/macros.xml", &[]),
    ("flowchart/delay-group.lst", &[]),
    ("flowchart/flip-flop-wait.lst", &[]),
    ("flowchart/interval-group.lst", &[]),
    ("flowchart/repeat-group.lst", &[]),
    ("flowchart/self-holding-stop.lst", &[]),
    ("flowchart/star-delta.lst", &[]),
    ("flowchart/star-delta-group.lst", &[]),
    ("flowchart/traffic-signals.lst", &[]),
    ("minasec-u/test-program.asm", &[]),
];

/// The program whose emulated captures are compared with its bound, and its plant.
const MACHINE: [&str; 2] =
    ["samples/minasec-u/test-program.asm", "samples/minasec-u/test-program.stimulus.csv"];

/// Boards: what is said of each, the options of the emulated machine, and those of the bound.
const BOARDS: &[(&str, &[&str], &[&str])] = &[
    ("the nominal clock, fast", &[], &[]),
    (
        "a clock up to 5 % off, which trembles by 1 %",
        &["--tolerance", "5%", "--jitter", "1%", "--seed", "3"],
        &[],
    ),
    ("the nominal clock, slow", &["--clock", "slow"], &["--clock", "slow"]),
];

fn main() {
    // Not as a test: tests change nothing.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    std::env::set_current_dir(env!("CARGO_MANIFEST_DIR")).expect("the repository is there");
    let samples: Vec<String> = SAMPLES.iter().map(|sample| told(sample_row(sample))).collect();
    let boards: Vec<String> = BOARDS.iter().map(|board| told(board_row(board))).collect();
    page::rewrite("evaluation.md", &[("samples", &samples), ("captures", &boards)]);
}

/// Prints a row while the others are still measured.
fn told(row: String) -> String {
    println!("{row}");
    row
}

fn sample_row((name, options): &(&str, &[&str])) -> String {
    let path = Path::new("samples").join(name);
    let run = Run::of("audit", &[path.as_os_str().to_str().expect("a name in ASCII")], options);
    let scan = &run.json["scan"];
    let ps = |key: &str| Picos(scan[key].as_u64().unwrap_or(0));
    let (upper, lower) = (ps("upper_ps"), ps("lower_ps"));
    let ratio = upper.0 as f64 / lower.0.max(1) as f64;
    let (naive, structural) = (naive_sum(&path, options), ps("naive_ps"));
    let Run { seconds, megabytes, .. } = run;
    format!(
        "| {name} | {naive} | {structural} | {upper} | {lower} | {ratio:.2} | {seconds:.2} | {megabytes} |"
    )
}

/// Every instruction of the program once, at the larger of its two times, and the overhead of a scan.
fn naive_sum(path: &Path, options: &[&str]) -> Picos {
    let value = |option: &str| {
        let at = options.iter().position(|one| *one == option)?;
        options.get(at + 1).copied()
    };
    let text = |file: &str| std::fs::read_to_string(file).expect("the sample's file can be read");
    let ignored = Ignore::parse(std::iter::empty()).expect("no pattern");
    let gathered = gather(&[PathBuf::from(path)], &ignored).expect("the sample can be read");
    let facts = value("--facts")
        .map(|file| Facts::parse(file, &text(file)).expect("the sample's facts"))
        .unwrap_or_default();
    let table = value("--table")
        .map(|file| Table::parse(file, text(file).as_bytes()).expect("the sample's table").table);
    let request = Request {
        cpu: value("--cpu"),
        table: table.as_ref(),
        ..Request::new(&gathered.inputs, &facts)
    };
    let prices = ready(&request).expect("the sample has a price").prices;
    prices.overhead_sum()
        + prices.times().iter().map(|times| times.on.max(times.off)).sum::<Picos>()
}

fn board_row((what, emulated, bound): &(&str, &[&str], &[&str])) -> String {
    let directory = tempfile::tempdir().expect("a directory can be made");
    let trace = directory.path().join("trace.csv");
    let trace = trace.to_str().expect("a name in ASCII");
    let [program, stimulus] = MACHINE;
    let made = Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .args(["emulate", program, "--stimulus", stimulus, "--for", "30s", "--trace", trace])
        .args(*emulated)
        .output()
        .expect("scanbound runs");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let Run { json, .. } = Run::of("compare", &[program, trace], bound);
    let [scans, upper] = [&json["scans"], &json["bound"]["upper_ps"]];
    let ps = |value: &Value| Picos(value.as_u64().unwrap_or(0));
    let (least, most, upper) = (ps(&scans["min_ps"]), ps(&scans["max_ps"]), ps(upper));
    let share = most.0 as f64 * 100.0 / upper.0.max(1) as f64;
    let count = &scans["count"];
    format!("| {what} | {count} | {least} | {most} | {upper} | {share:.1} % |")
}

/// A command that was run: its JSON, its time, and its largest memory.
struct Run {
    json: Value,
    seconds: f64,
    megabytes: u64,
}

impl Run {
    fn of(command: &str, files: &[&str], options: &[&str]) -> Run {
        let begin = Instant::now();
        let mut child = Command::new(env!("CARGO_BIN_EXE_scanbound"))
            .args([command, "--format", "json"])
            .args(files)
            .args(options)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("scanbound runs");
        let status = format!("/proc/{}/status", child.id());
        let mut out = child.stdout.take().expect("a pipe");
        let reader = std::thread::spawn(move || {
            let mut text = String::new();
            std::io::Read::read_to_string(&mut out, &mut text).map(|_| text)
        });
        let mut kilobytes = 0;
        while child.try_wait().expect("the child can be waited for").is_none() {
            let text = std::fs::read_to_string(&status).unwrap_or_default();
            let peak = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let peak = peak.and_then(|peak| peak.split_whitespace().next()?.parse::<u64>().ok());
            kilobytes = kilobytes.max(peak.unwrap_or(0));
            std::thread::sleep(Duration::from_millis(1));
        }
        let seconds = begin.elapsed().as_secs_f64();
        let text = reader.join().expect("the reader ends").expect("the report is UTF-8");
        let json = serde_json::from_str(&text).expect("the report is JSON");
        Run { json, seconds, megabytes: kilobytes.div_ceil(1024) }
    }
}
