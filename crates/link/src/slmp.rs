//! Frames of SLMP and of the MC protocol, 3E: requests and answers, in binary and in ASCII.
//!
//! Only the commands that read are supported: devices in units of words and of bits (0401), and the CPU's name
//! (0101). docs/measuring.md names the sources.

use super::device::{Area, AreaKind, Device};
use super::fault::Wrong;
use super::{Memory, Split};

const fn area(name: &'static str, code: u8, kind: AreaKind, hexadecimal: bool) -> Area {
    Area { name, code, kind, hexadecimal }
}

/// The areas with their codes in binary frames. ASCII frames contain the name; `*` follows a name of one letter.
pub const AREAS: &[Area] = &[
    area("SM", 0x91, AreaKind::Bit, false),
    area("SD", 0xA9, AreaKind::Word, false),
    area("X", 0x9C, AreaKind::Bit, true),
    area("Y", 0x9D, AreaKind::Bit, true),
    area("M", 0x90, AreaKind::Bit, false),
    area("L", 0x92, AreaKind::Bit, false),
    area("F", 0x93, AreaKind::Bit, false),
    area("V", 0x94, AreaKind::Bit, false),
    area("B", 0xA0, AreaKind::Bit, true),
    area("D", 0xA8, AreaKind::Word, false),
    area("W", 0xB4, AreaKind::Word, true),
    area("TS", 0xC1, AreaKind::Bit, false),
    area("TC", 0xC0, AreaKind::Bit, false),
    area("TN", 0xC2, AreaKind::Word, false),
    area("CS", 0xC4, AreaKind::Bit, false),
    area("CC", 0xC3, AreaKind::Bit, false),
    area("CN", 0xC5, AreaKind::Word, false),
    area("SB", 0xA1, AreaKind::Bit, true),
    area("SW", 0xB5, AreaKind::Word, true),
    area("S", 0x98, AreaKind::Bit, false),
    area("Z", 0xCC, AreaKind::Word, false),
    area("R", 0xAF, AreaKind::Word, false),
    area("ZR", 0xB0, AreaKind::Word, false),
];

/// The most words that a request may ask for.
pub const MAX_WORDS: u32 = 960;
/// The most bits that a request may ask for.
const MAX_BITS: u32 = 7168;

/// The coding of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// As bytes.
    Binary,
    /// As hexadecimal digits.
    Ascii,
}

/// A request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// Words from a device on. If it is a bit device, a word holds sixteen of them.
    Words(Device, u16),
    /// Bits from a device on.
    Bits(Device, u16),
    /// The CPU's name.
    Model,
}

/// The known end codes and their meanings.
const END_CODES: &[(u16, &str)] = &[
    (0xC050, "the ASCII data contain a character that is not a digit"),
    (0xC051, "too many devices at once"),
    (0xC052, "too many devices at once"),
    (0xC056, "the devices are beyond the end of their area"),
    (0xC059, "the CPU does not know this command"),
    (0xC05B, "these devices cannot be read"),
    (0xC05C, "the request is not well-formed, or words were requested of a bit device"),
    (0xC060, "the request is not well-formed"),
    (0xC061, "the length in the request does not agree with its data"),
    (0xC0B5, "the request contains data that cannot be handled"),
    (0x4031, "the devices are beyond the range that the CPU's parameters set"),
    (0x4080, "the request contains data that cannot be handled"),
    (0xC201, "the connection is locked by a remote password"),
];

/// The meaning of an end code. Unknown codes refer to the manual.
#[must_use]
pub fn meaning(code: u16) -> &'static str {
    let known = END_CODES.iter().find(|(one, _)| *one == code);
    known.map_or("see the error codes in the manual of the module or CPU", |(_, what)| what)
}

/// How long the PLC waits for its CPU, in quarters of a second.
const PATIENCE: u16 = 4;

