//! What slips of a newcomer get: files that would be lost, names that mean nothing, and projects that are not read.

use crate::command::scanbound;
use std::path::Path;

const PROGRAM: &str = "LD X0\nMOV K1 D0\nEND\n";

/// A directory with these files.
fn with(files: &[(&str, &str)]) -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a directory");
    for (name, text) in files {
        std::fs::write(directory.path().join(name), text).expect("written");
    }
    directory
}

/// The exit code, and what stderr says on one line.
fn told(arguments: &[&str], directory: &Path) -> (Option<i32>, String) {
    let output = scanbound(arguments, directory);
    let text = String::from_utf8_lossy(&output.stderr);
    (output.status.code(), text.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn facts_writes_over_no_file() {
    let directory = with(&[("a.il", PROGRAM), ("plant.toml", "[io]\ninputs = 64\n")]);
    let facts = ["facts", "a.il", "--cpu", "Q26UDV", "-o", "plant.toml"];
    let (code, why) = told(&facts, directory.path());
    assert_eq!(code, Some(2), "{why}");
    assert!(why.contains("plant.toml exists") && why.contains("stdout"), "{why}");
    let kept = std::fs::read_to_string(directory.path().join("plant.toml")).expect("still there");
    assert_eq!(kept, "[io]\ninputs = 64\n");
    std::fs::remove_file(directory.path().join("plant.toml")).expect("removed");
    assert_eq!(told(&facts, directory.path()).0, Some(0));
    assert!(directory.path().join("plant.toml").is_file());
}

#[test]
fn facts_begins_the_file_that_the_project_names() {
    let project = "programs = [\"a.il\"]\ncpu = \"Q26UDV\"\nfacts = \"plant.toml\"\n";
    let directory = with(&[("a.il", PROGRAM), ("scanbound.toml", project)]);
    assert_eq!(told(&["check", "--limit", "1s"], directory.path()).0, Some(2));
    let on_stdout = scanbound(&["facts"], directory.path());
    assert_eq!(on_stdout.status.code(), Some(0), "{on_stdout:?}");
    assert_eq!(told(&["facts", "-o", "plant.toml"], directory.path()).0, Some(0));
    let written = std::fs::read(directory.path().join("plant.toml")).expect("written");
    assert_eq!(written, on_stdout.stdout);
    assert_eq!(told(&["check", "--limit", "1s"], directory.path()).0, Some(0));
    // One that the command line names must be there.
    let (code, why) = told(&["facts", "--facts", "nowhere.toml"], directory.path());
    assert!(code == Some(2) && why.contains("nowhere.toml cannot be read"), "{why}");
}

#[test]
fn a_report_in_a_format_that_is_not_known_is_refused() {
    let directory = with(&[("a.il", PROGRAM)]);
    let audit = ["audit", "a.il", "--cpu", "Q26UDV"];
    for file in ["rep.pdf", "x.foo", "a.json.gz"] {
        let (code, why) = told(&[&audit[..], &["-o", file]].concat(), directory.path());
        assert_eq!(code, Some(2), "{file}: {why}");
        assert!(why.contains(file) && why.contains(".sarif") && why.contains(".txt"), "{why}");
        assert!(!directory.path().join(file).exists());
        let named = [&audit[..], &["-o", file, "--format", "json"]].concat();
        assert_eq!(told(&named, directory.path()).0, Some(0), "{file}");
    }
    // A list has fewer formats.
    let list = ["doctor", "a.il", "--cpu", "Q26UDV", "-o", "a.html"];
    let (code, why) = told(&list, directory.path());
    assert!(code == Some(2) && why.contains(".csv") && !why.contains(".sarif"), "{why}");
    for file in ["report", "a.txt", "-"] {
        let plain = [&audit[..], &["-o", file]].concat();
        assert_eq!(told(&plain, directory.path()).0, Some(0), "{file}");
    }
}

#[test]
fn a_project_file_that_is_not_read_is_told() {
    let project = "programs = [\"a.il\"]\ncpu = \"Q26UDV\"\nlimit = \"1s\"\n";
    let directory = with(&[("a.il", PROGRAM), ("scanbound.toml", project)]);
    let read_where = "scanbound.toml here is read only if no program is named";
    for arguments in [&["check", "."][..], &["diff", "a.il", "a.il"]] {
        let (code, why) = told(arguments, directory.path());
        assert!(code == Some(2) && why.contains(read_where), "{arguments:?}: {why}");
    }
    assert_eq!(told(&["check"], directory.path()).0, Some(0));
    std::fs::remove_file(directory.path().join("scanbound.toml")).expect("removed");
    let (_, why) = told(&["check", "."], directory.path());
    assert!(why.contains("no limit is given") && !why.contains("is read only"), "{why}");
}

/// A program as GX Works2 writes it to CSV, for this CPU.
fn exported(cpu: &str, rows: &str) -> String {
    let heads = "\"Step No.\",\"Line Statement\",\"Instruction\",\"I/O (Device)\",\"Blank\",\"P Statement\",\"Note\"";
    format!("\"MAIN\"\n\"PLC Information:\",\"QCPU (Q mode) {cpu}\"\n{heads}\n{rows}")
}

#[test]
fn a_cpu_of_another_series_than_the_program_says_is_told() {
    let rows = "\"0\",\"\",\"LD\",\"X0\",\"\",\"\",\"\"\n\"1\",\"\",\"OUT\",\"Y1\",\"\",\"\",\"\"\n\"2\",\"\",\"END\",\"\",\"\",\"\",\"\"\n";
    let directory = with(&[("MAIN.csv", &exported("Q26UDV", rows))]);
    let report = |cpu: &str| {
        let how = ["audit", "MAIN.csv", "--cpu", cpu, "--format", "json"];
        let output = scanbound(&how, directory.path());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let all = report["warnings"].as_array().expect("warnings").clone();
        let told = all.iter().filter(|one| one["code"] == "other-cpu");
        told.map(|one| one["message"].as_str().expect("text").to_owned()).collect::<Vec<_>>()
    };
    for cpu in ["FX3U", "CJ2M", "L26", "Q26UDH"] {
        let told = report(cpu);
        assert_eq!(told.len(), 1, "{cpu}");
        assert!(told[0].contains("for Q26UDV") && told[0].contains(cpu), "{told:?}");
    }
    for cpu in ["Q26UDV", "Q13UDV", "q26udvcpu"] {
        assert_eq!(report(cpu), [""; 0], "{cpu}");
    }
    let listed = scanbound(&["doctor", "MAIN.csv", "--cpu", "L26"], directory.path());
    assert!(String::from_utf8_lossy(&listed.stdout).contains("is of another"), "{listed:?}");
}

#[test]
fn a_misspelt_cpu_or_word_is_offered_as_it_was_meant() {
    let program = "LD X0\nBMOV D0 D1000 D37442\nMOV D37442 D5\nEND\n";
    let files = [
        ("a.il", program),
        ("b.il", "LD X0\nMOV D37442 D5\nEND\n"),
        ("counts.toml", "[counts]\nD34742 = [0, 20]\n"),
        ("ranges.toml", "[ranges]\nD34742 = [0, 20]\n"),
    ];
    let directory = with(&files);
    let (_, why) = told(&["audit", "a.il", "--cpu", "Q26UVD"], directory.path());
    assert!(why.contains("did you mean Q26UDV?"), "{why}");
    // A CPU that there is and that has no table is no slip.
    let (_, why) = told(&["audit", "a.il", "--cpu", "FX3G"], directory.path());
    assert!(why.contains("no timing table") && !why.contains("did you mean"), "{why}");
    let stated = |program, facts| ["audit", program, "--cpu", "Q26UDV", "--facts", facts];
    let (_, why) = told(&stated("a.il", "counts.toml"), directory.path());
    assert!(why.contains("did you mean D37442?"), "{why}");
    let shown = scanbound(&stated("b.il", "ranges.toml"), directory.path());
    let shown =
        String::from_utf8_lossy(&shown.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(shown.contains("does not use: did you mean D37442?"), "{shown}");
}

#[test]
fn stated_points_are_held_against_the_program_and_the_cpu_and_listed() {
    let files = [
        ("a.il", "LD X2F\nOUT Y5\nEND\n"),
        ("few.toml", "[io]\ninputs = 16\noutputs = 16\n"),
        ("many.toml", "[io]\ninputs = 100000\noutputs = 16\n"),
    ];
    let directory = with(&files);
    let shown = |more: &[&str]| {
        let how = [&["audit", "a.il", "--cpu", "Q26UDV"], more].concat();
        let output = scanbound(&how, directory.path());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let text = String::from_utf8_lossy(&output.stdout);
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let open = shown(&[]);
    assert!(open.contains("[io] inputs = 48, outputs = 16"), "{open}");
    let few = shown(&["--facts", "few.toml"]);
    assert!(few.contains("16 input points are stated, but the program shows 48"), "{few}");
    let believed = few.split("What was stated and is believed").nth(1).expect("a section");
    assert!(believed.contains("16 input points are refreshed"), "{believed}");
    let many = shown(&["--facts", "many.toml"]);
    let told = "100000 input points are stated, but the CPU can address only 4096";
    assert!(many.contains(told), "{many}");
    assert!(!many.contains("output points are stated, but"), "{many}");
    let json = shown(&["--facts", "few.toml", "--format", "json"]);
    assert!(json.contains("16 output points are refreshed"), "{json}");
}

#[test]
fn what_belongs_to_scanbound_is_told_where_it_is_given_as_a_program() {
    let times = "# our own\ninstruction,on_us,off_us,evidence\nMOV,1,1,measured\n";
    let files = [
        ("a.il", PROGRAM),
        ("times.csv", times),
        ("plant.toml", "# the plant\n[counts]\nD0 = [0, 20]\n"),
        ("project.toml", "programs = [\"a.il\"]\ncpu = \"Q26UDV\"\n"),
    ];
    let directory = with(&files);
    let written = ["audit", "a.il", "--cpu", "Q26UDV", "-o", "a.json"];
    assert_eq!(told(&written, directory.path()).0, Some(0));
    let facts = ["facts", "a.il", "--cpu", "Q26UDV", "-o", "offered.toml"];
    assert_eq!(told(&facts, directory.path()).0, Some(0));
    for (file, what, option) in [
        ("times.csv", "this is a timing table", "--table"),
        ("plant.toml", "this is a facts file", "--facts"),
        ("offered.toml", "this is a facts file", "--facts"),
        ("project.toml", "this is a project file", "no program is named"),
        ("a.json", "this is a report of scanbound", "the program files"),
    ] {
        for more in [&[][..], &["a.il"]] {
            let how = [&["audit", "--cpu", "Q26UDV", file], more].concat();
            let (code, why) = told(&how, directory.path());
            assert_eq!(code, Some(2), "{file}: {why}");
            assert!(why.contains(what) && why.contains(option), "{file}: {why}");
        }
    }
    // Beside a program in a directory they are no programs either.
    let all = told(&["audit", ".", "--cpu", "Q26UDV"], directory.path());
    assert_eq!(all.0, Some(0), "{}", all.1);
}

#[test]
fn the_step_that_asks_for_facts_can_be_typed_as_it_stands() {
    let counted = "LD X0\nBMOV D0 D1000 D37442\nEND\n";
    let project = "programs = [\"b.il\"]\ncpu = \"Q26UDV\"\n";
    let directory = with(&[("a b.il", counted), ("b.il", counted), ("scanbound.toml", project)]);
    let step = |arguments: &[&str]| {
        let output = scanbound(arguments, directory.path());
        let text = String::from_utf8_lossy(&output.stdout);
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let (_, step) = text.split_once("depend on it: ").expect("a step");
        step.to_owned()
    };
    let named = step(&["audit", "a b.il", "--cpu", "Q26UDV"]);
    assert!(named.starts_with("scanbound facts 'a b.il' --cpu Q26UDV "), "{named}");
    let here = step(&["audit"]);
    assert!(
        here.starts_with("scanbound facts ") && !here.starts_with("scanbound facts b.il"),
        "{here}"
    );
}
