//! Frames of Host Link in C-mode, the way to CPUs that have a serial port alone.
//!
//! `@`, the unit's number, a header, text, a check sum (all characters so far joined by exclusive or, in two hexadecimal
//! digits), `*` and a carriage return. Only headers that read: RR (inputs, outputs and relays), RH, RJ (auxiliary), RD
//! (data), MS (state).

use super::device::{Area, Device, Kind};
use super::fault::Wrong;
use super::{Memory, Split, State};

/// The areas; a code is the header's second letter.
pub const AREAS: &[Area] = &[
    Area { name: "AR", code: b'J', kind: Kind::Word, hexadecimal: false },
    Area { name: "A", code: b'J', kind: Kind::Word, hexadecimal: false },
    Area { name: "HR", code: b'H', kind: Kind::Word, hexadecimal: false },
    Area { name: "H", code: b'H', kind: Kind::Word, hexadecimal: false },
    Area { name: "DM", code: b'D', kind: Kind::Word, hexadecimal: false },
    Area { name: "D", code: b'D', kind: Kind::Word, hexadecimal: false },
    Area { name: "IR", code: b'R', kind: Kind::Word, hexadecimal: false },
    Area { name: "CIO", code: b'R', kind: Kind::Word, hexadecimal: false },
];

/// The most words that a request may ask for: those that the answer's first frame holds.
pub const MOST_WORDS: u32 = 30;
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

/// A request for the CPU's state.
#[must_use]
pub fn state_request(unit: u8) -> Vec<u8> {
    closed(format!("@{unit:02}MS"))
}

/// How far a stream's beginning is a frame.
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

/// Unit and header of a whole frame, and the text behind; none if it is no frame.
fn opened(frame: &[u8]) -> Result<(&str, &str), Wrong> {
    let body = frame.strip_suffix(b"*\r").filter(|body| body.first() == Some(&b'@'));
    let body = body.ok_or_else(|| Wrong::no("no Host Link frame"))?;
    let Some((text, sum)) = body.split_at_checked(body.len().saturating_sub(2)) else {
        return Err(Wrong::no("no Host Link frame"));
    };
    let told = std::str::from_utf8(sum).ok().and_then(|sum| u8::from_str_radix(sum, 16).ok());
    let own = check_sum(text);
    if told != Some(own) {
        let told = String::from_utf8_lossy(sum).into_owned();
        return Err(Wrong::no(format!(
            "its check sum is {told}, that of its characters {own:02X}: the line disturbs it, or the parity differs"
        )));
    }
    let text = std::str::from_utf8(text).ok().filter(|text| text.is_ascii());
    let text = text.ok_or_else(|| Wrong::no("it holds what is no ASCII"))?;
    text.split_at_checked(5).ok_or_else(|| Wrong::no("no Host Link frame"))
}

/// What an end code means, as far as it is known here.
#[must_use]
pub fn meaning(code: u8) -> &'static str {
    match code {
        0x01 => "not in RUN",
        0x02 => "not in MONITOR",
        0x0B => "not in PROGRAM",
        0x13 => "the check sum of the request is wrong",
        0x14 => "the request is not well-formed",
        0x15 => "the words lie beyond the end of their area",
        0x16 => "the unit does not know this command",
        0x18 => "the frame is too long",
        0x19 => "it cannot be done",
        0x21 => "the CPU has an error",
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
        Err(_) => Err(Wrong::no("its end code is no number")),
    }
}

fn numbers(data: &str) -> Option<Vec<u16>> {
    let four = |four: &[u8]| u16::from_str_radix(std::str::from_utf8(four).ok()?, 16).ok();
    data.len().is_multiple_of(4).then(|| data.as_bytes().chunks(4).map(four).collect())?
}

/// The words of an answer to that request.
///
/// # Errors
/// It is no answer to it, or a refusal.
pub fn words(frame: &[u8], request: &[u8], count: u16) -> Result<Vec<u16>, Wrong> {
    let words = numbers(accepted(frame, request)?).ok_or_else(|| Wrong::no("it holds no words"))?;
    if words.len() != usize::from(count) {
        return Err(Wrong::no(format!("{count} words were asked for, {} came", words.len())));
    }
    Ok(words)
}

/// The CPU's state of an answer to that request.
///
/// # Errors
/// It is no answer to it, or a refusal.
pub fn state(frame: &[u8], request: &[u8]) -> Result<State, Wrong> {
    let data = accepted(frame, request)?;
    let status = data.get(..4).and_then(numbers);
    let status = status.and_then(|words| words.first().copied());
    let status = status.ok_or_else(|| Wrong::no("the CPU's state is cut short"))?;
    // Bits 8 and 9: 00 program, 10 run, 11 monitor.
    Ok(if status >> 9 & 1 == 1 { State::Run } else { State::Stop })
}

/// The answer of a CPU to a whole frame; none to what is not for this unit.
#[must_use]
pub fn answer(frame: &[u8], unit: u8, memory: &mut dyn Memory) -> Option<Vec<u8>> {
    let own = format!("@{unit:02}");
    let begins = frame.get(..5).and_then(|head| std::str::from_utf8(head).ok());
    let head = begins.filter(|head| head.starts_with(&own))?;
    let back = match opened(frame) {
        Ok((_, text)) => answered(&head[3..], text, memory),
        Err(_) => Err(0x13),
    };
    Some(closed(match back {
        Ok(data) => format!("{head}00{data}"),
        Err(code) => format!("{head}{code:02X}"),
    }))
}

