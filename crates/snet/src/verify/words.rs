//! Parses a list of the C200H or of CX-Programmer, limited to the instructions in code of nets.

use crate::address::{Address, Area};
use crate::translate::{Instruction, Listing, Operand, Operation};
use crate::{Diagram, Kind};
use scanbound_base::code::Code;
use scanbound_base::diagnostic::Diagnostic;

/// An instruction. Relays are named as [`Address`] writes them, timers `TIM 000`, counters `CNT 000`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Word {
    Load(bool, String),
    And(bool, String),
    Or(bool, String),
    AndBlock,
    OrBlock,
    /// OUT, or OUT NOT (true).
    Out(bool, String),
    Set(String),
    Reset(String),
    Keep(String),
    /// TIM and CNT, with their set value.
    Timer(String, String),
    Counter(String, String),
    /// OUT of a counter in MELSEC, with its set value, and its RST: each has its own condition.
    Count(String, String),
    ResetCounter(String),
    End,
}

/// An instruction with its place in the code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Line {
    /// Its line, from 1.
    pub(super) line: u32,
    /// As it is written.
    pub(super) text: String,
    pub(super) word: Word,
}

/// Parses a code of the C200H or CX-Programmer.
pub(super) fn read(file: &str, code: &str) -> Result<Vec<Line>, Vec<Diagnostic>> {
    let known =
        "use only LD, AND, OR and their NOT, AND LD, OR LD, OUT, SET, RSET, KEEP, TIM, CNT and END";
    gather(file, code, |line, text, words| {
        word(words).ok_or_else(|| faulty(file, line, text, known))
    })
}

/// The error for an instruction that code of nets does not have; `known` lists those that it may have.
pub(super) fn faulty(file: &str, line: u32, text: &str, known: &str) -> Diagnostic {
    let message = "code of a net cannot have this instruction";
    Diagnostic::line(Code::UnknownInstruction, file, line, text, message, known)
}

/// Parses a code line by line with `word`.
pub(super) fn gather(
    file: &str,
    code: &str,
    word: impl Fn(u32, &str, &[&str]) -> Result<Word, Diagnostic>,
) -> Result<Vec<Line>, Vec<Diagnostic>> {
    let mut lines: Vec<Line> = Vec::new();
    let mut faults = Vec::new();
    // The translator prints lists of gates and addresses before the code.
    let begin = code.lines().position(|line| line.trim_start().starts_with("NAME:"));
    for (at, text) in code.lines().enumerate().skip(begin.map_or(0, |at| at + 1)) {
        let line = u32::try_from(at + 1).unwrap_or(u32::MAX);
        let text = text.trim();
        let mut words: Vec<&str> = bare(text).split_whitespace().collect();
        // A line may begin with rung number and program address.
        while words.len() > 1 && is_digits(words[0]) && !words[1].starts_with('#') {
            words.remove(0);
        }
        if words.is_empty() {
            continue;
        }
        if let ([value], Some(last)) = (&words[..], lines.last_mut())
            && value.starts_with('#')
            && let Word::Timer(_, own) | Word::Counter(_, own) = &mut last.word
        {
            *own = setting(value);
            continue;
        }
        match word(line, text, &words) {
            Ok(word) => lines.push(Line { line, text: text.to_owned(), word }),
            Err(fault) => faults.push(fault),
        }
    }
    if lines.is_empty() && faults.is_empty() {
        let help = "give a list for the C200H or MELSEC, or mnemonics of CX-Programmer";
        let message = "the file has no instructions";
        faults.push(Diagnostic::file(Code::NoInstructions, file, message, help));
    }
    if faults.is_empty() { Ok(lines) } else { Err(faults) }
}

/// The line without comments, headings and names in parentheses.
fn bare(text: &str) -> &str {
    if ["---", "***", ";", "'", "//"].iter().any(|mark| text.starts_with(mark)) {
        return "";
    }
    text.split([';', '(']).next().unwrap_or_default()
}

fn is_digits(text: &str) -> bool {
    text.bytes().all(|b| b.is_ascii_digit())
}

/// Makes equal set values equal texts: `#0025`, `#25` and `025`.
pub(super) fn setting(text: &str) -> String {
    text.trim_start_matches(['#', '&']).trim_start_matches('0').to_owned()
}

