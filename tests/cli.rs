//! The command line as its users meet it: arguments, output and exit codes.

#[path = "it/command.rs"]
mod command;

use command::{binary, scanbound};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Output};

/// The cases under `tests/cli`, and the examples of the README and the method's page.
#[test]
fn cases() {
    trycmd::TestCases::new().case("tests/cli/*.trycmd").case("README.md").case("docs/method.md");
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
        let mut child = binary()
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
    // Without --format the file's name says which it is; no suffix means text.
    for (name, begins) in [("a.csv", "\u{FEFF}group,"), ("a", "The longest scan takes")] {
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

/// A program's run with a text as its stdin.
fn fed(arguments: &[&str], text: &str, directory: &Path) -> Output {
    use std::process::Stdio;
    let mut child = binary()
        .args(arguments)
        .current_dir(directory)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    child.stdin.take().expect("a pipe").write_all(text.as_bytes()).expect("written");
    child.wait_with_output().expect("it ends")
}

#[test]
fn a_program_on_stdin_is_as_one_in_a_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = |output: Output| {
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{told}");
        String::from_utf8(output.stdout).expect("text")
    };
    let directory = tempfile::tempdir().expect("a directory");
    let program = std::fs::read_to_string(root.join("samples/paper/program.il"));
    let program = program.expect("a sample");
    let table = root.join("samples/paper/table.csv");
    std::fs::copy(table, directory.path().join("table.csv")).expect("copied");
    // As reports name it.
    std::fs::write(directory.path().join("stdin"), &program).expect("written");
    let how = ["--table", "table.csv"];
    for command in [&["audit"][..], &["check", "--limit", "1s"], &["show"], &["facts"]] {
        let named = text(scanbound(&[command, &["stdin"], &how].concat(), directory.path()));
        let piped = [command, &["-", "--dialect", "melsec-list"], &how].concat();
        assert_eq!(text(fed(&piped, &program, directory.path())), named);
        if command != ["show"] {
            let out = [command, &["-", "-o", "-"], &how].concat();
            assert_eq!(text(fed(&out, &program, directory.path())), named);
        }
    }
    let machine = std::fs::read_to_string(root.join("samples/minasec-u/test-program.asm"));
    let machine = machine.expect("a sample");
    let hex = text(fed(&["convert", "-", "--to", "hex"], &machine, root));
    assert!(hex.starts_with(':'), "{hex}");
    let scans = text(fed(&["emulate", "-", "--scans", "3"], &hex, root));
    assert_eq!(
        scans.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())).count(),
        3,
        "{scans}"
    );
    let program = "tests/cli/minasec.in/program.asm";
    let measured = fed(&["compare", program, "-"], "scan_ms\n0.61\n0.62\n", root);
    assert!(text(measured).contains("stdin"));
    // Twice the same, and nothing at all.
    for (arguments, told) in [(&["audit", "-", "-"][..], "given twice"), (&["audit", "-"], "empty")]
    {
        let output = fed(arguments, "", root);
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains(told), "{output:?}");
    }
}

#[test]
fn colours_are_where_they_are_asked_for() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let audit = ["audit", "samples/paper/program.il", "--table", "samples/paper/table.csv"];
    for (how, coloured) in [("always", true), ("never", false), ("auto", false)] {
        let report = scanbound(&[&audit[..], &["--color", how]].concat(), root).stdout;
        let fault = scanbound(&["--color", how, "audit", "nowhere.il"], root).stderr;
        for text in [report, fault] {
            assert_eq!(text.contains(&0x1B), coloured, "{how}: {}", String::from_utf8_lossy(&text));
        }
    }
    // A file has none.
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("a.txt");
    let out = ["--color", "always", "-o", file.to_str().expect("a plain path")];
    assert_eq!(scanbound(&[&audit[..], &out].concat(), root).status.code(), Some(0));
    assert!(!std::fs::read(file).expect("a report").contains(&0x1B));
}