fn answered(header: &str, text: &str, memory: &mut dyn Memory) -> Result<String, u8> {
    if header == "MS" {
        let runs = memory.state() == State::Run;
        return Ok(if runs { "0200" } else { "0000" }.to_owned());
    }
    let letter = header.strip_prefix('R').and_then(|rest| rest.bytes().next());
    let areas: Vec<&Area> = AREAS.iter().filter(|area| Some(area.code) == letter).collect();
    if areas.is_empty() {
        return Err(0x16);
    }
    let number = |part: Option<&str>| {
        part.filter(|part| part.bytes().all(|byte| byte.is_ascii_digit()))
            .and_then(|part| part.parse::<u32>().ok())
            .ok_or(0x14u8)
    };
    let (first, count) = (number(text.get(..4))?, number(text.get(4..))?);
    if text.len() != 8 || !(1..=MOST_WORDS).contains(&count) {
        return Err(0x14);
    }
    // An area has different names on different CPUs.
    let words = areas.iter().find_map(|area| memory.words(area.name, first, count));
    Ok(words.ok_or(0x15u8)?.iter().map(|word| format!("{word:04X}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Counted;

    impl Memory for Counted {
        fn words(&mut self, area: &str, first: u32, count: u32) -> Option<Vec<u16>> {
            let all = matches!(area, "AR" | "DM") && first + count <= 1000;
            all.then(|| (first..first + count).map(|n| n as u16).collect())
        }

        fn bits(&mut self, _: &str, _: u32, _: u32) -> Option<Vec<bool>> {
            None
        }

        fn state(&mut self) -> State {
            State::Run
        }

        fn model(&mut self) -> String {
            String::new()
        }

        fn scan_times(&mut self) -> [u32; 3] {
            [0; 3]
        }
    }

    fn device(name: &str) -> Device {
        Device::named(name, AREAS).expect("a device")
    }

    #[test]
    fn frames_end_with_the_sum_of_their_characters() {
        // By hand: 40^30^30^52^44 = 56, ^ "00000010" = 57.
        assert_eq!(request(0, device("DM0"), 10), b"@00RD0000001057*\r");
        assert_eq!(request(0, device("AR26"), 2)[..13], *b"@00RJ00260002");
        assert_eq!(state_request(0), b"@00MS5E*\r");
    }

    #[test]
    fn answers_are_read() {
        let request = request(0, device("DM0"), 2);
        let good = closed("@00RD0000030190".to_owned());
        assert_eq!(words(&good, &request, 2), Ok(vec![3, 0x190]));
        let mut wrong = good.clone();
        let at = wrong.len() - 3;
        wrong[at] = if wrong[at] == b'0' { b'1' } else { b'0' };
        let Err(Wrong::NoAnswer(why)) = words(&wrong, &request, 2) else { panic!("a fault") };
        assert!(why.contains("check sum"));
        let refused = closed("@00RD15".to_owned());
        let Err(Wrong::EndCode { code, meaning }) = words(&refused, &request, 2) else {
            panic!("a refusal")
        };
        assert_eq!((&*code, meaning.contains("beyond")), ("15", true));
        let other = closed("@01RD000003".to_owned());
        assert!(matches!(words(&other, &request, 1), Err(Wrong::NoAnswer(_))));
        let asked = state_request(0);
        assert_eq!(state(&closed("@00MS000000".to_owned()), &asked), Ok(State::Stop));
        assert_eq!(state(&closed("@00MS000300".to_owned()), &asked), Ok(State::Run));
    }

    #[test]
    fn the_cpu_answers_what_it_is_asked() {
        let ask = |frame: &[u8]| answer(frame, 0, &mut Counted);
        let asked = request(0, device("AR26"), 2);
        let back = ask(&asked).expect("an answer");
        assert_eq!(split(&back), Split::Frame(back.len()));
        assert_eq!(words(&back, &asked, 2), Ok(vec![26, 27]));
        let asked = state_request(0);
        assert_eq!(state(&ask(&asked).expect("an answer"), &asked), Ok(State::Run));
        assert_eq!(ask(&request(1, device("AR26"), 2)), None);
        let code = |text: &str| ask(&closed(text.to_owned())).expect("an answer")[5..7].to_vec();
        assert_eq!(code("@00RD99990002"), b"15");
        assert_eq!(code("@00RD0000"), b"14");
        assert_eq!(code("@00RD00000031"), b"14");
        assert_eq!(code("@00WD00000001"), b"16");
        assert_eq!(ask(b"@00RD0000001000*\r").expect("an answer")[5..7], *b"13");
    }

    #[test]
    fn no_frame_brings_it_down() {
        for frame in [request(0, device("AR26"), 2), state_request(0)] {
            for at in 0..frame.len() {
                let _ = answer(&frame[..at], 0, &mut Counted);
                for value in 0..=255 {
                    let mut changed = frame.clone();
                    changed[at] = value;
                    let _ = split(&changed);
                    let _ = answer(&changed, 0, &mut Counted);
                    let _ = words(&changed, &frame, 2);
                }
            }
        }
    }
}
