//! What OMRON instructions may write or let in, where a manual leaves it open or a program does not say it: the bound
//! holds with all of it.

use scanbound::audit::{Audit, Failure, Request, audit};
use scanbound::base::diagnostic::Diagnostic;
use scanbound::base::facts::Facts;
use scanbound::front::Input;
use scanbound::timing::table::Table;

const C: &str = "omron-c200h";
const CX: &str = "omron-cx";

fn audited(
    dialect: &str,
    files: &[(&str, &str)],
    facts: &str,
    table: &str,
) -> Result<Audit, Vec<Diagnostic>> {
    let inputs: Vec<Input> = files
        .iter()
        .map(|(name, text)| Input { name: (*name).to_owned(), bytes: text.as_bytes().to_vec() })
        .collect();
    let base = if dialect == C { "c200h" } else { "cj2m" };
    let table = format!("instruction,on_us,off_us\n@base,{base}\n{table}");
    let table = Table::parse("t.csv", table.as_bytes()).expect("a table").table;
    let facts = Facts::parse("facts.toml", facts).expect("facts");
    let request =
        Request { dialect: Some(dialect), table: Some(&table), ..Request::new(&inputs, &facts) };
    audit(&request).map_err(|failure| match failure {
        Failure::Input(faults) => faults,
        Failure::Internal(why) => panic!("{why}"),
    })
}

const SECOND: u64 = 1_000_000_000_000;

/// How many seconds the longest scan takes, where `OpN` takes N seconds and all else less than one together.
fn seconds(dialect: &str, lines: &[&str], facts: &str) -> u64 {
    let ops = ["Op1,1000000,0", "Op2,2000000,0", "Op4,4000000,0", "Other,1,0"].join("\n");
    // What else the CPU serves is left out of these seconds.
    let facts = format!("{facts}\n[scan]\nfactor = 1.0\n");
    let audit = audited(dialect, &[("a.txt", &lines.join("\n"))], &facts, &ops).expect("an audit");
    audit.bound.upper.0 / SECOND
}

fn codes(dialect: &str, lines: &[&str], facts: &str) -> Vec<&'static str> {
    let faults = audited(dialect, &[("a.txt", &lines.join("\n"))], facts, "").expect_err("faults");
    faults.iter().map(|fault| fault.code.name()).collect()
}

/// Whether a bit (or what an instruction in front asks for) may be on, and then off behind some lines.
fn changes(dialect: &str, lines: &[&str], bit: &str) -> bool {
    let (on, off) = (format!("LD {bit}"), format!("LDNOT {bit}"));
    let always = if dialect == C { "LD 25313" } else { "LD P_On" };
    let mut all = vec![on.as_str(), "Op1", always];
    all.extend(lines);
    all.extend([off.as_str(), "Op2", "END"]);
    seconds(dialect, &all, "") == 3
}

#[test]
fn a_timer_behind_an_index_is_any_timer() {
    assert!(changes(CX, &["TIM ,IR0 #10"], "T0005"));
    assert!(changes(CX, &["CNR(545) ,IR0 ,IR1"], "T0005"));
    assert!(!changes(CX, &["TIM 6 #10"], "T0005"));
    // One of 1 ms behind an index may be any: it may run out between two tests.
    let lines = ["LD P_On", "TMHH(540) ,IR0 #10", "LDNOT T0005", "Op1", "LD T0005", "Op2", "END"];
    assert_eq!(seconds(CX, &lines, ""), 3);
}

#[test]
fn a_users_instruction_may_write_the_whole_area_of_its_operands() {
    for (dialect, operand, bit) in [
        (CX, "W0", "W20.00"),
        (CX, "T0", "T0009"),
        (C, "HR 00", "HR 2000"),
        (C, "CNT 001", "TIM 100"),
    ] {
        assert!(changes(dialect, &[&format!("Other {operand}")], bit), "{operand} {bit}");
    }
    assert!(!changes(CX, &["Other W0"], "H20.00"));
    assert!(changes(CX, &["TRSET(549) T0009"], "T0009"));
    assert!(changes(CX, &["FREAD(700) D0 D2 D4 W0"], "W300.00"));
    assert!(changes(CX, &["RXDU(255) W0 D0 #0020"], "W30.00"));
    assert!(changes(C, &["RXD(47) HR 00 #0000 #0020"], "HR 1500"));
}

#[test]
fn macros_and_refreshes_write_the_words_of_every_cpu_of_the_series() {
    let routine = |bit: &str| {
        let (on, off) = (format!("LD {bit}"), format!("LD NOT {bit}"));
        let lines = [
            &on,
            "Op1",
            "LD 25313",
            "MCRO(99) 01 DM 0000 DM 0010",
            &off,
            "Op2",
            "SBN(92) 01",
            "RET(93)",
            "END(01)",
        ];
        seconds(C, &lines, "")
    };
    assert_eq!((routine("09603"), routine("19703"), routine("19003")), (3, 3, 2));
    assert!(changes(C, &["IORF(97) 040 040"], "15000"));
    assert!(!changes(C, &["IORF(97) 001 002"], "15000"));
}

