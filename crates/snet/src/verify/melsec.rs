//! Parses a MELSEC-Q/L list, limited to the instructions in code of nets, and converts it to the operations of C200H
//! code.
//!
//! A relay's number is its word times 16 plus its bit. X and M of the same number are two relays; the addresses of
//! outer gates tell which of them the net means.

use super::words::{Line, Word, faulty, gather, setting};
use crate::address::{Address, Area};
use scanbound_base::diagnostic::Diagnostic;
use std::collections::BTreeSet;

/// Whether a code is for MELSEC: it has relays that OMRON PLCs do not have.
pub(super) fn is_melsec(code: &str) -> bool {
    code.lines().any(|line| {
        let mut words = line.split_whitespace();
        let relay = |word: &str| {
            let word = word.to_ascii_uppercase();
            ["SM", "X", "M", "L", "B"].iter().any(|letters| {
                word.strip_prefix(letters).is_some_and(|number| {
                    !number.is_empty() && number.bytes().all(|b| b.is_ascii_hexdigit())
                })
            })
        };
        let is_instruction = |word: &&str| ["LD", "LDI", "OUT", "SET", "RST"].contains(word);
        words.any(|word| is_instruction(&word)) && words.next().is_some_and(relay)
    })
}

/// Parses a code; `outers` are the relays of the net's outer gates.
pub(super) fn read(
    file: &str,
    code: &str,
    outers: &BTreeSet<String>,
) -> Result<Vec<Line>, Vec<Diagnostic>> {
    let known = "use only LD, AND, OR, LDI, ANI, ORI, ANB, ORB, OUT, SET, RST and END";
    gather(file, code, |line, text, words| {
        word(words, outers).ok_or_else(|| faulty(file, line, text, known))
    })
}

fn word(words: &[&str], outers: &BTreeSet<String>) -> Option<Word> {
    let upper: Vec<String> = words.iter().map(|word| word.to_ascii_uppercase()).collect();
    let (name, rest) = upper.split_first()?;
    let one = || match rest {
        [own] => relay(own, outers),
        _ => None,
    };
    Some(match name.as_str() {
        "LD" => Word::Load(false, one()?),
        "LDI" => Word::Load(true, one()?),
        "AND" => Word::And(false, one()?),
        "ANI" => Word::And(true, one()?),
        "OR" => Word::Or(false, one()?),
        "ORI" => Word::Or(true, one()?),
        "ANB" if rest.is_empty() => Word::AndBlock,
        "ORB" if rest.is_empty() => Word::OrBlock,
        "OUT" => match rest {
            [own] => Word::Out(false, plain(relay(own, outers)?)?),
            [own, value] => {
                let (own, value) = (relay(own, outers)?, setting(value.strip_prefix('K')?));
                match own.get(..3)? {
                    "TIM" => Word::Timer(own, value),
                    "CNT" => Word::Count(own, value),
                    _ => return None,
                }
            }
            _ => return None,
        },
        "SET" => Word::Set(plain(one()?)?),
        "RST" => match one()? {
            own if own.starts_with("CNT") => Word::ResetCounter(own),
            own => Word::Reset(plain(own)?),
        },
        "END" if rest.is_empty() => Word::End,
        _ => return None,
    })
}

/// A relay, unless it belongs to a timer or counter.
fn plain(relay: String) -> Option<String> {
    (!relay.starts_with("TIM") && !relay.starts_with("CNT")).then_some(relay)
}

/// The unique name of a relay: the address from which the translator makes it.
fn relay(text: &str, outers: &BTreeSet<String>) -> Option<String> {
    if text == "SM402" {
        return Some("25315".to_owned());
    }
    let number = |letters: &str, radix: u32| {
        let digits = text.strip_prefix(letters)?;
        let digits = digits.bytes().all(|b| b.is_ascii_hexdigit()).then_some(digits)?;
        u32::from_str_radix(digits, radix).ok()
    };
    for (letters, own) in [("T", "TIM"), ("C", "CNT")] {
        if let Some(number) = number(letters, 10) {
            return Some(format!("{own} {number:03}"));
        }
    }
    let areas = [
        ("X", 16, Area::Internal),
        ("M", 10, Area::Internal),
        ("L", 10, Area::Holding),
        ("B", 16, Area::Link),
    ];
    let (letters, number, area) = areas.into_iter().find_map(|(letters, radix, area)| {
        number(letters, radix).map(|number| (letters, number, area))
    })?;
    let (word, bit) = (u16::try_from(number / 16).ok()?, (number % 16) as u8);
    let address = Address { area, word, bit }.to_string();
    let is_meant = match letters {
        "X" => outers.contains(&address),
        "M" => !outers.contains(&address),
        _ => true,
    };
    Some(if is_meant { address } else { text.to_owned() })
}
