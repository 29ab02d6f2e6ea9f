//! MELSEC and OMRON lists: operands, operation errors, damaged files, and what trust is worth.

use super::{audit, case, lower_ns, scanbound, upper_ns};
use serde_json::Value;
use std::fs;
use std::process::Command;

/// The rows of a table of the attack's directory.
fn table(name: &str) -> String {
    fs::read_to_string(case("attack").join(name)).expect("a table")
}

/// The report on a list by a table, where all rows that are not named cost nothing.
fn report(list: &str, rows: &str, arguments: &str) -> Value {
    let directory = tempfile::tempdir().expect("a directory");
    fs::write(directory.path().join("a.il"), list.replace("; ", "\n")).expect("written");
    let rows = format!("{}{}", table("zero-ops.csv"), rows.replace("; ", "\n"));
    fs::write(directory.path().join("t.csv"), rows).expect("written");
    let output = Command::new(env!("CARGO_BIN_EXE_scanbound"))
        .args(["audit", "a.il", "--table", "t.csv", "--format", "json"])
        .args(arguments.split_whitespace())
        .current_dir(directory.path())
        .output()
        .expect("the command runs");
    let run = super::Run::of(&output);
    assert_eq!(run.code, Some(0), "{list}\n{}{}", run.stdout, run.stderr);
    run.json()
}

/// The bounds of a list in microseconds.
fn bounds(list: &str, rows: &str, arguments: &str) -> (u64, u64) {
    let report = report(list, rows, arguments);
    (lower_ns(&report) / 1000, upper_ns(&report).div_ceil(1000))
}

const Q: &str = "--cpu Q26UDV --dialect melsec-list";

#[test]
fn an_operand_pays_for_each_of_its_modifiers() {
    let report = audit(
        "attack",
        "module-index.il --table module-index.csv --cpu Q26UDV --dialect melsec-list",
    );
    assert_eq!(upper_ns(&report), 110_000);
    let rows = "@+module,10,1; @+indexed,100,1; @+wordbit,1000,0; @+digits,10000,1; @+ZR,100000,0; @+D,1000000,0";
    for (list, want) in [
        ("LD U0\\G100.3; OUT Y0; END", 1010),
        ("LD U0Z1\\G100.3; OUT Y0; END", 1110),
        ("LD U0\\G100Z1.3; OUT Y0; END", 1110),
        ("LD U0\\G100.3Z1; OUT U3E0\\G7.A; END", 2120),
        ("LD SM400; MOV U3E0\\HG100Z2 W5; END", 110),
        ("LD SM400; MOV J1\\W10Z1 W5; END", 110),
        ("LD SM400; MOV J1\\K4B0 W5; END", 10_010),
        ("LD J1\\W10.3; OUT Y0; END", 1010),
        ("LD SM400; MOV K4M0Z0 W5; END", 10_100),
        ("LD SM400; MOV @ZR0 W5; END", 200_100),
        ("LD SM400; MOV W5 @ZR0Z1; END", 200_100),
        ("LD SM400; MOV @ZR0 @ZR4; END", 400_100),
        ("LD SM400; MOV @D0 W5; END", 2_000_100),
        ("LD= @ZR0 K1; OUT Y0; END", 200_100),
        ("LD SM400; MOV ZR0Z1 W5; END", 100_100),
        ("LD ZR0Z1.3; OUT Y0; END", 101_100),
        ("LD SM400; MOV K10Z1 W5; END", 100),
    ] {
        assert_eq!(bounds(list, rows, Q).1, want, "{list}");
    }
    // A row for one kind of operand leaves the others to be added.
    let own = format!("{rows}; MOV:module,5,0");
    assert_eq!(bounds("LD SM400; MOV U0\\G1Z1 W5; END", &own, Q).1, 105);
}

#[test]
fn module_access_that_is_not_understood_is_refused() {
    for operand in ["U0\\G100Q", "U0\\G100.G", "J1\\D5", "U0Q\\G1", "U0\\G"] {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.il");
        fs::write(&path, format!("LD SM400\nMOV {operand} D0\nEND\n")).expect("written");
        let run = scanbound("attack", &format!("audit {} {Q}", path.display()));
        assert_eq!(run.code, Some(2), "{operand}: {}", run.stdout);
        assert!(run.stderr.contains(operand), "{}", run.stderr);
    }
}
