//! Reads MELSEC list text: one instruction a line, operands separated by blanks.

use super::source::RawInstruction;
use super::words;
use scanbound_base::code::Code;
use scanbound_front::Faults;
use scanbound_front::WordPositions;
use scanbound_front::text;

/// The dialect name of list text.
pub(super) const DIALECT: &str = "melsec-list";

/// The number of instruction lines that are examined to recognise a file.
const LOOKED_AT: usize = 40;

/// Common mnemonics, by which list text is recognised.
const COMMON: [&str; 62] = [
    "LD", "LDI", "AND", "ANI", "OR", "ORI", "LDP", "LDF", "ANDP", "ANDF", "ORP", "ORF", "LDPI",
    "LDFI", "ANDPI", "ANDFI", "ORPI", "ORFI", "ANB", "ORB", "MPS", "MRD", "MPP", "INV", "MEP",
    "MEF", "EGP", "EGF", "OUT", "OUTH", "SET", "RST", "PLS", "PLF", "FF", "MC", "MCR", "STL",
    "RET", "SRET", "CJ", "SCJ", "JMP", "CALL", "CALLP", "FEND", "FOR", "NEXT", "EI", "DI", "IRET",
    "END", "NOP", "NOPLF", "MOV", "MOVP", "DMOV", "DMOVP", "INC", "INCP", "BMOV", "FMOV",
];

/// Mnemonics that MELSEC does not have, but other vendors' lists do.
const FOREIGN: [&str; 13] = [
    "ST", "STI", "LDNOT", "ANDNOT", "ORNOT", "OUTNOT", "ANDLD", "ORLD", "RSET", "KEEP", "DIFU",
    "DIFD", "NOT",
];

/// Whether a file begins like list text. Of its first 40 instruction lines, the first must have a common MELSEC
/// mnemonic, none may have a mnemonic that only other vendors' lists have, and at least half must have a common
/// mnemonic, or any mnemonic with operands; all operands of these lines must look like MELSEC devices. Markup is not
/// list text.
pub(super) fn sniff(beginning: &str) -> bool {
    if text::is_markup(beginning) {
        return false;
    }
    let mut likely = 0_usize;
    let mut seen = 0_usize;
    for line in beginning.lines() {
        let Ok(mut found) = words::split(code(line)) else { continue };
        take_step(&mut found);
        let Some((first, operands)) = found.split_first() else { continue };
        // MELSEC has no function numbers such as `MOV(21)` either.
        let numbered = first.ends_with(')') && first.contains('(');
        if numbered || FOREIGN.iter().any(|word| first.eq_ignore_ascii_case(word)) {
            return false;
        }
        seen += 1;
        let devices = operands.iter().all(|operand| is_device(operand));
        let common = is_common(first) && devices;
        if seen == 1 && !common {
            return false;
        }
        let other = words::can_be_mnemonic(first) && devices && !operands.is_empty();
        likely += usize::from(common || other);
        if seen == LOOKED_AT {
            break;
        }
    }
    seen > 0 && likely * 2 >= seen
}

fn is_common(word: &str) -> bool {
    let upper = word.trim_end_matches(':').to_ascii_uppercase();
    if words::is_pointer(&upper) {
        return true;
    }
    let contact = ["LD", "AND", "OR"]
        .iter()
        .filter_map(|stem| upper.strip_prefix(stem))
        .any(|rest| rest.trim_start_matches(['D', 'E', '$']).starts_with(['=', '<', '>']));
    contact || COMMON.contains(&upper.as_str())
}

/// Whether a word looks like a device, constant or string of MELSEC. Lists of other vendors also have LD and OUT, but
/// with bare numbers; prose has words without numbers.
fn is_device(word: &str) -> bool {
    word.starts_with('"')
        || (!word.starts_with(|c: char| c.is_ascii_digit())
            && word.contains(|c: char| c.is_ascii_digit()))
}

/// Reads the instructions of a list text, and checks the file as a whole. Lines with errors are reported and left out.
pub(super) fn read(text: &str, faults: &mut Faults<'_>) -> Vec<RawInstruction> {
    let mut instructions = Vec::new();
    let mut number = 0_u32;
    for line in text.lines() {
        number = number.saturating_add(1);
        read_line(text, line, number, &mut instructions, faults);
        if words::are_too_many(&instructions, faults) {
            return instructions;
        }
    }
    words::check(&instructions, number, faults);
    instructions
}

fn read_line(
    text: &str,
    line: &str,
    number: u32,
    out: &mut Vec<RawInstruction>,
    faults: &mut Faults<'_>,
) {
    let mut found = match words::split(code(line)) {
        Ok(found) => found,
        Err(open) => {
            let message = ("a string has no closing quotation mark", "close the string with \"");
            return faults.error_at(Code::OpenString, number, line, open, message);
        }
    };
    let step = take_step(&mut found);
    let mut rest = &found[..];
    if rest.is_empty() {
        if step.is_some() {
            faults.error_in_line(
                Code::BareStep,
                number,
                line,
                "this line has a step number, but no instruction",
                "write the instruction after the step number, or remove the line",
            );
        }
        return;
    }
    // A label may be on the same line as the instruction after it.
    let label = rest[0].strip_suffix(':').unwrap_or(rest[0]);
    if words::is_pointer(label) {
        let places = WordPositions::of_slices(text, [label]);
        out.push(words::instruction(number, step, label, Vec::new(), places));
        rest = &rest[1..];
    }
    let Some((mnemonic, operands)) = rest.split_first() else { return };
    if !words::can_be_mnemonic(mnemonic) {
        let message = (
            "this line is not an instruction",
            "write a mnemonic and its operands, separated by blanks, such as LD X0; comments begin with ; or //",
        );
        return faults.error_at(Code::NotAnInstruction, number, line, mnemonic, message);
    }
    let places = WordPositions::of_slices(text, rest.iter().copied());
    let operands = operands.iter().map(|&operand| operand.to_owned()).collect();
    out.push(words::instruction(number, step, mnemonic, operands, places));
}

/// The line without its comment. A `;` or `//` inside a string does not begin a comment.
fn code(line: &str) -> &str {
    if !line.contains([';', '/']) {
        return line;
    }
    let mut quoted = false;
    let mut before = ' ';
    for (at, c) in line.char_indices() {
        match c {
            '"' => quoted = !quoted,
            ';' if !quoted => return &line[..at],
            '/' if !quoted && before == '/' => return &line[..at - 1],
            _ => {}
        }
        before = c;
    }
    line
}

/// Removes a leading step number (`12`, `0012:`, `12:LD`) from the words, and returns it. `None` if the line has none.
fn take_step(words: &mut Vec<&str>) -> Option<u32> {
    let first = *words.first()?;
    let digits = first.find(|c: char| !c.is_ascii_digit()).unwrap_or(first.len());
    let step = first[..digits].parse().ok()?;
    match &first[digits..] {
        "" | ":" => {
            words.remove(0);
        }
        rest => words[0] = rest.strip_prefix(':')?,
    }
    Some(step)
}
