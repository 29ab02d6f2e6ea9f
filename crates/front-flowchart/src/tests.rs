//! Tests of the reading of flowchart programs: notations, errors, recognition.

use super::*;

fn read(text: &str) -> Source {
    read_text("a.lst", text).expect("a program")
}

fn faults(text: &str) -> Vec<(&'static str, Option<u32>)> {
    let told = read_text("a.lst", text).expect_err("faults").into_iter();
    told.map(|fault| {
        assert!(!fault.help.is_empty() && !fault.message.is_empty());
        (fault.code.name(), fault.line)
    })
    .collect()
}

#[test]
fn spellings_of_the_documents_mean_the_same() {
    let plain = "LBL 0\nAND NOT 1\nCJP LBL0\nOUT NOT 200\nTIM 10 #30\nCJP LBL0\nCNR TIM 10\nGOFF 0\nGJ\nJMP LBL0\nGN 0\nGE 0\n";
    let odd = "ADR. LABEL MNEMONIC OPERAND COMMENT\n0000 LBL0: AND·NOT 1 ;(PB-B)\n2 cjp LBL 0\n3 OUT・NOT 200 ; (X)\n\n TIM 10\n   #30 ; 3 s\nCJP 0\nCNR·TIM 10\nG OFF 0\nG J\nJMP LBL 0\nGN 00 \nGE 0\n";
    let ops = |text| read(text).instructions.iter().map(|one| one.op).collect::<Vec<_>>();
    assert_eq!(ops(plain), ops(odd));
    let source = read(odd);
    assert_eq!(source.comments, [(1, "PB-B".to_owned()), (200, "X".to_owned())].into());
    assert_eq!((source.instructions[0].step, source.instructions[1].step), (Some(0), None));
    assert_eq!(source.instructions[4].text, "TIM 10 #30");
    assert_eq!(source.routines.len(), 2);
    assert_eq!(source.shortest_timer(), Some(30));
}

#[test]
fn all_faults_are_told_at_once_with_their_lines() {
    let text = "LBL0: AND 1\nOUT 200\nCJP LBL0\nCTP LBL0\nJMP LBL7\nAND\nLBL0: AND 2 3\nGS 5\nTIM 10\nWAIT\n5\n#7 8\nJMP LBL0\n";
    let mut found = faults(text);
    found.sort_by_key(|fault| fault.1);
    assert_eq!(
        found,
        [
            ("unused-condition", Some(1)),
            ("no-condition", Some(3)),
            ("unknown-instruction", Some(4)),
            ("no-label", Some(5)),
            ("no-operand", Some(6)),
            ("extra-operand", Some(7)),
            ("label-twice", Some(7)),
            ("unused-condition", Some(7)),
            ("no-group", Some(8)),
            ("no-time", Some(9)),
            ("bare-address", Some(11)),
            ("time-alone", Some(12)),
        ]
    );
}

#[test]
fn routines_are_kept_apart() {
    let main = "LBL0: GJ\nJMP LBL0\n";
    for (group, code) in [
        ("GN 0\nJMP LBL0\n", "jump-out"),
        ("GN 0\nGJ\nGE 0\n", "jump-in-group"),
        ("GN 0\nGS 0\nGE 0\n", "own-group"),
        ("GN 0\nGE 1\n", "wrong-end"),
        ("GN 0\nOUT 200\n", "no-end"),
        ("GN 0\nGE 0\nGN 0\nGE 0\n", "group-twice"),
        ("GN 33\nGE 33\n", "group-number"),
        ("GN 0\nTIM 10 #3\nAND 1\nWAIT\nGE 0\n", "mixed-condition"),
    ] {
        let codes: Vec<_> = faults(&format!("{main}{group}")).iter().map(|fault| fault.0).collect();
        assert_eq!(codes, [code], "{group}");
    }
    assert_eq!(faults("GN 0\nGE 0\n")[0].0, "no-main");
    assert_eq!(faults("LBL0: OUT 200\n")[0].0, "no-end");
    assert_eq!(faults("; nothing\n")[0].0, "no-instructions");
    let many: String = (0..=32).map(|group| format!("GN {group}\nGE {group}\n")).collect();
    assert_eq!(faults(&format!("{main}{many}"))[0].0, "too-many-groups");
}

#[test]
fn any_text_ends_in_a_program_or_faults() {
    for text in [
        "",
        "#",
        "LBL",
        "LBL0:",
        "TIM #",
        "GN",
        "JMP",
        "0",
        "\u{FEFF}",
        "AND 99999999999",
        "LBL0: LBL1: #3",
    ] {
        assert!(read_text("a", text).is_err(), "{text}");
    }
}

#[test]
fn the_main_routine_may_stay_in_inner_loops() {
    let source = read("LBL0: AND 0\nCJP LBL1\nJMP LBL0\nLBL1: AND 1\nCJP LBL0\nJMP LBL1\n");
    let lines: Vec<_> = source.warnings().iter().map(|one| one.line).collect();
    assert_eq!(lines, [Some(6)]);
}

#[test]
fn a_loop_is_endless_only_where_its_rounds_were_followed_to_their_end() {
    // Each relay ends one round of its own.
    let rounds = |count: u32| {
        let round = |one: u32| {
            let (label, next, relay) = (10 + one, 11 + one, 300 + one);
            format!("LBL{label}: AND {relay}\nCJP LBL{next}\nOUT {relay}\nJMP LBL10\n")
        };
        let all: String = (0..count).map(round).collect();
        let end = 10 + count;
        let source = read(&format!("LBL0: GS 0\nGJ\nJMP LBL0\nGN 0\n{all}LBL{end}: GE 0\n"));
        back_jumps::jumps_back(&source, &source.routines[1], false)
    };
    assert_eq!([rounds(1), rounds(60), rounds(70)], [Some(1), Some(60), None]);
}
