//! What slips of a newcomer get: files that would be lost, names that mean nothing, and projects that are not read.

use std::path::Path;
use std::process::{Command, Output};

const PROGRAM: &str = "LD X0\nMOV K1 D0\nEND\n";

fn scanbound(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .args(arguments)
        .current_dir(directory)
        .output()
        .expect("the program starts")
}

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
    assert!(why.contains("plant.toml is there already") && why.contains("stdout"), "{why}");
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
    let read_where = "scanbound.toml here is read only where no program is named";
    for arguments in [&["check", "."][..], &["diff", "a.il", "a.il"]] {
        let (code, why) = told(arguments, directory.path());
        assert!(code == Some(2) && why.contains(read_where), "{arguments:?}: {why}");
    }
    assert_eq!(told(&["check"], directory.path()).0, Some(0));
    std::fs::remove_file(directory.path().join("scanbound.toml")).expect("removed");
    let (_, why) = told(&["check", "."], directory.path());
    assert!(why.contains("no limit is given") && !why.contains("is read only"), "{why}");
}
