//! Reads the instruction list: addresses, labels, spellings of the mnemonics, operands and comments.

use crate::dialect::Faults;

/// How many lines are looked at to tell what a file is.
const LOOKED_AT: usize = 60;
/// No number is larger: operands have four digits.
const LARGEST: u32 = 9999;
/// What an instruction looks like.
const FORM: &str = "the instructions are AND n, AND NOT n, OUT n, OUT NOT n, TIM n #t, CNR TIM n, JMP LBLn, CJP LBLn, WAIT, LBL n, GJ, GS n, GOFF n, GN n and GE n; comments begin with ;";

/// A mnemonic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Word {
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

/// Every mnemonic with its parts.
const WORDS: [(&[&str], Word); 17] = [
    (&["AND", "NOT"], Word::AndNot),
    (&["AND"], Word::And),
    (&["OUT", "NOT"], Word::OutNot),
    (&["OUT"], Word::Out),
    (&["CNR", "TIM"], Word::ResetTimer),
    (&["TIM"], Word::Timer),
    (&["JMP"], Word::Jump),
    (&["CJP"], Word::JumpIf),
    (&["WAIT"], Word::Wait),
    (&["LBL"], Word::Label),
    (&["G", "OFF"], Word::Stop),
    (&["GOFF"], Word::Stop),
    (&["G", "J"], Word::Groups),
    (&["GJ"], Word::Groups),
    (&["GS"], Word::Start),
    (&["GN"], Word::Head),
    (&["GE"], Word::End),
];

impl Word {
    /// Whether other makers' lists do not have it.
    fn is_own(self) -> bool {
        !matches!(
            self,
            Word::And | Word::AndNot | Word::Out | Word::OutNot | Word::Timer | Word::Jump
        )
    }

    fn has_operand(self) -> bool {
        !matches!(self, Word::Wait | Word::Groups)
    }

    fn jumps(self) -> bool {
        matches!(self, Word::Jump | Word::JumpIf)
    }
}

/// One instruction, its names not yet looked up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// What it is.
    pub word: Word,
    /// Its operand; 0 if it has none.
    pub operand: u32,
    /// A timer's time in tenths of a second.
    pub time: Option<u32>,
    /// Its line.
    pub line: u32,
    /// Its address, if one is given.
    pub step: Option<u32>,
    /// As written.
    pub text: String,
    /// The comment of its line.
    pub comment: String,
}

/// A line taken apart: words and the comment. Dots between words are blanks (`OUT·NOT`), and what sticks to
/// a number is apart from it (`LBL0:` is `LBL`, `0`, `:`).
fn split(line: &str) -> (Vec<String>, String) {
    let line = line.trim_start_matches('\u{FEFF}');
    let (code, comment) = line.split_once([';', '；']).unwrap_or((line, ""));
    let mut words: Vec<String> = Vec::new();
    let mut join = false;
    for c in code.chars() {
        let kind = |c: char| {
            if c.is_ascii_digit() {
                1
            } else if c.is_alphanumeric() {
                2
            } else {
                3
            }
        };
        if c.is_whitespace() || matches!(c, '·' | '・' | '･' | '.' | '-') {
            join = false;
            continue;
        }
        match words.last_mut() {
            Some(word)
                if join && word.chars().next_back().map(kind) == Some(kind(c)) && kind(c) < 3 =>
            {
                word.push(c.to_ascii_uppercase());
            }
            _ => words.push(c.to_ascii_uppercase().to_string()),
        }
        join = true;
    }
    let comment = comment.trim();
    let inner = comment.strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
    (words, inner.unwrap_or(comment).trim().to_owned())
}

/// The mnemonic at the beginning of the words and how many of them it takes.
fn mnemonic(words: &[String]) -> Option<(Word, usize)> {
    let begins = |parts: &&(&[&str], Word)| {
        parts.0.len() <= words.len() && parts.0.iter().zip(words).all(|(part, word)| part == word)
    };
    WORDS.iter().find(begins).map(|(parts, word)| (*word, parts.len()))
}

/// Whether the beginning of a file is such a list: mostly its mnemonics with bare numbers, and no LD.
pub fn sniff(beginning: &str) -> bool {
    let (mut seen, mut known, mut own, mut loads) = (0_usize, 0_usize, 0_usize, 0_usize);
    for line in beginning.lines().take(LOOKED_AT) {
        let (words, _) = split(line);
        let mut rest = &words[..];
        if rest.first().is_some_and(|word| number(word).is_some()) {
            rest = &rest[1..];
        }
        let Some(first) = rest.first() else { continue };
        if is_head(rest) || first == "#" {
            continue;
        }
        seen += 1;
        loads += usize::from(first.starts_with("LD"));
        if let Some((word, taken)) = mnemonic(rest) {
            let label = word == Word::Label
                || (word.jumps() && rest.get(taken).is_some_and(|w| w == "LBL"));
            let bare = rest.get(taken).is_none_or(|operand| number(operand).is_some()) || label;
            known += usize::from(bare);
            // FX has a CJP too, with pointers; a label or a bare number is what is told from them.
            own += usize::from(bare && (word.is_own() || label));
        }
    }
    loads == 0 && seen > 0 && (known == seen || (own > 0 && known * 2 >= seen))
}

