//! MELSEC and OMRON lists: operands, operation errors, damaged files, and what trust is worth.

use super::{audit, case, lower_ns, scanbound, upper_ns};
use crate::command::binary;
use serde_json::Value;
use std::fs;

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
    let output = binary()
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

#[test]
fn a_division_by_zero_is_no_scan() {
    let report = audit("attack", &format!("operror-reached.il --table zero-ops.csv {Q}"));
    assert_eq!((lower_ns(&report), upper_ns(&report)), (0, 1000));
    assert_eq!(report["scan"]["exact"], false);
    let between = report["scan"]["stands_between"].as_str().expect("a reason");
    assert!(between.contains("operation error") && between.contains("on_error"), "{between}");
    let run = scanbound(
        "attack",
        &format!("check operror-reached.il --table zero-ops.csv {Q} --limit 500ns"),
    );
    assert_eq!(run.code, Some(3), "{}", run.stdout);
    for case in ["div-zero-reached.st", "null-interface-reached.st"] {
        let arguments = format!("{case} --table zero.csv --facts calls.toml --trust all");
        let report = audit("attack", &arguments);
        assert_eq!(report["scan"]["lower_kind"], "admissible", "{case}");
        assert!(report["witness_run"].as_array().is_none_or(Vec::is_empty), "{case}");
        let run = scanbound("attack", &format!("check {arguments} --limit 500ns --refute reached"));
        assert_eq!(run.code, Some(3), "{case}: {}", run.stdout);
    }
}

#[test]
fn operands_that_an_instruction_does_not_take_stop_the_cpu() {
    for operation in [
        "D/ D0 K0 D2",
        "BIN HA D2",
        "BCD K10000 D2",
        "BCD K-1 D2",
        "DBCD K100000000 D2",
        "LIMIT K10 K5 D0 D1",
        "DECO D0 D2 K9",
        "SQR E-1 D2",
        "BMOV D12280 D0 K20",
        "BMOV D0 D12280 K20",
        "FMOV K0 D12280 K20",
        "E/ E1 E0 D2",
        "B/ H10 H0 D2",
        "B+ HA H1 D2",
        "LOG E0 D2",
        "ASIN E1.5 D2",
        "INT E40000 D2",
        "WORD K40000 D2",
        "GRY K-1 D2",
        "DIS D0 D2 K5",
    ] {
        let list = format!("LD X0; {operation}; Op1; END");
        assert_eq!(bounds(&list, "", Q), (0, 1), "{operation}");
    }
    for (operation, lower) in [
        ("/ D0 K1 D2", 1),
        ("/ D0 D1 D2", 1),
        ("BIN H9 D2", 1),
        ("BIN D0 D2", 1),
        ("BCD K9999 D2", 1),
        ("BMOV D12268 D0 K20", 1),
        ("ENCO D10 D2 K4", 1),
        ("LIMIT K5 K5 D0 D1", 1),
        ("SQR E1 D2", 1),
        ("DECO D0 D2 K8", 1),
    ] {
        let list = format!("LD X0; {operation}; Op1; END");
        assert_eq!(bounds(&list, "", Q), (lower, 1), "{operation}");
    }
    // What stood in a word is worked out.
    for (before, operation, lower) in [
        ("MOV K0 D10", "ENCO D10 D2 K4", 0),
        ("MOV K1 D10", "ENCO D10 D2 K4", 1),
        ("MOV K-1 Z0", "MOV D0Z0 D2", 0),
        ("MOV K12288 Z0", "MOV D0Z0 D2", 0),
        ("MOV K5 Z0", "MOV D0Z0 D2", 1),
        ("MOV K-1 Z0", "OUT M0Z0", 0),
        ("MOV K-1 Z0", "MOV D2 D1Z0", 1),
        ("MOV K20000 D7", "BMOV D0 D100 D7", 0),
        ("MOV K20 D7", "BMOV D0 D100 D7", 1),
    ] {
        let list = format!("LD SM400; {before}; LD X0; {operation}; Op1; END");
        assert_eq!(bounds(&list, "", Q), (lower, 1), "{before}; {operation}");
    }
    // A contact is worked out whatever it gives: no scan counts.
    let contact = "LD SM400; MOV K-1 Z0; LD M0Z0; OUT Y0; LD X0; Op1; END";
    assert_eq!(bounds(contact, "", Q), (0, 1));
}

