//! The list as CX-Programmer imports it for CS, CJ and CP.
//!
//! Internal relays keep their word and bit, holding relays are H, link relays CIO 1000 on; special relays are those that
//! have a symbol there.

use super::c200h::{heading, setting};
use super::list::{Listing, Operand, Operation};
use crate::base::code::Code;
use crate::base::diagnostic::Diagnostic;
use crate::snet::address::{Address, Area};
use crate::snet::{Diagram, Head, Kind};
use std::fmt::Write as _;

/// Special relays of the C200H and the symbols that say the same.
const SYMBOLS: [(u16, u8, &str); 5] = [
    (253, 13, "P_On"),
    (253, 14, "P_Off"),
    (255, 0, "P_0_1s"),
    (255, 1, "P_0_2s"),
    (255, 2, "P_1s"),
];

/// The list.
///
/// # Errors
/// Relays that these CPUs have no counterpart of.
pub fn write(diagram: &Diagram, listing: &Listing) -> Result<String, Vec<Diagnostic>> {
    let mut faults = Vec::new();
    let heads = (diagram.outers.iter().map(|one| &one.head))
        .chain(diagram.transitions.iter().map(|one| &one.head))
        .chain(diagram.places.iter().map(|one| &one.head));
    for head in heads {
        if let Some(address) = head.address.filter(|address| relay(*address).is_none()) {
            let message = format!("{} = {address}: CS, CJ and CP have no such relay", head.name);
            let help =
                "give it an internal, holding or link relay, or one of the pulses 25500 to 25502";
            faults.push(Diagnostic::line(
                Code::NetAddress,
                &diagram.file,
                head.line,
                "",
                message,
                help,
            ));
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut out = String::new();
    for (element, instructions) in &listing.groups {
        let _ = writeln!(out, "'{}", heading(diagram, *element));
        for one in instructions {
            let own = operand(diagram, one.operand);
            let not = |is_closed: bool| if is_closed { "NOT" } else { "" };
            let _ = match one.operation {
                Operation::Load(is_closed) => writeln!(out, "LD{} {own}", not(is_closed)),
                Operation::And(is_closed) => writeln!(out, "AND{} {own}", not(is_closed)),
                Operation::Or(is_closed) => writeln!(out, "OR{} {own}", not(is_closed)),
                Operation::Out => writeln!(out, "OUT {own}"),
                Operation::Timer => {
                    writeln!(out, "TIM {} #{:04}", &own[1..], setting(diagram, one.operand))
                }
                Operation::Counter => {
                    writeln!(out, "CNT {} #{:04}", &own[1..], setting(diagram, one.operand))
                }
            };
        }
    }
    out += "END\n";
    Ok(out)
}

fn relay(address: Address) -> Option<String> {
    let Address { area, word, bit } = address;
    match area {
        Area::Internal if address.is_writable() => Some(format!("{word}.{bit:02}")),
        Area::Internal => {
            let found = SYMBOLS.iter().find(|(own, at, _)| (*own, *at) == (word, bit));
            found.map(|(.., symbol)| (*symbol).to_owned())
        }
        Area::Holding => Some(format!("H{word}.{bit:02}")),
        Area::Link => Some(format!("{}.{bit:02}", 1_000 + word)),
        Area::Auxiliary => None,
    }
}

fn operand(diagram: &Diagram, operand: Operand) -> String {
    let own = |head: &Head| head.address.and_then(relay).unwrap_or_default();
    match operand {
        Operand::Transition(at) => own(&diagram.transitions[at].head),
        Operand::Place(at) => own(&diagram.places[at].head),
        Operand::Outer(at) => own(&diagram.outers[at].head),
        Operand::FirstScan => "P_First_Cycle".to_owned(),
        Operand::Contact(at) => match diagram.places[at].kind {
            Kind::Timer { number, .. } => format!("T{:04}", number.unwrap_or(0)),
            Kind::Counter { number, .. } => format!("C{:04}", number.unwrap_or(0)),
            Kind::Box => own(&diagram.places[at].head),
        },
    }
}
