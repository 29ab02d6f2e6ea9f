//! What the user states beside the program: believed where it has use, told where it has none, refused where it is
//! wrong.

use crate::command::binary;

use common::audited::{audited, table};
use scanbound::audit::Concluded;
use scanbound::base::facts::Facts;

/// Audits programs of one dialect with facts, by times of one's own.
fn with(dialect: &str, files: &[(&str, &str)], facts: &str) -> Result<Concluded, String> {
    let facts = Facts::parse("facts.toml", facts).map_err(|faults| faults[0].message.clone())?;
    let table = table("CALL,2,1,0\nECALL,2,1,0\nSBS(91),2,1,0\nSBS,2,1,0\nOp1,1,0,0\nOp9,9,0,0\n");
    let cpu = (dialect == "melsec-list").then_some("Q26UDV");
    audited(dialect, cpu, files, &table, &facts)
}

/// What a MELSEC list takes beside its overhead, at most and at least, in microseconds.
fn bounds(text: &str, facts: &str) -> Result<(u64, u64), String> {
    let text = text.replace("; ", "\n") + "\n";
    let bound = with("melsec-list", &[("a.il", &text)], facts)?.audit.bound;
    let us = |time: scanbound::base::time::Picos| (time.0 - bound.overhead.0) / 1_000_000;
    Ok((us(bound.upper), us(bound.lower)))
}

#[test]
fn a_routine_that_is_not_there_takes_what_is_stated_wherever_it_is_called() {
    let once = "LD X0; CALL P153; END";
    let stated = "[calls]\nP153 = { time = '50us', writes = [] }";
    assert_eq!(bounds(once, stated), Ok((52, 52)));
    assert_eq!(bounds("LD X0; CALL P153; LD X1; CALL P153; END", stated), Ok((104, 104)));
    assert_eq!(bounds("LD X0; CALL P153; LDI X0; CALL P153; END", stated), Ok((53, 53)));
    assert_eq!(bounds("FOR K3; LD X0; CALL P153; NEXT; END", stated), Ok((156, 156)));
    let within = "LD X0; CALL P1; FEND; P1; LD X1; CALL P153; RET; END";
    assert_eq!(bounds(within, stated), Ok((54, 54)));
    let file = "[calls]\n'SUB:p03' = { time = '1.5us', writes = [] }";
    assert_eq!(bounds("LD X0; ECALL \"Sub\" P3; END", file), Ok((3, 3)));
}

#[test]
fn what_a_routine_writes_takes_any_value_and_nothing_else_does() {
    let program = "LD X0; OUT M5; LD SM400; MOV K1 D100; MOV K1 D5; LD SM400; CALL P1; LDI M5; AND X0; Op1; LD= D100 K2; Op9; LD= D5 K2; Op9; LD T3; Op9; LDI X0; OUT T3 K5; END";
    let takes =
        |writes: &str| bounds(program, &format!("[calls]\nP1 = {{ time = '1us'{writes} }}"));
    let of = |found: Result<(u64, u64), String>| found.map(|(upper, _)| upper);
    // The call and its routine, and T3, which may have run out.
    assert_eq!(takes(", writes = []"), Ok((12, 12)));
    assert_eq!(of(takes(", writes = ['M5']")), Ok(13));
    assert_eq!(of(takes(", writes = ['D100-D199']")), Ok(21));
    assert_eq!(of(takes(", writes = ['D0-D199', 'M0-M9']")), Ok(31));
    assert_eq!(of(takes("")), Ok(31));
    // A lower bound rests on nothing that only nobody knows.
    assert!(takes("").is_ok_and(|(_, lower)| lower < 31));
    let off = "LD SM400; RST T3; CALL P1; LD T3; Op9; END";
    let timer = |writes: &str| {
        of(bounds(off, &format!("[calls]\nP1 = {{ time = '1us', writes = [{writes}] }}")))
    };
    assert_eq!((timer(""), timer("'T0-T9'"), timer("'T4'")), (Ok(3), Ok(12), Ok(3)));
}

