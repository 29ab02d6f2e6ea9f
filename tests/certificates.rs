//! Certificates hold before another solver: the `z3` binary answers each question as the file says.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Audits a project and writes its certificates; the files.
fn certificates(directory: &Path, arguments: &[&str]) -> Vec<PathBuf> {
    let audit = Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .arg("audit")
        .args(arguments)
        .arg("--certificate")
        .arg(directory)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("scanbound runs");
    assert!(audit.status.success(), "{}", String::from_utf8_lossy(&audit.stderr));
    let mut files: Vec<PathBuf> = std::fs::read_dir(directory)
        .expect("a directory")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.sort();
    files
}

fn z3(file: &Path) -> String {
    let answer =
        Command::new("z3").arg(file).output().expect("the z3 binary runs (Debian's package z3)");
    String::from_utf8_lossy(&answer.stdout).trim().to_owned()
}

fn agrees(arguments: &[&str]) {
    let directory = tempfile::tempdir().expect("a directory");
    let files = certificates(directory.path(), arguments);
    assert!(files.len() >= 4, "{files:?}");
    for file in files {
        let name = file.file_name().expect("a name").to_string_lossy().into_owned();
        if name.ends_with("-scan.smt2") {
            assert_eq!(z3(&file), "sat", "{name}");
            continue;
        }
        assert_eq!(z3(&file), "unsat", "{name}");
        // Nothing lower would hold: a picosecond less, and the question has an answer.
        let text = std::fs::read_to_string(&file).expect("a text");
        let (head, tail) = text.split_once("(assert (> total ").expect("the question");
        let (bound, tail) = tail.split_once(')').expect("the bound");
        let less = bound.parse::<u64>().expect("picoseconds") - 1;
        std::fs::write(&file, format!("{head}(assert (> total {less}){tail}")).expect("written");
        assert_eq!(z3(&file), "sat", "{name} less a picosecond");
    }
}

#[test]
fn the_papers_example() {
    agrees(&["samples/paper/program.il", "--table", "samples/paper/table.csv"]);
}

#[test]
fn a_plant_with_words_and_timers() {
    agrees(&["samples/transfer-line/line.il", "--cpu", "Q26UDV"]);
}

#[test]
fn a_project_from_gx_works() {
    agrees(&["samples/filler"]);
}
