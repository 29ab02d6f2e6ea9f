//! Runs from power-up to the scan that refutes a limit: told where there is one, never of a state that none leads to.

use crate::command::binary;
use serde_json::Value;
use std::io::Write as _;
use std::process::Output;

fn run(arguments: &[&str], text: &str) -> Output {
    let mut file = tempfile::Builder::new().suffix(".il").tempfile().expect("a file");
    file.write_all(text.as_bytes()).expect("written");
    binary()
        .args(arguments)
        .args(["--time", "SwOp0=1ms/0us"])
        .arg(file.path())
        .output()
        .expect("it runs")
}

/// The report on a MELSEC program.
fn audit(lines: &[&str]) -> Value {
    let text = format!("{}\nEND\n", lines.join("\n"));
    let output = run(&["audit", "--cpu", "Q26UDV", "--format", "json"], &text);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// The inputs of each scan of the run, if one was found.
fn inputs(report: &Value) -> Option<Vec<Value>> {
    let scans = report.get("witness_run")?.as_array()?;
    let last = scans.last().expect("a scan")["took_ps"].as_u64();
    assert!(last >= report["scan"]["lower_ps"].as_u64(), "the last one takes as long");
    assert_eq!(report["scan"]["lower_kind"], "reached");
    Some(scans.iter().map(|scan| scan["inputs"].clone()).collect())
}

#[test]
fn a_relay_that_an_earlier_scan_leaves_on_is_led_up_to() {
    let report = audit(&["LD M1", "SwOp0", "LD X0", "AND X1", "OUT M1"]);
    let scans = inputs(&report).expect("a run");
    assert_eq!(scans.len(), 2);
    assert_eq!(scans[0]["X0"], true);
    assert_eq!(scans[0]["X1"], true);
}

#[test]
fn the_first_scan_is_one() {
    let report = audit(&["LD SM402", "SwOp0", "LD SM403", "AND X0", "SwOp0"]);
    assert_eq!(inputs(&report).map(|scans| scans.len()), Some(1));
}

#[test]
fn a_counter_is_counted_up_to() {
    let report = audit(&["LD C0", "SwOp0", "LD X0", "OUT C0 K2"]);
    let scans = inputs(&report).expect("a run");
    let rises = (0..scans.len()).filter(|&at| {
        let is_on = |at: usize| scans[at]["X0"] == true;
        is_on(at) && (at == 0 || !is_on(at - 1))
    });
    assert!(rises.count() >= 2, "{scans:?}");
}

#[test]
fn an_edge_needs_the_scan_before() {
    let report = audit(&["LDP X0", "SwOp0"]);
    let scans = inputs(&report).expect("a run");
    let [.., before, last] = &scans[..] else { panic!("two scans at least: {scans:?}") };
    assert_eq!((before.get("X0"), last.get("X0")), (None, Some(&Value::Bool(true))));
}

#[test]
fn what_no_run_leads_to_is_admissible_only() {
    let exclusive = ["LD M0", "AND M1", "SwOp0", "LD X0", "OUT M0", "LDI X0", "OUT M1"];
    let kept = ["LD M5", "SwOp0", "LD M5", "OUT M5"];
    let latched_apart = ["LD> D0 K9", "SwOp0", "LD X0", "MOV K5 D0"];
    let linked = ["LD B0", "SwOp0"];
    let written_input = ["LD X0", "SwOp0", "LD X1", "RST X0"];
    for lines in [&exclusive[..], &kept, &latched_apart, &linked, &written_input] {
        let report = audit(lines);
        assert_eq!(report["scan"]["lower_kind"], "admissible", "{lines:?}");
        assert_eq!(inputs(&report), None, "{lines:?}");
    }
}

#[test]
fn refuting_by_reached_scans_needs_a_run() {
    let check = |lines: &str, reached: bool| {
        let limit = ["check", "--cpu", "Q26UDV", "--limit", "1ms"];
        let more: &[&str] = if reached { &["--refute", "reached"] } else { &[] };
        let output = run(&[&limit, more].concat(), lines);
        let text = String::from_utf8(output.stdout).expect("text");
        // The verdict is wrapped; a blank line ends it.
        let verdict = text.lines().take_while(|line| !line.is_empty()).collect::<Vec<_>>();
        (output.status.code(), verdict.join(" "))
    };
    let possible = "LD X0\nSwOp0\nEND\n";
    let (code, text) = check(possible, false);
    assert_eq!(code, Some(1));
    assert!(!text.contains("unless"), "{text}");
    assert_eq!(check(possible, true).0, Some(1));
    let impossible = "LD M5\nSwOp0\nEND\n";
    let (code, text) = check(impossible, false);
    assert_eq!(code, Some(1));
    assert!(text.contains("no run from power-up to its start state was found"), "{text}");
    assert_eq!(check(impossible, true).0, Some(3));
}

#[test]
fn omron_inputs_are_the_words_that_the_program_does_not_write() {
    let audit = |text: &str| -> Value {
        let output =
            run(&["audit", "--cpu", "CJ2M", "--dialect", "omron-cx", "--format", "json"], text);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let report = audit("LD 100.00\nSwOp0\nLD 0.00\nOUT 100.00\nEND\n");
    assert_eq!(inputs(&report).map(|scans| scans.len()), Some(2));
    let report = audit("LD W0.00\nSwOp0\nLD 0.00\nOUT 100.00\nEND\n");
    assert_eq!(inputs(&report), None);
}

#[test]
fn the_first_scan_of_an_omron_cpu_is_led_up_to() {
    // DM0100 to DM0139 are too many words to decide whether a scan starts with their values.
    let list = "LD 03000\nXFER(70) #0040 DM0000 DM0100\nLD 25315\nOR 03000\nOUT 03000\nEND\n";
    let output = run(&["audit", "--cpu", "C200H", "--trust", "all", "--format", "json"], list);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(inputs(&report).map(|scans| scans.len()), Some(2), "{report}");
    assert_eq!(report["scan"]["exact"], true, "{report}");
    // The flag is off in the scans that follow.
    let list = list.replace("LD 03000", "LD 25315\nAND 03000");
    let output = run(&["audit", "--cpu", "C200H", "--trust", "all", "--format", "json"], &list);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(report["scan"]["lower_ps"].as_u64() < report["scan"]["upper_ps"].as_u64(), "{report}");
}
