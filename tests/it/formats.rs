//! Several reports of one run, each read back by what reads it elsewhere; the difference of two versions; project
//! files.

use crate::command::scanbound;
use quick_junit::{Report, TestCaseStatus};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use scanbound::report::FORMATS;
use serde_json::Value;
use serde_sarif::sarif::Sarif;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

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

/// The published schema of SARIF 2.1.0, which comes with the crate that reads SARIF here.
fn sarif_schema() -> Value {
    let rustc = Command::new("rustc").arg("-vV").output().expect("rustc starts");
    let rustc = String::from_utf8_lossy(&rustc.stdout).into_owned();
    let host = rustc.lines().find_map(|line| line.strip_prefix("host: ")).expect("a platform");
    // Crates for other platforms need not be here.
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--offline", "--locked"])
        .args(["--filter-platform", host])
        .output()
        .expect("cargo starts");
    assert!(output.status.success(), "{}", told(&output));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let crate_of = packages.iter().find(|one| one["name"] == "serde-sarif").expect("the crate");
    let manifest = Path::new(crate_of["manifest_path"].as_str().expect("a path"));
    let file = manifest.with_file_name("src").join("schema.json");
    let text = fs::read_to_string(file).expect("its schema");
    // Its pattern for languages has a bracket too many, which is no regular expression of JSON Schema's.
    let text = text.replace("-[a-zA-Z]{2}]?$", "-[a-zA-Z]{2}$");
    let schema: Value = serde_json::from_str(&text).expect("JSON");
    assert!(schema["title"].as_str().expect("a title").contains("Version 2.1.0"));
    schema
}

/// What of a SARIF log does not keep to the published schema.
fn sarif_faults(validator: &jsonschema::Validator, text: &str) -> Vec<String> {
    let log: Value = serde_json::from_str(text).expect("JSON");
    validator.iter_errors(&log).map(|fault| format!("{}: {fault}", fault.instance_path())).collect()
}