#[test]
fn the_error_offers_the_line_to_state() {
    let refused = |text: &str, stated: &str| {
        let text = text.replace("; ", "\n");
        let facts = Facts::parse("facts.toml", stated).expect("facts");
        let table = table("");
        let inputs =
            [scanbound::front::Input { name: "a.il".to_owned(), bytes: text.into_bytes() }];
        let request = scanbound::audit::Request {
            dialect: Some("melsec-list"),
            table: Some(&table),
            ..scanbound::audit::Request::new(&inputs, &facts)
        };
        match scanbound::audit::audit(&request) {
            Err(scanbound::audit::Failure::Input(faults)) => {
                let fault = faults[0].clone();
                (fault.file, fault.line, fault.help)
            }
            other => panic!("{:?}", other.map(|audit| audit.bound.upper)),
        }
    };
    for (call, line) in [
        ("CALL P153", "P153 = { time = \"50us\", writes = [\"D100-D199\"] }"),
        ("ECALL \"SUB A\" P3", "\"SUBA:P3\" = { time = \"50us\", writes = [\"D100-D199\"] }"),
    ] {
        let program = format!("LD X0; {call}; END");
        let (file, at, help) = refused(&program, "");
        assert_eq!((&*file, at), ("a.il", Some(2)));
        let (_, offered) = help.split_once("[calls] ").expect("a line is offered");
        assert_eq!(offered, line);
        // What is offered is taken.
        assert!(bounds(&program, &format!("[calls]\n{offered}")).is_ok(), "{offered}");
    }
    let wrong = "[calls]\nP1 = { time = '1us', writes = ['D9-D1'] }";
    assert_eq!(refused("LD X0; CALL P1; END", wrong).0, "facts.toml");
}

#[test]
fn a_stated_routine_that_is_there_or_is_not_called_is_told() {
    let told = |text: &str| {
        let text = text.replace("; ", "\n");
        let stated = "[calls]\nP1 = { time = '1us' }";
        let found = with("melsec-list", &[("a.il", &text)], stated).expect("an audit");
        assert!(found.audit.facts.is_empty(), "what is not used is not believed");
        let warnings = found.audit.warnings.iter().filter(|one| one.file == "facts.toml");
        warnings.map(|one| (one.line, one.message.clone())).collect::<Vec<_>>()
    };
    let is_there = "the statement about P1 under [calls] is not used: the program contains the routine, in a.il:4";
    assert_eq!(told("LD X0; CALL P1; FEND; P1; RET; END"), [(Some(2), is_there.to_owned())]);
    let not_called = "the statement about P1 under [calls] is not used: no instruction calls P1";
    assert_eq!(told("LD X0; OUT Y0; END"), [(Some(2), not_called.to_owned())]);
}

#[test]
fn omrons_subroutines_are_stated_by_their_numbers() {
    let us = |text: &str, facts: &str| {
        let text = text.replace("; ", "\n") + "\n";
        let bound = with("omron-c200h", &[("a.txt", &text)], facts)?.audit.bound;
        Ok::<_, String>((bound.upper.0 - bound.overhead.0) / 1_000_000)
    };
    let program = "LD 00000; SBS(91) 010; LD 01000; Op1; END(01)";
    assert!(
        us(program, "")
            .expect_err("refused")
            .contains("subroutine 10 does not exist in the project")
    );
    for stated in ["SBN10", "'SBN 010'", "sbn010"] {
        let facts = format!("[calls]\n{stated} = {{ time = '5us', writes = ['01000'] }}");
        assert_eq!(us(program, &facts), Ok(8), "{stated}");
    }
    let sets = "LD 00000; OUT 01000; SBS(91) 010; LDNOT 01000; AND 00000; Op1; END(01)";
    let writes = |writes: &str| us(sets, &format!("[calls]\nSBN10 = {{ time = '5us'{writes} }}"));
    assert_eq!(writes(", writes = ['DM 0100-DM 0199']"), Ok(7));
    assert_eq!(writes(", writes = ['010']"), Ok(8));
    assert_eq!(writes(""), Ok(8));
    let flags =
        "LD 00000; CMP(20) DM0000 DM0000; SBS(91) 010; LDNOT 25506; AND 00000; Op1; END(01)";
    let kept = |text: &str| us(text, "[calls]\nSBN10 = { time = '5us', writes = [] }");
    assert_eq!(kept(flags), Ok(8), "a routine leaves its own condition flags");
}

