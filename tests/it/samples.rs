//! The samples' audits: what must hold of every report, whatever the program.

use crate::command::binary;
use serde_json::Value;

/// What is audited, by the arguments behind `audit`.
const SAMPLES: [&[&str]; 8] = [
    &["samples/paper/program.il", "--table", "samples/paper/table.csv"],
    &["samples/transfer-line/line.il", "--cpu", "Q26UDV"],
    &["samples/filler"],
    &["samples/drives/drives.il", "--cpu", "FX3U"],
    &["samples/snet/self-holding.il", "--cpu", "C200H"],
    &["samples/sorter/sorter.il", "--cpu", "CJ2M"],
    &["samples/sorter/sorter.cxt"],
    &["samples/recipes", "--facts", "samples/recipes/facts.toml"],
];

fn json(arguments: &[&str]) -> Value {
    let output = binary()
        .arg("audit")
        .args(arguments)
        // However slow the machine is: none of these is to end early.
        .args(["--format", "json", "--time-limit", "600s"])
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn ps(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no time"))
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap_or_else(|| panic!("{value} is no list"))
}

#[test]
fn the_parts_add_up_to_the_bound() {
    for sample in SAMPLES {
        let report = json(sample);
        let scan = &report["scan"];
        let constant = ps(&scan["always_ps"]) + ps(&scan["overhead_ps"]);
        let sum = |key: &str| -> u64 {
            list(&report["groups"]).iter().map(|group| ps(&group[key])).sum()
        };
        assert_eq!(ps(&scan["upper_ps"]), constant + sum("upper_ps"), "{sample:?}");
        assert!(ps(&scan["lower_ps"]) <= constant + sum("lower_ps"), "{sample:?}");
        assert!(ps(&scan["upper_ps"]) <= ps(&scan["naive_ps"]));
        assert_eq!(scan["model_ps"], scan["upper_ps"], "{sample:?} is small enough");
        // Where the model's scan is one that a PLC makes, it is the longest.
        assert_eq!(scan["exact"] == true, scan["stands_between"].is_null(), "{sample:?}");
        for by in ["program", "routine", "rung", "instruction"] {
            let parts = list(&report["breakdown"][by]);
            let sum: u64 = parts.iter().map(|part| ps(&part["ps"])).sum();
            assert_eq!(ps(&scan["upper_ps"]), sum, "{sample:?} by {by}");
            assert!(parts.iter().all(|part| ps(&part["always_ps"]) <= ps(&part["ps"])
                && ps(&part["ps"]) <= ps(&part["most_ps"])));
        }
        let overhead: u64 = list(&report["overhead"]).iter().map(|term| ps(&term["ps"])).sum();
        assert_eq!(ps(&scan["overhead_ps"]), overhead);
    }
}

#[test]
fn a_groups_charges_add_up_to_what_its_best_scan_costs() {
    for sample in SAMPLES {
        for group in list(&json(sample)["groups"]) {
            let charges = list(&group["charges"]);
            let cost: u64 = charges.iter().map(|charge| ps(&charge["cost_ps"])).sum();
            assert_eq!(ps(&group["lower_ps"]), cost);
            for charge in charges {
                let expected = match (charge["runs"] == true, charge["reached"] == true) {
                    (true, _) => ps(&charge["on_ps"]),
                    (false, true) => ps(&charge["off_ps"]),
                    (false, false) => 0,
                };
                // Where it is not known how many units it handles, or whether it fires, it costs the least.
                assert!(ps(&charge["cost_ps"]) <= expected);
            }
        }
    }
}

#[test]
fn two_runs_and_any_number_of_threads_give_the_same_report() {
    for sample in SAMPLES {
        let run = |jobs: &str| {
            let mut report = json(&[sample, &["--jobs", jobs]].concat());
            report["seconds"] = Value::Null;
            report
        };
        let one = run("1");
        assert_eq!(one, run("1"));
        assert_eq!(one, run("4"));
    }
}

#[test]
fn the_papers_groups_and_maximum_are_found() {
    let report = json(SAMPLES[0]);
    let groups = list(&report["groups"]);
    assert_eq!(groups[0]["blocks"], serde_json::json!([1, 4, 6]));
    assert_eq!(groups[1]["blocks"], serde_json::json!([2, 3, 5]));
    // SwOp0 and SwOp3 run, SwOp5 costs what it costs when it does not.
    assert_eq!(ps(&groups[0]["upper_ps"]), 120_000_000 + 80_000_000 + 40_000);
}

#[test]
fn mnemonics_and_project_text_of_one_program_have_one_bound() {
    let [text, project] = [SAMPLES[5], SAMPLES[6]].map(json);
    for key in ["scan", "groups"] {
        let of = |report: &Value| match &report[key] {
            Value::Array(groups) => groups.iter().map(|group| group["upper_ps"].clone()).collect(),
            scan => vec![scan.clone()],
        };
        assert_eq!(of(&text), of(&project), "{key}");
    }
    assert_eq!(text["scan"]["model_ps"], text["scan"]["upper_ps"]);
    assert_eq!(text["program"]["dialect"], "omron-cx");
    assert_eq!(project["program"]["dialect"], "omron-cxt");
    assert_eq!(text["program"]["blocks"], project["program"]["blocks"]);
}

#[test]
fn a_scan_of_contacts_and_coils_alone_costs_the_same_whatever_the_inputs() {
    let report = json(SAMPLES[4]);
    assert_eq!(report["program"]["dialect"], "omron-c200h");
    assert_eq!(report["program"]["instructions"], 12);
    assert_eq!(list(&report["groups"]).len(), 0);
    assert_eq!(report["scan"]["upper_ps"], report["scan"]["lower_ps"]);
}
