//! Reads OMRON mnemonics as text, one instruction a line, and recognises the two notations.

use super::catalog;
use super::source::{RawInstruction, RawProgram, Symbols, Task};
use super::words::{self, Line};
use scanbound_base::code::Code;
use scanbound_front::Faults;
use scanbound_front::text;

/// The largest number of operands of an instruction.
const MAX_OPERANDS: usize = 100;

/// The number of lines that are examined to recognise a file.
const LOOKED_AT: usize = 200;

/// What a file contains of each notation, to recognise the notation of the file.
#[derive(Debug, Clone, Copy, Default)]
struct NotationEvidence {
    /// The number of function numbers with two digits.
    two_digits: usize,
    /// The number of function numbers that do not have two digits, as those of CS, CJ and CP.
    three_digits: usize,
    /// The number of signs of the C notation: `LD NOT`, bits such as `00300`, `DM 0100`.
    c: usize,
    /// The number of signs of the CX-Programmer notation: `LDNOT`, `100.00`, `W0.00`, symbols such as `P_On`.
    cx: usize,
    /// The number of signs that only OMRON lists have: function numbers, mnemonics such as KEEP, operands such as
    /// `#0010`.
    omron_only: usize,
    /// The number of instructions of the catalog whose operands are valid for OMRON.
    known: usize,
    /// The number of instructions counted in `known` that begin a branch.
    contacts: usize,
    /// The number of lines that are not valid OMRON instructions, and of operands that look like those of other
    /// vendors.
    unknown: usize,
    /// Whether the file has something that OMRON mnemonics never have.
    foreign: bool,
}

/// Mnemonics of other vendors that OMRON does not have.
const FOREIGN: [&str; 24] = [
    "LDI", "ANI", "ORI", "ANB", "ORB", "MPS", "MRD", "MPP", "RST", "PLS", "PLF", "MC", "MCR",
    "FEND", "LDB", "ANL", "ORL", "RES", "ENDH", "ST", "STI", "ANDI", "LDP", "LDF",
];

fn evidence(beginning: &str) -> NotationEvidence {
    let mut evidence = NotationEvidence::default();
    // This recognises most lists of other vendors without reading the catalog.
    if beginning.lines().take(LOOKED_AT).any(begins_foreign) {
        return NotationEvidence { foreign: true, ..evidence };
    }
    for line in beginning.lines().take(LOOKED_AT) {
        match words::read(beginning, line, 0) {
            Line::Empty | Line::Operands(..) => {}
            Line::Unknown => evidence.unknown += 1,
            Line::Instruction(instruction) => collect_evidence(&instruction, &mut evidence),
        }
    }
    evidence
}

/// Whether a line begins with a mnemonic that OMRON does not have.
fn begins_foreign(line: &str) -> bool {
    let first = line.split_whitespace().next().unwrap_or_default();
    FOREIGN.iter().any(|foreign| first.eq_ignore_ascii_case(foreign))
}