#[test]
fn whether_a_cpu_goes_on_after_an_error_can_be_stated() {
    let directory = tempfile::tempdir().expect("a directory");
    let facts = directory.path().join("on.toml");
    fs::write(&facts, "[scan]\non_error = \"continue\"\n").expect("written");
    let list = "LD X0; / D0 K0 D2; Op1; END";
    assert_eq!(bounds(list, "", &format!("{Q} --facts {}", facts.display())), (1, 1));
    // The FX goes on by default.
    assert_eq!(
        bounds("LD X0; DIV D0 K0 D2; Op1; END", "", "--cpu FX3U --dialect melsec-list"),
        (1, 1)
    );
    fs::write(&facts, "[scan]\non_error = \"stop\"\n").expect("written");
    let stated = format!("--cpu FX3U --dialect melsec-list --facts {}", facts.display());
    assert_eq!(bounds("LD X0; DIV D0 K0 D2; Op1; END", "", &stated), (0, 1));
}

#[test]
fn seventeen_levels_are_one_too_many() {
    let loops = |levels: usize| {
        let begin = "FOR K1; ".repeat(levels);
        format!("{begin}LD X0; Op1; {}END", "NEXT; ".repeat(levels))
    };
    let calls = |levels: usize| {
        let one = |n: usize| format!("P{n}; LD X0; CALL P{}; RET; ", n + 1);
        let all: String = (0..levels - 1).map(one).collect();
        format!("LD X0; CALL P0; FEND; {all}P{}; LD X0; Op1; RET; END", levels - 1)
    };
    for levels in [16, 17] {
        let lower = u64::from(levels == 16);
        assert_eq!(bounds(&loops(levels), "", Q), (lower, 1), "{levels} loops");
        assert_eq!(bounds(&calls(levels), "", Q), (lower, 1), "{levels} calls");
    }
    let fx = "--cpu FX3U --dialect melsec-list";
    assert_eq!(bounds(&loops(5), "", fx), (1, 1));
    assert_eq!(bounds(&loops(6), "", fx), (0, 1));
}

#[test]
fn single_values_of_a_word_hold_for_every_scan() {
    let report = audit("attack", "int70-single-values.il --table unit.csv --cpu Q26UDV");
    assert_eq!((lower_ns(&report), upper_ns(&report)), (200_000, 200_000));
    assert_eq!(report["assumptions"][0]["values"], serde_json::json!([0, 10]));
    // Values of a progression, and values on both sides of 0.
    let unit = table("unit.csv");
    for (list, want) in [
        ("LD SM400; WAND K7 D3 D7; BMOV D100 D300 D7; LIMIT K-10 K-10 D9 D3; END", 600),
        ("LD SM400; WAND K127 D3 D7; BMOV D100 D300 D7; WAND K48 D9 D3; END", 4800),
        ("LD SM400; WAND K15 D3 D7; BMOV D100 D300 D7; WAND K2032 D9 D3; END", 0),
    ] {
        let directory = tempfile::tempdir().expect("a directory");
        fs::write(directory.path().join("a.il"), list.replace("; ", "\n")).expect("written");
        fs::write(directory.path().join("t.csv"), &unit).expect("written");
        let file = directory.path().join("a.il");
        let arguments = format!(
            "audit {} --table {} --cpu Q26UDV --format json",
            file.display(),
            directory.path().join("t.csv").display()
        );
        let run = scanbound("attack", &arguments);
        assert_eq!(run.code, Some(0), "{list}\n{}", run.stderr);
        assert_eq!(upper_ns(&run.json()) / 1000, want, "{list}");
    }
}

