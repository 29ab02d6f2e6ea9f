//! What translations look like, and that they stand in the paper's order.

use super::*;
use crate::Diagram;
use crate::text::read;

fn net(text: &str) -> Diagram {
    read("n.snet", text).expect("a net")
}

const SELF_HOLDING: &str = include_str!("../../../../samples/snet/self-holding.snet");

#[test]
fn appendix_2_comes_out_as_printed() {
    let diagram = net(SELF_HOLDING);
    let list = c200h(&diagram, &listing(&diagram, false).expect("addresses"));
    let printed = "\
-----TRANSITION MAIN -T01
00000 LD NOT      00300 (MAIN :B01)
00001 AND         00001 (E01)
00002 AND NOT     00002 (E02)
00003 OUT         00305 (MAIN :T01)
-----TRANSITION MAIN -T02
00004 LD          00300 (MAIN :B01)
00005 AND         00002 (E02)
00006 OUT         00306 (MAIN :T02)
-----BOX MAIN -B01
00007 LD          00305 (MAIN :T01)
00008 OR          00300 (MAIN :B01)
00009 AND NOT     00306 (MAIN :T02)
00010 OUT         00300 (MAIN :B01)
00011 END
";
    assert_eq!(list, printed);
    assert_eq!(
        gates(&diagram),
        "***** ゲート状況リスト\n*****  MAIN *****\nTRANSITION NO : BOX NO . TIMER NO . COUNTER NO\n\
         T01           E01-E02\nT02           E02\n"
    );
    assert_eq!(
        assignment(&diagram),
        "***** アドレス割付け表\nトランジションの状態          外部ゲートの状態\n\
         MAIN      : T01=    00305\nMAIN      : T02=    00306\n\
         \x20                               E01=    00001\n\
         \x20                               E02=    00002\n\n\
         ボックスの状態\nMAIN      : B01=    00300\n"
    );
}

const ALL: &str = "\
outer E1 = 00001
box A marked = 00300
timer TM 2.5s = 00301 TIM 3
counter CN 10 = HR0002 CNT 4
transition T = 00310 : A -> TM if not CN E1
transition U = 00311 : TM -> CN A
transition V = 00312 : CN ->
stop X = 00313 : A TM CN *-> if E1
";

#[test]
fn stops_come_first_then_transitions_boxes_timers_and_counters() {
    let diagram = net(ALL);
    let list = c200h(&diagram, &listing(&diagram, true).expect("addresses"));
    let expected = "\
-----INITIAL
00000 LD          25315 (first scan)
00001 OR          00300 (MAIN :A)
00002 OUT         00300 (MAIN :A)
-----E-STOP MAIN -X
00003 LD          00300 (MAIN :A)
00004 OR          00301 (MAIN :TM)
00005 OR          HR0002 (MAIN :CN)
00006 AND         00001 (E1)
00007 OUT         00313 (MAIN :X)
-----TRANSITION MAIN -T
00008 LD          00300 (MAIN :A)
00009 AND NOT     00301 (MAIN :TM)
00010 AND         00001 (E1)
00011 AND NOT     CNT 004 (MAIN :CN)
00012 OUT         00310 (MAIN :T)
-----TRANSITION MAIN -U
00013 LD          TIM 003 (MAIN :TM)
00014 AND NOT     CNT 004 (MAIN :CN)
00015 AND NOT     00300 (MAIN :A)
00016 OUT         00311 (MAIN :U)
-----TRANSITION MAIN -V
00017 LD          CNT 004 (MAIN :CN)
00018 OUT         00312 (MAIN :V)
-----BOX MAIN -A
00019 LD          00311 (MAIN :U)
00020 OR          00300 (MAIN :A)
00021 AND NOT     00310 (MAIN :T)
00022 AND NOT     00313 (MAIN :X)
00023 OUT         00300 (MAIN :A)
-----TIMER MAIN -TM
00024 LD          00310 (MAIN :T)
00025 OR          00301 (MAIN :TM)
00026 AND NOT     00311 (MAIN :U)
00027 AND NOT     00313 (MAIN :X)
00028 OUT         00301 (MAIN :TM)
00029 LD          00301 (MAIN :TM)
00030 TIM         003 (MAIN :TM)
                  #0025
-----COUNTER MAIN -CN
00031 LD          00311 (MAIN :U)
00032 OR          HR0002 (MAIN :CN)
00033 AND NOT     00312 (MAIN :V)
00034 AND NOT     00313 (MAIN :X)
00035 OUT         HR0002 (MAIN :CN)
00036 LD          00311 (MAIN :U)
00037 LD          00312 (MAIN :V)
00038 OR          00313 (MAIN :X)
00039 CNT         004 (MAIN :CN)
                  #0010
00040 END
";
    assert_eq!(list, expected);
}

#[test]
fn melsec_counts_before_it_resets() {
    let diagram = net(ALL);
    let list = melsec(&diagram, &listing(&diagram, true).expect("addresses")).expect("a list");
    assert!(list.starts_with("; INITIAL\nLD SM402\nOR M48\nOUT M48\n"), "{list}");
    assert!(list.contains("OUT L2\nLD M59\nOUT C4 K10\nLD M60\nOR M61\nRST C4\n"), "{list}");
    assert!(list.contains("LD M49\nOUT T3 K25\n"), "{list}");
}

#[test]
fn what_has_no_address_or_no_counterpart_is_refused_with_its_line() {
    let bare = net("box A\ntransition T : A ->\ntransition U = 00001 : -> A");
    let lines: Vec<_> =
        listing(&bare, false).expect_err("no addresses").iter().map(|f| f.line).collect();
    assert_eq!(lines, [Some(1), Some(2)]);
    let special = net("outer E = AR0001\nbox A = 00300\ntransition T = 00301 : A -> if E");
    let list = listing(&special, false).expect("addresses");
    assert_eq!(cx(&special, &list).expect_err("no relay")[0].line, Some(1));
    assert_eq!(melsec(&special, &list).expect_err("no relay")[0].line, Some(1));
    let faults = plcopen(&net(ALL)).expect_err("no chart");
    assert_eq!(faults.iter().map(|f| f.line).collect::<Vec<_>>(), [Some(7), Some(8), Some(4)]);
}
