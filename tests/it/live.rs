//! `serve` and `live` together, as their users start them: an emulated CPU on loopback, and who reads it.

use crate::command::binary;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

const PROGRAM: &str = "LD X0\nBMOV D0 D100 K100\nLDI X0\nMOV K1 D0\nEND\n";
const TABLE: &str = "instruction,on_us,off_us\n@base,qnudv\n@factor,1\n@end,3000\nBMOV,2000,1\n";

fn program() -> Command {
    binary()
}

/// A server that ends with its test.
struct Served {
    child: Child,
    address: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Starts `serve`, and waits until it listens.
fn served(directory: &Path, arguments: &[&str]) -> Served {
    std::fs::write(directory.join("a.il"), PROGRAM).expect("written");
    std::fs::write(directory.join("t.csv"), TABLE).expect("written");
    let mut child = program()
        .args(["serve", "a.il", "--dialect", "melsec-list", "--cpu", "Q26UDV", "--table", "t.csv"])
        .args(["--for", "60s"])
        .args(arguments)
        .current_dir(directory)
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let stderr = BufReader::new(child.stderr.take().expect("its messages"));
    let mut lines = stderr.lines().map_while(Result::ok);
    let line = lines.find(|line| line.starts_with("listening")).expect("it listens");
    std::thread::spawn(move || lines.for_each(drop));
    let address = line.rsplit(' ').next().expect("an address").to_owned();
    Served { child, address }
}

fn live(directory: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } =
        program().arg("live").args(arguments).current_dir(directory).output().expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (status.code(), text(stdout), text(stderr))
}

#[test]
fn scan_times_are_read_and_compare_reads_them_again() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    let served = served(at, &["--slmp", "0", "--jitter", "300us", "--set", "X0=1"]);
    let project = ["a.il", "--dialect", "melsec-list", "--cpu", "Q26UDV", "--table", "t.csv"];
    let mut arguments = project.to_vec();
    arguments.extend(["--slmp", &served.address, "--for", "1500ms", "-o", "scans.csv"]);
    arguments.push("--watch-devices");
    let (code, stdout, stderr) = live(at, &arguments);
    assert_eq!(code, Some(1), "jitter lies above the bound of the quiet program: {stderr}");
    assert!(stderr.contains("is above the bound"), "{stderr}");
    assert!(stdout.contains("read from the CPU's registers"), "{stdout}");
    assert!(
        stdout.contains("1 of 1 devices had the values of the program's worst scan"),
        "{stdout}"
    );
    let text = std::fs::read_to_string(at.join("scans.csv")).expect("the readings");
    assert!(text.lines().count() > 10, "{text}");
    assert!(text.lines().any(|line| line.ends_with(",X0=1")), "{text}");
    // Whatever was read lies where the emulated CPU's times are: 5.1 ms, up to 0.3 ms longer, in steps of 0.1 ms.
    for line in text.lines().skip(1) {
        let ms: f64 = line.split(',').nth(1).expect("a time").parse().expect("a number");
        assert!((5.0..=5.6).contains(&ms), "{line}");
    }
    let compared = program()
        .arg("compare")
        .args(project)
        .arg("scans.csv")
        .current_dir(at)
        .output()
        .expect("it starts");
    assert_eq!(compared.status.code(), Some(1));
}

#[test]
fn a_scan_near_the_bound_is_told_of() {
    let directory = tempfile::tempdir().expect("a directory");
    let served = served(directory.path(), &["--slmp", "0"]);
    let base = ["--slmp", &served.address, "--for", "300ms", "--cpu", "Q26UDV", "--bound"];
    // Without X0 a scan takes 3.1 ms.
    let (code, stdout, stderr) = live(directory.path(), &[&base[..], &["3.25ms"]].concat());
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains("came within 5 % of the bound of 3.25 ms"), "{stderr}");
    assert!(stdout.contains("- bound -"), "{stdout}");
    let (code, _, stderr) = live(directory.path(), &[&base[..], &["30ms"]].concat());
    assert_eq!((code, &*stderr), (Some(0), ""));
}

