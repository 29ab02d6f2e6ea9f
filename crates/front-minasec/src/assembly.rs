//! Reads and writes MINASEC-U assembly: one instruction a line, with an optional address before it.

use super::source::{ASSEMBLY, Source};
use super::word::{Device, Opcode, WORDS, Word};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::Faults;
use scanbound_front::numbering::{self, NumberedLine};
use scanbound_front::slice_range;
use scanbound_front::text;
use std::fmt::Write as _;

/// The number of instruction lines that are examined to recognise a file.
const LOOKED_AT: usize = 40;
/// The help text about instructions.
const FORM: &str = "write LD, LDI, AND, ANDI, OR, ORI, ST or STI and a device, such as LD X00; comments begin with ; or //";
/// The help text about devices.
const DEVICES: &str =
    "the devices are X00-X07, Y00-Y07, M00-M07, M10-M13, T0, T1, C0 and its clear C0CLR";

/// Whether a file begins like MINASEC-U assembly. If there is a store, at least half of the instructions must have a
/// known mnemonic and one operand, and at least one a valid device: of other dialects, only instruction lists of IEC
/// 61131-3 have these stores, and their devices are different. A list without a store could be in another dialect, so
/// all its instructions and devices must be valid.
pub(super) fn sniff(beginning: &str) -> bool {
    if text::is_markup(beginning) {
        return false;
    }
    let (mut seen, mut known, mut named, mut stores) = (0_usize, 0_usize, 0_usize, 0_usize);
    for line in beginning.lines() {
        let mut words = split(line);
        take_address(&mut words);
        let (rest, pattern) = take_pattern(&words);
        if is_head(&words) || (rest.is_empty() && pattern.is_some()) {
            continue;
        }
        let [mnemonic, operands @ ..] = rest else { continue };
        seen += 1;
        if let (Some(opcode), [device]) = (Opcode::from_mnemonic(mnemonic), operands) {
            known += 1;
            named += usize::from(Device::from_name(device).is_some());
            stores += usize::from(opcode.is_store());
        }
        if seen == LOOKED_AT {
            break;
        }
    }
    match stores > 0 {
        true => known * 2 >= seen && named > 0,
        false => seen > 0 && known == seen && named == seen,
    }
}

/// Reads a program in assembly; `name` is the name of its file.
///
/// # Errors
/// The errors with their lines, at most 50. Reading stops at the first instruction whose address is above 255.
pub fn read(name: &str, text: &str) -> Result<Source, Vec<Diagnostic>> {
    let mut faults = Faults::new(name);
    let mut source = Source::new(name, ASSEMBLY);
    let mut next = 0_usize;
    let mut numbered = Vec::new();
    let mut number = 0_u32;
    for line in text.lines() {
        number = number.saturating_add(1);
        let mut words = split(line);
        if words.is_empty() || is_head(&words) {
            continue;
        }
        let written = take_address(&mut words);
        numbered.push(NumberedLine {
            line: number,
            address: match written {
                Some(Address::Number(address)) => u32::try_from(address).ok(),
                _ => None,
            },
            takes: Some(1),
            text: line,
            restarts: false,
        });
        let address = match written {
            Some(Address::Number(address)) => address,
            Some(Address::TooLarge) => WORDS,
            None => next,
        };
        next = next.max(address.saturating_add(1));
        match instruction(name, number, line, &words) {
            Err(fault) => faults.push(fault),
            Ok(_) if address >= WORDS => {
                faults.error_in_line(
                    Code::TooLong,
                    number,
                    line,
                    "this word is outside the program memory, which has 256 words",
                    "use addresses 0 to 255: the program counter has eight bits",
                );
                if address == next - 1 {
                    // One message is enough for all further words.
                    break;
                }
            }
            Ok(word) => {
                if let Some(first) = source.lines.insert(address as u8, number) {
                    faults.error_in_line(
                        Code::WordTwice,
                        number,
                        line,
                        &format!("line {first} already has address {address}"),
                        "give each word a different address, or omit all addresses",
                    );
                }
                source.words[address] = word;
            }
        }
    }
    if !faults.any_error() {
        numbering::check(numbered, &mut faults);
    }
    if number == 0 || (source.lines.is_empty() && !faults.any_error()) {
        faults.push(Diagnostic::file(
            Code::NoInstructions,
            name,
            "no instruction in this file",
            FORM,
        ));
    }
    if faults.any_error() { Err(faults.into_diagnostics()) } else { Ok(source) }
}

