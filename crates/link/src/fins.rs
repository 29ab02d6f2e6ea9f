//! Frames of FINS, over UDP and over TCP: requests and answers.
//!
//! Of its commands only those that read: memory areas (0101), the CPU's state (0601) and its cycle times (0620), as CS and
//! CJ CPUs have them (CS/CJ-series Communications Commands, sections 5-2 and 5-3).

use super::device::{Area, Device, Kind};
use super::fault::Wrong;
use super::{Memory, Split, State};

const fn words_of(name: &'static str, code: u8) -> Area {
    Area { name, code, kind: Kind::Word, hexadecimal: false }
}

/// The areas, by the codes of their words. The code of their bits is that less 80 (hexadecimal).
pub const AREAS: &[Area] = &[
    words_of("CIO", 0xB0),
    words_of("W", 0xB1),
    words_of("H", 0xB2),
    words_of("A", 0xB3),
    words_of("D", 0x82),
];

/// The most words that a request may ask for.
pub const MOST_WORDS: u32 = 500;

/// What a request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ask {
    /// Words from a device on.
    Words(Device, u16),
    /// The CPU's state.
    State,
    /// The cycle times.
    CycleTimes,
}

/// Who sends to whom: nodes of the local network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nodes {
    /// The own.
    pub own: u8,
    /// The PLC's.
    pub plc: u8,
}

/// What an end code means, as far as it is known here.
#[must_use]
pub fn meaning(main: u8, sub: u8) -> &'static str {
    match (main, sub) {
        (0x01, _) => "the local node is not ready",
        (0x02, _) => "the node that was asked is not there, or busy",
        (0x04, _) => "the CPU does not know this command",
        (0x05, _) => "there is no route to the node that was asked",
        (0x10, 0x01) => "the request is too long",
        (0x10, 0x02) => "the request is too short",
        (0x10, _) => "the request is not well-formed",
        (0x11, 0x01) => "there is no such memory area",
        (0x11, 0x03 | 0x04) => "the words lie beyond the end of their area",
        (0x11, 0x0B) => "the answer would be too long",
        (0x11, _) => "a parameter of the request is wrong",
        (0x20 | 0x21, _) => "this cannot be read, it is protected",
        (0x22, _) => "the CPU is not in a mode in which it answers this",
        (0x25, _) => "the unit has an error",
        (0x30, _) => "another node has the access right",
        _ => "see the end codes in the manual of communications commands",
    }
}

/// A request, as it is sent in one datagram.
#[must_use]
pub fn request(ask: Ask, nodes: Nodes, id: u8) -> Vec<u8> {
    let mut frame = vec![0x80, 0x00, 0x02, 0x00, nodes.plc, 0x00, 0x00, nodes.own, 0x00, id];
    match ask {
        Ask::Words(device, count) => {
            frame.extend([0x01, 0x01, device.area.code]);
            // No area has more words than these two bytes can tell.
            frame.extend(u16::try_from(device.index).unwrap_or(u16::MAX).to_be_bytes());
            frame.push(0);
            frame.extend(count.to_be_bytes());
        }
        Ask::State => frame.extend([0x06, 0x01]),
        Ask::CycleTimes => frame.extend([0x06, 0x20, 0x01]),
    }
    frame
}

/// What an answer to that request holds behind its end code.
///
/// # Errors
/// It is no answer to it, or a refusal.
pub fn accepted<'a>(frame: &'a [u8], request: &[u8]) -> Result<&'a [u8], Wrong> {
    let Some((head, rest)) = frame.split_at_checked(12) else {
        return Err(Wrong::no(format!("{} bytes are no FINS frame", frame.len())));
    };
    if head[0] & 0xC0 != 0xC0 {
        return Err(Wrong::no("it is no response"));
    }
    if head.get(9..12) != request.get(9..12) {
        return Err(Wrong::no("it answers another request"));
    }
    let Some((end, data)) = rest.split_at_checked(2) else {
        return Err(Wrong::no("it has no end code"));
    };
    // Bit 7 tells of an error on the way, bits 6 and 7 of the second byte of one of the CPU, which runs on.
    match (end[0] & 0x7F, end[1] & 0x3F) {
        (0, 0) => Ok(data),
        (main, sub) => Err(Wrong::EndCode {
            code: format!("{main:02X}{sub:02X}"),
            meaning: meaning(main, sub).to_owned(),
        }),
    }
}

