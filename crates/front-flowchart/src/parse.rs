//! Parses the instruction list: addresses, labels, mnemonics in several notations, operands and comments.

use scanbound_base::code::Code;
use std::ops::Range;

use scanbound_front::Faults;
use scanbound_front::slice_range;

/// The number of lines that are examined to recognise a file.
const LOOKED_AT: usize = 60;
/// The largest number that an operand can be: operands have at most four digits.
const LARGEST: u32 = 9999;
/// The help text with all instructions.
const FORM: &str = "the instructions are AND n, AND NOT n, OUT n, OUT NOT n, TIM n #t, CNR TIM n, JMP LBLn, CJP LBLn, WAIT, LBL n, GJ, GS n, GOFF n, GN n and GE n; comments begin with ;";

/// A mnemonic of flowchart PCs, in any of its notations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mnemonic {
    And,
    AndNot,
    Out,
    OutNot,
    Timer,
    ResetTimer,
    Jump,
    JumpIf,
    Wait,
    Label,
    Groups,
    Start,
    Stop,
    Head,
    End,
}

/// The notations of all mnemonics: the words that form each, and the mnemonic. The first entry that fits counts.
const WORDS: [(&[&str], Mnemonic); 17] = [
    (&["AND", "NOT"], Mnemonic::AndNot),
    (&["AND"], Mnemonic::And),
    (&["OUT", "NOT"], Mnemonic::OutNot),
    (&["OUT"], Mnemonic::Out),
    (&["CNR", "TIM"], Mnemonic::ResetTimer),
    (&["TIM"], Mnemonic::Timer),
    (&["JMP"], Mnemonic::Jump),
    (&["CJP"], Mnemonic::JumpIf),
    (&["WAIT"], Mnemonic::Wait),
    (&["LBL"], Mnemonic::Label),
    (&["G", "OFF"], Mnemonic::Stop),
    (&["GOFF"], Mnemonic::Stop),
    (&["G", "J"], Mnemonic::Groups),
    (&["GJ"], Mnemonic::Groups),
    (&["GS"], Mnemonic::Start),
    (&["GN"], Mnemonic::Head),
    (&["GE"], Mnemonic::End),
];

impl Mnemonic {
    /// Whether no other vendor's instruction list has this mnemonic.
    fn is_own(self) -> bool {
        !matches!(
            self,
            Mnemonic::And
                | Mnemonic::AndNot
                | Mnemonic::Out
                | Mnemonic::OutNot
                | Mnemonic::Timer
                | Mnemonic::Jump
        )
    }

    fn has_operand(self) -> bool {
        !matches!(self, Mnemonic::Wait | Mnemonic::Groups)
    }

    fn jumps(self) -> bool {
        matches!(self, Mnemonic::Jump | Mnemonic::JumpIf)
    }
}

/// One instruction with unresolved references.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// The mnemonic of the instruction.
    pub word: Mnemonic,
    /// The operand of the instruction; 0 if it has none.
    pub operand: u32,
    /// The time of a TIM, in tenths of a second. `None` for other instructions.
    pub time: Option<u32>,
    /// The line of the instruction in the file, from 1.
    pub line: u32,
    /// The address of the instruction, if one is given.
    pub step: Option<u32>,
    /// The instruction in one notation, with single blanks (`GOFF 1` also for `G OFF 1`), for messages.
    pub text: String,
    /// The byte range of its operand in the file, or of its mnemonic if it has none.
    pub at: Range<u32>,
    /// The comment of the instruction's line; empty if there is none.
    pub comment: String,
}

/// A word in capital letters, with its byte range in the line.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Token {
    word: String,
    at: Range<usize>,
}

impl PartialEq<str> for Token {
    fn eq(&self, other: &str) -> bool {
        self.word == other
    }
}

/// Splits a line into words and the comment. Dots and hyphens count as blanks (`OUT·NOT`), and signs are separated from
/// numbers (`LBL0:` becomes `LBL`, `0`, `:`).
fn split(line: &str) -> (Vec<Token>, String) {
    let (code, comment) = line.split_once([';', '；']).unwrap_or((line, ""));
    let mut words: Vec<Token> = Vec::new();
    let mut join = false;
    for (at, c) in code.char_indices() {
        let kind = |c: char| {
            if c.is_ascii_digit() {
                1
            } else if c.is_alphanumeric() {
                2
            } else {
                3
            }
        };
        if c.is_whitespace() || matches!(c, '·' | '・' | '･' | '.' | '-' | '\u{FEFF}') {
            join = false;
            continue;
        }
        match words.last_mut() {
            Some(Token { word, at: bytes })
                if join && word.chars().next_back().map(kind) == Some(kind(c)) && kind(c) < 3 =>
            {
                word.push(c.to_ascii_uppercase());
                bytes.end = at + c.len_utf8();
            }
            _ => words.push(Token {
                word: c.to_ascii_uppercase().to_string(),
                at: at..at + c.len_utf8(),
            }),
        }
        join = true;
    }
    let comment = comment.trim();
    let inner = comment.strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
    (words, inner.unwrap_or(comment).trim().to_owned())
}