/// A request.
#[must_use]
pub fn request(ask: Query, code: Code) -> Vec<u8> {
    let mut data = Writer::new(code);
    data.number(PATIENCE, 2);
    match ask {
        Query::Words(device, count) => {
            data.number(0x0401u16, 2);
            data.number(0x0000u16, 2);
            data.device(device);
            data.number(count, 2);
        }
        Query::Bits(device, count) => {
            data.number(0x0401u16, 2);
            data.number(0x0001u16, 2);
            data.device(device);
            data.number(count, 2);
        }
        Query::Model => {
            data.number(0x0101u16, 2);
            data.number(0x0000u16, 2);
        }
    }
    framed(0x5000, &data.bytes, code)
}

/// A frame: subheader, route to the connected station, length, and the rest.
fn framed(subheader: u16, rest: &[u8], code: Code) -> Vec<u8> {
    let mut frame = Writer::new(code);
    // The subheader alone is not swapped.
    match code {
        Code::Binary => frame.bytes.extend(subheader.to_be_bytes()),
        Code::Ascii => frame.number(subheader, 2),
    }
    frame.number(0x00u8, 1);
    frame.number(0xFFu8, 1);
    frame.number(0x03FFu16, 2);
    frame.number(0x00u8, 1);
    // All requests are short.
    frame.number(u16::try_from(rest.len()).unwrap_or(u16::MAX), 2);
    frame.bytes.extend(rest);
    frame.bytes
}

/// Writes numbers: in binary the low byte first, in ASCII the high digit first.
struct Writer {
    bytes: Vec<u8>,
    code: Code,
}

impl Writer {
    fn new(code: Code) -> Writer {
        Writer { bytes: Vec::new(), code }
    }

    fn number(&mut self, number: impl Into<u32>, bytes: usize) {
        let number = number.into();
        match self.code {
            Code::Binary => self.bytes.extend(&number.to_le_bytes()[..bytes]),
            Code::Ascii => {
                self.bytes.extend(format!("{number:0width$X}", width = 2 * bytes).bytes());
            }
        }
    }

    fn device(&mut self, device: Device) {
        match self.code {
            Code::Binary => {
                self.number(device.index, 3);
                self.number(device.area.code, 1);
            }
            Code::Ascii => {
                self.bytes.extend(format!("{:*<2}", device.area.name).bytes());
                let digits = match device.area.hexadecimal {
                    true => format!("{:06X}", device.index),
                    false => format!("{:06}", device.index),
                };
                self.bytes.extend(digits.bytes());
            }
        }
    }
}

/// Reads numbers. `None` if bytes are missing or are not digits.
struct Reader<'a> {
    bytes: &'a [u8],
    code: Code,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(head)
    }

    fn number(&mut self, bytes: usize) -> Option<u32> {
        match self.code {
            Code::Binary => {
                let bytes = self.take(bytes)?;
                Some(bytes.iter().rev().fold(0, |sum, &byte| sum << 8 | u32::from(byte)))
            }
            Code::Ascii => digits(self.take(2 * bytes)?, 16),
        }
    }

    fn word(&mut self) -> Option<u16> {
        self.number(2).and_then(|number| u16::try_from(number).ok())
    }

    /// A device; the inner `None` if the area is unknown.
    fn device(&mut self) -> Option<Option<Device>> {
        match self.code {
            Code::Binary => {
                let index = self.number(3)?;
                let code = self.number(1)?;
                let area = AREAS.iter().find(|area| u32::from(area.code) == code);
                Some(area.map(|area| Device { area, index, bit: None }))
            }
            Code::Ascii => {
                let name = std::str::from_utf8(self.take(2)?).ok()?;
                let number = self.take(6)?;
                let name = name.trim_end_matches(['*', ' ']);
                let Some(area) = AREAS.iter().find(|area| area.name == name) else {
                    return Some(None);
                };
                let index = digits(number, if area.hexadecimal { 16 } else { 10 })?;
                Some(Some(Device { area, index, bit: None }))
            }
        }
    }
}

