//! Texts of nets, right and wrong.

use super::*;
use crate::{Direction, Kind, Point, Signal};

const SELF_HOLDING: &str = "\
net T-TM(1)
outer E01 = 00001
outer E02 = 00002

page MAIN
box B01 = 00300
transition T01 = 00305 : -> B01 if E01 not E02
transition T02 = 00306 : B01 -> if E02
";

#[test]
fn the_papers_example_is_read_and_written() {
    let diagram = read("a.snet", SELF_HOLDING).expect("a net");
    assert_eq!((diagram.name.as_str(), diagram.pages[0].name.as_str()), ("T-TM(1)", "MAIN"));
    assert_eq!(diagram.places_of(0, Direction::OutOf).collect::<Vec<_>>(), [0]);
    assert_eq!(diagram.transitions_of(0, Direction::Into).collect::<Vec<_>>(), [1]);
    let gates: Vec<(Signal, bool)> =
        diagram.gates_of(0).map(|gate| (gate.signal, gate.is_inhibiting)).collect();
    assert_eq!(gates, [(Signal::Outer(0), false), (Signal::Outer(1), true)]);
    assert_eq!(write(&diagram), SELF_HOLDING);
}

#[test]
fn everything_is_read_as_it_is_written() {
    let text = "\
net 搬送
outer 非常停止 = 00009 at 5,-5
page A
box B01 marked = HR 0100 at 10,20
timer TM01 2.5s = 00310 TIM 007
counter CN01 12 CNT 8 = 00311
transition T01 = 00400 at 1,2 : B01, B02 -> TM01 P2.B1 if TM01, not CN01 not P2.B1 # a comment
transition T02 : TM01 ->
stop T00 : B01 TM01 CN01 *-> if 非常停止
box B02
arc T02 -> CN01
arbiter A1 : T01 T02
page P2
box B1
transition T01 : A.CN01 -> A.B02
";
    let diagram = read("a.snet", text).expect("a net");
    assert_eq!(diagram.places[1].kind, Kind::Timer { number: Some(7), tenths: 25 });
    assert_eq!(diagram.places[2].kind, Kind::Counter { number: Some(8), count: 12 });
    assert!(
        diagram.places[0].is_marked && diagram.places[0].head.at == Some(Point { x: 10, y: 20 })
    );
    assert_eq!(diagram.transition_name(3), "P2.T01");
    assert_eq!(diagram.arbiters[0].transitions, [0, 1]);
    let again = read("b.snet", &write(&diagram)).expect("a net again");
    assert_eq!(again.without_lines(), diagram.without_lines(), "{}", write(&diagram));
}

fn told(text: &str) -> Vec<(Option<u32>, String)> {
    let faults = read("a.snet", text).expect_err("faults");
    faults
        .into_iter()
        .map(|fault| (fault.line, format!("{} {}", fault.code, fault.message)))
        .collect()
}

#[test]
fn what_is_no_net_is_told_with_its_line() {
    let cases = [
        ("bux B01", 1, "cannot begin a line"),
        ("box", 1, "a name is missing"),
        ("box a.b", 1, "is not a valid name"),
        ("box B01\nbox B02\narc B01 -> B02", 3, "both are boxes"),
        ("transition T\ntransition U\narc T -> U", 3, "both are transitions"),
        ("box B\ntransition T : B *-> ", 2, "is not allowed here"),
        ("box B\ntransition T\narc B *-> T", 3, "must lead to an emergency stop"),
        ("box B\nstop T\narc B -> T", 3, "must be written *->"),
        ("box B\nstop T : *-> B", 2, "only removes marks"),
        ("outer E\ntransition T : E ->", 2, "an outer gate has no arcs"),
        ("box B\ntransition T : B", 2, "the `->` of T is missing"),
        ("box B\ntransition T : B -> if not", 2, "a gate is missing"),
        ("box B\ntransition T : B -> if U\ntransition U : -> B", 2, "the gate U is a transition"),
        ("box B\ntransition T : C ->", 2, "no element C"),
        ("box B\nbox B", 2, "already has the name B"),
        ("outer B\nbox B", 2, "an outer gate in line 1"),
        ("page A\npage A", 2, "already begins in line 1"),
        ("timer TM", 1, "the timer's set value"),
        ("timer TM 1000.0s", 1, "the timer's set value"),
        ("timer TM 1s CNT 3", 1, "cannot have such a number"),
        ("timer TM 1s TIM 512", 1, "is not a timer or counter number"),
        ("counter CN 0", 1, "the counter's set value"),
        ("box B = 00016", 1, "is not a relay"),
        ("box B = DM0100", 1, "is not a relay"),
        ("box B 5", 1, "a set value"),
        ("box B at 3", 1, "the drawing position"),
        ("transition T\narbiter A : T", 2, "two or more transitions"),
        ("box B extra", 1, "is not allowed here"),
    ];
    for (text, line, message) in cases {
        let found = told(text);
        let is_there = found.iter().any(|(at, own)| *at == Some(line) && own.contains(message));
        assert!(is_there, "{text:?}: {found:?}");
    }
    assert!(told("# nothing\n")[0].1.contains("contains no net"));
}

#[test]
fn a_fault_marks_its_part_of_the_line() {
    let fault = &read("a.snet", "  box B01 = 00399 # x").expect_err("a fault")[0];
    let (from, to) = fault.span.expect("marked");
    assert_eq!(&fault.text[from..to], "00399");
    assert!(fault.help.contains("00305"));
}

#[test]
fn a_file_that_is_no_net_is_told_once_and_many_faults_are_counted() {
    let found = read("a.il", "LD X0\nOUT Y0\nEND\n").expect_err("no net");
    assert_eq!(found.len(), 1);
    assert!(found[0].line == Some(1) && found[0].help.contains("give a file with a net"));
    let many: String = (0..30).map(|n| format!("box B{n} = 00099\n")).collect();
    let found = read("a.snet", &many).expect_err("faults");
    assert_eq!(found.len(), 21);
    assert!(found[20].message.contains("10 more errors"));
}