/// The words of such an answer.
///
/// # Errors
/// They are not as many as were asked for.
pub fn words(data: &[u8], count: u16) -> Result<Vec<u16>, Wrong> {
    let words: Vec<u16> =
        data.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect();
    if data.len() != 2 * usize::from(count) {
        return Err(Wrong::no(format!("{count} words were asked for, {} came", words.len())));
    }
    Ok(words)
}

/// The CPU's state of such an answer.
///
/// # Errors
/// It is cut short.
pub fn state(data: &[u8]) -> Result<State, Wrong> {
    match data.first() {
        Some(status) => Ok(if status & 0x7F == 1 { State::Run } else { State::Stop }),
        None => Err(Wrong::no("the CPU's state is cut short")),
    }
}

/// The mean, the largest and the least cycle time of such an answer, in tenths of a millisecond.
///
/// # Errors
/// It is cut short.
pub fn cycle_times(data: &[u8]) -> Result<[u32; 3], Wrong> {
    let number = |at: usize| {
        let four = data.get(4 * at..4 * at + 4)?;
        Some(u32::from_be_bytes(four.try_into().ok()?))
    };
    match (number(0), number(1), number(2)) {
        (Some(mean), Some(most), Some(least)) => Ok([mean, most, least]),
        _ => Err(Wrong::no("the cycle times are cut short")),
    }
}

/// The answer of a CPU to a datagram; none to what is no request.
#[must_use]
pub fn answer(frame: &[u8], memory: &mut dyn Memory) -> Option<Vec<u8>> {
    let (head, rest) = frame.split_at_checked(10)?;
    // A response is not answered, nor a request that wants none.
    if head[0] & 0x41 != 0 || head[0] & 0x80 == 0 {
        return None;
    }
    let (command, rest) = rest.split_at_checked(2)?;
    let mut back = vec![0xC0, 0x00, 0x02];
    back.extend([head[6], head[7], head[8], head[3], head[4], head[5], head[9]]);
    back.extend(command);
    match answered(command, rest, memory) {
        Ok(data) => {
            back.extend([0, 0]);
            back.extend(data);
        }
        Err(end) => back.extend(end.to_be_bytes()),
    }
    Some(back)
}

fn answered(command: &[u8], rest: &[u8], memory: &mut dyn Memory) -> Result<Vec<u8>, u16> {
    match (command, rest) {
        ([0x01, 0x01], &[code, high, low, bit, many, few]) => {
            let area = AREAS.iter().find(|area| area.code == code).ok_or(0x1101u16)?;
            let first = u32::from(u16::from_be_bytes([high, low]));
            let count = u32::from(u16::from_be_bytes([many, few]));
            if bit != 0 {
                return Err(0x1103);
            }
            if count > MOST_WORDS {
                return Err(0x110B);
            }
            let words = memory.words(area.name, first, count).ok_or(0x1104u16)?;
            Ok(words.iter().flat_map(|word| word.to_be_bytes()).collect())
        }
        ([0x06, 0x01], []) => {
            let runs = memory.state() == State::Run;
            let mut data = vec![u8::from(runs), if runs { 4 } else { 0 }];
            data.resize(26, 0);
            Ok(data)
        }
        ([0x06, 0x20], [0x01]) => {
            Ok(memory.scan_times().iter().flat_map(|time| time.to_be_bytes()).collect())
        }
        ([0x01, 0x01] | [0x06, 0x01] | [0x06, 0x20], _) if rest.len() < 6 => Err(0x1002),
        ([0x01, 0x01] | [0x06, 0x01] | [0x06, 0x20], _) => Err(0x1001),
        _ => Err(0x0401),
    }
}

/// What stands in front of each frame over TCP.
const MAGIC: &[u8; 4] = b"FINS";

/// The header of FINS over TCP: its command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// The client asks for its node's number.
    AskNode,
    /// The server tells both.
    TellNodes,
    /// A frame follows.
    Frame,
    /// The header was wrong.
    Fault,
}