#[test]
fn completions_and_pages_name_every_command() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let help = String::from_utf8(scanbound(&["--help"], root).stdout).expect("text");
    let commands = help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    let commands: Vec<&str> = commands
        .take_while(|line| line.starts_with("  "))
        .filter_map(|line| line[2..].split(' ').next().filter(|first| !first.is_empty()))
        .filter(|&command| command != "help")
        .collect();
    assert!(commands.contains(&"audit"), "{help}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = scanbound(&["completions", shell], root);
        let script = String::from_utf8(output.stdout).expect("text");
        let missing: Vec<_> =
            commands.iter().filter(|command| !script.contains(**command)).collect();
        assert!(missing.is_empty() && script.contains("time-limit"), "{shell}: {missing:?}");
    }
    let directory = tempfile::tempdir().expect("a directory");
    let place = directory.path().join("man1");
    let made = scanbound(&["man", place.to_str().expect("a plain path")], root);
    assert_eq!(made.status.code(), Some(0), "{made:?}");
    for command in commands {
        let file = place.join(format!("scanbound-{command}.1"));
        let page = std::fs::read_to_string(&file).unwrap_or_else(|_| panic!("{}", file.display()));
        assert!(page.contains(".SH SYNOPSIS"), "{page:.200}");
    }
    let page = String::from_utf8(scanbound(&["man"], root).stdout).expect("text");
    assert!(page.contains("scanbound\\-audit(1)"), "{page}");
}

/// Waits until a text has been said so often; what was said by then.
#[cfg(unix)]
fn heard(from: &std::sync::mpsc::Receiver<String>, text: &str, times: usize) -> String {
    let mut all = String::new();
    while all.matches(text).count() < times {
        let line = from.recv_timeout(std::time::Duration::from_secs(60));
        all += &line.unwrap_or_else(|_| panic!("{text} is not said: {all}"));
        all.push('\n');
    }
    all
}

#[cfg(unix)]
#[test]
fn a_watched_check_begins_again_when_a_file_changes() {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;
    let directory = tempfile::tempdir().expect("a directory");
    let at = |name: &str| directory.path().join(name);
    let write = |name: &str, text: &str| std::fs::write(at(name), text).expect("written");
    std::fs::create_dir(at("plc")).expect("a directory");
    write("plc/a.il", "LD X0\nMOV K1 D0\nEND\n");
    write("facts.toml", "[io]\ninputs = 16\noutputs = 16\n");
    let project = "programs = [\"plc\"]\ncpu = \"Q26UDV\"\nfacts = \"facts.toml\"\n";
    write("scanbound.toml", &format!("{project}limit = \"10ms\"\n"));
    let mut child = binary()
        // What it writes beside the programs does not begin it again.
        .args(["check", "--watch", "-o", "plc/report.json"])
        .current_dir(directory.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let (say, from) = std::sync::mpsc::channel();
    std::thread::spawn(move || lines.map_while(Result::ok).for_each(|line| drop(say.send(line))));
    let first = heard(&from, "watching ", 1);
    assert!(first.contains("PROVED") && first.contains("watching 3 files"), "{first}");
    // A fault is told, and mended by the next change.
    write("plc/a.il", "LD X0\nMVO K1 D0\nEND\n");
    let second = heard(&from, "watching ", 1);
    assert!(second.contains("a.il changed") && second.contains("MVO"), "{second}");
    write("plc/a.il", "LD X0\nMOV K1 D1\nEND\n");
    assert!(heard(&from, "watching ", 1).contains("PROVED"));
    write("scanbound.toml", &format!("{project}limit = \"1us\"\n"));
    let last = heard(&from, "watching ", 1);
    assert!(last.contains("scanbound.toml changed") && last.contains("REFUTED"), "{last}");
    let ended = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(ended.expect("a signal").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(1), "the last verdict");
    let report = std::fs::read_to_string(at("plc/report.json")).expect("a report");
    assert!(report.contains("\"verdict\": \"refuted\""));
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
    let commands = |text: &str| -> Vec<String> {
        let rows = text.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
        let rows = rows.take_while(|line| line.starts_with("  "));
        rows.filter_map(|line| line.split_whitespace().next().map(str::to_owned)).collect()
    };
    let all = help(&["--help"]);
    let mut known = options(&all);
    for command in commands(&all) {
        let own = help(&[&command, "--help"]);
        known.extend(options(&own));
        for action in commands(&own).iter().filter(|action| *action != "help") {
            known.extend(options(&help(&[&command, action, "--help"])));
        }
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
