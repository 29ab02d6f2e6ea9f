//! docs/json.md against the JSON that is written: every key is documented, and what is documented is written.

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Keys whose own keys are names of the program's.
const MAPS: [&str; 2] = ["witness", "witness_run.inputs"];

/// Documented keys that none of the reports below holds.
const UNSEEN: [&str; 0] = [];

/// The JSON of a command on files under the repository.
fn json(arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .args(arguments)
        .args(["--format", "json"])
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")))
        .output()
        .expect("the program starts");
    let told = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{arguments:?}: {told}"))
}

/// The keys of a value as paths, lists looked into: `groups.charges.line`.
fn keys(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(entries) if !MAPS.contains(&path) => {
            for (key, value) in entries {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                keys(value, &path, found);
                found.insert(path);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| keys(item, path, found)),
        _ => {}
    }
}

/// The keys in the first column of the tables below a heading, in the same form.
fn documented(heading: &str) -> BTreeSet<String> {
    let text = include_str!("../docs/json.md");
    let below = text.lines().skip_while(|line| *line != heading).skip(1);
    let mut found = BTreeSet::new();
    for row in below.take_while(|line| !line.starts_with("## ")) {
        let Some(cell) = row.strip_prefix("| `").and_then(|row| row.split(" | ").next()) else {
            continue;
        };
        let mut last = String::new();
        for name in cell.split("`, `").map(|name| name.trim_matches('`').replace("[]", "")) {
            last = match name.strip_prefix('.') {
                Some(own) => format!("{}.{own}", last.rsplit_once('.').expect("a neighbour").0),
                None => name,
            };
            assert!(found.insert(last.clone()), "{last} is documented twice");
        }
    }
    assert!(found.len() > 20, "{heading} has its table");
    found
}

/// Holds what is written against what is documented.
fn agree(written: &BTreeSet<String>, documented: &BTreeSet<String>) {
    let holds = |path: &String| documented.iter().any(|key| key.starts_with(&format!("{path}.")));
    let undocumented: Vec<&String> =
        written.iter().filter(|key| !documented.contains(*key) && !holds(key)).collect();
    assert!(undocumented.is_empty(), "not in docs/json.md: {undocumented:?}");
    let unseen: Vec<&String> = documented.difference(written).collect();
    assert_eq!(unseen, UNSEEN.iter().collect::<Vec<_>>(), "in docs/json.md, and not written");
}

