//! The rules that hold between the modules, read off the source text: who may know whom, and how files look.

use scanbound::base::code::Code;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms of the library in the order in which data flows. None imports a later one.
const ORDER: &[&str] = &[
    "base",
    "link",
    "net",
    "iec",
    "snet",
    "program",
    "front",
    "minasec",
    "passes",
    "timing",
    "scan",
    "solve",
    "replay",
    "emulated",
    "calibrate",
    "audit",
    "measured",
    "report",
    "command",
];

/// Whom a room, or a part of it, must not know although it comes earlier, and why. Beginnings of paths.
const STRANGERS: &[(&str, &[&str], &str)] = &[
    (
        "replay",
        &["front", "timing", "scan", "solve"],
        "the interpreter judges the analysis and shares nothing with it",
    ),
    ("scan", &["front", "timing"], "fronts end at the program, and times are copied"),
    (
        "solve",
        &["front", "timing", "scan::scan_model", "scan::Purpose", "scan::fit"],
        "the scan model is all there is to solve",
    ),
    ("timing::price", &["front"], "fronts end at the program"),
    ("timing::table", &["front", "program"], "a table is text and times"),
    (
        "minasec",
        &["program", "scan", "replay", "timing"],
        "the machine is emulated from its own description",
    ),
    (
        "emulated",
        &["front", "scan", "solve", "passes"],
        "an emulated CPU runs what it is given and knows nothing of the analysis",
    ),
    ("calibrate", &["scan", "solve", "passes"], "what is measured hangs on no analysis"),
    ("measured", &["scan", "solve", "timing::table"], "a comparison knows the audit's result only"),
    ("report", &["front", "scan", "solve"], "a report shows and computes nothing"),
    ("report::render", &["replay"], "rendering knows findings only"),
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

/// The modules that may know dialects: those before the program's end, the emulator of one machine, what writes programs,
/// and those that talk to the user.
const KNOW_DIALECTS: &[&str] = &["front", "minasec", "snet", "calibrate", "command", "main"];

/// Where floating point may be used: to show shares and to share out the search's own time, and where the PLC
/// itself computes with reals. Beginnings of paths.
const FLOATS: &[(&str, &[&str])] = &[
    (
        "f64",
        &[
            "src/report",
            "src/command",
            "src/front/iec/value.rs",
            "src/solve/maxima.rs",
            "src/replay/lists.rs",
        ],
    ),
    ("f32", &["src/front", "src/scan", "src/replay", "src/report", "src/command"]),
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
        ["tests.rs", "fixture.rs"].iter().any(|name| self.path.ends_with(name))
            || self.path.contains("/tests/")
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

/// What of this library a line of code names by path.
fn named(line: &str) -> impl Iterator<Item = &str> {
    let paths = line.match_indices("crate::").map(|(at, found)| &line[at + found.len()..]);
    paths.flat_map(|rest| {
        let group = rest.strip_prefix('{').map(|rest| rest.split('}').next().unwrap_or(rest));
        let items = group.unwrap_or(rest).split(',').take(group.map_or(1, |_| usize::MAX));
        items.map(|item| {
            let item = item.trim_start();
            let part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
            let end = item.find(|c: char| !part(c)).unwrap_or(item.len());
            item[..end].trim_end_matches(':')
        })
    })
}

/// The modules that code names as lying beside its own.
fn siblings(code: &str) -> BTreeSet<String> {
    let word = |text: &str| -> String {
        text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    let named = code.split("super::").skip(1).flat_map(|rest| match rest.strip_prefix('{') {
        Some(group) => group
            .split('}')
            .next()
            .unwrap_or_default()
            .split(',')
            .map(|item| word(item.trim_start()))
            .collect(),
        None => vec![word(rest)],
    });
    named.collect()
}

/// The files that are left when those are taken away, again and again, that import none of the others.
fn circles(mut imports: BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    loop {
        let free: Vec<String> = imports
            .iter()
            .filter(|(_, others)| others.iter().all(|other| !imports.contains_key(other)))
            .map(|(file, _)| file.clone())
            .collect();
        if free.is_empty() {
            return imports.into_keys().collect();
        }
        free.iter().for_each(|file| drop(imports.remove(file)));
    }
}

/// Whether a path is this one or one below it.
fn is_within(path: &str, room: &str) -> bool {
    path.strip_prefix(room).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
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
        let own = s.path.trim_start_matches("src/").trim_end_matches(".rs").replace('/', "::");
        let strangers = STRANGERS.iter().filter(|(room, ..)| is_within(&own, room));
        for (number, line) in s.code() {
            for other in named(line) {
                let room = other.split("::").next().unwrap_or(other);
                if place.get(room) > place.get(s.module()) && place.contains_key(room) {
                    faults.push(format!("{}:{number}: imports the later `{other}`", s.path));
                }
                for (_, others, why) in strangers.clone() {
                    // What a room exports with a common beginning, such as `scan_model_within`.
                    if others.iter().any(|one| {
                        is_within(other, one) || (one.contains("::") && other.starts_with(one))
                    }) {
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
            // The emulated machine's room is no dialect.
            let lower = line.to_lowercase().replace("crate::minasec::", "");
            if !lower.contains("timing-tables/") && DIALECTS.iter().any(|name| lower.contains(name))
            {
                faults.push(format!("{}:{number}: {line}", s.path));
            }
        }
    }
    none(faults);
}

#[test]
fn fronts_do_not_know_each_other() {
    let directory = root().join("src/front");
    let entries = fs::read_dir(directory).expect("the fronts");
    let names: Vec<String> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.is_dir() && !path.ends_with("input"))
        .filter_map(|path| path.file_name().map(|name| name.to_string_lossy().into_owned()))
        .collect();
    let mut faults = Vec::new();
    for s in library() {
        let Some(rest) = s.path.strip_prefix("src/front/") else { continue };
        let own = rest.split(['/', '.']).next().expect("a first part");
        // The one list of them names them all.
        for other in names.iter().filter(|name| *name != own && own != "mod") {
            let bad = s.code().filter(|(_, line)| has_word(line, other));
            let bad = bad.filter(|(_, line)| line.contains("::") && !line.contains('"'));
            faults.extend(bad.map(|(number, line)| format!("{}:{number}: {line}", s.path)));
        }
    }
    none(faults);
}

#[test]
fn files_of_a_directory_import_each_other_without_circles() {
    let mut directories: BTreeMap<String, Vec<Source>> = BTreeMap::new();
    for s in library().into_iter().filter(|s| !s.is_test() && !s.path.ends_with("/mod.rs")) {
        let directory = s.path.rsplit_once('/').expect("below src").0.to_owned();
        directories.entry(directory).or_default().push(s);
    }
    let mut faults = Vec::new();
    for (directory, files) in directories {
        let name = |s: &Source| {
            let file = s.path.rsplit('/').next().expect("a file");
            file.trim_end_matches(".rs").to_owned()
        };
        let imports = files.iter().map(|s| {
            let lines: String = s.code().map(|(_, line)| format!("{line} ")).collect();
            (name(s), siblings(&lines).into_iter().filter(|other| *other != name(s)).collect())
        });
        let left = circles(imports.collect());
        if !left.is_empty() {
            faults.push(format!("{directory}: {}", left.join(", ")));
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
fn every_code_is_used_and_has_a_name_and_a_page_of_its_own() {
    let sources = library();
    let mut faults = Vec::new();
    let mut known = BTreeSet::new();
    for &code in Code::ALL {
        let (variant, name) = (format!("{code:?}"), code.name());
        let words = name.split('-').map(|word| word[..1].to_uppercase() + &word[1..]);
        if words.collect::<String>() != variant {
            faults.push(format!("Code::{variant} is named {name}"));
        }
        if !known.insert(format!("{name}.md")) {
            faults.push(format!("two codes are named {name}"));
        }
        let path = format!("Code::{variant}");
        let uses = |s: &Source| s.code().any(|(_, line)| has_word(line, &path));
        if !sources.iter().filter(|s| !s.is_test()).any(uses) {
            faults.push(format!("{path} is used nowhere"));
        }
        let page = root().join("docs/codes").join(format!("{name}.md"));
        let text = fs::read_to_string(&page).unwrap_or_default();
        let begins = format!("# {name}\n\n{}.\n\n## Example\n\n", code.summary());
        if !text.starts_with(&begins) || !text.contains("\n## What to do\n\n") {
            faults.push(format!("docs/codes/{name}.md must begin with {begins:?}"));
        }
    }
    known.extend(scanbound::report::page::names().map(|name| format!("{name}.md")));
    known.insert("README.md".to_owned());
    let pages = fs::read_dir(root().join("docs/codes")).expect("docs/codes");
    let pages = pages.map(|page| page.expect("a page").file_name().to_string_lossy().into_owned());
    faults
        .extend(pages.filter(|page| !known.contains(page)).map(|page| format!("no code: {page}")));
    none(faults);
}

#[test]
fn the_rules_see_what_they_forbid() {
    assert_eq!(named("use crate::scan::walk;").collect::<Vec<_>>(), ["scan::walk"]);
    assert_eq!(named("use crate::{solve::x, time};").collect::<Vec<_>>(), ["solve::x", "time"]);
    assert!(is_within("scan::model", "scan") && !is_within("scanner::x", "scan"));
    assert_eq!(named("a(crate::base::time::Picos, crate::scan::model::Lit)").count(), 2);
    let others = siblings("use super::{a::X, b}; fn f() { super::c::g(super::d) }");
    assert_eq!(others, ["a", "b", "c", "d"].map(str::to_owned).into());
    let imports = |of: &[(&str, &str)]| -> Vec<String> {
        let one = |&(file, other): &(&str, &str)| (file.to_owned(), [other.to_owned()].into());
        circles(of.iter().map(one).collect())
    };
    assert_eq!(imports(&[("a", "b"), ("b", "c"), ("c", "x")]), [""; 0]);
    assert_eq!(imports(&[("a", "b"), ("b", "a"), ("c", "x")]), ["a", "b"]);
    assert!(has_word("x as f64;", "f64") && !has_word("my_f64", "f64"));
    let source = Source {
        path: "src/x.rs".to_owned(),
        module: Some("x".to_owned()),
        text: "//! X.\nuse a;\n  // no\n#[cfg(test)]\nmod tests {\nuse b;\n}\n".to_owned(),
    };
    assert_eq!(source.code().collect::<Vec<_>>(), [(2, "use a;"), (4, "#[cfg(test)]")]);
}
