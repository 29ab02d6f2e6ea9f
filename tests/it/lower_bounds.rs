//! Bounds that an audit gives where what a scan takes hangs on real values: the upper one is never below what a PLC can
//! take, the lower one never above, and `exact` is said only where they meet.

use common::audited::{audited, table};
use scanbound::base::facts::Facts;

/// What the operations `Op1`, `Op2`, `Op4` ... can take together, each its number: at most, at least, and whether it is
/// said to be exact.
fn bounds(dialect: &str, cpu: Option<&str>, text: &str) -> (u64, u64, bool) {
    bounds_with("", dialect, cpu, text)
}

/// The same with further rows in the table.
fn bounds_with(rows: &str, dialect: &str, cpu: Option<&str>, text: &str) -> (u64, u64, bool) {
    let ops = format!("Op1,1,0,0\nOp2,2,0,0\nOp4,4,0,0\nOp8,8,0,0\n{rows}");
    let lines = text.replace("; ", "\n") + "\n";
    let found = audited(dialect, cpu, &[("a.txt", &lines)], &table(&ops), &Facts::default());
    let bound = found.unwrap_or_else(|why| panic!("{text}\n{why}")).audit.bound;
    let us = |time: scanbound::base::time::Picos| time.0 / 1_000_000;
    (us(bound.upper), us(bound.lower), bound.exact())
}

fn q(text: &str) -> (u64, u64, bool) {
    bounds("melsec-list", None, text)
}

fn cx(text: &str) -> (u64, u64, bool) {
    bounds("omron-cx", None, text)
}

#[test]
fn values_that_are_rotated_or_coded_are_not_any_values() {
    let rotated = "LD SM400; MOV K1 D0; ROL D0 K1; LD= D0 K2; Op1; LD= D0 K1; Op2; END";
    assert_eq!(q(rotated), (1, 1, true));
    let coded = "LD SM400; WAND K7 D0; BIN D0 D1; LD= D1 K9; Op8; LD= D1 K7; Op1; END";
    assert_eq!(q(coded), (1, 1, true));
    let register =
        "LD P_On; MOVL(498) &100 IR0; LD=L(301) IR0 &100; Op1; LD<>L(306) IR0 &100; Op2; END(001)";
    assert_eq!(cx(register), (1, 1, true));
}

#[test]
fn blocks_take_as_long_as_their_counts_say() {
    let q = |text: &str| bounds_with("FMOV,2,0,1\nBMOV,2,0,1\n", "melsec-list", None, text);
    // 2 us and one for each word.
    assert_eq!(q("LD SM400; MOV K7 D50; FMOV K0 D0 D50; END"), (9, 9, true));
    assert_eq!(q("LD SM400; WAND K7 D50; FMOV K0 D0 D50; END"), (9, 9, true));
    assert_eq!(q("LD SM400; WAND K3 D50; INC D50; BMOV D100 D0 D50; END"), (6, 6, true));
    // A long move that needs one state and a short one that needs another.
    let states = "LD= D1 K1; MOV K5 D50; LD<> D1 K1; MOV K3 D50; LD SM400; FMOV K0 D100 D50; \
        LD= D1 K2; FMOV K0 D20 K3; END";
    assert_eq!(q(states), (10, 10, true));
    let alike = states.replace("D1 K2", "D1 K1");
    assert_eq!(q(&alike), (12, 12, true));
    // More than any CPU has: that none is moved is possible.
    let free = q("LD X0; FMOV K0 D0 D50; END");
    assert_eq!((free.0, free.2), (65_537, false));
    assert!((2_000..12_000).contains(&free.1), "{free:?}");
}

#[test]
fn counts_that_the_scan_works_out_are_what_loops_run() {
    for (before, iterations) in [
        ("MOV K3 D9", 3),
        ("WAND K7 D9", 7),
        ("MOV K40 D9; LDI X0; MOV K4 D9", 40),
        ("MOV K4 D9; INC D9; INC D9", 6),
        ("WAND K3 D9; ANDP X0; INC D9", 4),
        ("MOV K2 D8; FOR D8; LD SM400; INC D9; NEXT; LD> D9 K5; MOV K5 D9", 5),
    ] {
        let text = format!("LD SM400; {before}; FOR D9; LD SM400; Op1; NEXT; END");
        assert_eq!(q(&text), (iterations, iterations, true), "{text}");
    }
    let limited = "LD> D9 K20; MOV K20 D9; FOR D9; LD SM400; Op1; NEXT; END";
    assert_eq!(q(limited), (20, 20, true));
    let digit = "FOR K1X0; LD SM400; Op1; NEXT; END";
    assert_eq!(q(digit), (15, 15, true));
    let nested = "LD SM400; MOV K2 D0; MOV K3 D1; FOR D0; FOR D1; LD SM400; Op1; NEXT; NEXT; END";
    assert_eq!(q(nested), (6, 6, true));
    let inner = "LD SM400; MOV K3 D9; FOR K4; FOR D9; LD SM400; Op1; LD SM400; OUT Y0; LD X0; OUT Y1; NEXT; NEXT; END";
    assert_eq!(q(inner), (12, 12, true));
    // The same loop with a count of its own at each call, once within a loop that is not followed at first.
    let called = "LD SM400; MOV K1 D0; CALL P0; LD SM400; MOV K2 D1; FOR D1; LD SM400; MOV K7 D0; CALL P0; NEXT; FEND; \
        P0; FOR D0; LD SM400; Op1; NEXT; RET; END";
    assert_eq!(q(called), (15, 15, true));
    let free = "FOR D9; LD SM400; Op1; NEXT; END";
    assert_eq!(q(free), (32_767, 32_767, true));
}