#[test]
fn every_key_of_an_audit_is_documented() {
    let directory = tempfile::tempdir().expect("a directory");
    let endless = directory.path().join("endless.lst");
    let main = "LBL0: AND 1\nCJP LBL1\nGJ\nJMP LBL0\nLBL1: GS 0\nGJ\nJMP LBL0\n";
    let text = format!("{main}GN 0\nLBL5: OUT 200\nJMP LBL5\n");
    std::fs::write(&endless, text).expect("written");
    let endless = endless.to_str().expect("a plain path");
    let linked = directory.path().join("linked.il");
    std::fs::write(&linked, "LD B0\nOUT Y0\nEND\n").expect("written");
    let linked = linked.to_str().expect("a plain path");
    let counted = directory.path().join("counted.il");
    let far = "LD X0\nMOV K1 D1000Z0\nLD= D5 K3\nBMOV D0 W0 K9\n";
    std::fs::write(&counted, format!("LD X0\nFMOV K0 D0 D900\n{far}END\n")).expect("written");
    let counted = counted.to_str().expect("a plain path");
    let trusted = directory.path().join("trusted.il");
    std::fs::write(&trusted, "LD X0\nFMOV K0 D0 D900\nLD SM400\nMOV K9 D900\nEND\n")
        .expect("written");
    let trusted = trusted.to_str().expect("a plain path");
    let apart = directory.path().join("apart.il");
    let steps =
        "LDI M0\nANI M1\nAND X0\nSET M0\nLD M0\nAND X1\nSET M1\nRST M0\nLD M1\nAND X2\nRST M1\n";
    let pairs = steps.to_owned() + &steps.replace('M', "M1");
    let both = "LD M0\nAND M1\nAND M10\nAND M11\nFMOV K0 D1000 K5000\n";
    std::fs::write(&apart, format!("{both}{pairs}END\n")).expect("written");
    let apart = apart.to_str().expect("a plain path");
    let line = ["samples/transfer-line/line.il", "--cpu", "Q26UDV"];
    let mut found = BTreeSet::new();
    let runs: [&[&str]; 20] = [
        &["audit", line[0], line[1], line[2], "--time-limit", "1us"],
        &["audit", "samples/paper/program.il", "--table", "samples/paper/table.csv"],
        &["audit", line[0], line[1], line[2], "--time", "NONE=1us"],
        &["audit", "samples/filler", "--confirm"],
        &["audit", "samples/drives/drives.il", "--cpu", "FX3U"],
        &["audit", "samples/snet/self-holding.il", "--cpu", "C200H"],
        &["audit", "samples/sorter/sorter.il", "--cpu", "CJ2M"],
        &["audit", "samples/sorter/sorter.cxt"],
        &["audit", "samples/flowchart/traffic-signals.lst"],
        &["audit", "samples/flowchart/self-holding-stop-inner-loop.lst"],
        &["audit", "samples/minasec-u/test-program.asm", "--response"],
        &["audit", endless],
        &["audit", counted, "--cpu", "Q26UDV", "--what-if"],
        &["audit", trusted, "--cpu", "Q26UDV", "--what-if=20"],
        &["audit", apart, "--cpu", "Q26UDV", "--trust", "all", "--what-if"],
        &["audit", linked, "--cpu", "Q26UDV", "--dialect", "melsec-list"],
        &["check", line[0], line[1], line[2], "--limit", "1s"],
        &["check", line[0], line[1], line[2], "--limit", "1us"],
        &["check", line[0], line[1], line[2], "--limit", "1ms", "--margin", "10%"],
        &["check", line[0], line[1], line[2], "--limit", "1s", "--max-assumed", "30%"],
    ];
    for run in runs {
        let report = json(run);
        assert_eq!(report["schema"], "scanbound.audit/1");
        keys(&report, "", &mut found);
    }
    agree(&found, &documented("## audit and check"));
}

#[test]
fn every_key_of_a_comparison_is_documented() {
    let program = "tests/cli/minasec.in/program.asm";
    let directory = tempfile::tempdir().expect("a directory");
    let measured = directory.path().join("measured.csv");
    std::fs::write(&measured, "scan_ms\n0.61\n0.62\n0.60\n").expect("written");
    let measured = measured.to_str().expect("a plain path");
    let mut found = BTreeSet::new();
    let runs: [&[&str]; 4] = [
        &["compare", program, "tests/cli/minasec.in/scans.csv"],
        &["compare", program, "tests/cli/minasec.in/outlier.csv"],
        &["compare", program, "tests/cli/minasec.in/dump.vcd", "--signal", "scan", "--fit"],
        &["compare", "samples/filler", measured, "--fit"],
    ];
    for run in runs {
        let report = json(run);
        assert_eq!(report["schema"], "scanbound.compare/1");
        keys(&report, "", &mut found);
    }
    agree(&found, &documented("## compare"));
}

#[test]
fn every_key_of_a_difference_is_documented() {
    let directory = tempfile::tempdir().expect("a directory");
    // With step numbers, as GX Works exports them.
    let text = std::fs::read("samples/filler/SUB.csv").expect("a sample");
    let (old, new) = (directory.path().join("old"), directory.path().join("new"));
    for place in [&old, &new] {
        std::fs::create_dir(place).expect("a directory");
        std::fs::write(place.join("SUB.csv"), &text).expect("written");
    }
    let other = std::fs::read("samples/filler/MAIN.csv").expect("a sample");
    std::fs::write(new.join("MAIN.csv"), other).expect("written");
    let (old, new) = (old.to_str().expect("plain"), new.to_str().expect("plain"));
    let mut found = BTreeSet::new();
    for run in [["diff", old, new], ["diff", new, old]] {
        let report = json(&run);
        assert_eq!(report["schema"], "scanbound.diff/1");
        keys(&report, "", &mut found);
    }
    agree(&found, &documented("## diff"));
}
