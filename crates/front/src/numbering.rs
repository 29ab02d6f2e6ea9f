//! The addresses in front of a list's lines: where one is missing, doubled or out of order, a line was lost, doubled or moved.

use super::{Faults, shown};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// A line of a list.
pub struct Numbered<'a> {
    /// Its number in the file.
    pub line: u32,
    /// Its address, if it has one.
    pub address: Option<u32>,
    /// How many addresses it takes; `None` where that is not known, and at least one.
    pub takes: Option<u32>,
    /// Its text.
    pub text: &'a str,
    /// Whether the numbers may begin anew behind it.
    pub ends: bool,
}

const HELP: &str =
    "a line is missing, doubled or moved: correct the list, or take all addresses away";

/// Tells of each line whose address does not follow from the one before it. Where lines could not be read, they are missing
/// for that reason.
pub fn check<'a>(lines: impl IntoIterator<Item = Numbered<'a>>, faults: &mut Faults<'_>) {
    if faults.any_error() {
        return;
    }
    // The last address, and the one that follows it, where that is known.
    let mut last: Option<(u32, Option<u32>)> = None;
    for Numbered { line, address, takes, text, ends } in lines {
        let wrong = match (address, last) {
            (Some(address), Some((before, _))) if address == before => {
                Some(format!("address {address} is taken by the line before"))
            }
            (Some(address), Some((before, _))) if address < before => {
                Some(format!("address {address} follows address {before}"))
            }
            (Some(address), Some((before, Some(next)))) if address > next => {
                Some(format!("address {next} is missing: address {address} follows {before}"))
            }
            (Some(address), Some((before, Some(next)))) if address < next => Some(format!(
                "address {address} follows {before}, whose instruction takes the addresses up to {}",
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
        last = match (ends, at) {
            (true, _) => None,
            (false, Some(at)) => Some((at, takes.and_then(|takes| at.checked_add(takes)))),
            (false, None) => last.map(|(before, _)| (before, None)),
        };
    }
}