/// A CX-Programmer project with the rungs of one section, each as it stands in the file.
fn project(sections: &str) -> String {
    format!(
        "CXProgVer:=\"2.3\";\nName:=\"T\";\nResource[0]:=\nBEGIN\n PLC:=\n BEGIN\n  Config:=\"[DEV]DEV:CJ2M;CPU:CPU31;\";\n END;\n Programs:=\n BEGIN\n  Program[0]:=\n  BEGIN\n   Name:=\"P\";\n   Comment:=\"\";\n   TaskID:=256;\n   Sections:=\n   BEGIN\n{sections}   END;\n  END;\n  ProgramCount:=1;\n END;\nEND;\n"
    )
}

const SECTIONS: &str = "    SC:=2;\n    Sec[0]:=\n    BEGIN\n     SecName:=\"A\";\n     ProgramData:=\n     BEGIN\n      RC:=2;\n      R[0]:=\n      BEGIN\n       Com:=\"\";\n       Flags:=\"1,0\";\n       SL:=\n$?St$Bk?_#[1]\nLD 0.00\nOUT 100.00\n$?St$Bk?_#[1]\n       AtchCmts:=\n       BEGIN\n        CC:=0;\n       END;\n      END;\n      R[1]:=\n      BEGIN\n       Com:=\"\";\n       SL:=\"\";\n      END;\n     END;\n    END;\n    Sec[1]:=\n    BEGIN\n     SecName:=\"END\";\n     ProgramData:=\n     BEGIN\n      RC:=1;\n      R[0]:=\n      BEGIN\n       SL:=\n$?St$Bk?_#[2]\nEND(001)\n$?St$Bk?_#[2]\n      END;\n     END;\n    END;\n";

#[test]
fn a_damaged_project_is_an_error() {
    let run = scanbound("attack", "audit cxt-rung-dropped.cxt");
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("SL"), "{}", run.stderr);
    let whole = project(SECTIONS);
    assert_eq!(audited(&whole).code, Some(0), "{}", audited(&whole).stderr);
    for (from, to) in [
        ("SL:=\n$?St$Bk?_#[1]", "SLx:=\n$?St$Bk?_#[1]"),
        ("SL:=\n$?St$Bk?_#[1]", "SL:=\n"),
        ("OUT 100.00\n$?St$Bk?_#[1]\n", "OUT 100.00\n"),
        ("       SL:=\n$?St$Bk?_#[1]", "$?St$Bk?_#[1]"),
        ("SL:=\"\";", "SX:=\"\";"),
        ("R[0]:=", "RX[0]:="),
        ("R[0]:=", "R[0]:"),
        ("R[1]:=", "R[2]:="),
        ("      R[1]:=\n      BEGIN\n       Com:=\"\";\n       SL:=\"\";\n      END;\n", ""),
        ("RC:=2;", "RC:=3;"),
        ("RC:=2;", "RD:=2;"),
        ("SC:=2;", "SC:=3;"),
        ("Sec[1]:=", "Sex[1]:="),
        ("ProgramData:=", "SFCData:="),
        (
            "ProgramData:=\n",
            "STData:=\n$?St$Bk?_#[9]\nx := 1;\n$?St$Bk?_#[9]\n     ProgramData:=\n",
        ),
        ("Sections:=", "Section:="),
        ("ProgramCount:=1;", "ProgramCount:=2;"),
    ] {
        assert!(whole.contains(from), "{from}");
        let run = audited(&whole.replacen(from, to, 1));
        assert_eq!(run.code, Some(2), "{from} as {to}: {}", run.stdout);
        assert!(run.stderr.contains("broken-project"), "{from} as {to}: {}", run.stderr);
    }
}

/// The command's run on a CX-Programmer project.
fn audited(text: &str) -> super::Run {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("a.cxt");
    fs::write(&file, text).expect("written");
    scanbound("attack", &format!("audit {}", file.display()))
}

