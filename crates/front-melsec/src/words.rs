//! What CSV and list text share: splitting into words, strings, and checks of a whole file.

use super::source::RawInstruction;
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;
use scanbound_front::WordPositions;
use scanbound_front::numbering::{self, NumberedLine};
use scanbound_front::{Faults, shown};

/// The largest number of instructions of a file, because of memory use. The largest CPUs hold 1,200 K steps; real
/// projects have some ten thousand instructions.
const MAX_INSTRUCTIONS: usize = 400_000;
/// The largest accepted length of a line, in bytes.
const LONGEST: usize = 64 * 1024;

/// Splits at blanks and TABs. A word that begins with `"` extends to its closing `"`, including blanks. `Err` holds the
/// text from an unclosed quotation mark.
pub(super) fn split(text: &str) -> Result<Vec<&str>, &str> {
    let mut words = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let end = if rest.starts_with('"') {
            string_end(rest).ok_or(rest)?
        } else {
            rest.find(char::is_whitespace).unwrap_or(rest.len())
        };
        words.push(&rest[..end]);
        rest = rest[end..].trim_start();
    }
    Ok(words)
}

/// The length in bytes of the string at the start of `text`, quotation marks included: up to the first quotation mark
/// that a blank or the end follows. `None` if there is none.
fn string_end(text: &str) -> Option<usize> {
    text.match_indices('"')
        .skip(1)
        .map(|(at, _)| at + 1)
        .find(|&end| text[end..].chars().next().is_none_or(char::is_whitespace))
}

/// Whether a word is a pointer label: `P50`, `I0`.
pub(super) fn is_pointer(word: &str) -> bool {
    word.strip_prefix(['P', 'I', 'p', 'i'])
        .is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
}

/// Whether a word can be a mnemonic: letters of any script, digits and the signs that occur in mnemonics, not beginning
/// with a digit.
pub(super) fn can_be_mnemonic(word: &str) -> bool {
    !word.is_empty()
        && !word.starts_with(|c: char| c.is_ascii_digit())
        && word.chars().all(|c| c.is_alphanumeric() || "_.$+-*/=<>".contains(c))
}

/// Makes an instruction; its `text` is the mnemonic and the operands, separated by single blanks.
pub(super) fn instruction(
    line: u32,
    step: Option<u32>,
    mnemonic: &str,
    operands: Vec<String>,
    places: WordPositions,
) -> RawInstruction {
    let length = operands.iter().map(|operand| operand.len() + 1).sum::<usize>();
    let mut text = String::with_capacity(mnemonic.len() + length);
    text.push_str(mnemonic);
    for operand in &operands {
        text.push(' ');
        text.push_str(operand);
    }
    RawInstruction {
        line,
        step,
        mnemonic: mnemonic.to_owned(),
        operands,
        text: text.into(),
        places,
    }
}

/// Reports an error and returns true if a file has more instructions than scanbound accepts; reading then stops.
pub(super) fn are_too_many(instructions: &[RawInstruction], faults: &mut Faults<'_>) -> bool {
    let too_many = instructions.len() > MAX_INSTRUCTIONS;
    if too_many {
        faults.push(Diagnostic::file(
            Code::TooMany,
            faults.file(),
            format!("the file has more than {MAX_INSTRUCTIONS} instructions"),
            "check the file: real projects have far fewer instructions; scanbound reads no more from one file",
        ));
    }
    too_many
}

/// Reports an error and returns true if a line is longer than 64 KiB, which no tool writes.
pub(super) fn has_long_line(text: &str, faults: &mut Faults<'_>) -> bool {
    let mut at = 0;
    for line in text.as_bytes().split(|&byte| byte == b'\n' || byte == b'\r') {
        if line.len() > LONGEST {
            let number = text[..at].bytes().filter(|&b| b == b'\n').count() + 1;
            faults.error_in_line(
                Code::LongLine,
                u32::try_from(number).unwrap_or(u32::MAX),
                &text[at..at + line.len()],
                "this line is longer than 64 KiB",
                "export the file again: the file is damaged, or is not a program",
            );
            return true;
        }
        at += line.len() + 1;
    }
    false
}

/// Checks a whole file: reports step numbers that do not ascend, a missing END, and instructions after END. `lines` is
/// the number of its lines.
pub(super) fn check(instructions: &[RawInstruction], lines: u32, faults: &mut Faults<'_>) {
    let file = faults.file();
    // The number of steps of most instructions is unknown, and a label may have the step number of the next
    // instruction.
    let numbered = instructions.iter().filter(|one| !is_pointer(&one.mnemonic));
    let numbered = numbered.map(|one| NumberedLine {
        line: one.line,
        address: one.step,
        takes: None,
        text: &one.text,
        restarts: false,
    });
    numbering::check(numbered, faults);
    let is_end = |i: &RawInstruction| i.mnemonic.eq_ignore_ascii_case("END");
    match instructions.iter().position(is_end) {
        None => {
            let mut fault = Diagnostic::file(
                Code::NoEnd,
                file,
                "the program has no END",
                "if the file is truncated, export it again; otherwise write END after the last instruction",
            );
            fault.line = Some(lines.max(1));
            if let Some(instruction) = instructions.last() {
                fault.line = Some(instruction.line);
                fault.text = shown(&instruction.text);
                fault.step = instruction.step;
            }
            faults.push(fault);
        }
        Some(end) => {
            if let Some(instruction) = instructions.get(end + 1) {
                let more = instructions.len() - end - 2;
                let others = if more > 0 { format!(", and {more} more") } else { String::new() };
                faults.push(
                    Diagnostic::line(
                        Code::AfterEnd,
                        file,
                        instruction.line,
                        shown(&instruction.text),
                        format!(
                            "this instruction{others} comes after the program's END, which is in line {}",
                            instructions[end].line
                        ),
                        "keep one program in each file: remove what follows END, or remove this END",
                    )
                    .at_step(instruction.step),
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_strings() {
        assert_eq!(split("MOV  K1\tD0"), Ok(vec!["MOV", "K1", "D0"]));
        assert_eq!(split(r#"$MOV "a b" D0"#), Ok(vec!["$MOV", r#""a b""#, "D0"]));
        assert_eq!(split(r#""" D0"#), Ok(vec![r#""""#, "D0"]));
        assert_eq!(split(r#""a"b" D0"#), Ok(vec![r#""a"b""#, "D0"]));
        assert_eq!(split(r#"$MOV "a D0"#), Err(r#""a D0"#));
        assert_eq!(split(r#"""#), Err(r#"""#));
        assert_eq!(split("  "), Ok(vec![]));
    }

    #[test]
    fn pointers_and_mnemonics() {
        for word in ["P50", "I0", "p4095"] {
            assert!(is_pointer(word), "{word}");
        }
        for word in ["P", "PLS", "P5A", "INC", "K5"] {
            assert!(!is_pointer(word), "{word}");
        }
        for word in
            ["LD", "AND<>", "D+P", "$MOV", "ZP.OPEN", "SwOp0", "D*", "E/", "BKCMP=", "処理1"]
        {
            assert!(can_be_mnemonic(word), "{word}");
        }
        for word in ["", "0", "MOV(21)", "L;D", "\"a\"", "@D0"] {
            assert!(!can_be_mnemonic(word), "{word}");
        }
    }
}
