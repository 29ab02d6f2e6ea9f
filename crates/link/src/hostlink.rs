//! Frames of Host Link in C-mode, for CPUs that have only a serial port.
//!
//! `@`, the unit's number, a header, text, a check sum (all characters so far joined by exclusive or, in two
//! hexadecimal digits), `*` and a carriage return. Only headers that read, or do nothing: RR (inputs, outputs and
//! relays), RH, RL (links), RJ (auxiliary), RD (data), RC (present values of timers and counters), RG (their flags),
//! R#, R$ and R% (their set values), MS (state), TS (test).
//!
//! After OMRON's manuals: C200HS Operation Manual W235, section 11-3; C200HX/HG/HE Operation Manual W303, sections 8-2
//! and 10-3 (words a frame holds, end codes); CJ-series Communications Commands Reference Manual W342, section 4-3 (R$
//! and R% give the first such instruction from the program address on). A request is never so long that its answer
//! takes more than one frame, since what comes in one frame is from one moment.

mod answer;

pub use answer::answer;

use super::device::{Area, AreaKind, Device};
use super::fault::Wrong;
use super::{Coil, Setting, Split, State};

/// The areas; a code is the header's second letter.
pub const AREAS: &[Area] = &[
    Area { name: "AR", code: b'J', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "A", code: b'J', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "HR", code: b'H', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "H", code: b'H', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "LR", code: b'L', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "L", code: b'L', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "DM", code: b'D', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "D", code: b'D', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "SR", code: b'R', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "IR", code: b'R', kind: AreaKind::Word, hexadecimal: false },
    Area { name: "CIO", code: b'R', kind: AreaKind::Word, hexadecimal: false },
];

/// The most words in a request: as many as fit into the first frame of the answer.
pub const MAX_WORDS: u32 = 30;
/// The most flags of timers and counters, for the same reason.
pub const MAX_FLAGS: u32 = 120;
/// The longest frame.
const LONGEST: usize = 131;

/// The check sum of the characters from `@` on.
#[must_use]
pub fn check_sum(text: &[u8]) -> u8 {
    text.iter().fold(0, |sum, byte| sum ^ byte)
}

fn closed(text: String) -> Vec<u8> {
    let sum = check_sum(text.as_bytes());
    format!("{text}{sum:02X}*\r").into_bytes()
}

/// A request for words.
#[must_use]
pub fn request(unit: u8, device: Device, count: u16) -> Vec<u8> {
    let header = char::from(device.area.code);
    closed(format!("@{unit:02}R{header}{:04}{count:04}", device.index))
}

/// A request for present values of timers and counters.
#[must_use]
pub fn present_request(unit: u8, first: u32, count: u16) -> Vec<u8> {
    closed(format!("@{unit:02}RC{first:04}{count:04}"))
}

/// A request for flags of timers and counters.
#[must_use]
pub fn flags_request(unit: u8, first: u32, count: u16) -> Vec<u8> {
    closed(format!("@{unit:02}RG{first:04}{count:04}"))
}

/// A request for the set value of a timer or counter, where that is a number.
#[must_use]
pub fn number_request(unit: u8, coil: Coil, number: u32) -> Vec<u8> {
    closed(format!("@{unit:02}R#{:<4}{number:04}", coil.name()))
}

/// A request for the set value, or for the word that holds it, of the first such instruction from a program address on.
#[must_use]
pub fn setting_request(unit: u8, from: u32, coil: Coil, number: u32) -> Vec<u8> {
    let name = coil.name();
    closed(match from {
        0..10_000 => format!("@{unit:02}R${from:04}{name:<4}{number:04}"),
        _ => format!("@{unit:02}R%{from:06}{name:<4}{number:04}"),
    })
}

/// A test request; the unit sends the same characters back.
#[must_use]
pub fn test_request(unit: u8, text: &str) -> Vec<u8> {
    closed(format!("@{unit:02}TS{text}"))
}

/// A request for the CPU's state.
#[must_use]
pub fn state_request(unit: u8) -> Vec<u8> {
    closed(format!("@{unit:02}MS"))
}

/// Whether a stream begins with a frame.
#[must_use]
pub fn split(bytes: &[u8]) -> Split {
    if bytes.first().is_some_and(|first| *first != b'@') {
        return Split::Garbage;
    }
    match bytes.iter().position(|byte| *byte == b'\r') {
        Some(end) => Split::Frame(end + 1),
        None if bytes.len() > LONGEST => Split::Garbage,
        None => Split::More,
    }
}

/// Unit and header of a whole frame, and the text after them.
fn opened(frame: &[u8]) -> Result<(&str, &str), Wrong> {
    let body = frame.strip_suffix(b"*\r").filter(|body| body.first() == Some(&b'@'));
    let body = body.ok_or_else(|| Wrong::no("it is not a Host Link frame"))?;
    let Some((text, sum)) = body.split_at_checked(body.len().saturating_sub(2)) else {
        return Err(Wrong::no("it is not a Host Link frame"));
    };
    let told = std::str::from_utf8(sum).ok().and_then(|sum| u8::from_str_radix(sum, 16).ok());
    let own = check_sum(text);
    if told != Some(own) {
        let told = String::from_utf8_lossy(sum).into_owned();
        return Err(Wrong::no(format!(
            "its check sum is {told}, but the received characters give {own:02X}: the line is disturbed, or the parity setting is wrong"
        )));
    }
    let text = std::str::from_utf8(text).ok().filter(|text| text.is_ascii());
    let text = text.ok_or_else(|| Wrong::no("it contains characters that are not ASCII"))?;
    text.split_at_checked(5).ok_or_else(|| Wrong::no("it is not a Host Link frame"))
}

