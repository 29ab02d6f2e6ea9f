//! The command line as its users meet it: arguments, output and exit codes.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Output};

/// The cases under `tests/cli`, and the examples of the README and the method's page.
#[test]
fn cases() {
    trycmd::TestCases::new().case("tests/cli/*.trycmd").case("README.md").case("docs/method.md");
}

fn scanbound(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .args(arguments)
        .current_dir(directory)
        .output()
        .expect("the program starts")
}

/// So many bytes that no shortcut of a reader hides what a whole file of them does.
const GARBAGE: usize = 100 << 20;

/// Writes a file of `GARBAGE` bytes that `next` makes.
fn garbage(path: &Path, next: impl Fn(u64) -> u8) {
    let mut file = BufWriter::new(File::create(path).expect("a new file"));
    let mut state: u64 = 0x9E37_79B9_7F4A_7C15;
    for _ in 0..GARBAGE {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        file.write_all(&[next(state >> 33)]).expect("written");
    }
    file.flush().expect("written");
}

fn refused(directory: &Path, file: &str) {
    let output = scanbound(&["audit", file, "--cpu", "Q26UDV"], directory);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told:.2000}");
    assert!(output.stdout.is_empty());
    assert!(told.contains(file), "{told:.2000}");
    assert!(told.len() < 2_000_000, "{} bytes of messages", told.len());
}

#[test]
fn garbage_of_100_mb_is_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    // Bytes of every value; then printable lines; then lines that begin like instructions.
    garbage(&directory.path().join("bytes.csv"), |n| n.to_le_bytes()[0]);
    refused(directory.path(), "bytes.csv");
    garbage(&directory.path().join("lines.il"), |n| match n % 40 {
        0 => b'\n',
        n => 32 + u8::try_from(n).expect("below 40") * 2,
    });
    refused(directory.path(), "lines.il");
    let path = directory.path().join("almost.il");
    let mut file = BufWriter::new(File::create(&path).expect("a new file"));
    for _ in 0..GARBAGE / 8 {
        file.write_all(b"LD X0 Q\n").expect("written");
    }
    file.flush().expect("written");
    refused(directory.path(), "almost.il");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    use std::process::Stdio;
    let directory = tempfile::tempdir().expect("a directory");
    // Its reports take several writes.
    let text = format!("{}END\n", "LDP X0\nMOV K1 D0\n".repeat(400));
    std::fs::write(directory.path().join("a.il"), text).expect("written");
    let audit = |format| vec!["audit", "a.il", "--cpu", "Q26UDV", "--format", format];
    for arguments in [vec!["tables", "qnudv"], audit("text"), audit("json"), audit("csv")] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_scanbound"))
            .args(&arguments)
            .current_dir(directory.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("it ends");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
        assert!(!told.contains("cannot be written"), "{arguments:?}: {told}");
    }
}

#[test]
fn a_report_takes_the_old_ones_place_whole() {
    let directory = tempfile::tempdir().expect("a directory");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let report = directory.path().join("report.json");
    std::fs::write(&report, "old").expect("written");
    let report = report.to_str().expect("a plain path");
    let arguments = ["audit", "samples/paper/program.il", "--table", "samples/paper/table.csv"];
    let written = scanbound(&[&arguments[..], &["--format", "json", "-o", report]].concat(), root);
    assert_eq!(written.status.code(), Some(0));
    assert!(written.stdout.is_empty());
    let json = std::fs::read_to_string(report).expect("a report");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["schema"], "scanbound.audit/1");
    // Without --format the file's name says which it is; an unknown suffix means text.
    for (name, begins) in [("a.csv", "\u{FEFF}group,"), ("a.log", "The longest scan takes")] {
        let file = directory.path().join(name);
        let path = file.to_str().expect("a plain path");
        assert_eq!(
            scanbound(&[&arguments[..], &["-o", path]].concat(), root).status.code(),
            Some(0)
        );
        let text = std::fs::read_to_string(&file).expect("a report");
        assert!(text.starts_with(begins), "{name}: {text:.80}");
        std::fs::remove_file(file).expect("removed");
    }
    // A failing run leaves what is there.
    let failed = scanbound(&["audit", "nowhere.il", "-o", report], root);
    assert_eq!(failed.status.code(), Some(2));
    assert!(std::fs::read_to_string(report).expect("still there").starts_with('{'));
    let left = std::fs::read_dir(directory.path()).expect("a directory").count();
    assert_eq!(left, 1, "no half-written file is left behind");
}

/// Every file of Rust below a directory.
fn sources(directory: &Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            found.push(path);
        }
    }
}

/// The options that a text names: two dashes and a word.
fn options(text: &str) -> std::collections::BTreeSet<String> {
    let words = text.split("--").skip(1).map(|rest| {
        let end = rest.find(|c: char| !(c.is_ascii_lowercase() || c == '-')).unwrap_or(rest.len());
        rest[..end].trim_end_matches('-').to_owned()
    });
    words.filter(|word| word.len() > 1).collect()
}

#[test]
fn messages_name_options_that_there_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let help =
        |arguments: &[&str]| String::from_utf8(scanbound(arguments, root).stdout).expect("text");
    let all = help(&["--help"]);
    let commands = all.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    let commands = commands.take_while(|line| line.starts_with("  "));
    let mut known = options(&all);
    for command in commands.filter_map(|line| line.split_whitespace().next()) {
        known.extend(options(&help(&[command, "--help"])));
    }
    assert!(known.contains("time") && known.contains("facts"));
    let mut files = Vec::new();
    sources(&root.join("src"), &mut files);
    for file in files {
        let text = std::fs::read_to_string(&file).expect("text");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for line in code.lines().filter(|line| line.contains('"')) {
            for option in options(line) {
                assert!(known.contains(&option), "{}: --{option}: {line}", file.display());
            }
        }
    }
}