/// The mnemonic at the start of the words, and the number of words it takes. `None` if they begin with none.
fn mnemonic(words: &[Token]) -> Option<(Mnemonic, usize)> {
    let begins = |parts: &&(&[&str], Mnemonic)| {
        parts.0.len() <= words.len() && parts.0.iter().zip(words).all(|(part, word)| word == *part)
    };
    WORDS.iter().find(begins).map(|(parts, word)| (*word, parts.len()))
}

/// Whether a file begins like an instruction list of a flowchart PC: at least half of its first 60 lines are known
/// mnemonics with bare numbers or labels, and none is an LD. If no line shows that it belongs to a flowchart PC, all
/// must be known.
pub fn sniff(beginning: &str) -> bool {
    let (mut seen, mut known, mut own, mut loads) = (0_usize, 0_usize, 0_usize, 0_usize);
    for line in beginning.lines().take(LOOKED_AT) {
        let (words, _) = split(line);
        let mut rest = &words[..];
        if rest.first().is_some_and(|first| number(&first.word).is_some()) {
            rest = &rest[1..];
        }
        let Some(first) = rest.first() else { continue };
        if is_head(rest) || first == "#" {
            continue;
        }
        seen += 1;
        loads += usize::from(first.word.starts_with("LD"));
        if let Some((word, taken)) = mnemonic(rest) {
            let label = word == Mnemonic::Label
                || (word.jumps() && rest.get(taken).is_some_and(|one| one == "LBL"));
            let bare =
                rest.get(taken).is_none_or(|operand| number(&operand.word).is_some()) || label;
            known += usize::from(bare);
            // FX also has CJP, but with a pointer operand; a label or bare number shows a flowchart PC.
            own += usize::from(bare && (word.is_own() || label));
        }
    }
    loads == 0 && seen > 0 && (known == seen || (own > 0 && known * 2 >= seen))
}

fn number(word: &str) -> Option<u32> {
    let digits = !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    if digits { word.parse().ok() } else { None }
}

/// Whether the words are the heading of a printed list.
fn is_head(words: &[Token]) -> bool {
    words.first().is_some_and(|one| one == "ADR" || one == "ADDRESS" || one == "LABEL")
}

/// Reads the instructions of a list in source order. An error is reported, and the rest of its line is left out.
pub fn read(text: &str, faults: &mut Faults<'_>) -> Vec<Listed> {
    let mut list = Vec::new();
    let mut line = 0_u32;
    for written in text.lines() {
        line = line.saturating_add(1);
        let (words, comment) = split(written);
        let mut rest = &words[..];
        if rest.is_empty() || is_head(rest) {
            continue;
        }
        let begin = slice_range(text, written).map_or(0, |bytes| bytes.start as u32);
        let mut reader = Line { line, begin, written, comment, step: None };
        if let Some(address) = number(&rest[0].word) {
            reader.step = Some(address);
            rest = &rest[1..];
        }
        reader.read(rest, &mut list, faults);
    }
    if list.is_empty() && !faults.any_error() {
        let name = faults.file().to_owned();
        faults.push(scanbound_base::diagnostic::Diagnostic::file(
            Code::NoInstructions,
            &name,
            "no instruction in this file",
            FORM,
        ));
    }
    list
}

/// A line while it is parsed.
struct Line<'a> {
    line: u32,
    /// The byte offset of the line in the file.
    begin: u32,
    written: &'a str,
    comment: String,
    step: Option<u32>,
}