/// What operations give is learned by carrying them out.
#[test]
fn counts_that_operations_work_out_are_learned() {
    for (before, iterations) in [
        ("WAND K7 D0 D1; BIN D1 D9", 7),
        ("FMOV K3 D8 K4", 3),
        ("WAND K3 D0 D1; MOV K5 D2; BMOV D1 D8 K2", 5),
        ("WAND K7 D0 D1; SUM D1 D9", 3),
        ("WAND K3 D0 D1; ROL D1 K2; MOV D1 D9", 12),
    ] {
        let text = format!("LD SM400; {before}; FOR D9; LD SM400; Op1; NEXT; END");
        assert_eq!(q(&text), (iterations, iterations, true), "{text}");
    }
}

/// Which of the two it is no manual says.
#[test]
fn a_count_below_one_is_one_turn_or_none() {
    for count in ["K0", "K-5"] {
        let text = format!("LD SM400; MOV {count} D0; FOR D0; LD SM400; Op1; NEXT; END");
        assert_eq!(q(&text), (1, 0, false), "{text}");
    }
}

/// What a called routine's loop runs is the most of all its calls.
#[test]
fn a_loop_that_is_called_twice_runs_by_both_counts() {
    let text = "LD SM400; MOV K2 D9; CALL P1; LD X0; MOV K5 D9; CALL P1; FEND; P1; FOR D9; LD SM400; Op1; NEXT; RET; END";
    assert_eq!(q(text), (7, 7, true));
}

/// An interrupt may change the count between its write and the loop.
#[test]
fn a_count_that_an_interrupt_writes_is_not_known() {
    let text = "LD SM400; MOV K3 D9; FOR D9; LD SM400; Op1; NEXT; FEND; I0; LD SM400; MOV K5 D9; IRET; END";
    let (upper, lower, exact) = q(text);
    assert_eq!((upper, exact), (32_767, false));
    assert!(lower <= 5);
}

/// The contact is on only where the timer is through, so its value is not below. In a state that no timer leaves by
/// itself this is not settled, so it is no scan that is shown.
#[test]
fn a_timer_that_is_through_stands_at_its_setting() {
    let text = "LD X0; OUT T0 K100; LD T0; AND< T0 K50; Op1; LD T0; Op2; END";
    let (upper, lower, exact) = q(text);
    assert_eq!((lower, exact), (2, upper == 2));
}

/// Whether an edge in a loop shows in each iteration or once differs between CPUs.
#[test]
fn an_edge_in_a_loop_shows_once_at_least() {
    let text = "FOR K3; LDP X0; Op1; NEXT; END";
    assert_eq!(q(text), (1, 1, true));
    let (upper, lower, exact) = bounds("melsec-list", Some("FX3U"), text);
    assert!(1 <= lower && lower <= upper && upper <= 3 && exact == (lower == upper));
}

/// A program that another one may stop begins with a jump that no line of the source has.
#[test]
fn a_program_that_may_be_on_standby_is_named_where_that_decides() {
    let files =
        [("OFF.il", "LD X3\nOp1\nLDI M0\nOp2\nEND\n"), ("WORK.il", "LD X0\nPSTOP \"OFF\"\nEND\n")];
    let table = table("Op1,1,0,0\nOp2,2,0,0\n");
    let found = audited("melsec-list", Some("Q26UDV"), &files, &table, &Facts::default());
    let audit = found.unwrap_or_else(|why| panic!("{why}")).audit;
    let why = "the simulation stops at `OFF on standby` (OFF.il:1): which instruction follows it is unknown";
    assert_eq!(audit.stands_between.as_deref(), Some(why));
    let ties: Vec<&str> =
        audit.groups.iter().flat_map(|group| &group.devices).map(String::as_str).collect();
    assert!(ties.contains(&"`OFF on standby` in OFF.il:1"), "{ties:?}");
}
