//! Reports, commands and their figures.

mod figures;
mod pattern;
mod sections;

use super::run;
use crate::command::binary;
use figures::{Project, hold};
use std::io::Read;
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

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A new directory of this name.
fn fresh(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reports").join(name);
    if path.exists() {
        std::fs::remove_dir_all(&path).expect("an old one goes");
    }
    std::fs::create_dir_all(&path).expect("a directory");
    path
}

#[test]
fn what_is_slower_when_off_is_not_said_to_run() {
    let arguments = "--table table.csv --cpu Q26UDV off-dearer.il";
    let report = super::audit("off-dearer", arguments);
    let charges = report["groups"][0]["charges"].as_array().expect("charges");
    let charge = charges.iter().find(|one| one["instruction"] == "SwI D12").expect("a charge");
    assert_eq!((&charge["runs"], &charge["cost_ps"]), (&false.into(), &20_000_000.into()));
    let text = super::scanbound("off-dearer", &format!("audit -v {arguments}")).stdout;
    let line =
        "off 20.000 us rung 1 off-dearer.il:2 SwI D12 does not run: this is its time when off";
    assert!(pattern::normal(&text).contains(line), "{text}");
}

/// The file that `facts` proposes, with all that it proposes stated.
fn proposed(project: &str, directory: &Path) -> String {
    let offer = run(&format!("facts {project}"), directory);
    assert_eq!(offer.code, Some(0), "{project}: {}", offer.stderr);
    let lines = offer.stdout.lines().filter(|line| !line.starts_with("##"));
    lines.map(|line| format!("{}\n", line.strip_prefix("# ").unwrap_or(line))).collect()
}

#[test]
fn what_facts_proposes_is_taken() {
    let list = "LD SM400\nWOR K1000 D7\nFOR D7\nLD SM400\nMOV K1 D1\nNEXT\nLD X0\nMOV K900 D7\nLD X1\nBMOV D100 D300 D7\nEND\n";
    let directory = fresh("proposed");
    let own = directory.join("own.il");
    std::fs::write(&own, list).expect("written");
    let own = format!("{} --cpu Q26UDV", own.display());
    let projects = [
        "samples/paper/program.il --table samples/paper/table.csv",
        "samples/transfer-line/line.il --cpu Q26UDV",
        "samples/filler",
        "samples/drives/drives.il --cpu FX3U",
        "samples/snet/self-holding.il --cpu C200H",
        "samples/sorter/sorter.il --cpu CJ2M",
        "samples/sorter/sorter.cxt",
        "samples/recipes",
        "samples/sfc/line.st",
        "samples/sfc/macros.xml",
        "samples/minasec-u/test-program.asm",
        "samples/flowchart/star-delta.lst",
        &own,
    ];
    for (at, project) in projects.into_iter().enumerate() {
        let facts = directory.join(format!("{at}.toml"));
        std::fs::write(&facts, proposed(project, here())).expect("written");
        let taken = run(&format!("audit -q {project} --facts {}", facts.display()), here());
        assert_eq!(taken.code, Some(0), "{project}: {}", taken.stderr);
    }
    let facts = std::fs::read_to_string(directory.join("12.toml")).expect("written");
    assert!(facts.contains("\"D7\" = [0, 1000]"), "{facts}");
}

#[test]
fn a_fact_that_contradicts_the_program_is_named_with_the_instruction_that_does() {
    let directory = fresh("contradicting");
    let list = "LD SM400\nWOR K1000 D7\nFOR D7\nLD SM400\nMOV K1 D1\nNEXT\nEND\n";
    std::fs::write(directory.join("main.il"), list).expect("written");
    std::fs::write(directory.join("facts.toml"), "[counts]\n\"D7\" = [0, 20]\n").expect("written");
    let project = "main.il --cpu Q26UDV --facts facts.toml";
    let refused = run(&format!("audit {project}"), &directory);
    assert_eq!(refused.code, Some(2));
    for told in
        ["facts.toml:2", "0 to 20", "`FOR D7` (main.il:3)", "`WOR K1000 D7` (main.il:2) writes D7"]
    {
        assert!(refused.stderr.contains(told), "{told}: {}", refused.stderr);
    }
    let found = run(&format!("doctor {project}"), &directory);
    assert_eq!(found.code, Some(1));
    assert!(
        pattern::normal(&found.stdout).contains("cannot be 0 to 20 as stated"),
        "{}",
        found.stdout
    );
    // Nor is a fact blamed that the program keeps.
    std::fs::write(
        directory.join("facts.toml"),
        "[counts]\n\"D7\" = [0, 1000]\n[io]\ninputs = 0\noutputs = 0\n",
    )
    .expect("written");
    assert_eq!(run(&format!("audit -q {project}"), &directory).code, Some(0));
    assert_eq!(run(&format!("doctor {project}"), &directory).code, Some(0));
}