#[test]
fn more_trust_never_makes_a_bound_larger() {
    let upper = |arguments: &str, trust: &str| {
        upper_ns(&audit("attack", &format!("{arguments} --trust {trust}")))
    };
    for arguments in [
        "trust-order-melsec.il --table trust-order-melsec.csv --cpu Q26UDV",
        "trust-order-iec.st --table zero.csv --facts trust-order-iec.toml",
    ] {
        let [all, counts, none] = ["all", "counts", "none"].map(|trust| upper(arguments, trust));
        assert!(all <= counts && counts <= none, "{arguments}: {all} {counts} {none}");
    }
}

#[test]
fn one_pulse_contact_sees_the_edge_of_a_single_operation_relay() {
    let fx = "--cpu FX3U --dialect melsec-list";
    let report = audit("attack", "fx-m2800.il --table zero-ops.csv --cpu FX3U");
    assert_eq!(upper_ns(&report), 2000);
    assert!(lower_ns(&report) <= 2000);
    for (list, lower, upper) in [
        // The first contact alone is known to see it.
        ("LDP M2800; Op4; LDP M2800; Op2; LD X0; SET M2800; END", 4, 4),
        ("LDP M2800; Op1; LDP M2800; Op2; LDP M2800; Op4; LD X0; OUT M2800; END", 1, 4),
        // Relays beside these: each contact sees it.
        ("LDP M2799; Op1; LDP M2799; Op2; LD X0; OUT M2799; END", 3, 3),
        ("LDP M3072; Op1; LDP M3072; Op2; LD X0; OUT M3072; END", 3, 3),
        // Behind the coil it is seen again.
        ("LDP M2800; Op1; LD X0; OUT M2800; LDP M2800; Op2; LDP M2800; Op4; END", 2, 5),
        ("LDP M2800; Op1; LD X0; MOV K5 K4M2800; LDP M2800; Op2; END", 3, 3),
        // Two relays have an edge each.
        ("LDP M2800; Op1; LDP M2801; Op2; LD X0; OUT M2800; END", 3, 3),
        // A contact that is jumped over sees nothing.
        ("LD X1; CJ P0; LDP M2800; Op1; P0; LDP M2800; Op2; LD X0; OUT M2800; END", 1, 2),
    ] {
        let (found, bound) = bounds(list, "", fx);
        assert_eq!(bound, upper, "{list}");
        assert!(found >= lower && found <= upper, "{list}: {found}");
    }
}

#[test]
fn a_missing_routine_may_switch_what_changes_other_instructions() {
    let directory = tempfile::tempdir().expect("a directory");
    let run = |list: &str, facts: &str| {
        fs::write(directory.path().join("a.il"), list).expect("written");
        fs::write(directory.path().join("facts.toml"), facts).expect("written");
        let output = binary()
            .args(["audit", "a.il", "--cpu", "FX3U", "--facts", "facts.toml", "-v"])
            .current_dir(directory.path())
            .output()
            .expect("the command runs");
        super::Run::of(&output)
    };
    let from = "LD M8000\nCALL P7\nLD M8000\nFROM K0 K0 D0 K1\nEND\n";
    let moves = "LD M8000\nCALL P7\nLD M8000\nBMOV D0 D10 K3\nLD= D10 K1\nOUT Y0\nEND\n";
    for (writes, is_counted, is_reversed) in [
        ("", true, true),
        (", writes = [\"D5\"]", false, false),
        (", writes = [\"M8160-M8170\"]", true, true),
        (", writes = [\"M8024\"]", false, true),
    ] {
        let facts = format!("[calls]\nP7 = {{ time = \"50us\"{writes} }}\n");
        let counted = run(from, &facts);
        let code = if is_counted { 2 } else { 0 };
        assert_eq!(counted.code, Some(code), "{writes}: {}{}", counted.stdout, counted.stderr);
        let moved = run(moves, &facts);
        assert_eq!(moved.code, Some(0), "{writes}: {}", moved.stderr);
        let is_said = moved.stdout.contains("depends on M8024 or M8160");
        assert_eq!(is_said, is_reversed, "{writes}: {}", moved.stdout);
    }
    let without = moves.replace("CALL P7\n", "OUT Y1\n");
    let others = run(&without, "[external]\ndevices = [\"M8024\"]\n");
    assert!(others.stdout.contains("depends on M8024 or M8160"), "{}", others.stdout);
}

