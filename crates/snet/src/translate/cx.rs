//! The code as a list that CX-Programmer imports for CS, CJ and CP.

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
    let help = "give it an internal, holding or link relay, or one of the pulses 25500 to 25502";
    refuse_missing(diagram, Spelling::Cx, "CS, CJ and CP have", help)?;
    let mut out = String::new();
    for (element, instructions) in &listing.groups {
        let _ = writeln!(out, "'{}", heading(diagram, *element));
        for one in instructions {
            let own = operand(diagram, one.operand, Spelling::Cx);
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
