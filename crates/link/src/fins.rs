//! Frames of FINS, over UDP and over TCP: requests and answers.
//!
//! Only the commands that read are supported: memory areas (0101), the CPU's state (0601) and its cycle times (0620),
//! as CS and CJ CPUs have them (CS/CJ-series Communications Commands, sections 5-2 and 5-3).

use super::device::{Area, AreaKind, Device};
use super::fault::Wrong;
use super::{Memory, Split, State};

const fn words_of(name: &'static str, code: u8) -> Area {
    Area { name, code, kind: AreaKind::Word, hexadecimal: false }
}

/// The areas with the codes of their words. The code of the bits of an area is lower by 0x80.
pub const AREAS: &[Area] = &[
    words_of("CIO", 0xB0),
    words_of("W", 0xB1),
    words_of("H", 0xB2),
    words_of("A", 0xB3),
    words_of("D", 0x82),
];

/// The most words that a request may ask for.
pub const MAX_WORDS: u32 = 500;

/// A request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// Words from a device on.
    Words(Device, u16),
    /// The CPU's state.
    State,
    /// The cycle times.
    CycleTimes,
}

/// The node numbers of client and PLC in the local network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nodes {
    /// This program's node.
    pub own: u8,
    /// The PLC's node.
    pub plc: u8,
}

/// The meaning of an end code. Unknown codes refer to the manual.
#[must_use]
pub fn meaning(main: u8, sub: u8) -> &'static str {
    match (main, sub) {
        (0x01, _) => "the local node is not ready",
        (0x02, _) => "the PLC's node does not exist or is busy",
        (0x04, _) => "the CPU does not know this command",
        (0x05, _) => "there is no route to the PLC's node",
        (0x10, 0x01) => "the request is too long",
        (0x10, 0x02) => "the request is too short",
        (0x10, _) => "the request is not well-formed",
        (0x11, 0x01) => "there is no such memory area",
        (0x11, 0x03 | 0x04) => "the words are beyond the end of their area",
        (0x11, 0x0B) => "the answer would be too long",
        (0x11, _) => "a parameter of the request is wrong",
        (0x20 | 0x21, _) => "these data are read-protected",
        (0x22, _) => "the CPU does not allow this command in its present mode",
        (0x25, _) => "the unit has an error",
        (0x30, _) => "another node has the access right",
        _ => "see the end codes in the manual of communications commands",
    }
}

/// The frame of a request; it is one datagram.
#[must_use]
pub fn request(ask: Query, nodes: Nodes, id: u8) -> Vec<u8> {
    let mut frame = vec![0x80, 0x00, 0x02, 0x00, nodes.plc, 0x00, 0x00, nodes.own, 0x00, id];
    match ask {
        Query::Words(device, count) => {
            frame.extend([0x01, 0x01, device.area.code]);
            // No area has more words than two bytes can address.
            frame.extend(u16::try_from(device.index).unwrap_or(u16::MAX).to_be_bytes());
            frame.push(0);
            frame.extend(count.to_be_bytes());
        }
        Query::State => frame.extend([0x06, 0x01]),
        Query::CycleTimes => frame.extend([0x06, 0x20, 0x01]),
    }
    frame
}

/// The data of an answer, which follows its end code.
///
/// # Errors
/// The frame does not answer this request, or the PLC refuses.
pub fn accepted<'a>(frame: &'a [u8], request: &[u8]) -> Result<&'a [u8], Wrong> {
    let Some((head, rest)) = frame.split_at_checked(12) else {
        return Err(Wrong::no(format!("{} bytes are too few for a FINS frame", frame.len())));
    };
    if head[0] & 0xC0 != 0xC0 {
        return Err(Wrong::no("it is not a response"));
    }
    if head.get(9..12) != request.get(9..12) {
        return Err(Wrong::no("it answers another request"));
    }
    let Some((end, data)) = rest.split_at_checked(2) else {
        return Err(Wrong::no("it has no end code"));
    };
    // Bit 7 of the first byte: an error of the network. Bits 6 and 7 of the second byte: a CPU error that does not stop
    // it.
    match (end[0] & 0x7F, end[1] & 0x3F) {
        (0, 0) => Ok(data),
        (main, sub) => Err(Wrong::EndCode {
            code: format!("{main:02X}{sub:02X}"),
            meaning: meaning(main, sub).to_owned(),
        }),
    }
}

