//! The rules that hold between the modules, read off the source text: who may know whom, and how files look.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of the library in the order in which data flows. None imports a later one.
const ORDER: &[&str] = &[
    "time",
    "diagnostic",
    "budget",
    "column",
    "facts",
    "program",
    "dialect",
    "emulate",
    "input",
    "table",
    "price",
    "model",
    "scan",
    "groups",
    "solve",
    "replay",
    "audit",
    "verdict",
    "compare",
    "render",
    "report",
    "command",
];

/// What a module must not know although it comes earlier, and why.
const STRANGERS: &[(&str, &[&str], &str)] = &[
    (
        "replay",
        &["dialect", "table", "price", "model", "scan", "groups", "solve"],
        "the interpreter judges the analysis and shares nothing with it",
    ),
    ("scan", &["dialect", "table"], "dialects end at the program"),
    ("groups", &["dialect", "table", "price", "scan"], "the scan model is all there is to slice"),
    ("solve", &["dialect", "table", "price", "scan"], "the scan model is all there is to solve"),
    ("price", &["dialect"], "dialects end at the program"),
    ("table", &["dialect", "program"], "a table is text and times"),
    (
        "emulate",
        &["program", "scan", "replay", "table"],
        "the machine is emulated from its own description",
    ),
    (
        "compare",
        &["scan", "groups", "solve", "table"],
        "a comparison knows the audit's result only",
    ),
    ("report", &["dialect", "scan", "groups", "solve"], "a report shows and computes nothing"),
    ("render", &["dialect", "scan", "groups", "solve", "replay"], "rendering knows findings only"),
];

/// Names of dialects and of their makers, which nothing behind the program knows.
const DIALECTS: &[&str] = &[
    "melsec",
    "mitsubishi",
    "omron",
    "keyence",
    "rockwell",
    "minasec",
    "flowchart",
    "gx works",
    "gxworks",
];

/// The modules that may know dialects: those before the program's end, the emulator of one machine, and those
/// that talk to the user.
const KNOW_DIALECTS: &[&str] = &["dialect", "emulate", "audit", "command", "main"];

/// Where floating point may be used: to show shares and to share out the search's own time, and where the PLC
/// itself computes with reals. Beginnings of paths.
const FLOATS: &[(&str, &[&str])] = &[
    (
        "f64",
        &["src/report", "src/render", "src/command", "src/solve/maxima.rs", "src/replay/lists.rs"],
    ),
    ("f32", &["src/dialect", "src/scan", "src/replay", "src/report", "src/render", "src/command"]),
];

struct Source {
    path: String,
    /// The module of the library it belongs to; `None` outside `src`.
    module: Option<String>,
    text: String,
}

impl Source {
    /// The lines of code with their numbers: no comments, nothing behind the first test module.
    fn code(&self) -> impl Iterator<Item = (usize, &str)> {
        let lines = self.text.lines().enumerate().map(|(n, line)| (n + 1, line.trim()));
        let inline_tests = |text: &str| text == "mod tests {";
        lines
            .take_while(move |(_, line)| !inline_tests(line))
            .filter(|(_, line)| !line.starts_with("//"))
    }

    fn is_test(&self) -> bool {
        self.path.ends_with("tests.rs") || self.path.contains("/tests/")
    }