/// Whether a word is a numbered label, which OMRON lists do not have.
fn is_label(word: &str) -> bool {
    let word = word.trim_end_matches(':').to_ascii_uppercase();
    word.strip_prefix("LBL").is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

fn collect_evidence(instruction: &RawInstruction, evidence: &mut NotationEvidence) {
    let name = instruction.mnemonic.as_str();
    let words = std::iter::once(name).chain(instruction.operands.iter().map(String::as_str));
    evidence.foreign |= words.into_iter().any(is_label);
    evidence.foreign |= FOREIGN.contains(&name.to_ascii_uppercase().as_str());
    if let Some(number) = instruction.number {
        *(if number.digits == 2 {
            &mut evidence.two_digits
        } else {
            &mut evidence.three_digits
        }) += 1;
        evidence.omron_only += 1;
    }
    if name.ends_with("NOT") || name.ends_with("LD") && name != "LD" {
        let apart = instruction
            .text
            .split(' ')
            .nth(1)
            .is_some_and(|word| matches!(word.to_ascii_uppercase().as_str(), "NOT" | "LD"));
        *(if apart { &mut evidence.c } else { &mut evidence.cx }) += 1;
        evidence.omron_only += 1;
    }
    evidence.omron_only +=
        usize::from(["RSET", "KEEP", "DIFU", "DIFD", "CNTR", "TIMH"].contains(&name));
    let fits = instruction.operands.iter().all(|operand| sign(operand, name, evidence));
    let known = catalog::takes(name, instruction.operands.len());
    *(if fits && known { &mut evidence.known } else { &mut evidence.unknown }) += 1;
    evidence.contacts +=
        usize::from(fits && known && name.starts_with("LD") && !instruction.operands.is_empty());
}

/// Adds the operand to the evidence, if it is a sign of a notation. Returns whether it is valid for OMRON.
fn sign(operand: &str, name: &str, evidence: &mut NotationEvidence) -> bool {
    let upper = operand.to_ascii_uppercase();
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let numbered = |letters: &str| {
        upper
            .strip_prefix(letters)
            .is_some_and(|rest| digits(rest.split('.').next().unwrap_or(rest)))
    };
    if ["X", "Y", "M", "K", "S", "B", "R"].iter().any(|letter| numbered(letter)) {
        // It may be a symbol, but a program has few lines with such symbols.
        evidence.unknown += 1;
        return false;
    }
    if digits(&upper) {
        let bit = upper.len() >= 4
            && (name.starts_with("LD")
                || name.starts_with("AND")
                || name.starts_with("OR")
                || name.starts_with("OUT"));
        evidence.c += usize::from(bit);
        evidence.omron_only += usize::from(bit || ["TIM", "CNT"].contains(&name));
    } else if upper.starts_with("P_")
        || upper.split_once('.').is_some_and(|(word, bit)| digits(word) && digits(bit))
    {
        (evidence.cx, evidence.omron_only) = (evidence.cx + 1, evidence.omron_only + 1);
    } else if ["DM ", "HR ", "LR ", "AR ", "SR ", "IR ", "TIM ", "CNT ", "*DM "]
        .iter()
        .any(|area| upper.starts_with(area))
    {
        (evidence.c, evidence.omron_only) = (evidence.c + 1, evidence.omron_only + 1);
    } else if upper.starts_with('#') || upper.starts_with('&') {
        evidence.omron_only += 1;
    } else if numbered("W") || numbered("H") || numbered("A") {
        evidence.cx += 1;
    } else if !upper.contains(|c: char| c.is_ascii_digit()) {
        // A symbol.
        evidence.cx += 1;
    }
    true
}

impl NotationEvidence {
    fn is_omron(self) -> bool {
        let plain = self.omron_only > 0 && self.known * 2 >= self.known + self.unknown;
        !self.foreign && self.known > 0 && (plain || (self.unknown == 0 && self.contacts > 0))
    }
}

/// Whether a file begins in the notation of C200H manuals. True also if nothing tells this notation from that of
/// CX-Programmer.
pub(super) fn sniff_c(beginning: &str) -> bool {
    let evidence = evidence(beginning);
    if text::is_markup(beginning) || !evidence.is_omron() {
        return false;
    }
    match (evidence.two_digits, evidence.three_digits) {
        (0, 0) => evidence.c > 0 || evidence.cx == 0,
        (two, _) => two > 0,
    }
}

/// Whether a file begins in the notation of CX-Programmer for CS, CJ and CP. True also if nothing tells this notation
/// from that of C200H manuals.
pub(super) fn sniff_cx(beginning: &str) -> bool {
    let evidence = evidence(beginning);
    if text::is_markup(beginning) || !evidence.is_omron() {
        return false;
    }
    match (evidence.two_digits, evidence.three_digits) {
        (0, 0) => evidence.cx > 0 || evidence.c == 0,
        (_, three) => three > 0,
    }
}

/// Reads a file of mnemonics as one program, which runs in each scan. Reports the lines that are not instructions.
pub(super) fn read(text: &str, name: &str, faults: &mut Faults<'_>) -> RawProgram {
    let mut instructions = Vec::new();
    let mut number = 0_u32;
    for line in text.lines() {
        number = number.saturating_add(1);
        read_line(text, line, number, &mut instructions, faults);
    }
    RawProgram { name: name.to_owned(), task: Task::Each, symbols: Symbols::new(), instructions }
}

/// Reads a line and adds it to `out`: the next instruction, or further operands of the last one. Reports an error for
/// any other line that is not empty.
pub(super) fn read_line(
    text: &str,
    line: &str,
    number: u32,
    out: &mut Vec<RawInstruction>,
    faults: &mut Faults<'_>,
) {
    match words::read(text, line, number) {
        Line::Empty => {}
        Line::Instruction(instruction) => out.push(instruction),
        Line::Operands(operands, places) => match out.last_mut() {
            Some(before) if before.operands.len() < MAX_OPERANDS => {
                before.places.extend(places);
                before.text = [&*before.text, &operands.join(" ")].join(" ").into();
                before.operands.extend(operands);
            }
            _ => not_an_instruction(line, number, faults),
        },
        Line::Unknown => not_an_instruction(line, number, faults),
    }
}

fn not_an_instruction(line: &str, number: u32, faults: &mut Faults<'_>) {
    faults.error_in_line(
        Code::NotAnInstruction,
        number,
        line,
        "this line is not an instruction",
        "write a mnemonic and its operands, separated by blanks, such as LD 0.00 or MOV(21) #0010 DM 0100; comments begin with ; or //",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spellings_are_told_apart() {
        let c = [
            "LD NOT 00300\nAND 00001\nOUT 00305\nEND",
            "LD 00000\nMOV(21) #0010 DM 0100\nEND(01)",
            "LD TIM 000\nOUT 00500\nEND",
        ];
        let cx = [
            "LDNOT 0.00\nAND W0.00\nOUT 100.00\nEND(001)",
            "LD P_On\nMOV(021) &1 D0",
            "LD Start\nOUT 100.00\nEND(001)",
        ];
        for text in c {
            assert_eq!((sniff_c(text), sniff_cx(text)), (true, false), "{text}");
        }
        for text in cx {
            assert_eq!((sniff_c(text), sniff_cx(text)), (false, true), "{text}");
        }
    }

    #[test]
    fn what_could_be_both_is_taken_for_both() {
        for text in ["LD 0000\nMOV(21) #1 D0\nMOV(021) #1 D0", "LD NOT 00300\nOUTNOT 100.00\nEND"] {
            assert!(sniff_c(text) && sniff_cx(text), "{text}");
        }
    }

    #[test]
    fn other_makers_lists_are_not_taken() {
        for text in [
            "LD X0\nANI X1\nOUT Y0\nEND",
            "LD X0\nOUT Y0\nEND",
            "LD X00\nAND X01\nST Y00",
            "text of some kind",
            "LDI X0",
            "LD M0\nMOV K1 D0\nEND",
            "END",
            "EI\nFB1 D0\nEND",
            "or just call the customer, and set it out",
        ] {
            assert!(!sniff_c(text) && !sniff_cx(text), "{text}");
        }
    }
}
