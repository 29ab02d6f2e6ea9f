//! The gate status list and the assignment table, in the paper's format.

use crate::{Diagram, Head, Kind};
use std::fmt::Write as _;

/// The gates of each transition, page by page; inhibiting ones have a minus sign.
#[must_use]
pub fn gates(diagram: &Diagram) -> String {
    let mut out = String::from("***** ゲート状況リスト\n");
    for (page, own) in diagram.pages.iter().enumerate() {
        let _ = writeln!(out, "*****  {} *****", own.name);
        out += "TRANSITION NO : BOX NO . TIMER NO . COUNTER NO\n";
        for (at, transition) in diagram.transitions.iter().enumerate() {
            if transition.head.page != page {
                continue;
            }
            let mut gates = String::new();
            for gate in diagram.gates_of(at) {
                let name = diagram.signal_name(gate.signal);
                let sign = match (gate.is_inhibiting, gates.is_empty()) {
                    (true, _) => "-",
                    (false, true) => "",
                    (false, false) => " ",
                };
                let _ = write!(gates, "{sign}{name}");
            }
            let _ = writeln!(out, "{}", format!("{:<13} {gates}", transition.head.name).trim_end());
        }
    }
    out
}

/// A heading, and the test for the places under it.
type Group = (&'static str, fn(Kind) -> bool);

/// The relay and number of each element.
#[must_use]
pub fn assignment(diagram: &Diagram) -> String {
    let mut out =
        String::from("***** アドレス割付け表\nトランジションの状態          外部ゲートの状態\n");
    let line = |out: &mut String, head: &Head, more: &str| {
        let address = head.address.map_or(String::new(), |address| address.to_string());
        let page = &diagram.pages[head.page].name;
        let _ = writeln!(out, "{page:<10}: {}=    {address}{more}", head.name);
    };
    let transitions =
        |is_stop: bool| diagram.transitions.iter().filter(move |one| one.is_stop == is_stop);
    transitions(false).for_each(|one| line(&mut out, &one.head, ""));
    for outer in &diagram.outers {
        let address = outer.head.address.map_or(String::new(), |address| address.to_string());
        let _ = writeln!(out, "{:32}{}=    {address}", "", outer.head.name);
    }
    if transitions(true).next().is_some() {
        out += "\n緊急停止トランジションの状態\n";
        transitions(true).for_each(|one| line(&mut out, &one.head, ""));
    }
    let groups: [Group; 3] = [
        ("ボックスの状態", |kind| kind == Kind::Box),
        ("タイマの状態", |kind| matches!(kind, Kind::Timer { .. })),
        ("カウンタの状態", |kind| matches!(kind, Kind::Counter { .. })),
    ];
    for (heading, is) in groups {
        let own: Vec<_> = diagram.places.iter().filter(|place| is(place.kind)).collect();
        if own.is_empty() {
            continue;
        }
        let _ = writeln!(out, "\n{heading}");
        for place in own {
            let more = match place.kind {
                Kind::Box => String::new(),
                Kind::Timer { number, tenths } => {
                    format!("    TIM {:03} #{tenths:04}", number.unwrap_or(0))
                }
                Kind::Counter { number, count } => {
                    format!("    CNT {:03} #{count:04}", number.unwrap_or(0))
                }
            };
            line(&mut out, &place.head, &more);
        }
    }
    out
}