    fn module(&self) -> &str {
        self.module.as_deref().unwrap_or("")
    }
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn collect(directory: &Path, into: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(directory) else { return };
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

fn sources() -> Vec<Source> {
    let mut paths = Vec::new();
    for directory in ["src", "tests", "benches"] {
        collect(&root().join(directory), &mut paths);
    }
    paths.sort();
    paths.iter().map(|path| source(path)).collect()
}

fn source(path: &Path) -> Source {
    let relative = path.strip_prefix(root()).expect("below the root").to_string_lossy();
    let relative = relative.replace('\\', "/");
    let module = relative.strip_prefix("src/").map(|rest| {
        let first = rest.split('/').next().expect("a first part");
        first.trim_end_matches(".rs").to_owned()
    });
    let text = fs::read_to_string(path).expect("source is text");
    Source { path: relative, module, text }
}

fn library() -> Vec<Source> {
    let inside = |s: &Source| s.module.as_deref().is_some_and(|m| m != "lib" && m != "main");
    sources().into_iter().filter(inside).collect()
}

/// Whether the word stands in the text by itself.
fn has_word(text: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(part) && !text[at + word.len()..].starts_with(part))
}

/// The modules of this library that a line of code names by path.
fn named(line: &str) -> impl Iterator<Item = &str> {
    let paths = line.match_indices("crate::").map(|(at, found)| &line[at + found.len()..]);
    paths.flat_map(|rest| {
        let group = rest.strip_prefix('{').map(|rest| rest.split('}').next().unwrap_or(rest));
        let items = group.unwrap_or(rest).split(',').take(group.map_or(1, |_| usize::MAX));
        items.map(|item| {
            let item = item.trim_start();
            let end = item.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(item.len());
            &item[..end]
        })
    })
}

fn none(faults: Vec<String>) {
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

#[test]
fn every_file_begins_with_one_sentence_on_what_it_holds() {
    let starts = |s: &Source| s.text.lines().next().is_some_and(|line| line.starts_with("//! "));
    none(sources().iter().filter(|s| !starts(s)).map(|s| s.path.clone()).collect());
}

#[test]
fn no_file_is_longer_than_800_lines() {
    let lines = |s: &Source| s.text.lines().count();
    let long = |s: &Source| lines(s) > 800;
    none(
        sources().iter().filter(|s| long(s)).map(|s| format!("{}: {}", s.path, lines(s))).collect(),
    );
}

#[test]
fn every_module_has_its_place_in_the_order() {
    let text = fs::read_to_string(root().join("src/lib.rs")).expect("lib.rs");
    let modules = text.lines().filter_map(|line| line.trim_start().strip_prefix("pub mod "));
    let unplaced = modules
        .map(|name| name.trim_end_matches(';'))
        .filter(|name| !ORDER.contains(name))
        .map(|name| format!("give `{name}` its place in ORDER of tests/architecture.rs"));
    none(unplaced.collect());
}

#[test]
fn no_module_imports_a_later_one_or_a_stranger() {
    let place: BTreeMap<&str, usize> =
        ORDER.iter().enumerate().map(|(place, name)| (*name, place)).collect();
    let mut faults = Vec::new();
    for s in library().iter().filter(|s| !s.is_test()) {
        let strangers = STRANGERS.iter().filter(|(module, ..)| *module == s.module());
        for (number, line) in s.code() {
            for other in named(line) {
                if place.get(other) > place.get(s.module()) && place.contains_key(other) {
                    faults.push(format!("{}:{number}: imports the later `{other}`", s.path));
                }
                for (_, others, why) in strangers.clone() {
                    if others.contains(&other) {
                        faults.push(format!("{}:{number}: names `{other}`, but {why}", s.path));
                    }
                }
            }
        }
    }
    none(faults);
}

#[test]
fn only_solve_names_z3() {
    let mut faults = Vec::new();
    for s in library().iter().filter(|s| s.module() != "solve") {
        let bad = s.code().filter(|(_, line)| line.contains("z3::") || has_word(line, "z3_sys"));
        faults.extend(bad.map(|(number, line)| format!("{}:{number}: {line}", s.path)));
    }
    none(faults);
}

#[test]
fn nothing_behind_the_program_knows_a_dialect() {
    let mut faults = Vec::new();
    for s in library().iter().filter(|s| !KNOW_DIALECTS.contains(&s.module()) && !s.is_test()) {
        for (number, line) in s.code() {
            // A table's file is called after its machine.
            let lower = line.to_lowercase();
            if !lower.contains("timing-tables/") && DIALECTS.iter().any(|name| lower.contains(name))
            {
                faults.push(format!("{}:{number}: {line}", s.path));
            }
        }
    }
    none(faults);
}

#[test]
fn dialects_do_not_know_each_other() {
    let directory = root().join("src/dialect");
    let Ok(entries) = fs::read_dir(directory) else { return };
    let names: Vec<String> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter_map(|path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned()))
        .filter(|name| name != "mod")
        .collect();
    let mut faults = Vec::new();
    for s in library() {
        let Some(rest) = s.path.strip_prefix("src/dialect/") else { continue };
        let own = rest.split(['/', '.']).next().expect("a first part");
        for other in names.iter().filter(|name| *name != own && own != "mod") {
            let paths = [format!("dialect::{other}"), format!("super::{other}::")];
            let knows = |(_, line): &(usize, &str)| paths.iter().any(|path| line.contains(path));
            // Within one dialect's directory, `super::` means its own modules.
            let inner = rest.contains('/');
            let bad =
                s.code().filter(knows).filter(|(_, line)| !inner || line.contains("dialect::"));
            faults.extend(bad.map(|(number, line)| format!("{}:{number}: {line}", s.path)));
        }
    }
    none(faults);
}

#[test]
fn times_never_pass_through_floating_point() {
    let mut faults = Vec::new();
    for (float, allowed) in FLOATS {
        for s in library()
            .iter()
            .filter(|s| !s.is_test() && !allowed.iter().any(|at| s.path.starts_with(at)))
        {
            let bad = s.code().filter(|(_, line)| has_word(line, float));
            faults.extend(bad.map(|(number, line)| format!("{}:{number}: {line}", s.path)));
        }
    }
    none(faults);
}

#[test]
fn the_binary_is_thin() {
    let main = fs::read_to_string(root().join("src/main.rs")).expect("main.rs");
    assert!(main.lines().count() <= 80, "main.rs parses, calls and renders; the rest is library");
}

#[test]
fn the_library_prints_nothing() {
    let mut faults = Vec::new();
    for s in library().iter().filter(|s| s.module() != "command" && !s.is_test()) {
        let prints = |(_, line): &(usize, &str)| {
            ["print!(", "println!(", "eprint!(", "eprintln!(", "dbg!("]
                .iter()
                .any(|name| has_word(line, name.trim_end_matches('(')) && line.contains(name))
        };
        faults.extend(s.code().filter(prints).map(|(n, line)| format!("{}:{n}: {line}", s.path)));
    }
    none(faults);
}

#[test]
fn the_rules_see_what_they_forbid() {
    assert_eq!(named("use crate::scan::walk;").collect::<Vec<_>>(), ["scan"]);
    assert_eq!(named("use crate::{solve::x, time};").collect::<Vec<_>>(), ["solve", "time"]);
    assert_eq!(named("a(crate::time::Picos, crate::model::Lit)").count(), 2);
    assert!(has_word("x as f64;", "f64") && !has_word("my_f64", "f64"));
    let source = Source {
        path: "src/x.rs".to_owned(),
        module: Some("x".to_owned()),
        text: "//! X.\nuse a;\n  // no\n#[cfg(test)]\nmod tests {\nuse b;\n}\n".to_owned(),
    };
    assert_eq!(source.code().collect::<Vec<_>>(), [(2, "use a;"), (4, "#[cfg(test)]")]);
}