impl Line<'_> {
    fn read(&mut self, mut rest: &[Token], list: &mut Vec<Listed>, faults: &mut Faults<'_>) {
        if rest.is_empty() {
            return self.fault(
                faults,
                0..0,
                Code::BareAddress,
                "the line has an address, but no instruction",
                FORM,
            );
        }
        let mut first = true;
        while !rest.is_empty() {
            // A timer's time may be on a line of its own.
            if let [mark, time, behind @ ..] = rest
                && mark == "#"
            {
                let open = list
                    .last_mut()
                    .filter(|last| last.word == Mnemonic::Timer && last.time.is_none());
                match (number(&time.word), open) {
                    (Some(time), Some(last)) => {
                        last.time = Some(time);
                        last.text += &format!(" #{time}");
                    }
                    (None, _) => return self.bad_number(faults, time),
                    (_, None) => {
                        return self.fault(
                            faults,
                            mark.at.start..time.at.end,
                            Code::TimeAlone,
                            "this line has a time, but no timer that needs one comes before it",
                            "write TIM n #t, t in tenths of a second",
                        );
                    }
                }
                rest = behind;
                first = false;
                continue;
            }
            let Some((word, taken)) = mnemonic(rest) else {
                return self.unknown(faults, rest, first);
            };
            let name = rest[0].at.start..rest[taken - 1].at.end;
            rest = &rest[taken..];
            let named = word.jumps() && rest.first().is_some_and(|one| one == "LBL" || one == "L");
            if named {
                rest = &rest[1..];
            }
            let mut operand = 0;
            let mut at = name.clone();
            if word.has_operand() {
                let Some(written) = rest.first() else {
                    return self.fault(
                        faults,
                        name,
                        Code::NoOperand,
                        "the instruction has no operand",
                        FORM,
                    );
                };
                let Some(value) = number(&written.word).filter(|&value| value <= LARGEST) else {
                    return self.bad_number(faults, written);
                };
                operand = value;
                at = written.at.clone();
                rest = &rest[1..];
            }
            if rest.first().is_some_and(|one| one == ":") {
                rest = &rest[1..];
            }
            list.push(Listed {
                word,
                operand,
                time: None,
                line: self.line,
                step: if first { self.step } else { None },
                text: text(word, operand),
                at: (self.begin + at.start as u32)..(self.begin + at.end as u32),
                comment: self.comment.clone(),
            });
            first = false;
            // Only after a label may another instruction follow, and only after a timer a time.
            let more = word == Mnemonic::Label
                || rest.is_empty()
                || (word == Mnemonic::Timer && rest[0] == *"#");
            if !more {
                let message = format!(
                    "'{}' is too much: the instruction is complete before it",
                    concat(rest)
                );
                return self.fault(faults, span_of(rest), Code::ExtraOperand, &message, FORM);
            }
        }
    }

    fn unknown(&self, faults: &mut Faults<'_>, rest: &[Token], first: bool) {
        let Token { word, at } = &rest[0];
        let likeness = |known: &str| strsim::jaro_winkler(known, word);
        let near = WORDS
            .iter()
            .map(|(parts, _)| parts[0])
            .filter(|known| likeness(known) > 0.7)
            .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let help = near.map_or(FORM.to_owned(), |known| format!("did you mean {known}? {FORM}"));
        let message = if first || word.chars().all(char::is_alphabetic) {
            format!("a flowchart PC has no instruction '{word}'")
        } else {
            format!("'{}' is too much: the instruction is complete before it", concat(rest))
        };
        self.fault(faults, at.clone(), Code::UnknownInstruction, &message, &help);
    }

    fn bad_number(&self, faults: &mut Faults<'_>, written: &Token) {
        let message = format!("'{}' is not a number from 0 to {LARGEST}", written.word);
        self.fault(faults, written.at.clone(), Code::BadOperand, &message, FORM);
    }

    /// Reports an error at these bytes of the line.
    fn fault(
        &self,
        faults: &mut Faults<'_>,
        at: Range<usize>,
        code: Code,
        message: &str,
        help: &str,
    ) {
        faults.error_at(code, self.line, self.written, &self.written[at], (message, help));
    }
}

/// The words joined without blanks.
fn concat(words: &[Token]) -> String {
    words.iter().map(|one| one.word.as_str()).collect()
}

/// The range from the first word to the last one.
fn span_of(words: &[Token]) -> Range<usize> {
    match words {
        [first, .., last] => first.at.start..last.at.end,
        [only] => only.at.clone(),
        [] => 0..0,
    }
}

fn text(word: Mnemonic, operand: u32) -> String {
    let parts =
        WORDS.iter().rev().find(|(_, known)| *known == word).map_or(&[][..], |(parts, _)| parts);
    let name = parts.join(" ");
    match word {
        Mnemonic::Wait | Mnemonic::Groups => name,
        Mnemonic::Jump | Mnemonic::JumpIf => format!("{name} LBL{operand}"),
        Mnemonic::Label => format!("LBL{operand}"),
        _ => format!("{name} {operand}"),
    }
}
