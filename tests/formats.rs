//! Several reports of one run, each read back by what reads it elsewhere; the difference of two versions; project files.

use quick_junit::{Report, TestCaseStatus};
use serde_json::Value;
use serde_sarif::sarif::Sarif;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn scanbound(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .args(arguments)
        .current_dir(directory)
        .output()
        .expect("the program starts")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A small program, one that costs more, and what they need.
const OLD: &str = "LD X0\nMOV K1 D0\nLD X1\nOUT Y1\nLD X2\nBMOV D0 D100 K20\nLD X3\nOUT Y3\nEND\n";
const NEW: &str = "LD X3\nOUT Y3\nLD X0\nMOV K1 D0\nLD X1\nOUT Y1\nLD X2\nBMOV D0 D100 K400\nEND\n";
const FACTS: &str = "[io]\ninputs = 16\noutputs = 16\n";

fn project() -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a directory");
    for (name, text) in [("old.il", OLD), ("new.il", NEW), ("facts.toml", FACTS)] {
        fs::write(directory.path().join(name), text).expect("written");
    }
    directory
}

const HOW: [&str; 4] = ["--cpu", "Q26UDV", "--facts", "facts.toml"];

#[test]
fn one_run_writes_every_format_by_its_suffix() {
    let directory = project();
    let names = ["a.json", "a.csv", "a.sarif", "b.sarif.json", "a.xml", "a.md", "a.txt"];
    for (limit, code, failures) in [("10ms", 0, 0), ("1us", 1, 1)] {
        let outputs = names.iter().flat_map(|name| ["-o", name]);
        let command: Vec<&str> =
            ["check", "old.il", "--limit", limit].into_iter().chain(HOW).chain(outputs).collect();
        let output = scanbound(&command, directory.path());
        assert_eq!(output.status.code(), Some(code), "{}", told(&output));
        assert!(output.stdout.is_empty());
        let verdict = if code == 0 { "PROVED: " } else { "REFUTED: " };
        assert!(told(&output).starts_with(verdict), "{}", told(&output));
        let read = |name: &str| fs::read_to_string(directory.path().join(name)).expect(name);
        for name in ["a.sarif", "b.sarif.json"] {
            let log: Sarif = serde_json::from_str(&read(name)).expect("SARIF");
            assert_eq!(log.version, "2.1.0");
            let results = log.runs[0].results.as_ref().expect("results");
            let errors = results
                .iter()
                .filter(|one| one.level == Some(serde_sarif::sarif::ResultLevel::Error));
            assert_eq!(errors.count(), failures);
        }
        let report = Report::deserialize_from_str(&read("a.xml")).expect("JUnit");
        assert_eq!((report.tests, report.failures), (1, failures));
        let status = &report.test_suites[0].test_cases[0].status;
        assert_eq!(matches!(status, TestCaseStatus::Success { .. }), failures == 0);
        let json: Value = serde_json::from_str(&read("a.json")).expect("JSON");
        assert_eq!(json["schema"], "scanbound.audit/1");
        assert!(read("a.md").contains(&format!("**{}**", verdict.trim_end_matches(": "))));
        assert!(read("a.txt").starts_with(verdict));
        assert!(read("a.csv").contains("BMOV D0 D100 K20"));
    }
}

#[test]
fn annotations_name_the_file_and_the_line() {
    let directory = project();
    let command = [&["check", "old.il", "--limit", "1us", "--format", "github"][..], &HOW].concat();
    let output = scanbound(&command, directory.path());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let begins = "::error file=old.il,title=scanbound limit-refuted,line=";
    assert!(text.starts_with(begins) && text.contains("::REFUTED: a scan takes "), "{text}");
    assert!(text.lines().all(|line| line.starts_with("::")));
}