fn number(word: &str) -> Option<u32> {
    let digits = !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    if digits { word.parse().ok() } else { None }
}

/// Whether the words are the head of a printed list.
fn is_head(words: &[String]) -> bool {
    words.first().is_some_and(|word| word == "ADR" || word == "ADDRESS" || word == "LABEL")
}

/// Reads the list.
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
        let mut reader = Line { line, written, comment, step: None };
        if let Some(address) = number(&rest[0]) {
            reader.step = Some(address);
            rest = &rest[1..];
        }
        reader.read(rest, &mut list, faults);
    }
    if list.is_empty() && !faults.any_error() {
        let name = faults.file().to_owned();
        faults.push(crate::diagnostic::Diagnostic::file(
            "no-instructions",
            &name,
            "no instruction in this file",
            FORM,
        ));
    }
    list
}

/// A line being read.
struct Line<'a> {
    line: u32,
    written: &'a str,
    comment: String,
    step: Option<u32>,
}

impl Line<'_> {
    fn read(&mut self, mut rest: &[String], list: &mut Vec<Listed>, faults: &mut Faults<'_>) {
        if rest.is_empty() {
            return self.fault(faults, "bare-address", "an address without an instruction", FORM);
        }
        let mut first = true;
        while !rest.is_empty() {
            // A timer's time may stand on a line of its own.
            if let [mark, time, behind @ ..] = rest
                && mark == "#"
            {
                let open =
                    list.last_mut().filter(|last| last.word == Word::Timer && last.time.is_none());
                match (number(time), open) {
                    (Some(time), Some(last)) => {
                        last.time = Some(time);
                        last.text += &format!(" #{time}");
                    }
                    (None, _) => return self.bad_number(faults, time),
                    (_, None) => {
                        return self.fault(
                            faults,
                            "time-alone",
                            "a time without a timer in front of it",
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
            rest = &rest[taken..];
            let named =
                word.jumps() && rest.first().is_some_and(|word| word == "LBL" || word == "L");
            if named {
                rest = &rest[1..];
            }
            let mut operand = 0;
            if word.has_operand() {
                let Some(written) = rest.first() else {
                    return self.fault(faults, "no-operand", "the operand is missing", FORM);
                };
                let Some(value) = number(written).filter(|&value| value <= LARGEST) else {
                    return self.bad_number(faults, written);
                };
                operand = value;
                rest = &rest[1..];
            }
            if rest.first().is_some_and(|word| word == ":") {
                rest = &rest[1..];
            }
            list.push(Listed {
                word,
                operand,
                time: None,
                line: self.line,
                step: if first { self.step } else { None },
                text: text(word, operand),
                comment: self.comment.clone(),
            });
            first = false;
            // Only a label has another instruction behind it, only a timer a time.
            let more =
                word == Word::Label || rest.is_empty() || (word == Word::Timer && rest[0] == "#");
            if !more {
                let message = format!("'{}' is one operand too many", rest.concat());
                return self.fault(faults, "extra-operand", &message, FORM);
            }
        }
    }

    fn unknown(&self, faults: &mut Faults<'_>, rest: &[String], first: bool) {
        let word = &rest[0];
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
            format!("'{}' is one operand too many", rest.concat())
        };
        self.fault(faults, "unknown-instruction", &message, &help);
    }

    fn bad_number(&self, faults: &mut Faults<'_>, written: &str) {
        let message = format!("'{written}' is no number from 0 to {LARGEST}");
        self.fault(faults, "bad-operand", &message, FORM);
    }

    fn fault(&self, faults: &mut Faults<'_>, code: &'static str, message: &str, help: &str) {
        faults.at(code, self.line, self.written, message, help);
    }
}

fn text(word: Word, operand: u32) -> String {
    let parts =
        WORDS.iter().rev().find(|(_, known)| *known == word).map_or(&[][..], |(parts, _)| parts);
    let name = parts.join(" ");
    match word {
        Word::Wait | Word::Groups => name,
        Word::Jump | Word::JumpIf => format!("{name} LBL{operand}"),
        Word::Label => format!("LBL{operand}"),
        _ => format!("{name} {operand}"),
    }
}