#[test]
fn each_failure_is_told_and_is_no_result() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    let nobody = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = nobody.local_addr().expect("its address").to_string();
    let (code, _, stderr) =
        live(at, &["--slmp", &address, "--timeout", "200ms", "--for", "1s", "--cpu", "Q26UDV"]);
    assert_eq!(code, Some(2));
    assert!(stderr.contains("did not answer within 200 ms"), "{stderr}");
    drop(nobody);
    let (code, _, stderr) = live(at, &["--slmp", &address, "--for", "1s"]);
    assert_eq!(code, Some(2));
    assert!(stderr.contains("refused the connection"), "{stderr}");
    let (code, _, stderr) = live(at, &["--hostlink", "no-such-device", "--for", "1s"]);
    assert_eq!(code, Some(2));
    assert!(stderr.contains("no-such-device cannot be reached"), "{stderr}");
    let (code, _, stderr) = live(at, &["--for", "1s"]);
    assert_eq!(code, Some(2), "{stderr}");
    let (code, _, stderr) = live(at, &["--slmp", &address, "--watch-devices"]);
    assert_eq!(code, Some(2));
    assert!(stderr.contains("name the program, whose worst scan"), "{stderr}");
}

#[test]
fn a_plc_in_stop_is_told_of() {
    let directory = tempfile::tempdir().expect("a directory");
    let served = served(directory.path(), &["--slmp", "0", "--stop-after", "3"]);
    std::thread::sleep(std::time::Duration::from_millis(200));
    let (code, stdout, stderr) =
        live(directory.path(), &["--slmp", &served.address, "--for", "300ms", "--ascii"]);
    assert_eq!((code, &*stdout), (Some(0), ""), "{stderr}");
    assert!(stderr.contains("the CPU is in STOP"), "{stderr}");
}

#[test]
fn a_connection_that_is_lost_is_told_of_and_made_again() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    let first = served(at, &["--slmp", "0"]);
    let address = first.address.clone();
    let (_, port) = address.rsplit_once(':').expect("a port");
    let mut live = program();
    live.args(["live", "--slmp", &address, "--cpu", "Q26UDV", "--for", "4s", "-o", "s.csv"]);
    live.args(["--timeout", "500ms"]).current_dir(at);
    let live = live.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    // It has read something.
    let file = at.join("s.csv");
    let begun = std::time::Instant::now();
    let rows = || std::fs::read_to_string(&file).unwrap_or_default().lines().count();
    while begun.elapsed() < std::time::Duration::from_secs(2) && rows() < 3 {
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    drop(first);
    std::thread::sleep(std::time::Duration::from_millis(300));
    let second = served(at, &["--slmp", port]);
    let ended = live.wait_with_output().expect("it ends");
    let stderr = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("the connection was lost after"), "{stderr}");
    assert!(stderr.contains("connected again after"), "{stderr}");
    let text = std::fs::read_to_string(&file).expect("the readings");
    let gap = text.lines().position(|line| line.starts_with("# gap: ")).expect("a gap");
    assert!(gap > 1 && text.lines().count() > gap + 2, "{text}");
    drop(second);
}

#[test]
fn a_connection_that_stays_lost_is_a_failure_with_what_was_read() {
    let directory = tempfile::tempdir().expect("a directory");
    let at = directory.path();
    // It answers for half a second alone.
    let served = served(at, &["--slmp", "0"]);
    let address = served.address.clone();
    let killer = std::thread::spawn(move || {
        std::thread::sleep(std::time::Duration::from_millis(700));
        drop(served);
    });
    let arguments = ["--slmp", &address, "--cpu", "Q26UDV", "--for", "2s", "-o", "s.csv"];
    let (code, stdout, stderr) = live(at, &arguments);
    killer.join().expect("it ended");
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("trying again"), "{stderr}");
    assert!(stdout.contains("3.1 ms") || stdout.contains("3.100 ms"), "{stdout}");
    let text = std::fs::read_to_string(at.join("s.csv")).expect("the readings");
    assert!(text.lines().last().is_some_and(|line| line.starts_with("# gap: ")), "{text}");
}