#[test]
fn two_versions_differ_by_what_their_rungs_say() {
    let directory = project();
    let files = [
        "-o", "d.json", "-o", "d.csv", "-o", "d.sarif", "-o", "d.xml", "-o", "d.md", "-o", "d.txt",
    ];
    for (most, code) in [("0.5%", 1), ("5%", 0)] {
        let command =
            [&["diff", "old.il", "new.il", "--fail-above", most][..], &HOW, &files].concat();
        let output = scanbound(&command, directory.path());
        assert_eq!(output.status.code(), Some(code), "{}", told(&output));
        assert!(told(&output).starts_with("The bound rises from "), "{}", told(&output));
        let read = |name: &str| fs::read_to_string(directory.path().join(name)).expect(name);
        let json: Value = serde_json::from_str(&read("d.json")).expect("JSON");
        let changes = json["changes"].as_array().expect("changes");
        let ps = |value: &Value| value.as_i64().expect("a time");
        let sum: i64 = changes.iter().map(|change| ps(&change["delta_ps"])).sum();
        assert_eq!(sum + ps(&json["besides_ps"]), ps(&json["delta_ps"]));
        assert_eq!(
            ps(&json["new"]["upper_ps"]) - ps(&json["old"]["upper_ps"]),
            ps(&json["delta_ps"])
        );
        let kinds: Vec<&str> =
            changes.iter().filter_map(|change| change["kind"].as_str()).collect();
        assert_eq!(kinds, ["changed", "moved"]);
        assert_eq!(changes[0]["new"]["line"], 7);
        assert!(
            read("d.txt").contains("new.il:7, changed: BMOV D0 D100 K20 became BMOV D0 D100 K400")
        );
        let report = Report::deserialize_from_str(&read("d.xml")).expect("JUnit");
        assert_eq!(report.failures, usize::from(code == 1));
        let log: Sarif = serde_json::from_str(&read("d.sarif")).expect("SARIF");
        assert_eq!(log.runs[0].results.as_ref().expect("results").len(), 2);
        // A spreadsheet adds the differences up, as numbers.
        let csv = read("d.csv");
        let table = csv.strip_prefix('\u{FEFF}').expect("a mark");
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let numbers = reader.records().map(|row| row.expect("a row")[1].parse::<f64>());
        assert!(numbers.collect::<Result<Vec<_>, _>>().is_ok(), "{csv}");
    }
    let same = [&["diff", "old.il", "old.il", "--fail-above", "0%"][..], &HOW].concat();
    let output = scanbound(&same, directory.path());
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&output.stdout).starts_with("The bound stays at "));
    let one = scanbound(&["diff", "old.il"], directory.path());
    assert_eq!(one.status.code(), Some(2));
}

#[test]
fn a_scan_that_may_never_end_is_above_whatever_is_allowed() {
    let directory = project();
    let main = "LBL0: AND 1\nCJP LBL1\nGJ\nJMP LBL0\nLBL1: GS 0\nGJ\nJMP LBL0\nGN 0\nLBL5: ";
    for (name, group) in [("ends.lst", "TIM 10 #30\nWAIT\nOUT 200\n"), ("round.lst", "OUT 200\n")] {
        let text = format!("{main}{group}JMP LBL5\n");
        fs::write(directory.path().join(name), text).expect("written");
    }
    for (new, code) in [("round.lst", 1), ("ends.lst", 0)] {
        let command = ["diff", "ends.lst", new, "--fail-above", "100%", "--format", "json"];
        let output = scanbound(&command, directory.path());
        assert_eq!(output.status.code(), Some(code), "{}", told(&output));
        let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let is_endless = Value::from(code == 1);
        assert_eq!((&json["endless"], &json["above_allowed"]), (&is_endless, &is_endless));
        // Of the scans that end the bound is no higher.
        assert!(json["delta_ps"].as_i64() <= Some(0), "{json}");
    }
}

#[test]
fn a_project_file_stands_for_arguments() {
    let directory = project();
    let common = "cpu = \"Q26UDV\"\nfacts = \"../facts.toml\"\nprograms = [\"../old.il\"]\n";
    for (name, limit) in
        [("good", "limit = \"watchdog\"\n"), ("bad", "limit = \"1us\"\n"), ("none", "")]
    {
        let place = directory.path().join(name);
        fs::create_dir(&place).expect("a directory");
        fs::write(place.join("scanbound.toml"), format!("{common}{limit}")).expect("written");
    }
    let code = |arguments: &[&str], place: &str| {
        let output = scanbound(arguments, &directory.path().join(place));
        (
            output.status.code(),
            format!("{}{}", String::from_utf8_lossy(&output.stdout), told(&output)),
        )
    };
    let (proved, text) = code(&["check"], "good");
    assert_eq!(proved, Some(0), "{text}");
    assert!(text.contains("the limit is 200 ms"), "{text}");
    assert_eq!(code(&["check"], "bad").0, Some(1));
    assert_eq!(code(&["check", "--limit", "1s"], "bad").0, Some(0));
    assert_eq!(code(&["audit"], "bad").0, Some(0));
    let (none, text) = code(&["check"], "none");
    assert_eq!(none, Some(2));
    assert!(text.contains("limit = "), "{text}");
    let (no_file, text) = code(&["check", "--limit", "1s"], ".");
    assert_eq!(no_file, Some(2));
    assert!(text.contains("scanbound.toml"), "{text}");
    // Of all the gravest counts: the one without a limit.
    assert_eq!(code(&["check", "--all"], ".").0, Some(2));
    fs::remove_dir_all(directory.path().join("none")).expect("removed");
    let (all, text) = code(&["check", "--all"], ".");
    assert_eq!(all, Some(1), "{text}");
    assert!(text.contains("good/scanbound.toml") && text.contains("bad/scanbound.toml"), "{text}");
}