/// The report on a list with facts, where all rows that are not named cost nothing.
fn report_with(list: &str, facts: &str) -> Value {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("facts.toml");
    fs::write(&path, facts).expect("written");
    report(list, "", &format!("{Q} --facts {}", path.display()))
}

/// The devices that the longest scan found needs, as a report names them.
fn needed(report: &Value) -> String {
    report["scan"]["devices"].as_array().map_or_else(String::new, |all| {
        let one = |one: &Value| format!("{}{}", one["name"].as_str().unwrap_or(""), one["least"]);
        all.iter().map(one).collect::<Vec<_>>().join(" ")
    })
}

#[test]
fn a_scan_says_how_many_devices_it_needs() {
    let far = "LD SM400; MOV K5 Z1; MOV K7 ZR100Z1; LD= ZR100Z1 K7; Op1; END";
    let latch = "LD SM400; MOV K79 Z1; SET L22000Z1; LD L22000Z1; Op1; BMOV R0 K4L22000 K5; END";
    let short = "LD SM400; MOV K79 Z1; SET L22000Z1; LD L22000Z1; Op1; END";
    let data = "LD SM400; MOV K9 Z1; MOV K7 D20000Z1; LD= D20000Z1 K7; Op1; END";
    let bits = "[index]\nbits = 16\n";
    for (list, facts, lower, want) in [
        (far, "", 1, "ZR106"),
        (far, "[devices]\nZR = 105\n", 0, ""),
        (far, "[devices]\nZR = 106\n", 1, ""),
        // What a block of constant length needs, the program names.
        (latch, "", 1, ""),
        (latch, "[devices]\nL = 22079\n", 0, ""),
        (short, "", 1, "L22080"),
        (short, "[devices]\nl = 22079\n", 0, ""),
        (short, "[devices]\nl = 22080\n", 1, ""),
        (data, "", 1, "D20010"),
        // Whether an index leads from D12287 to the extended registers is unknown.
        ("LD D13000.0; Op2; LD SM400; MOV K9 Z1; MOV K7 D12280Z1; Op1; END", "", 0, ""),
    ] {
        let report = report_with(list, &format!("{bits}{facts}"));
        assert_eq!((lower_ns(&report) / 1000, needed(&report)), (lower, want.to_owned()), "{list}");
        assert!(upper_ns(&report) >= 1000, "{list}: the upper bound does not depend on them");
    }
    for (list, facts, want) in [
        (far, "[devices]\nZR = 50\n", "names one with the number 100"),
        (far, "[devices]\nX = 50\n", "cannot be stated"),
    ] {
        let directory = tempfile::tempdir().expect("a directory");
        let (program, path) = (directory.path().join("a.il"), directory.path().join("f.toml"));
        fs::write(&program, list.replace("Op1", "OUT Y0").replace("; ", "\n")).expect("written");
        fs::write(&path, facts).expect("written");
        let arguments = format!("audit {} {Q} --facts {}", program.display(), path.display());
        let run = scanbound("attack", &arguments);
        assert_eq!(run.code, Some(2), "{}", run.stdout);
        assert!(run.stderr.contains(want), "{}", run.stderr);
    }
}