/// A number from its digits.
fn digits(digits: &[u8], radix: u32) -> Option<u32> {
    let text = std::str::from_utf8(digits).ok()?;
    let all = !text.is_empty() && text.chars().all(|c| c.is_digit(radix));
    all.then(|| u32::from_str_radix(text, radix).ok()).flatten()
}

/// The coding of a stream, from its first bytes. `None` if it is not known yet.
fn code_of(bytes: &[u8]) -> Option<Code> {
    match *bytes.first()? {
        0x50 | 0xD0 if bytes.get(1) == Some(&0) => Some(Code::Binary),
        b'5' | b'D' => Some(Code::Ascii),
        _ => None,
    }
}

/// Whether a stream begins with a frame: an answer if `answers` is set, otherwise a request.
#[must_use]
pub fn split(bytes: &[u8], answers: bool) -> Split {
    let subheaders: [&[u8]; 2] =
        if answers { [&[0xD0, 0x00], b"D000"] } else { [&[0x50, 0x00], b"5000"] };
    let same = |known: &&&[u8]| {
        let both = known.len().min(bytes.len());
        known[..both] == bytes[..both]
    };
    // A binary 50 and an ASCII 5 are different bytes, and so are D0 and D.
    let Some(found) = subheaders.iter().find(same) else { return Split::Garbage };
    if bytes.len() < found.len() {
        return Split::More;
    }
    let code = if found.len() == 2 { Code::Binary } else { Code::Ascii };
    let mut head = Reader { bytes: &bytes[found.len()..], code };
    let route = if code == Code::Binary { 5 } else { 10 };
    if head.take(route).is_none() {
        return Split::More;
    }
    let length = if code == Code::Binary { 2 } else { 4 };
    if head.bytes.len() < length {
        return Split::More;
    }
    let Some(rest) = head.number(2) else { return Split::Garbage };
    let whole = found.len() + route + length + rest as usize;
    if bytes.len() < whole { Split::More } else { Split::Frame(whole) }
}

/// The part of a whole frame after its length.
fn opened(frame: &[u8]) -> Option<Reader<'_>> {
    let code = code_of(frame)?;
    let head = if code == Code::Binary { 9 } else { 18 };
    Some(Reader { bytes: frame.get(head..)?, code })
}

/// The words in an answer to a request for `count` words.
///
/// # Errors
/// The frame does not answer such a request, or the PLC refuses.
pub fn words(frame: &[u8], count: u16) -> Result<Vec<u16>, Wrong> {
    let mut data = accepted(frame)?;
    let mut words = Vec::new();
    while let Some(word) = data.word() {
        words.push(word);
    }
    if !data.bytes.is_empty() || words.len() != usize::from(count) {
        return Err(Wrong::no(format!(
            "{count} words were requested, but {} were received",
            words.len()
        )));
    }
    Ok(words)
}

/// The bits in an answer to a request for `count` bits.
///
/// # Errors
/// The frame does not answer such a request, or the PLC refuses.
pub fn bits(frame: &[u8], count: u16) -> Result<Vec<bool>, Wrong> {
    let data = accepted(frame)?;
    let count = usize::from(count);
    let bits: Vec<bool> = match data.code {
        Code::Binary => {
            data.bytes.iter().flat_map(|byte| [byte >> 4 == 1, byte & 1 == 1]).collect()
        }
        Code::Ascii => data.bytes.iter().map(|digit| *digit == b'1').collect(),
    };
    let expected = if data.code == Code::Binary { count.next_multiple_of(2) } else { count };
    if bits.len() != expected {
        return Err(Wrong::no(format!(
            "{count} bits were requested, but {} were received",
            bits.len()
        )));
    }
    Ok(bits[..count].to_vec())
}

/// The CPU's name in an answer.
///
/// # Errors
/// The frame does not answer such a request, or the PLC refuses.
pub fn model(frame: &[u8]) -> Result<String, Wrong> {
    let mut data = accepted(frame)?;
    let name = data.take(16).ok_or_else(|| Wrong::no("the CPU's name is incomplete"))?;
    Ok(String::from_utf8_lossy(name).trim().to_owned())
}