/// What an end code means, as far as it is known here.
#[must_use]
pub fn meaning(code: u8) -> &'static str {
    match code {
        0x01 => "the command is not allowed in RUN mode",
        0x02 => "the command is not allowed in MONITOR mode",
        0x04 => "the address lies beyond the end of the program",
        0x0B => "the command is not allowed in PROGRAM mode",
        0x13 => "the check sum of the request is wrong",
        0x14 => "the request is not well-formed",
        0x15 => "the words lie beyond the end of their area",
        0x16 => "the unit does not know this command, or the timer or counter does not exist",
        0x18 => "the frame is too long",
        0x19 => "the unit cannot execute the command",
        0x21 => "the CPU has an error",
        0x23 => "the program is protected from being read",
        0xA3 | 0xA4 | 0xA5 | 0xA8 => "the request was disturbed on its way",
        _ => "see the end codes in the manual of the unit",
    }
}

/// What an answer to that request holds behind its end code.
fn accepted<'a>(frame: &'a [u8], request: &[u8]) -> Result<&'a str, Wrong> {
    let (head, text) = opened(frame)?;
    if head.as_bytes() != request.get(..5).unwrap_or_default() {
        return Err(Wrong::no("it answers another request"));
    }
    let Some((code, data)) = text.split_at_checked(2) else {
        return Err(Wrong::no("it has no end code"));
    };
    match u8::from_str_radix(code, 16) {
        Ok(0) => Ok(data),
        Ok(code) => {
            Err(Wrong::EndCode { code: format!("{code:02X}"), meaning: meaning(code).to_owned() })
        }
        Err(_) => Err(Wrong::no("its end code is not a number")),
    }
}

fn numbers(data: &str) -> Option<Vec<u16>> {
    let four = |four: &[u8]| u16::from_str_radix(std::str::from_utf8(four).ok()?, 16).ok();
    data.len().is_multiple_of(4).then(|| data.as_bytes().chunks(4).map(four).collect())?
}

/// The words of an answer to that request.
///
/// # Errors
/// The frame does not answer this request, or the PLC refuses.
pub fn words(frame: &[u8], request: &[u8], count: u16) -> Result<Vec<u16>, Wrong> {
    let words =
        numbers(accepted(frame, request)?).ok_or_else(|| Wrong::no("it does not contain words"))?;
    if words.len() != usize::from(count) {
        return Err(Wrong::no(format!(
            "{count} words were requested, but {} were received",
            words.len()
        )));
    }
    Ok(words)
}

/// The flags of an answer to that request.
///
/// # Errors
/// The frame does not answer this request, or the PLC refuses.
pub fn flags(frame: &[u8], request: &[u8], count: u16) -> Result<Vec<bool>, Wrong> {
    let data = accepted(frame, request)?;
    if data.len() != usize::from(count) {
        return Err(Wrong::no(format!(
            "{count} flags were requested, but {} were received",
            data.len()
        )));
    }
    let flag = |one: u8| match one {
        b'0' => Ok(false),
        b'1' => Ok(true),
        _ => Err(Wrong::no("it does not contain flags")),
    };
    data.bytes().map(flag).collect()
}

/// The set value of an answer to that request, by number or by operand.
///
/// # Errors
/// The frame does not answer this request, or the PLC refuses.
pub fn setting(frame: &[u8], request: &[u8]) -> Result<Setting, Wrong> {
    let data = accepted(frame, request)?;
    let none = || Wrong::no("it does not contain a set value");
    let (operand, number) = match data.len() {
        4 => ("CON ", data),
        8 => data.split_at(4),
        _ => return Err(none()),
    };
    let digits = number.bytes().all(|digit| digit.is_ascii_digit());
    let decimal = digits.then(|| number.parse::<u16>().ok()).flatten().ok_or_else(none)?;
    if operand == "CON " {
        return Ok(Setting::Number(decimal));
    }
    let area = OPERANDS.iter().find(|(name, _)| *name == operand).ok_or_else(none)?.1;
    Ok(Setting::Word { area, index: decimal.into() })
}

/// The names of operands in answers, and their areas.
const OPERANDS: &[(&str, &str)] =
    &[("CIO ", "IR"), ("LR  ", "LR"), ("HR  ", "HR"), ("AR  ", "AR"), ("DM  ", "DM")];

/// The CPU's state in an answer to this request.
///
/// # Errors
/// The frame does not answer this request, or the PLC refuses.
pub fn state(frame: &[u8], request: &[u8]) -> Result<State, Wrong> {
    let data = accepted(frame, request)?;
    let status = data.get(..4).and_then(numbers);
    let status = status.and_then(|words| words.first().copied());
    let status = status.ok_or_else(|| Wrong::no("the CPU's state is incomplete"))?;
    // Bits 8 and 9: 00 program, 10 run, 11 monitor.
    Ok(if status >> 9 & 1 == 1 { State::Run } else { State::Stop })
}

#[cfg(test)]
mod tests;