#[test]
fn a_stated_range_holds_where_the_scan_starts_and_no_longer_than_that() {
    let stated = "[ranges]\nD0 = [1, 4]";
    assert_eq!(bounds("FOR D0; LD X0; Op1; NEXT; END", stated), Ok((4, 4)));
    let written = "LD X1; MOV K9 D0; FOR D0; LD X0; Op1; NEXT; LD SM400; MOV K2 D0; END";
    assert_eq!(bounds(written, stated), Ok((9, 9)));
    // What is written behind the count is of the next scan, which starts with what is stated.
    assert_eq!(bounds("FOR D0; LD X0; Op1; NEXT; LD X1; MOV K3 D0; END", stated), Ok((4, 4)));
}

/// The status of what is stated of D0, and what is warned of it.
fn status(text: &str, facts: &str) -> Result<(&'static str, Vec<String>), String> {
    let text = text.replace("; ", "\n") + "\n";
    let audit = with("melsec-list", &[("a.il", &text)], facts)?.audit;
    let told = audit.warnings.iter().filter(|one| one.file == "facts.toml");
    let told = told.map(|one| one.message.clone()).collect();
    Ok((audit.facts[0].status().word(), told))
}

#[test]
fn a_stated_range_is_kept_or_broken_or_neither() {
    let stated = "[ranges]\nD0 = [0, 4]";
    let of = |text: &str| status(&format!("FOR D0; LD X0; Op1; NEXT; {text}; END"), stated);
    let quiet = |status| Ok((status, Vec::new()));
    // Nobody but others write it.
    assert_eq!(of("LD X1; OUT Y0"), quiet("unproved"));
    assert_eq!(of("LD X1; MOV K3 D0; LD X2; MOV K1 D0"), quiet("kept"));
    assert_eq!(of("LD SM400; WAND K3 D5; LD> D5 K0; MOV D5 D0"), quiet("kept"));
    // At power-up it is 0, whatever the program writes.
    let above = status("FOR D0; LD X0; Op1; NEXT; LD X1; MOV K3 D0; END", "[ranges]\nD0 = [1, 4]");
    assert_eq!(above, quiet("unproved"));
    // A constant outside of the range, which a scan leaves there.
    let broken = "D0 = [0, 4]: the program violates this fact: `MOV K9 D0` (a.il:6) writes 9 to D0, and D0 has this value when the scan ends";
    assert_eq!(of("LD X1; MOV K9 D0; Op1"), Err(broken.to_owned()));
    // Only within the scan is it something else, which is not asked for, but the analysis cannot tell.
    assert_eq!(of("LD X1; MOV K9 D0; LD SM400; MOV K2 D0"), quiet("unproved"));
    // Nobody said what D5 holds.
    let (status, told) = of("LD X1; MOV D5 D0").expect("an audit");
    assert_eq!(status, "unproved");
    let may = told.iter().all(|one| {
        one.ends_with(
            "the known facts do not exclude this value, which would violate the stated range",
        )
    });
    assert!(may, "{told:?}");
    let both = "[ranges]\nD0 = [0, 4]\nD5 = [2, 3]";
    let text = "FOR D0; LD X0; Op1; NEXT; LD X1; MOV D5 D0; END";
    assert_eq!(self::status(text, both), quiet("kept"));
}

#[test]
fn what_is_about_the_plant_is_neither_kept_nor_broken() {
    let of = |facts: &str| status("LD X0; CALL P1; FOR D0; LD X1; Op1; NEXT; END", facts);
    assert_eq!(of("[calls]\nP1 = { time = '1us' }"), Ok(("stated", Vec::new())));
    let counts = "[counts]\nD0 = 5\n[calls]\nP1 = { time = '1us', writes = [] }";
    assert_eq!(of(counts), Ok(("unproved", Vec::new())));
}

