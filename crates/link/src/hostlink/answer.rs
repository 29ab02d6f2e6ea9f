//! The answers of an emulated CPU.

use super::{AREAS, LONGEST, MAX_FLAGS, MAX_WORDS, OPERANDS, closed, opened};
use crate::device::Area;
use crate::{Coil, Memory, Setting, State};

/// The answer to a whole frame. `None` if it is not for this unit.
#[must_use]
pub fn answer(frame: &[u8], unit: u8, memory: &mut dyn Memory) -> Option<Vec<u8>> {
    let own = format!("@{unit:02}");
    let begins = frame.get(..5).and_then(|head| std::str::from_utf8(head).ok());
    let head = begins.filter(|head| head.starts_with(&own))?;
    let back = match opened(frame) {
        Ok(_) if frame.len() > LONGEST => Err(0x18),
        // A test is answered with the same characters, without an end code.
        Ok((_, text)) if head.ends_with("TS") => return Some(closed(format!("{head}{text}"))),
        Ok((_, text)) => answered(&head[3..], text, memory),
        Err(_) => Err(0x13),
    };
    Some(closed(match back {
        Ok(data) => format!("{head}00{data}"),
        Err(code) => format!("{head}{code:02X}"),
    }))
}

/// A number in decimal digits.
fn number(part: Option<&str>) -> Result<u32, u8> {
    let digits = part.filter(|part| part.bytes().all(|byte| byte.is_ascii_digit()));
    digits.and_then(|part| part.parse().ok()).ok_or(0x14)
}

fn answered(header: &str, text: &str, memory: &mut dyn Memory) -> Result<String, u8> {
    match header {
        "MS" if text.is_empty() => {
            let runs = memory.state() == State::Run;
            Ok(if runs { "0200" } else { "0000" }.to_owned())
        }
        "MS" => Err(0x14),
        "RG" => {
            let (first, count) = range(text, MAX_FLAGS)?;
            let flags = memory.bits("TC", first, count).ok_or(0x15u8)?;
            Ok(flags.iter().map(|&flag| if flag { '1' } else { '0' }).collect())
        }
        "R#" => match setting(memory, 0, text)? {
            Setting::Number(number) => Ok(format!("{number:04}")),
            Setting::Word { .. } => Err(0x16),
        },
        "R$" | "R%" => {
            let digits = if header == "R$" { 4 } else { 6 };
            let from = number(text.get(..digits))?;
            let (operand, value) = match setting(memory, from, &text[digits..])? {
                Setting::Number(number) => ("CON ", u32::from(number)),
                Setting::Word { area, index } => {
                    let known = OPERANDS.iter().find(|(_, one)| *one == area);
                    (known.ok_or(0x16u8)?.0, index)
                }
            };
            Ok(format!("{operand}{value:04}"))
        }
        "RC" => read(&["TCPV"], text, memory),
        _ => {
            let letter = header.strip_prefix('R').and_then(|rest| rest.bytes().next());
            let areas = AREAS.iter().filter(|area| Some(area.code) == letter);
            // The same area has different names on different CPUs.
            let names: Vec<&str> = areas.map(|area: &Area| area.name).collect();
            if names.is_empty() { Err(0x16) } else { read(&names, text, memory) }
        }
    }
}

/// The first number and the count of a request.
fn range(text: &str, most: u32) -> Result<(u32, u32), u8> {
    let (first, count) = (number(text.get(..4))?, number(text.get(4..))?);
    match text.len() == 8 && (1..=most).contains(&count) {
        true => Ok((first, count)),
        false => Err(0x14),
    }
}

fn read(names: &[&str], text: &str, memory: &mut dyn Memory) -> Result<String, u8> {
    let (first, count) = range(text, MAX_WORDS)?;
    let words = names.iter().find_map(|name| memory.words(name, first, count));
    Ok(words.ok_or(0x15u8)?.iter().map(|word| format!("{word:04X}")).collect())
}

/// The set value of the timer or counter that a request names.
fn setting(memory: &mut dyn Memory, from: u32, text: &str) -> Result<Setting, u8> {
    let name = text.get(..4).filter(|_| text.len() == 8).ok_or(0x14u8)?;
    let coil = Coil::named(name.trim_end()).ok_or(0x15u8)?;
    memory.setting(coil, number(text.get(4..))?, from).ok_or(0x16)
}