/// Parses an instruction without its address: a mnemonic and a device, a bit pattern, or both if they agree.
fn instruction(name: &str, number: u32, line: &str, words: &[&str]) -> Result<Word, Diagnostic> {
    let fault = |code, message: String, help: &str, part: &str| {
        let mut found = Diagnostic::line(code, name, number, line.trim_end(), message, help);
        found.span = slice_range(line, part).map(|range| (range.start, range.end));
        Err(found)
    };
    let (words, pattern) = take_pattern(words);
    if let ([], Some(word)) = (words, pattern) {
        return if word.stores_to_input() {
            fault(Code::StoreToInput, format!("{word} writes to an input"), DEVICES, "")
        } else {
            Ok(word)
        };
    }
    let (mnemonic, device) = match words {
        [mnemonic, device] => (*mnemonic, *device),
        [] => {
            return fault(
                Code::BareAddress,
                "the line has an address, but no instruction".into(),
                FORM,
                "",
            );
        }
        [mnemonic] if Opcode::from_mnemonic(mnemonic).is_some() => {
            return fault(Code::NoDevice, format!("{mnemonic} has no device"), FORM, mnemonic);
        }
        [_] => {
            return fault(
                Code::NotAnInstruction,
                "this line is not an instruction".into(),
                FORM,
                "",
            );
        }
        [_, _, extra, ..] => {
            return fault(
                Code::ExtraOperand,
                format!("'{extra}' is too much: the instruction takes one device"),
                FORM,
                extra,
            );
        }
    };
    let Some(opcode) = Opcode::from_mnemonic(mnemonic) else {
        return fault(
            Code::UnknownInstruction,
            format!("MINASEC-U has no instruction '{mnemonic}'"),
            FORM,
            mnemonic,
        );
    };
    let Some(device) = Device::from_name(device) else {
        return fault(
            Code::UnknownDevice,
            format!("MINASEC-U has no device '{device}'"),
            DEVICES,
            device,
        );
    };
    let word = Word::new(opcode, device);
    if word.stores_to_input() {
        return fault(
            Code::StoreToInput,
            format!("{} writes to the input {device}", opcode.mnemonic()),
            "store to an output (Y00-Y07) or a relay (M00-M07, M10-M13): an input cannot be written",
            words[1],
        );
    }
    match pattern {
        Some(other) if other != word => fault(
            Code::OtherPattern,
            format!(
                "the bits of {word} are {}, but the line gives the bits {}",
                pattern_of(word),
                pattern_of(other)
            ),
            "correct the instruction or the bits, or omit the bits",
            words[0],
        ),
        _ => Ok(word),
    }
}

/// Removes a bit pattern of eight bits at the end of the words. Returns the words before it, and the program word with
/// these bits. Opcode and operand may be separate (`100 01000`, `10001000`). `None` if there is no pattern.
fn take_pattern<'w, 't>(words: &'w [&'t str]) -> (&'w [&'t str], Option<Word>) {
    let bits = |text: &str, count: usize| {
        let fits = text.len() == count && text.bytes().all(|b| matches!(b, b'0' | b'1'));
        u8::from_str_radix(text, 2).ok().filter(|_| fits)
    };
    if let [rest @ .., opcode, operand] = words
        && let (Some(opcode), Some(operand)) = (bits(opcode, 3), bits(operand, 5))
    {
        return (rest, Some(Word(opcode << 5 | operand)));
    }
    if let [rest @ .., pattern] = words
        && let Some(pattern) = bits(pattern, 8)
    {
        return (rest, Some(Word(pattern)));
    }
    (words, None)
}

/// The bits of a word, with opcode and operand separate.
fn pattern_of(word: Word) -> String {
    format!("{:03b} {:05b}", word.0 >> 5, word.0 & 0x1F)
}

/// Whether a line is the heading of a printed listing.
fn is_head(words: &[&str]) -> bool {
    let head = ["addr", "opcode", "operand", "binary"];
    words.len() > 1
        && words.iter().all(|word| head.iter().any(|one| word.eq_ignore_ascii_case(one)))
}

/// The words of a line without its comment.
fn split(line: &str) -> Vec<&str> {
    let code = line.find(';').map_or(line, |at| &line[..at]);
    let code = code.find("//").map_or(code, |at| &code[..at]);
    code.trim_start_matches('\u{FEFF}').split_whitespace().collect()
}

enum Address {
    Number(usize),
    TooLarge,
}

/// Removes an address (`12`, `12:`, `0x0C`) from the start of the words, and returns it. `None` if there is no address.
fn take_address(words: &mut Vec<&str>) -> Option<Address> {
    let first = words.first()?;
    let digits = first.strip_suffix(':').unwrap_or(first);
    if !digits.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let number = match digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")) {
        Some(hex) if !hex.is_empty() && hex.bytes().all(|b| b.is_ascii_hexdigit()) => {
            usize::from_str_radix(hex, 16)
        }
        None if digits.bytes().all(|b| b.is_ascii_digit()) => digits.parse(),
        _ => return None,
    };
    words.remove(0);
    Some(number.map_or(Address::TooLarge, Address::Number))
}

/// Writes a listing as in the description: address, mnemonic, device, and the bits for the programming switches, for
/// each word up to the last one that is not empty (at least one).
#[must_use]
pub fn write_listing(words: &[Word; WORDS]) -> String {
    let mut out = "Addr  OPCODE  OPERAND  Binary\n".to_owned();
    for (address, &word) in words[..used(words)].iter().enumerate() {
        let (opcode, device) = (word.opcode().mnemonic(), word.device().to_string());
        let _ = writeln!(out, "{address:>4}  {opcode:<6}  {device:<7}  {}", pattern_of(word));
    }
    out
}