#[test]
fn condition_flags_are_turned_off_or_left() {
    for lines in [
        vec!["TIM 0 #10"],
        vec!["SETB(532) D0 #1"],
        vec!["OUT W0.00", "FOR(512) &2", "NEXT(513)"],
        vec!["XCGL(562) D0 D2"],
        vec!["STC(040)"],
    ] {
        assert!(changes(CX, &lines, "P_EQ"), "{lines:?}");
        assert!(changes(CX, &lines, "P_N"), "{lines:?}");
    }
    // CY is what these say, and nothing else.
    let carry = |line, test| seconds(CX, &["LD P_On", line, test, "Op1", "END"], "");
    assert_eq!((carry("STC(040)", "LDNOT P_CY"), carry("STC(040)", "LD P_CY")), (0, 1));
    assert_eq!((carry("CLC(041)", "LDNOT P_CY"), carry("CLC(041)", "LD P_CY")), (1, 0));
}

#[test]
fn an_instruction_that_ends_in_an_error_leaves_the_flag_of_zero() {
    // What it reads is no number of decimal digits: the result's word stays 0, and the flag stays off.
    let cx = ["LD P_On", "CMP(020) D20 #1", "LD P_On", "BIN(023) D0 D10", "LD P_EQ", "OUT W0.00"];
    let asked = ["LD=(300) D10 #0", "Op1", "LDNOT W0.00", "Op2", "END"];
    assert_eq!(seconds(CX, &[&cx[..], &asked].concat(), ""), 3);
    let c = ["LD 25313", "DIV(33) DM 0000 DM 0001 DM 0010", "LD 25506", "OUT 01000"];
    let asked = ["LD 25313", "CMP(20) DM 0010 #0000", "LD 25506", "Op1", "LDNOT 01000", "Op2"];
    assert_eq!(seconds(C, &[&c[..], &asked, &["END"]].concat(), ""), 3);
}

#[test]
fn what_reaches_beyond_its_area_may_write_nothing() {
    let set = ["LD P_On", "MOV #1 D0", "LD P_On"];
    let asked = ["LD=(300) D0 #1", "Op1", "END"];
    let kept = |line: &str| seconds(CX, &[&set[..], &[line], &asked].concat(), "") == 1;
    assert!(kept("XFER(070) &10 D32760 D0"));
    assert!(!kept("BSET(071) #2 D0 D0"));
    let over = ["LD P_On", "MOV #1 D32760", "LD P_On", "XFER(070) &10 D0 D32760"];
    let asked = ["LD=(300) D32760 #1", "AND=(300) D0 #2", "Op1", "END"];
    assert_eq!(seconds(CX, &[&over[..], &asked].concat(), ""), 1);
    let bits = ["LD P_On", "MOV #1 D32767", "LD P_On", "RSTA(531) D32767 &0 &32"];
    let asked = ["LD=(300) D32767 #1", "Op1", "END"];
    assert_eq!(seconds(CX, &[&bits[..], &asked].concat(), ""), 1);
}

#[test]
fn a_setting_of_wrong_digits_leaves_the_flag() {
    let timer = |line: &str| {
        let lines = ["LD 0.00", line, "LD T0000", "ANDNOT 0.00", "Op1", "END"];
        seconds(CX, &lines, "") == 1
    };
    assert!(timer("TIM 0000 D0"));
    assert!(!timer("TIM 0000 #10"));
    assert!(!timer("TIMX(550) 0000 D0"));
    let counter = |setting: &str| {
        let count = format!("CNT 000 {setting}");
        let lines = ["LD 00000", "LD 00001", &count, "LD CNT 000", "AND 00001", "Op1", "END"];
        seconds(C, &lines, "") == 1
    };
    assert!(counter("DM 0000"));
    assert!(!counter("#0010"));
}

#[test]
fn an_edge_in_a_subroutine_that_other_programs_call_is_not_the_outsides() {
    let first =
        "LD 25313\nSBS(91) 1\nEND\nSBN(92) 1\nLD 00000\nDIFU(13) 01000\nLD 01000\nOp1\nRET(93)\n";
    let files = [("a.txt", first), ("b.txt", "LD 25313\nSBS(91) 1\nEND\n")];
    let audit = audited(C, &files, "", "Op1,1000000,0").expect("an audit");
    assert_eq!(audit.bound.upper.0 / SECOND, 2);
    assert_eq!(audit.bound.lower.0 / SECOND, 0);
}

