//! docs/json.md, the schemas and the JSON that is written against each other: every key is documented, what is
//! documented is written, and what is written keeps to its schema.

use crate::command::binary;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Keys whose own keys are names of the program's.
const MAPS: [&str; 2] = ["witness", "witness_run.inputs"];

/// Keys that hold a document of another schema.
const WITHIN: &str = "projects.report";

/// Documented keys that none of the reports below holds.
const UNSEEN: [&str; 0] = [];

/// The JSON of a command on files under the repository.
fn json(arguments: &[&str]) -> Value {
    let output =
        binary().args(arguments).args(["--format", "json"]).output().expect("the program starts");
    let told = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{arguments:?}: {told}"))
}

/// The keys of a value as paths, lists looked into: `groups.charges.line`.
fn keys(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(entries) if !MAPS.contains(&path) && path != WITHIN => {
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
    let text = include_str!("../../docs/json.md");
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
    assert!(found.len() > 5, "{heading} has its table");
    found
}

/// The schema of this name, as the program writes it.
fn schema(name: &str) -> Value {
    let output = binary().args(["schema", name]).output().expect("the program starts");
    serde_json::from_slice(&output.stdout).expect("a schema")
}

/// Whether a value keeps to a schema; what is wrong if it does not.
fn faults(schema: &Value, value: &Value) -> Vec<String> {
    jsonschema::meta::validate(schema).expect("a schema");
    let validator = jsonschema::validator_for(schema).expect("a schema");
    validator
        .iter_errors(value)
        .map(|fault| format!("{}: {fault}", fault.instance_path()))
        .collect()
}

/// The keys that a schema knows, in the form of [`keys`].
fn known(schema: &Value, path: &str, found: &mut BTreeSet<String>) {
    if MAPS.contains(&path) || path == WITHIN {
        return;
    }
    let forms = ["anyOf", "oneOf"].map(|form| schema[form].as_array().into_iter().flatten());
    forms
        .into_iter()
        .flatten()
        .chain(schema.get("items"))
        .for_each(|inner| known(inner, path, found));
    for (key, inner) in schema["properties"].as_object().into_iter().flatten() {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        known(inner, &path, found);
        found.insert(path);
    }
}

/// Holds what the schema knows against what is documented, and documents against the schema.
fn keeps(name: &str, heading: &str, documents: &[Value]) {
    let schema = schema(name);
    for document in documents {
        assert_eq!(faults(&schema, document), [""; 0], "{name}");
    }
    let mut found = BTreeSet::new();
    known(&schema, "", &mut found);
    // The lists of a breakdown have rows of one type, of which rungs alone have all keys.
    let documented = documented(heading);
    found.retain(|key| {
        let list = ["program", "routine", "instruction"]
            .iter()
            .find_map(|list| key.strip_prefix(&format!("breakdown.{list}.")));
        documented.contains(key)
            || !list.is_some_and(|own| documented.contains(&format!("breakdown.rung.{own}")))
    });
    agree(&found, &documented);
    // What is not written so is no such document.
    for (pointer, wrong) in
        [("/schema", Value::from("scanbound.other/1")), ("/schema", Value::Null)]
    {
        let mut document = documents[0].clone();
        *document.pointer_mut(pointer).expect("a key") = wrong;
        assert_ne!(faults(&schema, &document), [""; 0], "{name}");
    }
    for key in documents[0].as_object().expect("an object").keys() {
        let mut document = documents[0].clone();
        document[key] = serde_json::json!([[0]]);
        assert_ne!(faults(&schema, &document), [""; 0], "{name}: {key}");
    }
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/schema/{name}.json"));
    let kept: Value =
        serde_json::from_slice(&std::fs::read(page).unwrap_or_default()).unwrap_or_default();
    assert!(kept == schema, "write it anew: scanbound schema {name} > docs/schema/{name}.json");
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

/// A program with a statement that is not followed exactly, and a block that is not read and not called.
const ROUNDED: &str = r#"<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<types><dataTypes/><pous>
<pou name="main" pouType="program"><interface><localVars><variable name="r"><type><REAL/></type></variable></localVars></interface>
<body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">r := r * 0.1;</xhtml></ST></body></pou>
<pou name="other" pouType="functionBlock"><interface><localVars><variable name="x"><type><BOOL/></type></variable></localVars></interface>
<body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">x := ;</xhtml></ST></body></pou>
</pous></types><instances><configurations/></instances></project>"#;

#[test]
fn every_key_of_an_audit_is_documented() {
    let directory = tempfile::tempdir().expect("a directory");
    let endless = directory.path().join("endless.lst");
    let main = "LBL0: AND 1\nCJP LBL1\nGJ\nJMP LBL0\nLBL1: GS 0\nGJ\nJMP LBL0\n";
    let text = format!("{main}GN 0\nLBL5: OUT 200\nJMP LBL5\n");
    std::fs::write(&endless, text).expect("written");
    let endless = endless.to_str().expect("a plain path");
    let tasks = directory.path().join("tasks.st");
    let text = "PROGRAM a VAR x : BOOL; END_VAR x := TRUE; END_PROGRAM \
        CONFIGURATION c RESOURCE r ON plc TASK t(INTERVAL := T#1ms, PRIORITY := 0); \
        PROGRAM one WITH t : a; PROGRAM two : a; END_RESOURCE END_CONFIGURATION";
    std::fs::write(&tasks, text).expect("written");
    let tasks = tasks.to_str().expect("a plain path");
    let rounded = directory.path().join("rounded.xml");
    std::fs::write(&rounded, ROUNDED).expect("written");
    let rounded = rounded.to_str().expect("a plain path");
    let linked = directory.path().join("linked.il");
    std::fs::write(&linked, "LD B0\nOUT Y0\nEND\n").expect("written");
    let linked = linked.to_str().expect("a plain path");
    let needy = directory.path().join("needy.il");
    std::fs::write(&needy, "LD SM400\nMOV K5 Z1\nMOV K7 ZR100Z1\nEND\n").expect("written");
    let needy = needy.to_str().expect("a plain path");
    let bits = directory.path().join("bits.toml");
    std::fs::write(&bits, "[index]\nbits = 16\n").expect("written");
    let bits = bits.to_str().expect("a plain path");
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
    // What is trusted here is worth next to nothing.
    let minor = directory.path().join("minor.il");
    let block = "LD X0\nWAND K63 D900\nFMOV K0 D0 D900\nLD SM400\nMOV K9 D900\n";
    let others = "LD X0\nFMOV K0 D2000 K30000\nBMOV D0 D5000 K20000\nEND\n";
    std::fs::write(&minor, block.to_owned() + others).expect("written");
    let minor = minor.to_str().expect("a plain path");
    let set = directory.path().join("set.il");
    let sets = "LD M8000\nOUT M8039\nMOV K20 D8039\nMOV K300 D8000\nEND\n";
    std::fs::write(&set, sets).expect("written");
    let set = set.to_str().expect("a plain path");
    let line = ["samples/transfer-line/line.il", "--cpu", "Q26UDV"];
    let carousel = "samples/snet/carousel.snet";
    let mut found = BTreeSet::new();
    let runs: [&[&str]; 30] = [
        &["audit", tasks],
        &["audit", needy, "--cpu", "Q26UDV", "--facts", bits],
        &["audit", set, "--cpu", "FX3U"],
        &["audit", rounded],
        &["audit", "samples/sfc/line.st"],
        &["audit", line[0], line[1], line[2], "--time-limit", "1us"],
        &["audit", "samples/paper/program.il", "--table", "samples/paper/table.csv"],
        &["audit", line[0], line[1], line[2], "--time", "NONE=1us"],
        &["audit", "samples/filler", "--confirm"],
        &["audit", "samples/recipes"],
        &["audit", "samples/drives/drives.il", "--cpu", "FX3U"],
        &["audit", "samples/snet/self-holding.il", "--cpu", "C200H"],
        &["snet", "bound", "samples/snet/robot-mended.snet", "--trust", "all"],
        &["snet", "bound", carousel, "--trust", "all", "--initial", "first-scan"],
        &["audit", "samples/sorter/sorter.il", "--cpu", "CJ2M"],
        &["audit", "samples/sorter/sorter.cxt"],
        &["audit", "samples/flowchart/traffic-signals.lst"],
        &["audit", "samples/flowchart/self-holding-stop-inner-loop.lst"],
        &["audit", "samples/minasec-u/test-program.asm", "--response"],
        &["audit", endless],
        &["audit", counted, "--cpu", "Q26UDV", "--what-if"],
        &["audit", trusted, "--cpu", "Q26UDV", "--what-if=20"],
        &["audit", apart, "--cpu", "Q26UDV", "--trust", "all", "--what-if"],
        &["audit", minor, "--cpu", "Q26UDV", "--what-if", "--time-limit", "1us"],
        &["audit", "samples/recipes", "--what-if", "--time-limit", "1us"],
        &["audit", linked, "--cpu", "Q26UDV", "--dialect", "melsec-list"],
        &["check", line[0], line[1], line[2], "--limit", "1s"],
        &["check", line[0], line[1], line[2], "--limit", "1us"],
        &["check", line[0], line[1], line[2], "--limit", "1ms", "--margin", "10%"],
        &["check", line[0], line[1], line[2], "--limit", "1s", "--max-assumed", "30%"],
    ];
    let mut reports = Vec::new();
    for run in runs {
        let report = json(run);
        assert_eq!(report["schema"], "scanbound.audit/1");
        keys(&report, "", &mut found);
        reports.push(report);
    }
    agree(&found, &documented("## audit and check"));
    keeps("audit", "## audit and check", &reports);
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
    let mut reports = Vec::new();
    for run in runs {
        let report = json(run);
        assert_eq!(report["schema"], "scanbound.compare/1");
        keys(&report, "", &mut found);
        reports.push(report);
    }
    agree(&found, &documented("## compare"));
    keeps("compare", "## compare", &reports);
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
    let mut reports = Vec::new();
    for run in [["diff", old, new], ["diff", new, old]] {
        let report = json(&run);
        assert_eq!(report["schema"], "scanbound.diff/1");
        keys(&report, "", &mut found);
        reports.push(report);
    }
    agree(&found, &documented("## diff"));
    keeps("diff", "## diff", &reports);
}

#[test]
fn several_projects_are_one_document() {
    let directory = tempfile::tempdir().expect("a directory");
    let program = "LD X0\nMOV K1 D0\nEND\n";
    for (place, text) in [
        ("a", "programs = [\"p.il\"]\ncpu = \"Q26UDV\"\nlimit = \"1s\"\n"),
        ("b", "programs = [\"p.il\"]\ncpu = \"Q26UDV\"\nlimit = \"1us\"\n"),
        ("c", "programs = [\"p.il\"]\ncpu = \"Q26UDV\"\n"),
        ("d", "programs = [\"no.il\"]\ncpu = \"Q26UDV\"\nlimit = \"1s\"\n"),
    ] {
        let place = directory.path().join(place);
        std::fs::create_dir(&place).expect("a directory");
        std::fs::write(place.join("scanbound.toml"), text).expect("written");
        std::fs::write(place.join("p.il"), program).expect("written");
    }
    let check = |format: &[&str]| {
        let output = binary()
            .args(["check", "--all"])
            .args(format)
            .current_dir(directory.path())
            .output()
            .expect("the program starts");
        (output.status.code(), output.stdout, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, written, told) = check(&["--format", "json"]);
    assert_eq!(code, Some(2), "the gravest");
    let document: Value = serde_json::from_slice(&written).expect("one document");
    let projects = document["projects"].as_array().expect("projects");
    let ends: Vec<(&str, u64)> = projects
        .iter()
        .map(|one| {
            (one["file"].as_str().expect("a file"), one["exit_code"].as_u64().expect("a code"))
        })
        .collect();
    let file = |place: &str| format!("{place}/scanbound.toml");
    assert_eq!(ends, [(&*file("a"), 0), (&*file("b"), 1), (&*file("c"), 2), (&*file("d"), 2)]);
    assert_eq!(projects[1]["report"]["check"]["verdict"], "refuted");
    assert!(projects[2]["errors"][0]["message"].as_str().expect("a fault").contains("no limit"));
    assert_eq!(projects[3]["errors"][0]["code"], "unreadable");
    assert!(told.contains("no limit is given") && told.contains("d/scanbound.toml"), "{told}");
    let mut found = BTreeSet::new();
    keys(&document, "", &mut found);
    agree(&found, &documented("## check --all"));
    let report = schema("audit");
    for project in &projects[..2] {
        assert_eq!(faults(&report, &project["report"]), [""; 0]);
    }
    keeps("checks", "## check --all", &[document]);
    assert_eq!(check(&[]).0, Some(2));
    assert_eq!(check(&["-q", "--format", "json"]).1, b"");
}

/// What the source names as a document's `schema` is listed with its schema. (SARIF has its own, published by others.)
#[test]
fn every_kind_of_json_has_a_schema() {
    let output = binary().arg("schema").output();
    let listed = String::from_utf8(output.expect("the program starts").stdout).expect("text");
    let mut named = BTreeSet::new();
    let mut directories = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("crates")];
    while let Some(directory) = directories.pop() {
        for entry in std::fs::read_dir(directory).expect("a directory") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                directories.push(path);
            } else if path.extension().is_some_and(|kind| kind == "rs") {
                let text = std::fs::read_to_string(&path).expect("text");
                let ids =
                    text.split("\"scanbound.").skip(1).filter_map(|rest| rest.split('"').next());
                named.extend(ids.filter(|id| id.contains('/')).map(|id| format!("scanbound.{id}")));
            }
        }
    }
    assert!(named.len() >= 4, "{named:?}");
    for id in named {
        assert!(listed.contains(&id), "{id} is written and not listed: {listed}");
    }
}