/// The words in the data of an answer.
///
/// # Errors
/// Their number differs from the requested number.
pub fn words(data: &[u8], count: u16) -> Result<Vec<u16>, Wrong> {
    let words: Vec<u16> =
        data.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect();
    if data.len() != 2 * usize::from(count) {
        return Err(Wrong::no(format!(
            "{count} words were requested, but {} were received",
            words.len()
        )));
    }
    Ok(words)
}

/// The CPU's state in the data of an answer.
///
/// # Errors
/// The data is incomplete.
pub fn state(data: &[u8]) -> Result<State, Wrong> {
    match data.first() {
        Some(status) => Ok(if status & 0x7F == 1 { State::Run } else { State::Stop }),
        None => Err(Wrong::no("the CPU's state is incomplete")),
    }
}

/// The mean, the largest and the smallest cycle time in the data of an answer, in tenths of a millisecond.
///
/// # Errors
/// The data is incomplete.
pub fn cycle_times(data: &[u8]) -> Result<[u32; 3], Wrong> {
    let number = |at: usize| {
        let four = data.get(4 * at..4 * at + 4)?;
        Some(u32::from_be_bytes(four.try_into().ok()?))
    };
    match (number(0), number(1), number(2)) {
        (Some(mean), Some(most), Some(least)) => Ok([mean, most, least]),
        _ => Err(Wrong::no("the cycle times are incomplete")),
    }
}

/// The answer of an emulated CPU to a datagram. `None` if the datagram needs no answer.
#[must_use]
pub fn answer(frame: &[u8], memory: &mut dyn Memory) -> Option<Vec<u8>> {
    let (head, rest) = frame.split_at_checked(10)?;
    // Responses, and requests that want no response, are not answered.
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
            if count > MAX_WORDS {
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

/// The first bytes of each frame over TCP.
const MAGIC: &[u8; 4] = b"FINS";

/// The command in the header of FINS over TCP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// The client asks for its node number.
    AskNode,
    /// The server sends both node numbers.
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
    // All frames that are sent here are short.
    let length = u32::try_from(rest.len() + 8).unwrap_or(u32::MAX);
    let mut frame = MAGIC.to_vec();
    frame.extend(length.to_be_bytes());
    frame.extend(command.to_be_bytes());
    frame.extend(error.to_be_bytes());
    frame.extend(rest);
    frame
}

/// The first frame of a client over TCP: it asks for the node numbers.
#[must_use]
pub fn hello() -> Vec<u8> {
    over_tcp(Over::AskNode, 0, &[0; 4])
}

/// The longest accepted frame over TCP, including its header.
const LONGEST: usize = 4096;

/// Whether a stream begins with a frame over TCP.
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

/// The meaning of an error code in the header over TCP.
#[must_use]
pub fn tcp_meaning(error: u32) -> &'static str {
    match error {
        1 => "the header does not begin with FINS",
        2 => "the frame is too long",
        3 => "the command of the header is not known",
        0x20 => "all connections are in use",
        0x21 => "the node is already connected",
        0x22 => "the PLC does not accept connections from this address",
        0x23 => "this computer's node number is out of range",
        0x24 => "both nodes have the same number",
        0x25 => "all node numbers are in use",
        _ => "see the Ethernet unit's manual",
    }
}

/// The node numbers in a server's first answer.
///
/// # Errors
/// The answer has no node numbers, or reports an error.
pub fn nodes(frame: &[u8]) -> Result<Nodes, Wrong> {
    match opened(frame) {
        Some((_, error, _)) if error != 0 => Err(Wrong::EndCode {
            code: format!("{error:08X}"),
            meaning: tcp_meaning(error).to_owned(),
        }),
        Some((Some(Over::TellNodes), 0, &[_, _, _, own, _, _, _, plc])) => Ok(Nodes { own, plc }),
        _ => Err(Wrong::no("it does not contain the node numbers")),
    }
}

/// The FINS frame inside a frame over TCP.
///
/// # Errors
/// There is none, or the header reports an error.
pub fn unwrapped(frame: &[u8]) -> Result<&[u8], Wrong> {
    match opened(frame) {
        Some((_, error, _)) if error != 0 => Err(Wrong::EndCode {
            code: format!("{error:08X}"),
            meaning: tcp_meaning(error).to_owned(),
        }),
        Some((Some(Over::Frame), _, inner)) => Ok(inner),
        _ => Err(Wrong::no("it does not contain a FINS frame")),
    }
}

/// The answer of an emulated CPU to a whole frame over TCP.
#[must_use]
pub fn answer_over_tcp(frame: &[u8], memory: &mut dyn Memory) -> Option<Vec<u8>> {
    // The node numbers of client and server.
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