#[test]
fn the_carry_flag_is_known_behind_a_shift() {
    for (list, want) in [
        ("MOV K1 D0; SFR D0 K1; LD SM700; Op1", (1, 1)),
        ("MOV K1 D0; SFR D0 K2; LD SM700; Op1", (0, 0)),
        ("MOV H4000 D0; SFL D0 K2; LD X0; AND SM700; Op1", (1, 1)),
        ("MOV H4000 D0; SFL D0 K1; LD SM700; Op1", (0, 0)),
        ("MOV H8000 D0; ROL D0 K1; LD SM700; Op1", (1, 1)),
        // Another instruction may change it, and so may a shift by 0, or an interrupt program.
        ("MOV K1 D0; SFR D0 K1; MOV K1 D1; LD SM700; Op1", (0, 1)),
        ("MOV K1 D0; SFR D0 K0; LD SM700; Op1", (0, 1)),
        ("MOV K1 D0; SFR D0 K1; LD SM700; Op1; FEND; I0; IRET", (0, 1)),
        // It keeps its value if the shift is not executed.
        ("MOV K1 D0; LD X0; SFR D0 K1; LD SM700; ANI X0; Op1", (0, 1)),
    ] {
        let list = format!("LD SM400; {list}; END");
        let interrupts = if list.contains("I0") { " --interrupts I0=1" } else { "" };
        assert_eq!(bounds(&list, "", &format!("{Q}{interrupts}")), want, "{list}");
    }
}

#[test]
fn special_relays_are_results_or_come_from_outside() {
    for (list, want) in [
        ("LD SM400; MOV K1 D0; MOV K1 D1; BKCMP= D0 D1 M0 K1; LD SM704; Op1", (1, 1)),
        ("LD SM400; MOV K1 D0; MOV K2 D1; BKCMP= D0 D1 M0 K1; SET M9; LD SM704; Op1", (0, 1)),
        (
            "LD SM400; MOV K1 D0; MOV K1 D1; ADRSET D1 D10; BKCMP= D0 @D10 D20.3 K1; LD SM704; Op1",
            (1, 1),
        ),
        (
            "LD SM400; MOV K1 D0; MOV K2 D1; ADRSET D1 D10; BKCMP= D0 @D10 D20.3 K1; LDI SM704; Op1",
            (1, 1),
        ),
        // A network's relay is on or off in the whole scan; a CPU with a faulty module stops.
        ("LD SM255; Op1; Op1; LDI SM255; Op1", (2, 3)),
        ("LD SM61; Op1; Op1; LDI SM61; Op1", (1, 3)),
        ("LD X0; OUT SM255; LD SM255; Op1", (0, 1)),
    ] {
        assert_eq!(bounds(&format!("{list}; END"), "", Q), want, "{list}");
    }
}

#[test]
fn a_quotient_is_known_at_an_indexed_device() {
    let list = "LD SM400; MOV K3 Z1; / K17 K5 D10Z1; LD= D13 K3; AND= D14 K2; Op1; END";
    assert_eq!(bounds(list, "", Q), (1, 1));
    let list = "LD SM400; MOV K3 Z1; D/ K17 K5 D10Z1; LDD= D13 K3; ANDD= D15 K2; Op1; END";
    assert_eq!(bounds(list, "", Q), (1, 1));
}

#[test]
fn a_number_becomes_a_text() {
    for (relay, want) in [("X0", 1), ("SM701", 0)] {
        let list = format!(
            "LD {relay}; OUT Y1; LD SM400; MOV K-325 D0; BINDA D0 D10; LD= D10 H202D; AND= D12 H3532; Op1; END"
        );
        assert_eq!(bounds(&list, "", Q), (want, 1), "{list}");
    }
}

#[test]
fn blocks_of_relays_are_moved_as_words() {
    let list = "LD SM400; MOV H8001 K4M100; MOV K2 K4M116; BMOV K4M100 K4M200 K2; BMOV K4M200 D0 K2; LD M200; AND M215; AND M217; ANI M216; AND= D0 H8001; AND= D1 K2; Op1; END";
    assert_eq!(bounds(list, "", Q), (1, 1));
    let list = "LD SM400; MOV H8001 D0; BMOV D0 K4M200 K1; LD M200; AND M215; ANI M201; Op1; END";
    assert_eq!(bounds(list, "", Q), (1, 1));
}