#[test]
fn interrupts_let_subroutines_in() {
    let runs = |line: &str, number: &str| {
        let (begin, label) = (format!("SBN(92) {number}"), format!("\"SBN {number}\""));
        let lines = [
            "LD 25313",
            line,
            "LD 25313",
            "OUT 01000",
            &begin,
            "LD 25313",
            "Op1",
            "RET(93)",
            "END(01)",
        ];
        let facts = format!("[interrupts]\n{label} = 2");
        (seconds(C, &lines, ""), seconds(C, &lines, &facts))
    };
    assert_eq!(runs("STIM(69) 003 #0010 #0023", "23"), (1, 2));
    assert_eq!(runs("CTBL(63) 000 000 DM 0000", "05"), (1, 2));
    assert_eq!(runs("INT(89) 000 000 #000E", "01"), (1, 2));
    // A routine that is called as well.
    let lines = |line| {
        [
            "LD 25313",
            line,
            "LD 25313",
            "SBS(91) 02",
            "SBN(92) 02",
            "LD 25313",
            "Op1",
            "RET(93)",
            "END(01)",
        ]
    };
    assert_eq!(seconds(C, &lines("INT(89) 000 000 #000E"), ""), 2);
    assert_eq!(seconds(C, &lines("MOV(21) #000E DM 0000"), ""), 1);
}

#[test]
fn tasks_of_interrupts_are_stated_or_doubted() {
    let main = "LD P_On\nMSKS(690) 2 D0\nLD W0.00\nOp1\nEND(001)\n";
    let task = "LD P_On\nSET W0.00\nLD P_On\nOp2\nEND(001)\n";
    let both = [("main.txt", main), ("tick.txt", task)];
    let table = "Op1,1000000,0\nOp2,2000000,0";
    let alone = audited(CX, &both[..1], "", table).expect("an audit");
    assert!(alone.doubts.iter().any(|doubt| doubt.to_string().contains("unlisted tasks")));
    let none = audited(CX, &both[..1], "[interrupts]\n\"unlisted tasks\" = 0", table);
    assert_eq!(none.expect("an audit").doubts, []);
    let some = audited(CX, &both[..1], "[interrupts]\n\"unlisted tasks\" = 2", table);
    assert_eq!(some.expect_err("no programs")[0].code.name(), "no-interrupt");
    let stated = audited(CX, &both, "[interrupts]\ntick = 3\n[scan]\nfactor = 1.0", table)
        .expect("an audit");
    assert_eq!((stated.bound.upper.0 / SECOND, stated.doubts.len()), (7, 0));
}

#[test]
fn values_of_timers_change_in_the_midst_of_a_scan() {
    // Also that of T1, which is read behind T0's.
    let both = |equal: &str, other: &str, operands: &str, timer: &str| {
        let (a, b) = (format!("{equal} {operands}"), format!("{other} {operands}"));
        seconds(CX, &["LD P_On", timer, &a, "Op1", &b, "Op2", "END"], "")
    };
    let (equal, other) = ("LD=(300)", "LD<>(305)");
    assert_eq!(both(equal, other, "T0 #5", "TIM 0 #10"), 3);
    assert_eq!(both("LD=L(301)", "LD<>L(306)", "T3000 #5", "TIMH(015) 3001 #10"), 3);
    assert_eq!(both(equal, other, "T3000 #5", "TIM 3000 #10"), 2);
}

#[test]
fn a_jump_to_the_first_of_several_jmes_may_go_back() {
    let lines =
        ["LD W0.00", "JMP(004) #1", "JME(005) #1", "LD W0.01", "JMP(004) #1", "JME(005) #1", "END"];
    assert_eq!(codes(CX, &lines, ""), ["jump"]);
}

#[test]
fn every_word_that_is_written_counts_as_points() {
    let points = |dialect, lines: &[&str]| {
        let audit = audited(dialect, &[("a.txt", &lines.join("\n"))], "", "").expect("an audit");
        audit.points.iter().map(|points| points.taken).collect::<Vec<_>>()
    };
    let lines = ["LD 0.00", "XFER(070) &10 D0 0", "LD 0.00", "BSET(071) #0 20 29", "END"];
    assert_eq!(points(CX, &lines)[1], 320);
    let lines = ["LD 03500", "OUT 04000", "END(01)"];
    assert_eq!(points(C, &lines), [16, 16]);
}

