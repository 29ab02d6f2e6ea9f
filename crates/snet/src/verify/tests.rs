//! Codes that do what the net says, and codes that do not.

use super::*;
use crate::text::read as net;
use crate::translate::{c200h, cx, listing, melsec};

const NET: &str = "\
outer E1 = 00001
box A marked = 00300
timer TM 2.5s = 00301 TIM 3
counter CN 10 = HR0002 CNT 4
transition T = 00310 : A -> TM if not CN E1
transition U = 00311 : TM -> CN A
transition V = 00312 : CN ->
stop X = 00313 : A TM CN *-> if E1
";

fn told(code: &str) -> Vec<(Option<u32>, String)> {
    let diagram = net("n.snet", NET).expect("a net");
    let own = listing(&diagram, false).expect("addresses");
    let found = verify(&diagram, &own, "code.txt", code).expect("a code");
    found.into_iter().map(|one| (one.line, one.message)).collect()
}

fn code() -> String {
    let diagram = net("n.snet", NET).expect("a net");
    c200h(&diagram, &listing(&diagram, false).expect("addresses"))
}

#[test]
fn a_nets_own_code_does_what_it_says_in_both_spellings() {
    assert_eq!(told(&code()), []);
    let diagram = net("n.snet", NET).expect("a net");
    let list = listing(&diagram, false).expect("addresses");
    assert_eq!(told(&cx(&diagram, &list).expect("a list")), []);
}

#[test]
fn code_written_otherwise_may_do_the_same() {
    // A's box by KEEP, T's condition with a relay of its own and in another order.
    let same = code()
        .replace(
            "LD          00311 (MAIN :U)\n00017 OR          00300 (MAIN :A)\n00018 AND NOT     00310 (MAIN :T)\n00019 AND NOT     00313 (MAIN :X)\n00020 OUT         00300 (MAIN :A)",
            "LD          00311\n00017 LD          00310\n00018 OR          00313\n00019 KEEP        00300",
        );
    assert_ne!(same, code());
    assert_eq!(told(&same), []);
    let helped = code().replace(
        "-----TRANSITION MAIN -T\n",
        "LD 00001\nAND NOT CNT 004\nOUT 05000\nLD 05000\nOR 05000\nOUT 05001\n",
    );
    let helped = helped.replacen(
        "AND         00001 (E1)\n00008 AND NOT     CNT 004 (MAIN :CN)",
        "AND 05001",
        1,
    );
    assert!(helped.contains("AND 05001"), "{helped}");
    assert_eq!(told(&helped), []);
}

#[test]
fn what_differs_is_told_at_its_line() {
    let lines: Vec<String> = code().lines().map(str::to_owned).collect();
    let at = |text: &str| lines.iter().position(|line| line.contains(text)).expect("a line");
    // Every contact turned round, every contact left out, every set value changed: each is seen at its output's line.
    let mut tried = 0;
    for (number, line) in lines.iter().enumerate() {
        let changed = if line.contains("AND NOT ") {
            line.replace("AND NOT ", "AND ")
        } else if line.contains(" AND ") {
            line.replace(" AND ", " AND NOT ")
        } else if line.contains(" OR ") {
            line.replace(" OR ", " AND ")
        } else if line.contains('#') {
            line.replace('#', "#9")
        } else {
            continue;
        };
        tried += 1;
        let mut other = lines.clone();
        other[number] = changed;
        let found = told(&other.join("\n"));
        let is_output =
            |line: &String| [" OUT ", " TIM  ", " CNT  "].iter().any(|word| line.contains(word));
        let end = if line.contains('#') {
            number
        } else {
            number + 1 + lines[number..].iter().position(is_output).expect("an output")
        };
        assert!(found.len() == 1, "{line}: {found:?}");
        let is_there = |one: &(Option<u32>, String)| one.0 == u32::try_from(end).ok();
        assert!(found.iter().all(is_there) && !found.is_empty(), "{line}: {found:?}");
    }
    assert!(tried > 15);
    let short = lines[..at("COUNTER")].join("\n");
    let found = told(&short);
    assert!(
        found
            .iter()
            .all(|(line, message)| line.is_none() && message.contains("the code does not write"))
    );
    assert_eq!(found.len(), 3);
    assert!(
        told(&code().replace("00001 (E1)\n", "00001 (E1)\nOUT 00001\n"))
            .iter()
            .any(|(_, m)| m.contains("is an input of the net"))
    );
}

#[test]
fn a_relay_that_is_read_too_early_is_seen() {
    // Box A written before the transitions that look at it.
    let text = code();
    let begin = text.find("-----BOX MAIN -A").expect("the box");
    let end = text.find("-----TIMER").expect("the timer");
    let moved = format!("{}{}{}", &text[begin..end], &text[..begin], &text[end..]);
    assert!(!told(&moved).is_empty());
}

fn for_melsec() -> String {
    let diagram = net("n.snet", NET).expect("a net");
    melsec(&diagram, &listing(&diagram, false).expect("addresses")).expect("a list")
}

#[test]
fn melsec_code_does_what_the_net_says() {
    let code = for_melsec();
    assert_eq!(told(&code), [], "{code}");
    // Blocks, and relays set and reset.
    let same = code.replace("ANI M49\nAND X1\n", "LDI M49\nANB\nLD X1\nANB\n");
    assert_ne!(same, code);
    assert_eq!(told(&same), [], "{same}");
}

#[test]
fn slips_in_melsec_code_are_told() {
    let code = for_melsec();
    // M1 is another relay than the outer gate X1.
    for (right, wrong, what) in [
        ("AND X1\n", "AND M1\n", "X (00313)"),
        ("K25", "K26", "set value 26"),
        ("K10", "K11", "set value 11"),
        ("ANI C4", "AND C4", "T (00310)"),
        ("OUT M48", "OUT M400", "the code does not write A (00300)"),
    ] {
        let wrong = code.replacen(right, wrong, 1);
        assert_ne!(wrong, code, "{right} in\n{code}");
        let found = told(&wrong);
        assert!(found.iter().any(|(_, message)| message.contains(what)), "{what}: {found:?}");
    }
    let behind = code.find("OUT C4").expect("a counter");
    let (begin, count) = (code[..behind].rfind("LD ").expect("LD"), "OUT C4 K10\n");
    let counts = code[begin..behind + count.len()].to_owned();
    let turned = code.replacen(&counts, "", 1).replace("RST C4\n", &format!("RST C4\n{counts}"));
    let found = told(&turned);
    assert!(
        found.iter().any(|(_, message)| message.contains("counts after its reset")),
        "{found:?}"
    );
}
