//! Checks the addresses at the start of a list's lines: a missing, repeated or unordered address shows that a line was
//! lost, repeated or moved.

use super::{Faults, shown};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// A line of a list that has an instruction.
pub struct NumberedLine<'a> {
    /// The number of the line in the file, from 1.
    pub line: u32,
    /// The address at the beginning of the line. `None` if it has none.
    pub address: Option<u32>,
    /// The number of addresses that the instruction occupies; `None` if unknown (but at least one).
    pub takes: Option<u32>,
    /// The text of the line after the address, for messages.
    pub text: &'a str,
    /// Whether the addresses may start again from 0 after this line.
    pub restarts: bool,
}

const HELP: &str =
    "a line is missing, repeated or moved: correct the list, or remove all addresses";

/// Adds an error for each line whose address does not follow from the line before. Does nothing if the file already has
/// errors, because lines that could not be read are missing here.
pub fn check<'a>(lines: impl IntoIterator<Item = NumberedLine<'a>>, faults: &mut Faults<'_>) {
    if faults.any_error() {
        return;
    }
    // The address of the line before, and the address that must follow it, if known.
    let mut last: Option<(u32, Option<u32>)> = None;
    for NumberedLine { line, address, takes, text, restarts } in lines {
        let wrong = match (address, last) {
            (Some(address), Some((before, _))) if address == before => {
                Some(format!("the line before has address {address} too"))
            }
            (Some(address), Some((before, _))) if address < before => {
                Some(format!("address {address} follows address {before}"))
            }
            (Some(address), Some((before, Some(next)))) if address > next => {
                Some(format!("address {next} is missing: address {address} follows {before}"))
            }
            (Some(address), Some((before, Some(next)))) if address < next => Some(format!(
                "address {address} follows {before}, whose instruction occupies the addresses up to {}",
                next - 1
            )),
            _ => None,
        };
        if let Some(message) = wrong {
            let file = faults.file();
            faults.push(
                Diagnostic::line(Code::StepOrder, file, line, shown(text), message, HELP)
                    .at_step(address),
            );
        }
        let at = address.or(last.and_then(|(_, next)| next));
        last = match (restarts, at) {
            (true, _) => None,
            (false, Some(at)) => Some((at, takes.and_then(|takes| at.checked_add(takes)))),
            (false, None) => last.map(|(before, _)| (before, None)),
        };
    }
}
