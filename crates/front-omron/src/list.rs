//! Reads OMRON mnemonics as text, an instruction a line, and tells the two spellings from each other.

use super::catalog;
use super::source::{RawInstruction, RawProgram, Symbols, Task};
use super::words::{self, Line};
use scanbound_base::code::Code;
use scanbound_front::Faults;
use scanbound_front::text;

/// No instruction has more operands: what follows so many is none of them.
const MOST_OPERANDS: usize = 100;

/// How many lines are looked at to tell what a file is.
const LOOKED_AT: usize = 200;

/// What speaks for each spelling, and against both.
#[derive(Debug, Clone, Copy, Default)]
struct Signs {
    /// Two-digit functions.
    two_digits: usize,
    /// Three-digit functions, and mnemonics that only CS, CJ and CP have.
    three_digits: usize,
    /// `LD NOT`, five-digit bits, `DM 0100`.
    c: usize,
    /// `LDNOT`, `100.00`, `W0.00`, `P_On`.
    cx: usize,
    /// What only OMRON's mnemonics have.
    own: usize,
    /// Instructions that the catalog has and whose operands can be OMRON's.
    known: usize,
    /// Those of them that begin a branch.
    contacts: usize,
    /// Other lines.
    unknown: usize,
    /// What OMRON's mnemonics never have.
    foreign: bool,
}

/// Mnemonics of other makers that no OMRON program has.
const FOREIGN: [&str; 24] = [
    "LDI", "ANI", "ORI", "ANB", "ORB", "MPS", "MRD", "MPP", "RST", "PLS", "PLF", "MC", "MCR",
    "FEND", "LDB", "ANL", "ORL", "RES", "ENDH", "ST", "STI", "ANDI", "LDP", "LDF",
];

fn signs(beginning: &str) -> Signs {
    let mut signs = Signs::default();
    // Most lists of other makers show it without the catalog.
    if beginning.lines().take(LOOKED_AT).any(begins_foreign) {
        return Signs { foreign: true, ..signs };
    }
    for line in beginning.lines().take(LOOKED_AT) {
        match words::read(beginning, line, 0) {
            Line::Empty | Line::Operands(..) => {}
            Line::Unknown => signs.unknown += 1,
            Line::Instruction(instruction) => look(&instruction, &mut signs),
        }
    }
    signs
}

/// Whether a line begins with a mnemonic that no OMRON program has.
fn begins_foreign(line: &str) -> bool {
    let first = line.split_whitespace().next().unwrap_or_default();
    FOREIGN.iter().any(|foreign| first.eq_ignore_ascii_case(foreign))
}