#[test]
fn all_formats_of_several_checks_show_one_bound() {
    let directory = fresh("several");
    for (name, limit) in [("one", "10ms"), ("two", "1ms")] {
        let own = directory.join(name);
        std::fs::create_dir_all(&own).expect("a directory");
        std::fs::write(own.join("main.il"), "LD X0\nOUT Y0\nLD X1\nBMOV D0 D100 K50\nEND\n")
            .expect("written");
        let file = format!("programs = [\"main.il\"]\ncpu = \"Q26UDV\"\nlimit = \"{limit}\"\n");
        std::fs::write(own.join("scanbound.toml"), file).expect("written");
    }
    let of = |format: &str| run(&format!("check --all --format {format}"), &directory).stdout;
    let json: serde_json::Value = serde_json::from_str(&of("json")).expect("JSON");
    let projects = json["projects"].as_array().expect("projects");
    assert_eq!(projects.len(), 2);
    let table = of("csv");
    let (html, text) = (of("html"), pattern::normal(&of("text")));
    for (project, row) in projects.iter().zip(table.lines().skip(1)) {
        let scan = &project["report"]["scan"];
        let cells: Vec<&str> = row.split(',').collect();
        let us = |key: &str| scan[key].as_u64().expect("a time") as f64 / 1e6;
        assert_eq!(cells[4].parse::<f64>().expect("a time"), us("proved_ps"), "{row}");
        assert_eq!(cells[5].parse::<f64>().expect("a time"), us("refuted_ps"), "{row}");
        let told = scanbound::base::time_text::at_most(scanbound::base::time::Picos(
            scan["proved_ps"].as_u64().expect("a time"),
        ));
        assert!(html.contains(&format!("<td class=\"n\">{told}</td>")), "{told}: {html}");
        assert!(text.contains(&format!("than {told}")), "{told}: {text}");
    }
}

#[test]
fn a_loop_whose_end_is_not_known_has_no_upper_bound_in_any_format() {
    let directory = fresh("no-bound");
    let text = "PROGRAM p VAR i, k : DINT; n : INT; END_VAR FOR i := 1 TO k DO n := n + 1; END_FOR; END_PROGRAM";
    std::fs::write(directory.join("main.st"), text).expect("written");
    let file = "programs = [\"main.st\"]\nlimit = \"1s\"\n";
    std::fs::write(directory.join("scanbound.toml"), file).expect("written");
    let report = run("audit main.st --format json", &directory).json();
    let scan = &report["scan"];
    for key in ["upper_ps", "cycle_ps", "proved_ps"] {
        assert!(scan[key].is_null(), "{key}: {scan}");
    }
    assert_eq!(
        (&scan["exact"], report["unbounded"].as_array().map(Vec::len)),
        (&false.into(), Some(1))
    );
    let of = |format: &str| run(&format!("check --all --format {format}"), &directory).stdout;
    let table = of("csv");
    let row: Vec<&str> = table.lines().nth(1).expect("a row").split(',').collect();
    assert_eq!((row[1], row[4]), ("undecided", ""), "{table}");
    assert!(of("html").contains("<td class=\"n\"></td>"));
    let checks: serde_json::Value = serde_json::from_str(&of("json")).expect("JSON");
    assert!(checks["projects"][0]["report"]["scan"]["upper_ps"].is_null());
}

/// The data of a page.
fn page(arguments: &str) -> serde_json::Value {
    let page = run(&format!("audit {arguments} --format html"), here()).stdout;
    let (_, data) = page.split_once("id=\"data\">").expect("data");
    let (data, _) = data.split_once("</script>").expect("data");
    serde_json::from_str(data).expect("JSON")
}

