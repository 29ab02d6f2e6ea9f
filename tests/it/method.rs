//! The search as its users see it: which one found a maximum, its steps, and what a second solver says.

use crate::command::binary;
use serde_json::Value;
use std::process::Output;
use unicode_width::UnicodeWidthStr;

const SAMPLES: [&[&str]; 5] = [
    &["samples/paper/program.il", "--table", "samples/paper/table.csv"],
    &["samples/filler"],
    &["samples/transfer-line/line.il", "--cpu", "Q26UDV"],
    &["samples/drives/drives.il", "--cpu", "FX3U"],
    &["samples/sorter/sorter.cxt"],
];

fn scanbound(arguments: &[&str]) -> Output {
    binary().args(arguments).output().expect("the program starts")
}

/// What a command says on stderr, without how long questions took.
fn trace(arguments: &[&str]) -> String {
    let output = scanbound(arguments);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code().is_some_and(|code| code != 2 && code != 70), "{told}");
    without_times(&told)
}

fn without_times(text: &str) -> String {
    let words = text.split_inclusive([' ', '\n']).collect::<Vec<_>>();
    let timed = |index: usize| words.get(index + 1).is_some_and(|next| next.trim() == "ms");
    let shown = words.iter().enumerate().filter(|&(index, word)| {
        let time = timed(index) && word.trim().parse::<f64>().is_ok();
        !time && !word.trim().is_empty()
    });
    shown.map(|(_, word)| *word).collect()
}

fn json(arguments: &[&str]) -> Value {
    let output = scanbound(&[arguments, &["--format", "json"]].concat());
    let told = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{arguments:?}: {told}"))
}

#[test]
fn a_trace_is_readable_and_does_not_depend_on_threads() {
    for sample in SAMPLES {
        for method in ["auto", "cores", "subsets"] {
            let with = |jobs: &str| {
                let own = ["--trace-search", "--method", method, "--jobs", jobs];
                trace(&[&["audit"], sample, &own].concat())
            };
            let alone = with("1");
            assert!(alone.contains("Search of group 1"), "{alone}");
            assert_eq!(alone, with("2"), "{sample:?}");
            if method != "cores" {
                assert!(alone.contains("T_MAX"), "{alone}");
            }
        }
        let output = scanbound(&[&["audit"], sample, &["--trace-search"]].concat());
        let told = String::from_utf8_lossy(&output.stderr);
        // Instructions are shown whole, however long they are.
        let long: Vec<&str> = told
            .lines()
            .filter(|line| line.width() > 80 && !line.starts_with("    rung"))
            .collect();
        assert!(long.is_empty(), "{sample:?}: {long:#?}");
    }
}

#[test]
fn a_trace_in_a_file_is_whole_and_leaves_the_report_alone() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("trace.txt");
    let option = format!("--trace-search={}", file.display());
    let plain = scanbound(&[&["audit"], SAMPLES[1]].concat());
    let traced = scanbound(&[&["audit"], SAMPLES[1], &[option.as_str()]].concat());
    assert_eq!(plain.stdout, traced.stdout);
    assert!(traced.stderr.is_empty());
    let text = std::fs::read_to_string(&file).expect("a trace");
    assert!(text.contains("Search of group 7"), "{text}");
    assert!(!text.contains("\u{1b}["), "no colours in a file");
    // A file that cannot be written is told before the work is done, and nothing is written.
    let nowhere = scanbound(&[&["audit"], SAMPLES[0], &["--trace-search=no/where.txt"]].concat());
    assert_eq!(nowhere.status.code(), Some(2));
    assert!(nowhere.stdout.is_empty());
}

#[test]
fn check_and_compare_trace_and_confirm_too() {
    let own = ["--trace-search", "--confirm"];
    let check = [&["check"], SAMPLES[0], &["--limit", "1ms"], &own].concat();
    let compare = [
        &["compare", "samples/minasec-u/test-program.asm", "tests/cli/minasec.in/scans.csv"],
        &own[..],
    ]
    .concat();
    assert!(trace(&check).contains("Search of group 1"));
    assert!(trace(&compare).contains("There is nothing to search"), "{}", trace(&compare));
    let report = json(&check);
    assert_eq!(report["groups"][0]["confirmed"], "yes");
    assert_eq!(report["check"]["verdict"], "proved");
}

#[test]
fn small_groups_are_searched_by_subsets_and_large_ones_by_cores() {
    let methods = |report: &Value| -> Vec<String> {
        let groups = report["groups"].as_array().expect("groups");
        groups.iter().map(|group| group["method"].as_str().expect("a method").to_owned()).collect()
    };
    assert_eq!(methods(&json(&[&["audit"], SAMPLES[0]].concat())), ["subsets"; 2]);
    let cores = [&["audit"], SAMPLES[0], &["--method", "cores"]].concat();
    assert_eq!(methods(&json(&cores)), ["cores"; 2]);
    // Forty steps that exclude each other.
    let directory = tempfile::tempdir().expect("a directory");
    let program = directory.path().join("steps.il");
    let step = |n: u32| format!("LD= D0 K{n}\nBMOV D{} D1000 K{}\n", 100 + n, 2 + n);
    let text: String = (0..40).map(step).collect();
    std::fs::write(&program, text + "END\n").expect("written");
    let program = program.to_str().expect("a plain path");
    let report = json(&["audit", program, "--cpu", "Q26UDV", "--confirm"]);
    assert_eq!(methods(&report), ["cores"]);
    assert_eq!(report["groups"][0]["confirmed"], "yes");
    assert_eq!(report["scan"]["exact"], true);
    let told = trace(&["audit", program, "--cpu", "Q26UDV", "--trace-search"]);
    assert!(told.contains("not together"), "{told}");
    assert!(told.contains("the bounds meet at"), "{told}");
}

#[test]
fn every_sample_is_confirmed_whichever_search_it_was() {
    for sample in SAMPLES {
        let mut bounds = Vec::new();
        for method in ["auto", "cores", "subsets"] {
            let report = json(&[&["audit"], sample, &["--confirm", "--method", method]].concat());
            let groups = report["groups"].as_array().expect("groups");
            assert!(groups.iter().all(|group| group["confirmed"] == "yes"), "{sample:?}");
            bounds.push(report["scan"]["upper_ps"].clone());
        }
        assert!(bounds.iter().all(|bound| *bound == bounds[0]), "{sample:?}: {bounds:?}");
    }
}
