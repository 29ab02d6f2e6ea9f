//! Reports, commands and their figures.

mod figures;
mod pattern;

use figures::{Project, hold};
use std::path::{Path, PathBuf};
use std::time::Duration;

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(name)
}

/// Files of a directory of samples as a project.
fn samples(directory: &str, files: &[&str]) -> Project {
    let read = |file: &&str| {
        let path = sample(directory).join(file);
        (
            (*file).to_owned(),
            std::fs::read(&path).unwrap_or_else(|fault| panic!("{path:?}: {fault}")),
        )
    };
    Project { files: files.iter().map(read).collect(), ..Project::default() }
}

fn text(path: &str) -> String {
    std::fs::read_to_string(sample(path)).expect("a sample")
}

#[test]
fn figures_of_the_samples_follow_from_each_other() {
    let of_cpu = |cpu, project: Project| Project { cpu: Some(cpu), ..project };
    let line = of_cpu("Q26UDV", samples("transfer-line", &["line.il"]));
    let table = std::fs::read(sample("paper/table.csv")).expect("a table");
    let projects = [
        Project {
            table: Some(("table.csv".to_owned(), table)),
            ..samples("paper", &["program.il"])
        },
        Project { facts: text("transfer-line/facts.toml"), ..line.clone() },
        line,
        samples("filler", &["MAIN.csv", "SUB.csv", "COMMENT.csv"]),
        of_cpu("FX3U", samples("drives", &["drives.il"])),
        of_cpu("C200H", samples("snet", &["self-holding.il"])),
        of_cpu("CJ2M", samples("sorter", &["sorter.il"])),
        samples("sorter", &["sorter.cxt"]),
        samples("sfc", &["line.st"]),
        samples("sfc", &["line.xml"]),
        samples("sfc", &["macros.xml"]),
        Project { has_response: true, ..samples("minasec-u", &["test-program.asm"]) },
    ];
    projects.iter().for_each(hold);
}

#[test]
fn figures_of_loops_whose_counts_nobody_states_follow_from_each_other() {
    let recipes = samples("recipes", &["MAIN.csv", "STORE.csv", "RECIPE.csv", "COMMENT.csv"]);
    hold(&recipes);
    hold(&Project { facts: text("recipes/facts.toml"), ..recipes });
}

#[test]
fn figures_of_flowcharts_follow_from_each_other() {
    for entry in std::fs::read_dir(sample("flowchart")).expect("samples") {
        let name = entry.expect("a file").file_name();
        hold(&samples("flowchart", &[name.to_str().expect("a name")]));
    }
}

#[test]
fn figures_of_what_is_not_stated_follow_from_each_other() {
    let points = "LD X0\nOUT Y17\nLD X1\nBMOV D100 D200 K50\nLDI X1\nBMOV D100 D300 K40\nEND\n";
    let interrupt = "EI\nLD X0\nMOV K1 D0\nFEND\nI0\nLD SM400\nINC D1\nIRET\nEND\n";
    let count =
        "LD X0\nBMOV D100 D200 D7\nLD X1\nBMOV D300 D400 D8\nLDI X1\nFMOV K0 D500 D9\nEND\n";
    let network = "LD B0\nMOV W10 D0\nLD X0\nOUT Y0\nEND\n";
    let off = "LD X20\nSwI D12\nEND\n";
    let stated = |project: Project, facts: &str| Project { facts: facts.to_owned(), ..project };
    let q = |list| Project::list("Q26UDV", list);
    let table = "instruction,on_us,off_us\nLD,0.1,0.1\nSwI,5,20\nEND,5,5\n";
    let projects = [
        q(points),
        stated(q(points), "[io]\ninputs = 64\noutputs = 32\n"),
        stated(q(points), "[io]\ninputs = 64\noutputs = 32\nbase = \"main\"\n"),
        stated(q(points), "[io]\nbase = \"main\"\n"),
        Project::list("FX3U", points),
        Project::list("L26CPU-BT", points),
        q(interrupt),
        stated(q(interrupt), "[interrupts]\nI0 = 2\n[io]\ninputs = 16\noutputs = 16\n"),
        q(network),
        stated(q(network), "[network]\nrefresh = \"1.5ms\"\n"),
        q(count),
        stated(q(count), "[counts]\nD7 = [0, 20]\n"),
        Project { time_limit: Some(Duration::ZERO), ..q(points) },
        Project { time_limit: Some(Duration::ZERO), ..q(count) },
        Project { table: Some(("table.csv".to_owned(), table.into())), ..q(off) },
    ];
    projects.iter().for_each(hold);
}