/// A frame as it is sent over TCP.
#[must_use]
pub fn over_tcp(over: Over, error: u32, rest: &[u8]) -> Vec<u8> {
    let command: u32 = match over {
        Over::AskNode => 0,
        Over::TellNodes => 1,
        Over::Frame => 2,
        Over::Fault => 3,
    };
    // What is sent here fits a frame by far.
    let length = u32::try_from(rest.len() + 8).unwrap_or(u32::MAX);
    let mut frame = MAGIC.to_vec();
    frame.extend(length.to_be_bytes());
    frame.extend(command.to_be_bytes());
    frame.extend(error.to_be_bytes());
    frame.extend(rest);
    frame
}

/// What a client asks first over TCP: the numbers of the nodes.
#[must_use]
pub fn hello() -> Vec<u8> {
    over_tcp(Over::AskNode, 0, &[0; 4])
}

/// The longest frame over TCP that is taken, its header included.
const LONGEST: usize = 4096;

/// How far a stream's beginning is a frame over TCP.
#[must_use]
pub fn split(bytes: &[u8]) -> Split {
    let both = bytes.len().min(4);
    if bytes[..both] != MAGIC[..both] {
        return Split::Garbage;
    }
    let Some(Ok(length)) = bytes.get(4..8).map(<[u8; 4]>::try_from) else { return Split::More };
    let length = u32::from_be_bytes(length) as usize;
    if !(8..=LONGEST).contains(&length) {
        return Split::Garbage;
    }
    if bytes.len() < 8 + length { Split::More } else { Split::Frame(8 + length) }
}

/// The command, the error and the rest of a whole frame over TCP.
#[must_use]
pub fn opened(frame: &[u8]) -> Option<(Option<Over>, u32, &[u8])> {
    let number = |at: usize| Some(u32::from_be_bytes(frame.get(at..at + 4)?.try_into().ok()?));
    let over = match number(8)? {
        0 => Some(Over::AskNode),
        1 => Some(Over::TellNodes),
        2 => Some(Over::Frame),
        3 => Some(Over::Fault),
        _ => None,
    };
    Some((over, number(12)?, frame.get(16..)?))
}

/// What an error in the header over TCP means.
#[must_use]
pub fn tcp_meaning(error: u32) -> &'static str {
    match error {
        1 => "the header does not begin with FINS",
        2 => "the frame is too long",
        3 => "the command of the header is not known",
        0x20 => "all connections are in use",
        0x21 => "the node is connected already",
        0x22 => "the PLC is protected from this address",
        0x23 => "the number of the own node is out of range",
        0x24 => "both nodes have the same number",
        0x25 => "all numbers of nodes are in use",
        _ => "see the Ethernet unit's manual",
    }
}

/// The nodes that a server tells.
///
/// # Errors
/// It tells none.
pub fn nodes(frame: &[u8]) -> Result<Nodes, Wrong> {
    match opened(frame) {
        Some((_, error, _)) if error != 0 => Err(Wrong::EndCode {
            code: format!("{error:08X}"),
            meaning: tcp_meaning(error).to_owned(),
        }),
        Some((Some(Over::TellNodes), 0, &[_, _, _, own, _, _, _, plc])) => Ok(Nodes { own, plc }),
        _ => Err(Wrong::no("it does not tell the numbers of the nodes")),
    }
}

/// The frame in what came over TCP.
///
/// # Errors
/// There is none.
pub fn unwrapped(frame: &[u8]) -> Result<&[u8], Wrong> {
    match opened(frame) {
        Some((_, error, _)) if error != 0 => Err(Wrong::EndCode {
            code: format!("{error:08X}"),
            meaning: tcp_meaning(error).to_owned(),
        }),
        Some((Some(Over::Frame), _, inner)) => Ok(inner),
        _ => Err(Wrong::no("it holds no FINS frame")),
    }
}

/// The answer of a CPU to a whole frame over TCP.
#[must_use]
pub fn answer_over_tcp(frame: &[u8], memory: &mut dyn Memory) -> Option<Vec<u8>> {
    // The numbers of the nodes of client and server.
    const NODES: [u8; 8] = [0, 0, 0, 2, 0, 0, 0, 1];
    match opened(frame)? {
        (Some(Over::AskNode), ..) => Some(over_tcp(Over::TellNodes, 0, &NODES)),
        (Some(Over::Frame), _, inner) => {
            answer(inner, memory).map(|back| over_tcp(Over::Frame, 0, &back))
        }
        _ => Some(over_tcp(Over::Fault, 3, &[])),
    }
}

#[cfg(test)]
mod tests;