#[test]
fn a_count_in_a_word_is_any_count_unless_its_range_is_stated() {
    let lines = ["FOR(512) D0", "LD P_On", "Op1", "NEXT(513)", "END(001)"];
    assert!(seconds(CX, &lines, "") >= 65_535);
    assert_eq!(seconds(CX, &lines, "[ranges]\nD0 = [0, 7]"), 7);
    let written = ["LD P_On", "MOV(021) D2 D0", lines[0], lines[1], lines[2], lines[3], lines[4]];
    assert!(seconds(CX, &written, "[ranges]\nD0 = [0, 7]") >= 65_535);
    // What is stated of another loop's word says nothing of this one.
    let other = ["FOR(512) D1", "LD P_On", "MOV(021) #1 D3", "NEXT(513)"];
    let both = [&written[..6], &other[..], &["END(001)"]].concat();
    assert!(seconds(CX, &both, "[ranges]\nD1 = [0, 7]") >= 65_535);
    let large = ["FOR(512) &65535", "LD P_On", "Op1", "Op1", "NEXT(513)", "END(001)"];
    assert!(seconds(CX, &large, "") >= 131_070);
    assert_eq!(codes(CX, &["FOR(512) +1.5", "NEXT(513)", "END(001)"], ""), ["loop-count"]);
}

#[test]
fn every_form_of_an_index_and_marks_apart_are_read() {
    for operand in [",IR0", "+5,IR0", "-31,IR15", "DR0,IR0", ",-IR0", ",--IR0", ",IR0+", ",IR0++"] {
        let line = format!("MOV(021) {operand} D0");
        assert_eq!(seconds(CX, &["LD P_On", &line, "LD W0.00", "Op1", "END"], ""), 1, "{operand}");
        let line = format!("MOV(021) #1 {operand}");
        assert!(changes(CX, &[&line], "W7.00"), "{operand}");
    }
    let lines = ["LD !0.00", "Op1", "LDNOT !0.00", "Op2", "LD P_On", "MOV(021) # 0020 D0", "END"];
    assert_eq!(seconds(CX, &lines, ""), 3);
    assert_eq!(
        seconds(CX, &["LD P_On", "MOV(021) # 0020 D0", "LD=(300) D0 #20", "Op1", "END"], ""),
        1
    );
}

#[test]
fn symbols_stand_in_a_table_beside_the_mnemonics() {
    let program = "LD Start\nAND Ready\nOUT Lamp\nLD Lamp\nOp1\n";
    let table = "Start\tBOOL\t0.00\t\t\t0\nReady\tBOOL\tW0.01\tall in place\t\t0\nLamp\tBOOL\t100.00\t\t\t0\n";
    let files = [("logic.txt", program), ("symbols.csv", table)];
    let facts = "[scan]\nfactor = 1.0";
    let audit = audited(CX, &files, facts, "Op1,1000000,0").expect("an audit");
    assert_eq!(audit.bound.upper.0 / SECOND, 1);
    let told: Vec<_> = audit.warnings.iter().map(|one| (one.code.name(), one.line)).collect();
    assert_eq!(told, [("no-end", Some(5))]);
    let broken =
        [files[0], ("symbols.csv", "Start\tBOOL\t0.00\nReady\tBOOL\tW0.01\nStart\tBOOL\t0.02\n")];
    let faults = audited(CX, &broken, "", "").expect_err("a symbol twice");
    assert_eq!((faults[0].code.name(), faults[0].line), ("symbol-twice", Some(3)));
}

#[test]
fn empty_comments_are_a_warning() {
    for (dialect, program) in [(CX, "LD 0.00\nOUT 1.00\nEND\n"), (C, "LD 00000\nOUT 00100\nEND\n")]
    {
        for empty in ["", "\r\n\r\n"] {
            let files = [("a.txt", program), ("p/COMMENT.csv", empty)];
            let audit = audited(dialect, &files, "", "").expect("an audit");
            let told: Vec<_> = audit.warnings.iter().map(|one| one.code.name()).collect();
            assert_eq!(told, ["empty-file"]);
        }
    }
}

#[test]
fn index_registers_hold_what_is_moved_to_them() {
    let both = |lines: &[&str]| {
        let ask = ["LD=L(301) IR0 &100", "Op1", "LD=L(301) IR0 &101", "Op2", "END"];
        seconds(CX, &[&["LD P_On", "MOVL(498) &100 IR0"], lines, &ask].concat(), "")
    };
    assert_eq!(both(&[]), 1);
    // Moved on by an operand, also by a contact.
    assert_eq!(both(&["LD P_On", "MOV(021) ,IR0+ D0"]), 2);
    assert_eq!(both(&["LD ,--IR0", "OUT W0.00"]), 2);
    assert_eq!(both(&["LD P_On", "MOV(021) ,IR1+ D0"]), 1);
    assert_eq!(both(&["LD P_On", "MOVR(560) D0 IR0"]), 2);
    assert_eq!(codes(CX, &["LD P_On", "MOVL(498) &100 IR16", "END"], ""), ["operand"]);
}
