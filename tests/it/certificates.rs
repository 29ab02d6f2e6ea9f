//! Certificates hold before another solver: the `z3` binary answers each question as the file says, and Z3 itself those
//! on what scans keep.

use crate::command::binary;

use common::audited::{asked, listed, table};
use scanbound::audit::{Concluded, certificates as files_of, conclude, follow};
use scanbound::base::facts::Facts;
use scanbound::passes::values::Trust;
use scanbound::program::{BitTarget, ExclusiveBits, Step};
use scanbound::scan::model::Group;
use scanbound::scan::size_limits::SizeLimits;
use scanbound::scan::violations::{Violation, scan_model_of_violations};
use scanbound::solve::export::never;
use scanbound::solve::{Limits, unreachable_charges};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Audits a project and writes its certificates; the files.
fn certificates(directory: &Path, arguments: &[&str]) -> Vec<PathBuf> {
    let audit = binary()
        .arg("audit")
        .args(arguments)
        .arg("--certificate")
        .arg(directory)
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
    assert!(files.len() >= 5, "{files:?}");
    for file in files {
        let name = file.file_name().expect("a name").to_string_lossy().into_owned();
        if name == "README.txt" {
            continue;
        }
        if name.ends_with("-scan.smt2") {
            assert_eq!(z3(&file), "sat", "{name}");
            continue;
        }
        assert_eq!(z3(&file), "unsat", "{name}");
        if !name.starts_with("group-") {
            continue;
        }
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

fn concluded(trust: Trust, facts: &str, text: &str) -> Concluded {
    let table = table("Op1,1,0,0\nFMOV,0,0,1\nBMOV,0,0,1\n");
    let inputs = listed(text.replace("; ", "\n") + "\n");
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    let request = asked(&inputs, &table, &facts, trust);
    conclude(follow(&request).expect("followed"), &request).expect("an audit")
}

/// Z3's answer to a question.
fn asks(text: &str) -> z3::SatResult {
    let solver = z3::Solver::new();
    solver.from_string(text.replace("(check-sat)", ""));
    solver.check()
}

/// The files on what the bound rests on, each of which Z3 answers as it should, and the index's lines on that.
fn rests_on(concluded: &Concluded) -> (Vec<String>, String) {
    let mut names = Vec::new();
    let mut index = String::new();
    for file in files_of(concluded) {
        if file.name == "README.txt" {
            index = file.text;
        } else if !file.name.starts_with("group-") {
            assert_eq!(asks(&file.text), z3::SatResult::Unsat, "{}\n{}", file.name, file.text);
            names.push(file.name);
        }
    }
    let lines =
        index.lines().filter(|line| line.starts_with(' ') || line.contains("No file for these"));
    (names, lines.map(|line| format!("{}\n", line.trim())).collect())
}

/// Whether each breach is proved never to happen here, and Z3's answer to all of them at once.
fn breaches(concluded: &Concluded) -> (Vec<(Violation, bool)>, z3::SatResult) {
    let followed = &concluded.followed;
    let times = followed.prices.times();
    let (model, found) =
        scan_model_of_violations(&followed.program, &times, &SizeLimits::default())
            .expect("followed");
    let constraints = (0..model.constraints.len()).collect();
    let group = Group { charges: (0..found.len()).collect(), variables: Vec::new(), constraints };
    let shown = unreachable_charges(&model, &group, &Limits::default());
    let answer = asks(&never(&model, &group, &[], &|_| String::new()));
    let told = found.into_iter().enumerate().map(|(at, breach)| (breach, shown.contains(&at)));
    (told.collect(), answer)
}

const ALL: [&str; 3] = ["invariants-power-up.smt2", "invariants-kept.smt2", "counts.smt2"];

#[test]
fn what_words_are_trusted_with_is_shown_to_be_kept() {
    let round = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; LD X1; MOV K7 D50; END";
    let (names, index) = rests_on(&concluded(Trust::Counts, "", round));
    assert_eq!(names, ALL);
    let says = "D50 is 0, 7 or 19\nD50 is 0, 7 or 19\nthe number of iterations or units of a.txt:1 FOR D50 is at most the limit that the bound uses\n";
    assert_eq!(index, says);
    // One word rests on another.
    let two = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV D51 D50; WAND K15 D0 D51; END";
    let (names, index) = rests_on(&concluded(Trust::Counts, "", two));
    assert_eq!(names, ALL);
    assert!(index.contains("D50 is 0 to 15\nD51 is 0 to 15\n"), "{index}");
    // Nothing is trusted, but the scan itself says how far it counts.
    let within = "LD SM400; WAND K7 D0 D50; FOR D50; LD X0; Op1; NEXT; END";
    let (names, index) = rests_on(&concluded(Trust::None, "", within));
    assert_eq!(names, ["counts.smt2"]);
    assert_eq!(
        index,
        "the number of iterations or units of a.txt:3 FOR D50 is at most the limit that the bound uses\n"
    );
    // What scans are stated to start with is taken as given.
    let stated = "LD SM400; + K3 D0 D50; FOR D50; LD X0; Op1; NEXT; END";
    let (names, _) = rests_on(&concluded(Trust::None, "[ranges]\nD0 = [0, 4]\n", stated));
    assert_eq!(names, ["counts.smt2"]);
}

#[test]
fn what_the_scans_formula_does_not_show_is_told() {
    // What `SER` gives is any value in the formula.
    let search = "FOR D50; LD X0; Op1; NEXT; LD SM400; SER D0 D100 D50 K30; MOV K3 D60; FMOV D0 D200 D60; END";
    let (names, index) = rests_on(&concluded(Trust::Counts, "", search));
    assert_eq!(names, ["invariants-power-up.smt2", "counts.smt2"]);
    let (shown, open) = index.split_once("No file for these").expect("something is not shown");
    assert!(shown.contains("D200 D60") && open.contains("D50 is 0 to 30"), "{index}");
    // A loop that is summed up is not followed.
    let summed = "LD SM400; WAND K7 D0 D50; FOR K3000; NOPS; LD X0; FMOV K0 D100 D50; NEXT; END";
    let summed = summed.replace("NOPS", &["NOP"; 150].join("; "));
    let (names, index) = rests_on(&concluded(Trust::None, "", &summed));
    assert_eq!(names, [""; 0]);
    let (_, open) = index.split_once("No file for these").expect("something is not shown");
    assert!(open.contains("FMOV K0 D100 D50 is at most the limit that the bound uses"), "{index}");
}

#[test]
fn blocks_and_indices_are_shown_to_reach_no_further_than_was_found() {
    let block = "LD X0; AND>= D50 K0; AND<= D50 K9; FMOV K0 D100 D50; END";
    let (names, index) = rests_on(&concluded(Trust::None, "", block));
    assert_eq!(names, ["counts.smt2"]);
    assert!(index.contains("FMOV K0 D100 D50 is at most the limit that the bound uses"), "{index}");
    let write = "LD SM400; WAND K7 Z0; MOV K19 D50; MOV D9 D60Z0; FOR D50; LD X0; Op1; NEXT; END";
    let mut sure = concluded(Trust::None, "", write);
    let (names, index) = rests_on(&sure);
    assert_eq!(names, ["counts.smt2"]);
    assert!(
        index.contains("MOV D9 D60Z0 writes only cells that the bound takes into account"),
        "{index}"
    );
    for indexed in sure.followed.program.indexed.values_mut() {
        indexed.proved.iter_mut().for_each(|(_, high)| *high -= 1);
    }
    let (found, answer) = breaches(&sure);
    let open: Vec<Violation> = found.iter().filter(|one| !one.1).map(|one| one.0.clone()).collect();
    assert!(matches!(open[..], [Violation::Reach(_)]) && answer == z3::SatResult::Sat, "{found:?}");
}

#[test]
fn relays_are_shown_to_stay_apart() {
    let steps = "LD M0; AND X0; SET M1; RST M0; LD M1; AND X1; SET M0; RST M1; LDI M0; ANI M1; SET M0; \
        LD M0; AND M1; Op1; END";
    let (names, index) = rests_on(&concluded(Trust::All, "", steps));
    assert_eq!(names, ALL[..2]);
    assert_eq!(index, "M0 and M1 are not both on\nM0 and M1 are not both on\n");
}

#[test]
fn relays_that_are_off_after_memory_was_cleared_are_asked_about() {
    let steps = "LD X0; SET M0; LD X1; SET M1; LD M0; AND M1; Op1; END";
    let mut sure = concluded(Trust::All, "", steps);
    let program = &mut sure.followed.program;
    let cells = program.instructions.iter().flat_map(|one| one.operands.iter());
    let mut cells = cells.map(|operand| operand.device.cell);
    let m0 = cells.find(|&cell| program.cell_name(cell) == "M0").expect("a relay");
    let bits = vec![BitTarget::Cell(m0)];
    program.mutually_exclusive.push(ExclusiveBits { bits, max_on: 0, writers: Vec::new() });
    let file = |sure: &Concluded| {
        let mut files = files_of(sure);
        files.find(|file| file.name == ALL[0]).expect("a file").text
    };
    let text = file(&sure);
    let says = "M0 is off when the first scan starts, because memory was cleared before it";
    assert!(text.contains(says), "{text}");
    assert_eq!(asks(&text), z3::SatResult::Unsat, "{text}");
    // If it were on then, the file would say so.
    sure.followed.program.power_up.values.insert(m0, 1);
    let text = file(&sure);
    assert_eq!(asks(&text), z3::SatResult::Sat, "{text}");
}

/// What is not so is not shown, by the solver here or by Z3.
#[test]
fn what_is_not_kept_is_not_shown() {
    let round = "FOR D50; LD X0; Op1; NEXT; LD SM400; MOV K19 D50; MOV K7 D50; END";
    let sure = concluded(Trust::Counts, "", round);
    let (found, answer) = breaches(&sure);
    assert!(found.iter().all(|(_, shown)| *shown) && answer == z3::SatResult::Unsat, "{found:?}");
    let kept = |change: &dyn Fn(&mut Concluded)| {
        let mut wrong = concluded(Trust::Counts, "", round);
        change(&mut wrong);
        let (found, answer) = breaches(&wrong);
        (found.iter().map(|(_, shown)| *shown).collect::<Vec<bool>>(), answer)
    };
    // 19 stands there for a moment only, but a power failure leaves it there.
    let narrower = kept(&|one| {
        let program = &mut one.followed.program;
        (program.trusted_ranges[0].high, program.stated_ranges[0].high) = (18, 18);
        program.trusted_ranges[0].values.retain(|&value| value != 19);
        program.stated_ranges[0].values.retain(|&value| value != 19);
    });
    assert_eq!(narrower, (vec![false, true], z3::SatResult::Sat));
    // Without the range the loop may make more turns than were followed.
    let fewer = kept(&|one| match &mut one.followed.program.instructions[0].step {
        Step::ForBegin { most, .. } => *most = 18,
        step => panic!("{step:?}"),
    });
    assert_eq!(fewer, (vec![true, false], z3::SatResult::Sat));
    let unknown = kept(&|one| one.followed.program.stated_ranges.clear());
    assert_eq!(unknown, (vec![true, false], z3::SatResult::Sat));
    let steps = "LD X0; SET M0; LD X1; SET M1; LD M0; AND M1; Op1; END";
    let mut both = concluded(Trust::All, "", steps);
    let program = &mut both.followed.program;
    assert_eq!(program.mutually_exclusive, []);
    let [m0, m1] = ["M0", "M1"].map(|name| {
        let cells = program.instructions.iter().flat_map(|one| one.operands.iter());
        let mut cells = cells.map(|operand| operand.device.cell);
        cells.find(|&cell| program.cell_name(cell) == name).expect("a relay")
    });
    let bits = vec![BitTarget::Cell(m0), BitTarget::Cell(m1)];
    program.mutually_exclusive.push(ExclusiveBits {
        bits: bits.clone(),
        max_on: 1,
        writers: Vec::new(),
    });
    assert_eq!(breaches(&both), (vec![(Violation::All(bits), false)], z3::SatResult::Sat));
}
