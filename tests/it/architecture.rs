//! The rules that hold between the modules, read off the source text: who may know whom, and how files look.

use crate::imports::Crate;
use scanbound::base::code::Code;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Crates that may depend on these crates of the workspace only, and why. What a crate may see at all, its manifest
/// says.
const SEES: &[(&str, &[&str], &str)] = &[
    ("replay", &["base", "ir"], "the interpreter judges the analysis and shares nothing with it"),
    ("scan", &["base", "ir", "model"], "fronts end at the program, and times are copied"),
    ("solve", &["base", "ir", "model"], "the scan model is all there is to solve"),
    ("timing", &["base", "ir"], "a table is text and times, and fronts end at the program"),
    ("passes", &["base", "ir"], "fronts end at the program"),
];

/// Modules that must not name these crates although their crate depends on them, and why.
const STRANGERS: &[(&str, &[&str], &str)] = &[
    (
        "crates/plant/src/minasec",
        &["ir", "replay", "timing"],
        "the machine is emulated from its own description",
    ),
    ("crates/timing/src/table", &["ir"], "a table is text and times"),
    ("crates/report/src/render", &["audit"], "rendering knows findings only"),
];

/// Where the pages on codes stand: those of findings in the input, and the rules of reports.
const PAGES: [&str; 2] = ["crates/base/codes", "crates/report/codes"];

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

/// The modules that may know dialects: those before the program's end, the emulator of one machine, what writes
/// programs, and those that talk to the user.
const KNOW_DIALECTS: &[&str] = &[
    "front",
    "front-flowchart",
    "front-iec",
    "front-melsec",
    "front-minasec",
    "front-omron",
    "fronts",
    "measured",
    "plant",
    "snet",
    "scanbound",
];

/// Where floating point may be used: to show shares and to share out the search's own time, and where the PLC
/// itself computes with reals. Beginnings of paths.
const FLOATS: &[(&str, &[&str])] = &[
    (
        "f64",
        &[
            "crates/report",
            "src/command",
            "crates/front-iec/src/assembler/value.rs",
            "crates/solve/src/maxima.rs",
            "crates/replay/src/lists.rs",
        ],
    ),
    (
        "f32",
        &[
            "crates/plant/src/simulation",
            "crates/front",
            "crates/iec-tree/src/resolve/initial.rs",
            "crates/scan",
            "crates/replay",
            "crates/report",
            "src/command",
        ],
    ),
];

struct Source {
    path: String,
    /// The crate it belongs to; `None` for tests and benches.
    of: Option<String>,
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