#[test]
fn every_key_of_a_choice_of_cpus_is_documented() {
    let (mut found, mut reports) = (BTreeSet::new(), Vec::new());
    let line = ["cpus", "samples/transfer-line/line.il", "--cpu", "Q26UDV"];
    for more in [&["--limit", "1ms"][..], &["--limit", "watchdog"], &["--strict-times"]] {
        let report = json(&[&line, more].concat());
        assert_eq!(report["schema"], "scanbound.cpus/1");
        keys(&report, "", &mut found);
        reports.push(report);
    }
    agree(&found, &documented("## cpus"));
    keeps("cpus", "## cpus", &reports);
}

#[test]
fn every_key_of_advice_and_of_a_diagnosis_is_documented() {
    let runs: [(&str, &[&[&str]]); 2] = [
        (
            "advise",
            &[
                &["samples/filler", "--budget", "5s"],
                &["samples/recipes", "--budget", "10min"],
                &["samples/recipes", "--budget", "10min", "--time-limit", "1us"],
            ],
        ),
        ("doctor", &[&["samples/recipes"], &["tests/cli/doctor.in/plant", "--cpu", "Q26UDV"]]),
    ];
    for (command, runs) in runs {
        let (mut found, mut reports) = (BTreeSet::new(), Vec::new());
        for run in runs {
            let report = json(&[&[command], *run].concat());
            keys(&report, "", &mut found);
            reports.push(report);
        }
        agree(&found, &documented(&format!("## {command}")));
        keeps(command, &format!("## {command}"), &reports);
    }
}

#[test]
fn every_key_of_an_explanation_is_documented() {
    let (mut found, mut reports) = (BTreeSet::new(), Vec::new());
    for run in [&["explain", "MOV", "--cpu", "Q26UDV"][..], &["explain", "DADD"]] {
        let report = json(run);
        keys(&report, "", &mut found);
        reports.push(report);
    }
    agree(&found, &documented("## explain"));
    keeps("explain", "## explain", &reports);
}