/// What `scanbound facts` writes, from the repository's directory.
fn offered(arguments: &[&str]) -> String {
    let output = binary().arg("facts").args(arguments).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// Takes the first `#` of each line away.
fn uncommented(text: &str) -> String {
    text.lines().map(|line| line.strip_prefix('#').unwrap_or(line).to_owned() + "\n").collect()
}

#[test]
fn what_is_offered_is_a_facts_file_commented_out_or_not() {
    let samples: [&[&str]; 5] = [
        &["samples/recipes"],
        &["samples/filler"],
        &["samples/sorter/sorter.il", "--cpu", "CJ2M"],
        &["samples/drives/drives.il", "--cpu", "FX3U"],
        &["samples/minasec-u/test-program.asm"],
    ];
    for sample in samples {
        let text = offered(sample);
        let nothing = Facts::parse("facts.toml", &text).expect("a facts file");
        assert_eq!(
            Facts { places: Default::default(), read_from: None, ..nothing },
            Facts::default(),
            "{text}"
        );
        let all = uncommented(&text);
        Facts::parse("facts.toml", &all).unwrap_or_else(|faults| panic!("{faults:?}\n{all}"));
    }
    let all = uncommented(&offered(samples[0]));
    let all = Facts::parse("facts.toml", &all).expect("a facts file");
    assert_eq!(all.counts.len(), 3);
    assert_eq!((all.inputs, all.outputs), (Some(32), Some(48)));
}

#[test]
fn what_is_stated_of_what_is_offered_is_not_offered_again() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("facts.toml");
    let all = uncommented(&offered(&["samples/recipes"]));
    // Whatever others write as well would be a count that is not known.
    let all = all.replace(" devices = [\"D592\"]", "");
    std::fs::write(&file, all).expect("written");
    let file = file.to_str().expect("a name");
    let left = offered(&["samples/recipes", "--facts", file]);
    let left = Facts::parse("facts.toml", &uncommented(&left)).expect("a facts file");
    let external = vec!["D592".to_owned()];
    let only = Facts { external, ..Facts::default() };
    assert_eq!(Facts { places: Default::default(), read_from: None, ..left }, only);
}

#[test]
fn what_is_trusted_and_what_else_could_be_is_offered_with_what_it_is_worth() {
    let text = offered(&["samples/recipes"]);
    assert!(
        text.contains("\n[external]\n") && text.contains("\n# devices = [\"D592\"]\n"),
        "{text}"
    );
    let text = offered(&["samples/filler", "--what-if=20"]);
    let (_, internal) = text.split_once("\n[internal]\n").expect("relays of the program's own");
    let (_, bound) = internal.split_once("the listed devices, the bound is ").expect("a bound");
    let bound = bound.lines().next().expect("a line");
    let stated = internal.lines().find_map(|line| line.strip_prefix("# devices")).expect("a list");
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("facts.toml");
    std::fs::write(&file, format!("[internal]\ndevices{stated}\n")).expect("written");
    let file = file.to_str().expect("a name");
    let then = offered(&["samples/filler", "--facts", file]);
    assert!(then.starts_with(&format!("## The bound is {bound}.\n")), "{bound}: {then}");
    assert!(!text.starts_with(&format!("## The bound is {bound}.\n")), "it is lower");
}

#[test]
fn every_word_that_is_trusted_is_offered() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("a.il");
    let repeated = (100..160).map(|at| format!("FOR D{at}\nLD X0\nOUT Y0\nNEXT\n"));
    let set = (100..160).map(|at| format!("LD SM400\nMOV K3 D{at}\n"));
    let program: String = repeated.chain(set).chain(["END\n".to_owned()]).collect();
    std::fs::write(&file, program).expect("written");
    let text = offered(&["--cpu", "Q26UDV", file.to_str().expect("a name")]);
    let stated = Facts::parse("facts.toml", &uncommented(&text)).expect("a facts file");
    let all: Vec<String> = (100..160).map(|at| format!("D{at}")).collect();
    assert_eq!(stated.external, all);
}