/// The number of words up to the last one that is not empty, at least one.
fn used(words: &[Word; WORDS]) -> usize {
    words.iter().rposition(|&word| word != Word::default()).map_or(1, |last| last + 1)
}

/// Writes a program as assembly: one line with its address for each word up to the last one that is not empty (at least
/// one).
#[must_use]
pub fn write(words: &[Word; WORDS]) -> String {
    let mut out = String::new();
    for (address, word) in words[..used(words)].iter().enumerate() {
        let _ = writeln!(out, "{address:>3}  {:<4} {}", word.opcode().mnemonic(), word.device());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> Vec<(&'static str, Option<u32>)> {
        read("a.asm", text)
            .expect_err("faults")
            .into_iter()
            .map(|fault| {
                assert!(!fault.help.is_empty());
                (fault.code.name(), fault.line)
            })
            .collect()
    }

    #[test]
    fn addresses_and_comments_may_stand_or_not() {
        let text =
            "; head\n  ld x00 // run\n\nOR Y00\n10: ST Y00\n0x0B STI m13 ; inverse\n12 LDI T01\n";
        let source = read("a.asm", text).expect("a program");
        assert_eq!(source.words[0], Word(0));
        assert_eq!(source.words[1], Word(0b100_01000));
        assert_eq!(source.words[10], Word(0b110_01000));
        assert_eq!(source.words[11], Word(0b111_11011));
        assert_eq!(source.words[12], Word(0b001_11101));
        assert_eq!(source.lines.keys().copied().collect::<Vec<_>>(), [0, 1, 10, 11, 12]);
        assert_eq!(source.lines[&11], 6);
        assert_eq!(source.used(), 13);
    }

    #[test]
    fn the_printed_listing_is_written_and_read_back() {
        let source = read("a.asm", "LD X00\nOR Y00\nANDI X01\nST Y00\n").expect("a program");
        let listing = write_listing(&source.words);
        assert_eq!(
            listing,
            "Addr  OPCODE  OPERAND  Binary\n   0  LD      X00      000 00000\n   1  OR      Y00      100 01000\n   2  ANDI    X01      011 00001\n   3  ST      Y00      110 01000\n"
        );
        assert!(sniff(&listing));
        assert_eq!(read("b.asm", &listing).expect("the listing").words, source.words);
        let bits = "Addr Binary\n0 000 00000\n1 10001000\n2 01100001\n3 110 01000\n";
        assert_eq!(read("c.asm", bits).expect("bits alone").words, source.words);
        assert_eq!(
            faults("0 LD X00 000 00001\n1 110 00000\n"),
            [("other-pattern", Some(1)), ("store-to-input", Some(2)),]
        );
    }

    #[test]
    fn every_instruction_with_every_device_reads_back_as_written() {
        for byte in 0..=255 {
            let word = Word(byte);
            let read = read("a.asm", &format!("{word}"));
            if word.stores_to_input() {
                assert_eq!(read.expect_err("refused")[0].code.name(), "store-to-input");
            } else {
                assert_eq!(read.expect("a word").words[0], word);
            }
        }
    }

    #[test]
    fn what_the_machine_cannot_do_is_refused_with_its_line() {
        assert_eq!(
            faults("LD X00\nST X01\nOUT Y00\nLD X8\nLD\nAND X00 X01\nfoo\n12\n"),
            [
                ("store-to-input", Some(2)),
                ("unknown-instruction", Some(3)),
                ("unknown-device", Some(4)),
                ("no-device", Some(5)),
                ("extra-operand", Some(6)),
                ("not-an-instruction", Some(7)),
                ("bare-address", Some(8)),
            ]
        );
        assert_eq!(faults("3 LD X00\n3 ST Y00"), [("word-twice", Some(2))]);
        assert_eq!(faults("; nothing\n"), [("no-instructions", None)]);
        assert_eq!(faults(""), [("no-instructions", None)]);
    }

    #[test]
    fn word_257_is_refused_once() {
        let full = "LD X01\n".repeat(256);
        assert!(read("a.asm", &full).is_ok());
        assert_eq!(faults(&(full + "ST Y00\nST Y01\n")), [("too-long", Some(257))]);
        assert_eq!(faults("256 LD X00"), [("too-long", Some(1))]);
        assert_eq!(faults("99999999999999999999999 LD X00"), [("too-long", Some(1))]);
    }

    #[test]
    fn a_list_is_told_from_other_dialects() {
        assert!(sniff("LD X00\nOR Y00\nANDI X01\nST Y00\n"));
        assert!(sniff("LD X00\nST Y00\nOUT Y01\n"), "a fault is told of, not taken for a dialect");
        assert!(sniff("LD X00\n"));
        assert!(!sniff("LD X0\nAND M100\n"));
        assert!(!sniff("LD X00\nOUT Y00\nEND\n"));
        assert!(!sniff(""));
    }
}