    fn of(&self) -> &str {
        self.of.as_deref().unwrap_or("")
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
    for directory in ["src", "crates", "tests", "benches"] {
        collect(&root().join(directory), &mut paths);
    }
    paths.sort();
    paths.iter().map(|path| source(path)).collect()
}

fn source(path: &Path) -> Source {
    let relative = path.strip_prefix(root()).expect("below the root").to_string_lossy();
    let relative = relative.replace('\\', "/");
    let of = match relative.split('/').collect::<Vec<_>>()[..] {
        ["src", ..] => Some("scanbound".to_owned()),
        ["crates", name, "src", ..] => Some(name.to_owned()),
        _ => None,
    };
    let text = fs::read_to_string(path).expect("source is text");
    Source { path: relative, of, text }
}

fn library() -> Vec<Source> {
    sources().into_iter().filter(|s| s.of.is_some()).collect()
}

/// The crates of the workspace that a crate depends on, tests apart.
fn dependencies(name: &str) -> BTreeSet<String> {
    let manifest = root().join("crates").join(name).join("Cargo.toml");
    let text = fs::read_to_string(manifest).expect("a manifest");
    let lines = text.lines().skip_while(|line| *line != "[dependencies]").skip(1);
    let lines = lines.take_while(|line| !line.starts_with('['));
    let names = lines.filter_map(|line| line.strip_prefix("scanbound-"));
    names.map(|rest| rest.split(['.', ' ']).next().unwrap_or(rest).to_owned()).collect()
}

/// Whether the word stands in the text by itself.
fn has_word(text: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(part) && !text[at + word.len()..].starts_with(part))
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

/// rustfmt leaves comments as they are. Rows of tables may be longer.
#[test]
fn comments_are_at_most_120_characters_wide() {
    let sources = sources().into_iter();
    let is_comment = |line: &str| line.starts_with("//") && !line.contains(" | ");
    let is_long = |line: &str| is_comment(line.trim_start()) && line.chars().count() > 120;
    let long = |s: Source| {
        let lines = s.text.lines().enumerate().filter(|(_, line)| is_long(line));
        lines.map(|(at, _)| format!("{}:{}", s.path, at + 1)).collect::<Vec<_>>()
    };
    none(sources.flat_map(long).collect());
}

#[test]
fn crates_see_no_more_than_they_may() {
    let mut faults = Vec::new();
    for (name, allowed, why) in SEES {
        let more = dependencies(name).into_iter().filter(|one| !allowed.contains(&one.as_str()));
        faults.extend(more.map(|one| format!("{name} depends on {one}, but {why}")));
    }
    for s in library().iter().filter(|s| !s.is_test()) {
        for (_, others, why) in STRANGERS.iter().filter(|(room, ..)| s.path.starts_with(room)) {
            let names: Vec<String> = others.iter().map(|one| format!("scanbound_{one}")).collect();
            let bad = s.code().filter(|(_, line)| names.iter().any(|name| has_word(line, name)));
            faults.extend(bad.map(|(n, line)| format!("{}:{n}: {line}, but {why}", s.path)));
        }
    }
    none(faults);
}

#[test]
fn only_solve_names_z3() {
    let mut faults = Vec::new();
    for s in library().iter().filter(|s| s.of() != "solve") {
        let bad = s.code().filter(|(_, line)| line.contains("z3::") || has_word(line, "z3_sys"));
        faults.extend(bad.map(|(number, line)| format!("{}:{number}: {line}", s.path)));
    }
    none(faults);
}

#[test]
fn nothing_behind_the_program_knows_a_dialect() {
    let mut faults = Vec::new();
    for s in library().iter().filter(|s| !KNOW_DIALECTS.contains(&s.of()) && !s.is_test()) {
        for (number, line) in s.code() {
            // A table's file is called after its machine.
            // The emulated machine's room is no dialect.
            let lower = line.to_lowercase().replace("scanbound_plant::minasec::", "");
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
    let entries = fs::read_dir(root().join("crates")).expect("the crates");
    let names =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut faults = Vec::new();
    for name in names.filter(|name| name.starts_with("front-")) {
        let others = dependencies(&name).into_iter().filter(|one| one.starts_with("front"));
        faults.extend(
            others.filter(|one| one != "front").map(|one| format!("{name} depends on {one}")),
        );
    }
    none(faults);
}

#[test]
fn files_of_a_crate_use_each_other_without_circles() {
    let sources = library();
    // The library and the command of the top level are two crates, in one directory.
    let is_command = |s: &Source| s.path == "src/main.rs" || s.path.starts_with("src/command/");
    let crate_of = |s: &Source| match is_command(s) {
        true => "the command".to_owned(),
        false => s.of().to_owned(),
    };
    let mut crates: BTreeMap<String, Vec<(&str, &str)>> = BTreeMap::new();
    for s in sources.iter().filter(|s| !s.is_test()) {
        let (_, path) = s.path.split_once("src/").expect("below src");
        crates.entry(crate_of(s)).or_default().push((path, &s.text));
    }
    let found = crates.into_iter().flat_map(|(name, files)| {
        let circles = Crate::new(files).circles().into_iter();
        circles.map(move |files| format!("{name}: {}", files.join(" ")))
    });
    none(found.collect());
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
    let may_print = |s: &Source| s.path.starts_with("src/command/") || s.path == "src/main.rs";
    for s in library().iter().filter(|s| !may_print(s) && !s.is_test()) {
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
    let lines = sources.iter().filter(|s| !s.is_test()).flat_map(Source::code);
    let used: BTreeSet<&str> = lines
        .flat_map(|(_, line)| line.split("Code::").skip(1))
        .map(|rest| rest.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default())
        .collect();
    for &code in Code::ALL {
        let (variant, name) = (format!("{code:?}"), code.name());
        let words = name.split('-').map(|word| word[..1].to_uppercase() + &word[1..]);
        if words.collect::<String>() != variant {
            faults.push(format!("Code::{variant} is named {name}"));
        }
        if !known.insert(format!("{name}.md")) {
            faults.push(format!("two codes are named {name}"));
        }
        if !used.contains(variant.as_str()) {
            faults.push(format!("Code::{variant} is used nowhere"));
        }
        let page = root().join(PAGES[0]).join(format!("{name}.md"));
        let text = fs::read_to_string(&page).unwrap_or_default();
        let begins = format!("# {name}\n\n{}.\n\n## Example\n\n", code.summary());
        if !text.starts_with(&begins) || !text.contains("\n## What to do\n\n") {
            faults.push(format!("{}/{name}.md must begin with {begins:?}", PAGES[0]));
        }
    }
    known.extend(scanbound::report::page::names().map(|name| format!("{name}.md")));
    known.insert("README.md".to_owned());
    let pages = PAGES.iter().flat_map(|pages| fs::read_dir(root().join(pages)).expect("pages"));
    let pages = pages.map(|page| page.expect("a page").file_name().to_string_lossy().into_owned());
    faults
        .extend(pages.filter(|page| !known.contains(page)).map(|page| format!("no code: {page}")));
    none(faults);
}

#[test]
fn the_rules_see_what_they_forbid() {
    assert!(has_word("x as f64;", "f64") && !has_word("my_f64", "f64"));
    let source = Source {
        path: "src/x.rs".to_owned(),
        of: Some("x".to_owned()),
        text: "//! X.\nuse a;\n  // no\n#[cfg(test)]\nmod tests {\nuse b;\n}\n".to_owned(),
    };
    assert_eq!(source.code().collect::<Vec<_>>(), [(2, "use a;"), (4, "#[cfg(test)]")]);
}
