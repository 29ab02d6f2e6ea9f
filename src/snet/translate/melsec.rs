//! The list for MELSEC-Q and L.
//!
//! A relay's number is its word times 16 and its bit: internal relays are M, holding ones L, link ones B, outer gates among
//! the internal ones X. Timers count 100 ms, as on the C200H.

use super::c200h::{heading, setting};
use super::list::{Listing, Operand, Operation};
use crate::base::code::Code;
use crate::base::diagnostic::Diagnostic;
use crate::snet::address::{Address, Area};
use crate::snet::{Diagram, Head, Kind};
use std::fmt::Write as _;

/// The list.
///
/// # Errors
/// Relays that these CPUs have no counterpart of.
pub fn write(diagram: &Diagram, listing: &Listing) -> Result<String, Vec<Diagnostic>> {
    let mut faults = Vec::new();
    for outer in &diagram.outers {
        let head = &outer.head;
        if let Some(address) = head.address.filter(|address| device(*address, true).is_none()) {
            let message = format!("{} = {address}: MELSEC has no such relay", head.name);
            let help = "give it an internal, holding or link relay";
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
        let _ = writeln!(out, "; {}", heading(diagram, *element));
        let mut reset = 0;
        for (at, one) in instructions.iter().enumerate() {
            let own = operand(diagram, one.operand);
            let contact = |open: &str, closed: &str, is_closed: bool| {
                format!("{} {own}", if is_closed { closed } else { open })
            };
            let text = match one.operation {
                Operation::Load(is_closed) => {
                    // What resets a counter begins with its second condition.
                    if instructions[at..]
                        .iter()
                        .skip(1)
                        .all(|next| !matches!(next.operation, Operation::Load(_)))
                    {
                        reset = at;
                    }
                    contact("LD", "LDI", is_closed)
                }
                Operation::And(is_closed) => contact("AND", "ANI", is_closed),
                Operation::Or(is_closed) => contact("OR", "ORI", is_closed),
                Operation::Out => format!("OUT {own}"),
                Operation::Timer => format!("OUT {own} K{}", setting(diagram, one.operand)),
                Operation::Counter => format!("RST {own}"),
            };
            // The counter counts before it is reset.
            let counts = instructions.last().filter(|last| last.operation == Operation::Counter);
            if let Some(last) = counts.filter(|_| at == reset && at > 0) {
                let (counter, value) =
                    (operand(diagram, last.operand), setting(diagram, last.operand));
                let _ = writeln!(out, "OUT {counter} K{value}");
            }
            let _ = writeln!(out, "{text}");
        }
    }
    out += "END\n";
    Ok(out)
}

fn device(address: Address, is_outer: bool) -> Option<String> {
    let number = u32::from(address.word) * 16 + u32::from(address.bit);
    match address.area {
        Area::Internal if !address.is_writable() => None,
        Area::Internal if is_outer => Some(format!("X{number:X}")),
        Area::Internal => Some(format!("M{number}")),
        Area::Holding => Some(format!("L{number}")),
        Area::Link => Some(format!("B{number:X}")),
        Area::Auxiliary => None,
    }
}

fn operand(diagram: &Diagram, operand: Operand) -> String {
    let own = |head: &Head, is_outer| {
        head.address.and_then(|address| device(address, is_outer)).unwrap_or_default()
    };
    match operand {
        Operand::Transition(at) => own(&diagram.transitions[at].head, false),
        Operand::Place(at) => own(&diagram.places[at].head, false),
        Operand::Outer(at) => own(&diagram.outers[at].head, true),
        Operand::FirstScan => "SM402".to_owned(),
        Operand::Contact(at) => match diagram.places[at].kind {
            Kind::Timer { number, .. } => format!("T{}", number.unwrap_or(0)),
            Kind::Counter { number, .. } => format!("C{}", number.unwrap_or(0)),
            Kind::Box => own(&diagram.places[at].head, false),
        },
    }
}
