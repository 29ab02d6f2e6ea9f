//! The code as a list for MELSEC-Q and L. Timers have a time base of 100 ms, as on the C200H.

use super::c200h::{heading, setting};
use super::list::{Listing, Operation};
use super::relay::{Spelling, operand, refuse_missing};
use crate::Diagram;
use scanbound_base::diagnostic::Diagnostic;
use std::fmt::Write as _;

/// Writes the list.
///
/// # Errors
/// Relays that these CPUs do not have.
pub fn write(diagram: &Diagram, listing: &Listing) -> Result<String, Vec<Diagnostic>> {
    let help = "give it an internal, holding or link relay";
    refuse_missing(diagram, Spelling::Melsec, "MELSEC has", help)?;
    let named = |of| operand(diagram, of, Spelling::Melsec);
    let mut out = String::new();
    for (element, instructions) in &listing.groups {
        let _ = writeln!(out, "; {}", heading(diagram, *element));
        let mut reset = 0;
        for (at, one) in instructions.iter().enumerate() {
            let own = named(one.operand);
            let contact = |open: &str, closed: &str, is_closed: bool| {
                format!("{} {own}", if is_closed { closed } else { open })
            };
            let text = match one.operation {
                Operation::Load(is_closed) => {
                    // The instructions from its second condition on reset the counter.
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
                let (counter, value) = (named(last.operand), setting(diagram, last.operand));
                let _ = writeln!(out, "OUT {counter} K{value}");
            }
            let _ = writeln!(out, "{text}");
        }
    }
    out += "END\n";
    Ok(out)
}