/// An element as the schema of Jenkins (its xUnit plugin's junit-10.xsd) has it: the attributes that it must have,
/// those that it may have, and what may stand in it.
type Rule =
    (&'static str, &'static [&'static str], &'static [&'static str], &'static [&'static str]);

const SUITE: [&str; 10] =
    ["group", "time", "skipped", "timestamp", "hostname", "id", "package", "file", "log", "url"];
const RULES: [Rule; 6] = [
    ("testsuites", &[], &["name", "time", "tests", "failures", "errors"], &["testsuite"]),
    (
        "testsuite",
        &["name", "tests", "failures", "errors"],
        &SUITE,
        &["testsuite", "properties", "testcase", "system-out", "system-err"],
    ),
    (
        "testcase",
        &["name"],
        &["time", "classname", "group"],
        &["skipped", "error", "failure", "system-out", "system-err"],
    ),
    ("failure", &[], &["type", "message"], &[]),
    ("system-out", &[], &[], &[]),
    ("system-err", &[], &[], &[]),
];

/// What of a JUnit report does not keep to these rules.
fn junit_faults(text: &str) -> Vec<String> {
    let mut reader = Reader::from_str(text);
    let (mut faults, mut open) = (Vec::new(), Vec::<String>::new());
    let mut opened = |tag: &BytesStart<'_>, open: &[String]| {
        let name = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
        let holds = |rule: &&Rule, within: &str| rule.0 == within && rule.3.contains(&&*name);
        let fits = match open.last() {
            Some(within) => RULES.iter().any(|rule| holds(&rule, within)),
            None => name == "testsuites" || name == "testsuite",
        };
        let found: Vec<(String, String)> = tag
            .attributes()
            .map(|attribute| {
                let attribute = attribute.expect("well formed");
                let value = attribute.unescape_value().expect("well formed").into_owned();
                (String::from_utf8_lossy(attribute.key.as_ref()).into_owned(), value)
            })
            .collect();
        match RULES.iter().find(|rule| rule.0 == name).filter(|_| fits) {
            None => faults.push(format!("{name} in {open:?}")),
            Some((_, must, may, _)) => {
                let has = |key: &str| found.iter().any(|(name, _)| name == key);
                faults.extend(must.iter().filter(|key| !has(key)).map(|key| format!("no {key}")));
                let known = |key: &str| must.contains(&key) || may.contains(&key);
                let number = |key: &str| ["tests", "failures", "errors"].contains(&key);
                let time = |value: &str| value.parse::<f64>().is_ok_and(f64::is_sign_positive);
                faults.extend(found.iter().filter_map(|(key, value)| {
                    let right = match key.as_str() {
                        key if !known(key) => false,
                        "time" => time(value),
                        key if number(key) => value.parse::<u32>().is_ok(),
                        _ => true,
                    };
                    (!right).then(|| format!("{name}: {key} {value:?}"))
                }));
            }
        }
        name
    };
    loop {
        match reader.read_event().expect("well-formed XML") {
            Event::Start(tag) => {
                let name = opened(&tag, &open);
                open.push(name);
            }
            Event::Empty(tag) => drop(opened(&tag, &open)),
            Event::End(_) => drop(open.pop()),
            Event::Text(text) => {
                let within = open.last().map_or("", String::as_str);
                let blank = text.iter().all(u8::is_ascii_whitespace);
                assert!(
                    blank || ["failure", "system-out", "system-err"].contains(&within),
                    "{within}"
                );
            }
            Event::Eof => return faults,
            _ => {}
        }
    }
}

#[test]
fn reports_keep_to_the_published_schemas() {
    let directory = project();
    let validator = jsonschema::validator_for(&sarif_schema()).expect("a schema");
    let read = |name: &str| fs::read_to_string(directory.path().join(name)).expect(name);
    let scans = directory.path().join("scans.csv");
    fs::write(&scans, "scan_ms\n0.61\n900\n").expect("written");
    let runs: [&[&str]; 6] = [
        &["audit", "old.il"],
        &["check", "old.il", "--limit", "10ms"],
        &["check", "old.il", "--limit", "1us"],
        &["check", "old.il", "--limit", "1s", "--max-assumed", "0%"],
        &["diff", "old.il", "new.il", "--fail-above", "0.5%"],
        &["compare", "old.il", "scans.csv"],
    ];
    for run in runs {
        let command = [run, &HOW, &["-o", "a.sarif", "-o", "a.xml"]].concat();
        let output = scanbound(&command, directory.path());
        assert_ne!(output.status.code(), Some(2), "{run:?}: {}", told(&output));
        let (sarif, junit) = (read("a.sarif"), read("a.xml"));
        assert_eq!(sarif_faults(&validator, &sarif), [""; 0], "{run:?}");
        assert_eq!(junit_faults(&junit), [""; 0], "{run:?}");
        // Damage is seen.
        let damaged = sarif.replace("\"version\": \"2.1.0\"", "\"version\": \"2.0\"");
        assert_eq!(sarif_faults(&validator, &damaged).len(), 1);
        for (from, to) in [
            (" tests=\"1\"", " test=\"1\""),
            ("<testcase ", "<case "),
            ("</testcase>", "<b/></testcase>"),
        ] {
            let damaged = junit.replace(from, to);
            let damaged = if from == "<testcase " {
                damaged.replace("</testcase>", "</case>")
            } else {
                damaged
            };
            assert_ne!(junit_faults(&damaged), [""; 0], "{from}");
        }
    }
}

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

/// The suffixes of all formats.
fn suffixes() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.suffixes).copied()
}

#[test]
fn reports_in_the_directory_of_the_programs_are_not_taken_for_programs() {
    let directory = project();
    fs::write(directory.path().join("m.csv"), "scan_ms\n0.1\n").expect("written");
    let programs = directory.path().join("programs");
    fs::create_dir(&programs).expect("a directory");
    fs::copy(directory.path().join("old.il"), programs.join("old.il")).expect("copied");
    let all: Vec<&str> = suffixes().collect();
    // A command, and the reports of each of its runs.
    let lists: [&[&str]; 3] = [&["txt"], &["json"], &["csv"]];
    let commands: [(&[&str], &[&[&str]]); 8] = [
        (&["audit", "old.il"], &[&all]),
        (&["check", "old.il", "--limit", "1us"], &[&all]),
        (&["check", "old.il", "--limit", "1s"], &[&all]),
        (&["compare", "old.il", "m.csv"], &[&all]),
        (&["diff", "old.il", "new.il"], &[&all]),
        (&["advise", "old.il"], &lists),
        (&["doctor", "old.il"], &lists),
        (&["cpus", "old.il"], &lists),
    ];
    let mut written = 0;
    for (number, (command, runs)) in commands.iter().enumerate() {
        for suffixes in *runs {
            let file = |suffix| format!("programs/report-{number}.{suffix}");
            let files: Vec<String> = suffixes.iter().map(file).collect();
            let outputs = files.iter().flat_map(|file| ["-o", file]);
            let whole: Vec<&str> = command.iter().copied().chain(HOW).chain(outputs).collect();
            let output = scanbound(&whole, directory.path());
            assert!(matches!(output.status.code(), Some(0 | 1)), "{command:?}: {}", told(&output));
            written += files.len();
        }
    }
    let annotations = ["check", "old.il", "--limit", "1us", "--format", "github"];
    let output = scanbound(&[&annotations[..], &HOW].concat(), directory.path());
    fs::write(programs.join("annotations.txt"), output.stdout).expect("written");
    let chart = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/sfc/line.st");
    let others: [&[&str]; 3] = [&["sfc", chart], &["explain", "MOV"], &["explain", "no-time"]];
    for (number, command) in others.iter().enumerate() {
        let output = scanbound(command, directory.path());
        assert_eq!(output.status.code(), Some(0), "{}", told(&output));
        fs::write(programs.join(format!("other-{number}.txt")), output.stdout).expect("written");
    }
    let output = scanbound(&[&["audit", "programs"][..], &HOW].concat(), directory.path());
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    // Besides the reports, the annotations and the program.
    assert_eq!(fs::read_dir(&programs).expect("a directory").count(), written + 5);
}

#[test]
fn a_suffix_names_the_format_of_other_commands_or_is_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    let chart = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/sfc/line.st");
    let group = ["export", chart, "--group", "1"];
    for (command, file, begins) in [
        (&["sfc", chart][..], "a.gv", "digraph"),
        (&["sfc", chart], "a.SVG", "<svg"),
        (&["sfc", chart], "a.json", "{"),
        (&["sfc", chart], "a", "line.st"),
        (&["explain", "MOV"], "b.json", "scanbound.explain/1"),
        (&["explain", "MOV"], "b.txt", "MOV"),
        (&group, "c.smt2", "(assert-soft"),
        (&group, "c.wcnf", "h "),
    ] {
        let output = scanbound(&[command, &["-o", file]].concat(), directory.path());
        let text = fs::read_to_string(directory.path().join(file)).expect(file);
        assert!(text.contains(begins), "{file}: {}{text}", told(&output));
    }
    let output = scanbound(&["sfc", chart, "-o", "a.log"], directory.path());
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    let all = "use one of .text, .txt, .dot, .gv, .svg, .json";
    assert!(told(&output).contains(all), "{}", told(&output));
    assert!(!directory.path().join("a.log").exists());
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
fn annotations_go_to_stdout_beside_files_that_are_called_after_other_formats() {
    let directory = project();
    let how = ["check", "old.il", "--limit", "10ms", "--format", "github"];
    let output =
        scanbound(&[&how[..], &["-o", "a.sarif", "-o", "a.json"], &HOW].concat(), directory.path());
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(!lines.is_empty() && lines.lines().all(|line| line.starts_with("::")), "{lines}");
    let read = |name: &str| fs::read_to_string(directory.path().join(name)).expect(name);
    let log: Sarif = serde_json::from_str(&read("a.sarif")).expect("SARIF");
    // Code hosts refuse the whole log if one result has no place.
    for one in log.runs[0].results.as_ref().expect("results") {
        assert_eq!(one.locations.as_ref().map(Vec::len), Some(1), "{one:?}");
    }
    let json: Value = serde_json::from_str(&read("a.json")).expect("JSON");
    assert_eq!(json["check"]["verdict"], "proved");
}

#[test]
fn no_report_takes_the_place_of_what_is_read_from_a_directory() {
    let directory = project();
    for name in ["old.il", "scanbound.toml"] {
        let kept = fs::read(directory.path().join(name)).ok();
        let output = scanbound(&[&["audit", ".", "-o", name][..], &HOW].concat(), directory.path());
        assert_eq!(output.status.code(), Some(2), "{}", told(&output));
        assert!(told(&output).contains("would overwrite"), "{}", told(&output));
        assert_eq!(fs::read(directory.path().join(name)).ok(), kept);
    }
    // Nor where the directory cannot be read as a whole.
    let broken = tempfile::tempdir().expect("a directory");
    fs::write(broken.path().join("old.il"), "LD X0\nOUT Y0\nEND\n").expect("written");
    fs::write(broken.path().join("new.il"), "LD X0\nNOSUCH D0 (\n").expect("written");
    for name in ["old.il", "new.il"] {
        let kept = fs::read(broken.path().join(name)).ok();
        let output =
            scanbound(&[&["audit", ".", "-o", name][..], &HOW[..2]].concat(), broken.path());
        assert_eq!(output.status.code(), Some(2), "{}", told(&output));
        assert!(told(&output).contains("would overwrite"), "{}", told(&output));
        assert_eq!(fs::read(broken.path().join(name)).ok(), kept);
    }
    // Its own reports it writes again.
    for _ in 0..2 {
        let how = ["audit", ".", "-o", "bound.csv", "-o", "bound.json"];
        let output = scanbound(&[&how[..], &HOW].concat(), directory.path());
        assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    }
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

/// A repository of three projects: one keeps its limit, one does not, one cannot be read.
fn repository() -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a directory");
    let projects = [
        ("fast", "LD X0\nOUT Y0\nEND\n", "10s"),
        ("slow", "LD X0\nMOV K1 D0\nEND\n", "1ns"),
        ("broken", "LD X0\nNOSUCH D0\nEND\n", "10s"),
    ];
    for (name, program, limit) in projects {
        let project = directory.path().join(name);
        fs::create_dir(&project).expect("made");
        fs::write(project.join("main.il"), program).expect("written");
        // A directory by its name, and as the one in which the file is.
        let programs = if name == "broken" { "main.il" } else { "." };
        let file = format!("programs = [\"{programs}\"]\ncpu = \"Q26UDV\"\nlimit = \"{limit}\"\n");
        fs::write(project.join("scanbound.toml"), file).expect("written");
    }
    directory
}

#[test]
fn all_projects_are_one_document_in_every_format() {
    let directory = repository();
    let files: Vec<String> = suffixes().map(|suffix| format!("a.{suffix}")).collect();
    let named: Vec<&str> = files.iter().flat_map(|file| ["-o", file]).collect();
    let how = [&["check", "--all", "--format", "github"][..], &named].concat();
    let output = scanbound(&how, directory.path());
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    let is_annotation = |line: &str| line.starts_with("::");
    assert!(lines.lines().count() >= 3 && lines.lines().all(is_annotation), "{lines}");
    let read = |name: &str| fs::read_to_string(directory.path().join(name)).expect(name);

    let log: Sarif = serde_json::from_str(&read("a.sarif")).expect("SARIF");
    assert_eq!(log.runs.len(), 1);
    let results = log.runs[0].results.as_ref().expect("results");
    let place = |one: &serde_sarif::sarif::Result| {
        let place = one.locations.as_ref().expect("a place")[0].physical_location.clone();
        place.and_then(|place| place.artifact_location?.uri).expect("a file")
    };
    for name in ["fast", "slow", "broken"] {
        let file = format!("{name}/main.il");
        assert!(results.iter().any(|one| place(one) == file), "{name}");
    }

    let report = Report::deserialize_from_str(&read("a.xml")).expect("JUnit");
    let tests: Vec<(&str, &str)> = report
        .test_suites
        .iter()
        .map(|suite| (suite.name.as_str(), suite.test_cases[0].name.as_str()))
        .collect();
    let case = "no scan takes longer than the limit";
    let suites = ["broken", "fast", "slow"].map(|name| format!("{name}/scanbound.toml"));
    assert_eq!(tests, suites.each_ref().map(|suite| (suite.as_str(), case)));
    assert_eq!((report.tests, report.failures, report.errors), (3, 1, 1));

    let json: Value = serde_json::from_str(&read("a.json")).expect("JSON");
    let codes: Vec<&Value> = json["projects"]
        .as_array()
        .expect("projects")
        .iter()
        .map(|one| &one["exit_code"])
        .collect();
    assert_eq!(codes, [2, 0, 1]);
    assert_eq!(read("a.csv").lines().count(), 4);
    for (file, told) in [
        ("a.html", "1 of 3 projects keep to their limits."),
        ("a.md", "# slow/scanbound.toml"),
        ("a.txt", "slow/scanbound.toml\nREFUTED"),
    ] {
        assert!(read(file).contains(told), "{file}: {}", read(file));
    }
    let broken = read("a.txt");
    assert!(broken.contains("NOSUCH") && !broken.contains('\u{1b}'), "{broken}");
}

#[test]
fn what_cannot_be_read_is_told_in_the_formats_of_pipelines() {
    let directory = repository();
    let how = ["check", "broken/main.il", "--limit", "10ms", "-o", "a.sarif", "-o", "a.xml"];
    let output =
        scanbound(&[&how[..], &HOW[..2], &["--format", "github"]].concat(), directory.path());
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(
        lines.starts_with("::error file=broken/main.il,title=scanbound input,line=2::"),
        "{lines}"
    );
    let read = |name: &str| fs::read_to_string(directory.path().join(name)).expect(name);
    let log: Sarif = serde_json::from_str(&read("a.sarif")).expect("SARIF");
    assert_eq!(log.runs[0].results.as_ref().map(Vec::len), Some(1));
    let report = Report::deserialize_from_str(&read("a.xml")).expect("JUnit");
    assert_eq!((report.failures, report.errors), (0, 1));
}