/// The data of an answer whose end code reports success.
fn accepted(frame: &[u8]) -> Result<Reader<'_>, Wrong> {
    let mut data = opened(frame).ok_or_else(|| Wrong::no("it is not a 3E frame"))?;
    let code = data.word().ok_or_else(|| Wrong::no("it has no end code"))?;
    match code {
        0 => Ok(data),
        _ => Err(Wrong::EndCode { code: format!("{code:04X}"), meaning: meaning(code).to_owned() }),
    }
}

/// The answer of an emulated CPU to a whole request; an end code if the request is not supported.
#[must_use]
pub fn answer(frame: &[u8], memory: &mut dyn Memory) -> Vec<u8> {
    let code = code_of(frame).unwrap_or(Code::Binary);
    let answered = opened(frame).map_or(Err(0xC061), |data| answered(data, memory));
    let mut rest = Writer::new(code);
    match answered {
        Ok(data) => {
            rest.number(0u16, 2);
            rest.bytes.extend(data);
        }
        Err(end) => {
            rest.number(end, 2);
            // The station, command and subcommand of the request.
            let (command, sub) = asked(frame).unwrap_or_default();
            rest.number(0x00u8, 1);
            rest.number(0xFFu8, 1);
            rest.number(0x03FFu16, 2);
            rest.number(0x00u8, 1);
            rest.number(command, 2);
            rest.number(sub, 2);
        }
    }
    framed(0xD000, &rest.bytes, code)
}

/// The command and subcommand of a request.
fn asked(frame: &[u8]) -> Option<(u16, u16)> {
    let mut data = opened(frame)?;
    data.word()?;
    Some((data.word()?, data.word()?))
}

fn answered(mut data: Reader<'_>, memory: &mut dyn Memory) -> Result<Vec<u8>, u16> {
    const SHORT: u16 = 0xC061;
    let code = data.code;
    data.word().ok_or(SHORT)?;
    let command = data.word().ok_or(SHORT)?;
    let sub = data.word().ok_or(SHORT)?;
    let mut out = Writer::new(code);
    match (command, sub) {
        (0x0401, 0 | 1) => {
            let device = data.device().ok_or(SHORT)?;
            let count = data.word().ok_or(SHORT)?.into();
            if !data.bytes.is_empty() {
                return Err(SHORT);
            }
            let device = device.ok_or(0xC05Bu16)?;
            if sub == 0 {
                if !(1..=MAX_WORDS).contains(&count) {
                    return Err(0xC051);
                }
                // Words of bit devices begin at a multiple of 16.
                if device.area.kind == AreaKind::Bit && !device.index.is_multiple_of(16) {
                    return Err(0xC05C);
                }
                let words = memory.words(device.area.name, device.index, count);
                words.ok_or(0xC056u16)?.into_iter().for_each(|word| out.number(word, 2));
            } else {
                if device.area.kind == AreaKind::Word {
                    return Err(0xC05C);
                }
                if !(1..=MAX_BITS).contains(&count) {
                    return Err(0xC052);
                }
                let bits = memory.bits(device.area.name, device.index, count).ok_or(0xC056u16)?;
                match code {
                    Code::Ascii => {
                        out.bytes.extend(bits.iter().map(|bit| if *bit { b'1' } else { b'0' }));
                    }
                    Code::Binary => {
                        let pair = |pair: &[bool]| {
                            let second = pair.get(1).copied().unwrap_or(false);
                            u8::from(pair[0]) << 4 | u8::from(second)
                        };
                        out.bytes.extend(bits.chunks(2).map(pair));
                    }
                }
            }
        }
        (0x0101, 0) => {
            let name = memory.model();
            let name: Vec<u8> = name.bytes().chain(std::iter::repeat(b' ')).take(16).collect();
            out.bytes.extend(name);
            // The type code differs between CPUs; no CPU has 0.
            out.number(0u16, 2);
        }
        _ => return Err(0xC059),
    }
    Ok(out.bytes)
}

#[cfg(test)]
mod tests;