fn word(words: &[&str]) -> Option<Word> {
    let upper: Vec<String> = words.iter().map(|word| word.to_ascii_uppercase()).collect();
    let mut rest: Vec<&str> = upper.iter().map(String::as_str).collect();
    let mut name = rest.remove(0).to_owned();
    if rest.first().is_some_and(|next| *next == "NOT" || (*next == "LD" && name != "LD")) {
        name += rest.remove(0);
    }
    let numbered = |letters: &str| -> Option<(String, String)> {
        let number: u16 = rest.first()?.parse().ok()?;
        let value = rest.get(1).map_or(String::new(), |value| setting(value));
        Some((format!("{letters} {number:03}"), value))
    };
    let relay = || relay(&rest.join(" "));
    Some(match name.as_str() {
        "LD" => Word::Load(false, relay()?),
        "LDNOT" => Word::Load(true, relay()?),
        "AND" => Word::And(false, relay()?),
        "ANDNOT" => Word::And(true, relay()?),
        "OR" => Word::Or(false, relay()?),
        "ORNOT" => Word::Or(true, relay()?),
        "ANDLD" if rest.is_empty() => Word::AndBlock,
        "ORLD" if rest.is_empty() => Word::OrBlock,
        "OUT" => Word::Out(false, relay()?),
        "OUTNOT" => Word::Out(true, relay()?),
        "SET" => Word::Set(relay()?),
        "RSET" => Word::Reset(relay()?),
        "KEEP" => Word::Keep(relay()?),
        "TIM" => numbered("TIM").map(|(name, value)| Word::Timer(name, value))?,
        "CNT" => numbered("CNT").map(|(name, value)| Word::Counter(name, value))?,
        "END" => Word::End,
        _ => return None,
    })
}

/// The unique name of a relay, in any notation.
fn relay(text: &str) -> Option<String> {
    for (letters, timing) in [("TIM", "TIM"), ("CNT", "CNT"), ("T", "TIM"), ("C", "CNT")] {
        let number = text.strip_prefix(letters).map(str::trim_start);
        if let Some(number) = number.filter(|number| !number.is_empty() && is_digits(number)) {
            return Some(format!("{timing} {:03}", number.parse::<u16>().ok()?));
        }
    }
    let symbols = [
        ("P_FIRST_CYCLE", "25315"),
        ("P_ON", "25313"),
        ("P_OFF", "25314"),
        ("P_0_1S", "25500"),
        ("P_0_2S", "25501"),
        ("P_1S", "25502"),
    ];
    if let Some((_, own)) = symbols.iter().find(|(symbol, _)| *symbol == text) {
        return Some((*own).to_owned());
    }
    if let Some((word, bit)) = text.split_once('.') {
        let (area, word) =
            word.strip_prefix('H').map_or((Area::Internal, word), |word| (Area::Holding, word));
        let (word, bit): (u16, u8) = (word.parse().ok()?, bit.parse().ok()?);
        let (area, word) = if area == Area::Internal && word >= 1_000 {
            (Area::Link, word - 1_000)
        } else {
            (area, word)
        };
        return Some(Address { area, word, bit }.to_string());
    }
    let joined: String = text.split(' ').collect();
    joined.parse::<Address>().ok().map(|address| address.to_string())
}

/// The net's own code in this form.
pub(super) fn of_net(diagram: &Diagram, listing: &Listing) -> Vec<Line> {
    let all = listing.groups.iter().flat_map(|(_, instructions)| instructions);
    let word = |one: &Instruction| {
        let name = name(diagram, one.operand);
        let setting = || match one.operand {
            Operand::Contact(at) => match diagram.places[at].kind {
                Kind::Timer { tenths, .. } => setting(&tenths.to_string()),
                Kind::Counter { count, .. } => setting(&count.to_string()),
                Kind::Box => String::new(),
            },
            _ => String::new(),
        };
        match one.operation {
            Operation::Load(is_closed) => Word::Load(is_closed, name),
            Operation::And(is_closed) => Word::And(is_closed, name),
            Operation::Or(is_closed) => Word::Or(is_closed, name),
            Operation::Out => Word::Out(false, name),
            Operation::Timer => Word::Timer(name, setting()),
            Operation::Counter => Word::Counter(name, setting()),
        }
    };
    all.map(|one| Line { line: 0, text: String::new(), word: word(one) }).collect()
}

/// The name of an operand.
pub(super) fn name(diagram: &Diagram, operand: Operand) -> String {
    let address = |address: Option<Address>| address.map_or(String::new(), |one| one.to_string());
    match operand {
        Operand::Transition(at) => address(diagram.transitions[at].head.address),
        Operand::Place(at) => address(diagram.places[at].head.address),
        Operand::Outer(at) => address(diagram.outers[at].head.address),
        Operand::FirstScan => "25315".to_owned(),
        Operand::Contact(at) => match diagram.places[at].kind {
            Kind::Timer { number, .. } => format!("TIM {:03}", number.unwrap_or(0)),
            Kind::Counter { number, .. } => format!("CNT {:03}", number.unwrap_or(0)),
            Kind::Box => address(diagram.places[at].head.address),
        },
    }
}