/// Whether a word is a label with a number, which no OMRON list has.
fn is_label(word: &str) -> bool {
    let word = word.trim_end_matches(':').to_ascii_uppercase();
    word.strip_prefix("LBL").is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

fn look(instruction: &RawInstruction, signs: &mut Signs) {
    let name = instruction.mnemonic.as_str();
    let words = std::iter::once(name).chain(instruction.operands.iter().map(String::as_str));
    signs.foreign |= words.into_iter().any(is_label);
    signs.foreign |= FOREIGN.contains(&name.to_ascii_uppercase().as_str());
    if let Some(number) = instruction.number {
        *(if number.digits == 2 { &mut signs.two_digits } else { &mut signs.three_digits }) += 1;
        signs.own += 1;
    }
    if name.ends_with("NOT") || name.ends_with("LD") && name != "LD" {
        let apart = instruction
            .text
            .split(' ')
            .nth(1)
            .is_some_and(|word| matches!(word.to_ascii_uppercase().as_str(), "NOT" | "LD"));
        *(if apart { &mut signs.c } else { &mut signs.cx }) += 1;
        signs.own += 1;
    }
    signs.own += usize::from(["RSET", "KEEP", "DIFU", "DIFD", "CNTR", "TIMH"].contains(&name));
    let fits = instruction.operands.iter().all(|operand| sign(operand, name, signs));
    let known = catalog::takes(name, instruction.operands.len());
    *(if fits && known { &mut signs.known } else { &mut signs.unknown }) += 1;
    signs.contacts +=
        usize::from(fits && known && name.starts_with("LD") && !instruction.operands.is_empty());
}

/// Counts what an operand speaks for; whether it can be one of OMRON's.
fn sign(operand: &str, name: &str, signs: &mut Signs) -> bool {
    let upper = operand.to_ascii_uppercase();
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let numbered = |letters: &str| {
        upper
            .strip_prefix(letters)
            .is_some_and(|rest| digits(rest.split('.').next().unwrap_or(rest)))
    };
    if ["X", "Y", "M", "K", "S", "B", "R"].iter().any(|letter| numbered(letter)) {
        // These could be symbols, but hardly so many of them as to be a program.
        signs.unknown += 1;
        return false;
    }
    if digits(&upper) {
        let bit = upper.len() >= 4
            && (name.starts_with("LD")
                || name.starts_with("AND")
                || name.starts_with("OR")
                || name.starts_with("OUT"));
        signs.c += usize::from(bit);
        signs.own += usize::from(bit || ["TIM", "CNT"].contains(&name));
    } else if upper.starts_with("P_")
        || upper.split_once('.').is_some_and(|(word, bit)| digits(word) && digits(bit))
    {
        (signs.cx, signs.own) = (signs.cx + 1, signs.own + 1);
    } else if ["DM ", "HR ", "LR ", "AR ", "SR ", "IR ", "TIM ", "CNT ", "*DM "]
        .iter()
        .any(|area| upper.starts_with(area))
    {
        (signs.c, signs.own) = (signs.c + 1, signs.own + 1);
    } else if upper.starts_with('#') || upper.starts_with('&') {
        signs.own += 1;
    } else if numbered("W") || numbered("H") || numbered("A") {
        signs.cx += 1;
    } else if !upper.contains(|c: char| c.is_ascii_digit()) {
        // A symbol.
        signs.cx += 1;
    }
    true
}

impl Signs {
    fn is_omron(self) -> bool {
        let plain = self.own > 0 && self.known * 2 >= self.known + self.unknown;
        !self.foreign && self.known > 0 && (plain || (self.unknown == 0 && self.contacts > 0))
    }
}

/// Whether the beginning of a file is in the C200H's spelling.
pub(super) fn sniff_c(beginning: &str) -> bool {
    let signs = signs(beginning);
    if text::is_markup(beginning) || !signs.is_omron() {
        return false;
    }
    match (signs.two_digits, signs.three_digits) {
        (0, 0) => signs.c > 0 || signs.cx == 0,
        (two, _) => two > 0,
    }
}

/// Whether the beginning of a file is in CX-Programmer's spelling for CS, CJ and CP.
pub(super) fn sniff_cx(beginning: &str) -> bool {
    let signs = signs(beginning);
    if text::is_markup(beginning) || !signs.is_omron() {
        return false;
    }
    match (signs.two_digits, signs.three_digits) {
        (0, 0) => signs.cx > 0 || signs.c == 0,
        (_, three) => three > 0,
    }
}

/// Reads a file of mnemonics.
pub(super) fn read(text: &str, name: &str, faults: &mut Faults<'_>) -> RawProgram {
    let mut instructions = Vec::new();
    let mut number = 0_u32;
    for line in text.lines() {
        number = number.saturating_add(1);
        read_line(text, line, number, &mut instructions, faults);
    }
    RawProgram { name: name.to_owned(), task: Task::Each, symbols: Symbols::new(), instructions }
}

/// Reads a line of the text, which is the next instruction, or further operands of the one before.
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
            Some(before) if before.operands.len() < MOST_OPERANDS => {
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
    faults.at(
        Code::NotAnInstruction,
        number,
        line,
        "this line is no instruction",
        "an instruction is a mnemonic and its operands apart by blanks, such as LD 0.00 or MOV(21) #0010 DM 0100; comments begin with ; or //",
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