#[test]
fn facts_are_offered_where_an_audit_is_refused_for_a_routine() {
    let directory = tempfile::tempdir().expect("a directory");
    let program = directory.path().join("a.il");
    let text = "LD X0\nCALL P153\nLD X1\nECALL \"SUB A\" P3\nFOR D0\nLD X2\nOUT Y0\nNEXT\nLD X3\nMOV K1 D100Z0\nFEND\nI0\nLD X4\nOUT Y1\nIRET\nEND\n";
    std::fs::write(&program, text).expect("written");
    let program = program.to_str().expect("a name");
    let text = offered(&[program, "--cpu", "Q26UDV"]);
    let all = Facts::parse("facts.toml", &uncommented(&text)).unwrap_or_else(|_| panic!("{text}"));
    let names = |found: Vec<&String>| found.into_iter().cloned().collect::<Vec<_>>();
    assert_eq!(names(all.calls.keys().collect()), ["P153", "SUBA:P3"]);
    assert_eq!(names(all.interrupts.keys().collect()), ["I0"]);
    assert_eq!(names(all.counts.keys().collect()), ["a.il:5"]);
    assert!(text.contains("a.il:2  CALL P153"), "{text}");
}

#[test]
fn what_is_written_by_an_index_reaches_as_far_as_is_stated() {
    let program = "LD SM400; MOV K3 D150; LD X0; MOV D7 D100Z0; LD= D150 K4; Op9; END";
    let takes =
        |facts: &str| bounds(program, &format!("[index]\n{facts}\n")).map(|(upper, _)| upper);
    assert_eq!(takes(""), Ok(9));
    assert_eq!(takes("Z0 = [0, 49]"), Ok(0));
    assert_eq!(takes("z0 = [0, 50]"), Ok(9));
    assert_eq!(takes("Z0 = [51, 90]"), Ok(0));
    assert_eq!(takes("'a.il:4' = [-9, 49]"), Ok(0));
    assert_eq!(takes("'a.il:4' = [0, 60]\nZ0 = [-5, 49]"), Ok(0));
    // A scan with another index is none that the lower bound may rest on.
    let guarded = program.replace("LD X0", "LD= Z0 K50");
    let lower = |facts: &str| bounds(&guarded, facts).map(|(_, lower)| lower);
    assert_eq!(lower(""), Ok(9));
    assert_eq!(lower("[index]\nZ0 = [0, 50]"), Ok(9));
    assert_eq!(lower("[index]\nZ0 = [0, 49]"), Ok(0));
    let fault = |facts: &str| takes(facts).unwrap_err();
    assert!(
        fault("Z5 = [0, 9]")
            .ends_with("no instruction writes to a device that the index 'Z5' selects")
    );
    assert!(
        fault("'a.il:2' = [0, 9]")
            .ends_with("at a.il:2, no instruction writes to a device that an index selects")
    );
    assert!(
        fault("Z0 = [40000, 50000]")
            .contains("the index 'Z0' cannot be 40000 to 50000: with 16 bits")
    );
    let apart = fault("'a.il:4' = [0, 9]\nZ0 = [10, 20]");
    assert!(apart.contains("cannot be"), "{apart}");
    assert!(Facts::parse("facts.toml", "[index]\nZ0 = [9, 0]").is_err());
    // Of 16 bits or of 32?
    let far = "LD SM400; MOV K3 ZR9; LD X0; MOV D7 ZR0Z0; LD= ZR9 K4; Op9; END";
    let both = bounds(far, "[index]\nZ0 = [0, 8]").unwrap_err();
    assert!(both.ends_with("the number of bits of the index 'Z0' is not stated"), "{both}");
    assert_eq!(bounds(far, "[index]\nbits = 16\nZ0 = [0, 8]"), Ok((0, 0)));
    assert_eq!(bounds(far, "[index]\nbits = 32\nZ0 = [0, 9]").map(|found| found.0), Ok(9));
}