#[test]
fn the_page_draws_inputs_as_the_report_has_them() {
    let projects = [
        "samples/recipes --facts samples/recipes/facts.toml",
        "samples/filler",
        "samples/transfer-line/line.il --cpu Q26UDV",
    ];
    let mut looked_at = 0;
    for project in projects {
        let page = page(project);
        let report = run(&format!("audit {project} --format json"), here()).json();
        let numbers: std::collections::BTreeSet<u64> = page["ladder"]
            .as_array()
            .expect("rungs")
            .iter()
            .map(|rung| rung[0].as_u64().expect("a number"))
            .collect();
        assert_eq!(numbers.len() as u64, report["program"]["blocks"].as_u64().expect("rungs"));
        for rung in page["ladder"].as_array().expect("rungs") {
            // Symbol, text, label, line, comments, timed, reached, runs: the first contact of a rung runs if it
            // conducts.
            let element = &rung[3][0];
            let text = element[1].as_str().expect("a text");
            let Some(device) = text.strip_prefix("LD X") else { continue };
            let (timed, reached, runs) = (&element[5], &element[6], &element[7]);
            let on = report["witness"][format!("X{device}")].as_bool();
            if let (Some(on), 1, 1) =
                (on, timed.as_u64().unwrap_or(0), reached.as_u64().unwrap_or(0))
            {
                assert_eq!(runs.as_u64(), Some(u64::from(on)), "{project}: {element}");
                looked_at += 1;
            }
        }
    }
    assert!(looked_at > 5, "{looked_at}");
}

#[test]
fn a_bound_without_a_controller_says_so_in_its_first_line() {
    let told = "(table iec, all times assumed, no controller named)";
    let text = run("audit samples/sfc/line.st", here()).stdout;
    assert!(
        pattern::normal(&text).contains(&format!("the longest found takes 63.6 us {told}.")),
        "{text}"
    );
    let report = run("audit samples/sfc/line.st --format json", here()).json();
    assert!(report["answer"].as_str().is_some_and(|answer| answer.contains(told)));
    assert_eq!(
        (&report["table"]["all_assumed"], &report["program"]["cpu"]),
        (&true.into(), &().into())
    );
    let check = run("check samples/sfc/line.st --limit 1ms", here()).stdout;
    assert!(pattern::normal(&check).contains(told), "{check}");
    let named = run("audit samples/drives/drives.il --cpu FX3U", here()).stdout;
    assert!(!pattern::normal(&named).contains("no controller named"), "{named}");
}

#[test]
fn words_that_only_count_summarised_loops_are_part_of_the_witness() {
    let directory = fresh("summarised");
    let list = "LD SM400\nMOV K1 D0\nFOR D7\nLD SM400\nINC D1\nNEXT\nEND\n";
    std::fs::write(directory.join("main.il"), list).expect("written");
    let report = run("audit main.il --cpu Q26UDV --format json", &directory).json();
    assert_eq!(report["witness"]["D7"], 32_767, "{}", report["witness"]);
    let conditions = report["conditions"].as_array().expect("conditions");
    assert!(conditions.iter().any(|one| one["name"] == "D7"), "{conditions:?}");
}

#[test]
fn a_budget_that_is_over_leaves_all_untried() {
    let asked = run("advise samples/recipes --budget 1ms --format json", here());
    assert_eq!(asked.code, Some(0), "{}", asked.stderr);
    let advice = asked.json();
    assert!(advice["untried"].as_u64() > Some(0), "{advice}");
    assert_eq!(advice["statements"].as_array().map_or(0, Vec::len), 0, "{advice}");
}

#[test]
fn the_help_of_diff_asks_for_two_versions_and_for_no_project_file() {
    let help = pattern::normal(&run("diff --help", here()).stdout);
    assert!(help.contains("The two versions, each a file or a directory"), "{help}");
    assert!(help.contains("scanbound.toml is not read"), "{help}");
    assert!(!help.contains("those of scanbound.toml"), "{help}");
}

/// Ended from outside, as batch systems do, an audit says what is proved.
#[test]
#[cfg(unix)]
fn sigterm_ends_an_audit_with_what_is_proved() {
    let mut child = binary()
        .args(["audit", "samples/recipes"])
        .current_dir(here())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the command runs");
    // Before it watches for signals, one would end it.
    std::thread::sleep(Duration::from_millis(1_500));
    let told = std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(told.is_ok());
    let mut text = String::new();
    child.stdout.take().expect("a pipe").read_to_string(&mut text).expect("text");
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(0), "{text}");
    assert!(text.starts_with("No scan takes longer than "), "{text}");
}

#[test]
fn what_a_controller_does_differently_is_stated_of_iec_programs_alone() {
    let directory = fresh("controller");
    std::fs::write(directory.join("main.il"), "LD X0\nOUT Y0\nEND\n").expect("written");
    let facts = "[controller]\n\"actions have no final scan\" = true\n";
    std::fs::write(directory.join("facts.toml"), facts).expect("written");
    let told = run("audit main.il --cpu Q26UDV --facts facts.toml", &directory);
    assert_eq!(told.code, Some(2), "{}", told.stdout);
    assert!(told.stderr.contains("[controller] cannot be stated for this PLC"), "{}", told.stderr);
}
