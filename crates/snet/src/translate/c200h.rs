//! The code as a list in C200H mnemonics with program addresses, in the paper's format.

use super::list::{Element, Listing, Operand, Operation};
use crate::address::Address;
use crate::{Diagram, Head, Kind};
use std::fmt::Write as _;

/// The relay that is on only in the first scan.
const FIRST_SCAN: Address = Address::internal(253, 15);

/// Writes the list.
#[must_use]
pub fn write(diagram: &Diagram, listing: &Listing) -> String {
    let mut out = String::new();
    let mut step = 0;
    let mut line = |out: &mut String, mnemonic: &str, operand: &str, name: &str| {
        let name = if name.is_empty() { String::new() } else { format!(" ({name})") };
        let text = format!("{step:05} {mnemonic:<12}{operand}{name}");
        let _ = writeln!(out, "{}", text.trim_end());
        step += 1;
    };
    for (element, instructions) in &listing.groups {
        let _ = writeln!(out, "-----{}", heading(diagram, *element));
        for one in instructions {
            let (operand, name) = operand(diagram, one.operand);
            let closed = |word: &str, is_closed: bool| {
                if is_closed { format!("{word} NOT") } else { word.to_owned() }
            };
            match one.operation {
                Operation::Load(is_closed) => {
                    line(&mut out, &closed("LD", is_closed), &operand, &name)
                }
                Operation::And(is_closed) => {
                    line(&mut out, &closed("AND", is_closed), &operand, &name)
                }
                Operation::Or(is_closed) => {
                    line(&mut out, &closed("OR", is_closed), &operand, &name)
                }
                Operation::Out => line(&mut out, "OUT", &operand, &name),
                Operation::Timer | Operation::Counter => {
                    let (letters, number) = operand.split_once(' ').unwrap_or(("", &operand));
                    line(&mut out, letters, number, &name);
                    let _ = writeln!(out, "{:18}#{:04}", "", setting(diagram, one.operand));
                }
            }
        }
    }
    line(&mut out, "END", "", "");
    out
}

/// The heading of a group of instructions.
pub(super) fn heading(diagram: &Diagram, element: Element) -> String {
    let own = |what: &str, head: &Head| {
        format!("{what} {} -{}", diagram.pages[head.page].name, head.name)
    };
    match element {
        Element::Initial => "INITIAL".to_owned(),
        Element::Transition(at) if diagram.transitions[at].is_stop => {
            own("E-STOP", &diagram.transitions[at].head)
        }
        Element::Transition(at) => own("TRANSITION", &diagram.transitions[at].head),
        Element::Place(at) => {
            let what = match diagram.places[at].kind {
                Kind::Box => "BOX",
                Kind::Timer { .. } => "TIMER",
                Kind::Counter { .. } => "COUNTER",
            };
            own(what, &diagram.places[at].head)
        }
    }
}

/// An operand's address, and the name that is printed after it.
fn operand(diagram: &Diagram, operand: Operand) -> (String, String) {
    let own = |head: &Head| {
        let address = head.address.map_or(String::new(), |address| address.to_string());
        (address, format!("{} :{}", diagram.pages[head.page].name, head.name))
    };
    match operand {
        Operand::Transition(at) => own(&diagram.transitions[at].head),
        Operand::Place(at) => own(&diagram.places[at].head),
        Operand::Outer(at) => {
            let head = &diagram.outers[at].head;
            (own(head).0, head.name.clone())
        }
        Operand::FirstScan => (FIRST_SCAN.to_string(), "first scan".to_owned()),
        Operand::Contact(at) => {
            let name = own(&diagram.places[at].head).1;
            match diagram.places[at].kind {
                Kind::Timer { number, .. } => (format!("TIM {:03}", number.unwrap_or(0)), name),
                Kind::Counter { number, .. } => (format!("CNT {:03}", number.unwrap_or(0)), name),
                Kind::Box => own(&diagram.places[at].head),
            }
        }
    }
}

/// The set value of a timer or counter.
pub(super) fn setting(diagram: &Diagram, operand: Operand) -> u16 {
    let Operand::Contact(at) = operand else { return 0 };
    match diagram.places[at].kind {
        Kind::Timer { tenths, .. } => tenths,
        Kind::Counter { count, .. } => count,
        Kind::Box => 0,
    }
}
