//! Parses one line of OMRON mnemonics: prefixes, mnemonic, function number and operands, in both notations.

use super::catalog;
use super::source::{Edge, FunctionNumber, RawInstruction};
use scanbound_front::WordPositions;

/// The content of a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Line {
    /// Nothing, a comment or a separator line.
    Empty,
    Instruction(RawInstruction),
    /// Only operands, which belong to the instruction before them, as in the tables of the manuals.
    Operands(Vec<String>, WordPositions),
    /// A line that is neither empty nor an instruction.
    Unknown,
}

/// Area letters that are written apart from the number: `DM 0100`, `TIM 000`.
const SEPARATED_AREAS: [&str; 17] = [
    "DM", "*DM", "@DM", "EM", "*EM", "HR", "*HR", "AR", "LR", "SR", "IR", "CIO", "TR", "TIM",
    "CNT", "TC", "*LR",
];

/// Parses a line; `number` is its line number in the file.
pub(super) fn read(text: &str, line: &str, number: u32) -> Line {
    let code = code(line);
    let mut words: Vec<&str> = code.split_whitespace().collect();
    // A line may begin with two numbers: rung number and program address.
    let mut step = None;
    for _ in 0..2 {
        let numbered = words.first().is_some_and(|word| is_digits(word))
            && words.get(1).is_some_and(|next| begins_instruction(next));
        let second = words.len() > 2
            && is_digits(words[0])
            && is_digits(words[1])
            && begins_instruction(words[2]);
        if numbered || second {
            step = words[0].parse().ok();
            words.remove(0);
        }
    }
    if words.is_empty() {
        return Line::Empty;
    }
    match head(&words) {
        Some((mut instruction, used)) => {
            instruction.line = number;
            instruction.step = step;
            let starts;
            (instruction.operands, starts) = operands(&words[used..]);
            instruction.places =
                WordPositions::of_slices(text, std::iter::once(words[0]).chain(starts));
            // `LD !0.00` means `!LD 0.00`.
            for operand in &mut instruction.operands {
                if let Some(rest) = operand.strip_prefix('!').map(str::to_owned) {
                    (*operand, instruction.immediate) = (rest, true);
                }
            }
            instruction.text = std::iter::once(words[..used].join(" "))
                .chain(instruction.operands.iter().cloned())
                .collect::<Vec<_>>()
                .join(" ")
                .into();
            Line::Instruction(instruction)
        }
        None if words.iter().all(|word| is_operand(word)) => {
            let (operands, starts) = operands(&words);
            Line::Operands(operands, WordPositions::of_slices(text, starts))
        }
        None => Line::Unknown,
    }
}

/// The line without comments and separators.
fn code(line: &str) -> &str {
    let trimmed = line.trim();
    let rule = ["---", "***", "===", "'", ";", "//"].iter().any(|mark| trimmed.starts_with(mark));
    if rule && !trimmed.starts_with("--(") {
        return "";
    }
    let mut quoted = false;
    let mut before = ' ';
    for (at, c) in trimmed.char_indices() {
        match c {
            '"' => quoted = !quoted,
            ';' if !quoted => return &trimmed[..at],
            '/' if !quoted && before == '/' => return &trimmed[..at - 1],
            // A remark in parentheses has a blank before it; a function number has none, or has digits only.
            '(' if !quoted && before.is_whitespace() && !is_function(&trimmed[at..]) => {
                return &trimmed[..at];
            }
            _ => {}
        }
        before = c;
    }
    trimmed
}

/// Whether the text begins with a function number in parentheses.
fn is_function(text: &str) -> bool {
    text.strip_prefix('(')
        .and_then(|rest| rest.split_once(')'))
        .is_some_and(|(inner, _)| is_number_text(inner))
}

/// Whether the text in parentheses is a function number: two or three digits, or dashes for an unassigned one.
fn is_number_text(text: &str) -> bool {
    (is_digits(text) && (2..=3).contains(&text.len()))
        || (!text.is_empty() && text.chars().all(|c| matches!(c, '-' | '–' | '—' | '_')))
}

fn begins_instruction(word: &str) -> bool {
    head(&[word]).is_some()
        || (word.starts_with(|c: char| c.is_ascii_alphabetic() || "@%!".contains(c))
            && !is_operand(word))
}

/// The instruction at the start of the words, without operands, and the number of words it takes. `None` if they do not
/// begin with an instruction.
fn head(words: &[&str]) -> Option<(RawInstruction, usize)> {
    let first = *words.first()?;
    let marks = first.len() - first.trim_start_matches(['@', '%', '!']).len();
    let (prefix, rest) = first.split_at(marks);
    let mut used = 1;
    let (mut name, mut number_text) = match rest
        .strip_suffix(')')
        .and_then(|rest| rest.rsplit_once('('))
    {
        Some((name, number)) if is_number_text(number) => (name.to_ascii_uppercase(), Some(number)),
        _ => (rest.to_ascii_uppercase(), None),
    };
    if number_text.is_none() {
        let next = words.get(1).map(|word| word.to_ascii_uppercase());
        match (name.as_str(), next.as_deref()) {
            ("LD" | "AND" | "OR" | "OUT", Some("NOT")) | ("AND" | "OR", Some("LD")) => {
                name.push_str(next.as_deref().unwrap_or_default());
                used = 2;
            }
            // Also `MOV (21)`, and `FUN 21` and `FUN(21)` of the programming console.
            (_, Some(next)) if is_function(next) && next.ends_with(')') => {
                number_text = words.get(1).map(|word| word.trim_matches(['(', ')']));
                used = 2;
            }
            ("FUN", Some(next)) if is_number_text(next) => {
                number_text = words.get(1).copied();
                used = 2;
            }
            _ => {}
        }
    }
    let number = number_text.filter(|text| is_digits(text)).and_then(|text| {
        Some(FunctionNumber { value: text.parse().ok()?, digits: u8::try_from(text.len()).ok()? })
    });
    if name == "FUN" && number.is_some() {
        name.clear();
    }
    // CX-Programmer's two-word names of comparison contacts: `LD =`, `AND <>L`.
    let known = catalog::knows(&name) || (name.is_empty() && number.is_some());
    let user = number_text.is_some() || (is_name(&name) && !is_operand(&name));
    (known || user).then(|| {
        let instruction = RawInstruction {
            line: 0,
            step: None,
            edge: match () {
                () if prefix.contains('@') => Some(Edge::Rising),
                () if prefix.contains('%') => Some(Edge::Falling),
                () => None,
            },
            immediate: prefix.contains('!'),
            mnemonic: if known { name } else { rest.split('(').next().unwrap_or(rest).to_owned() },
            number,
            operands: Vec::new(),
            text: "".into(),
            places: WordPositions::default(),
        };
        (instruction, used)
    })
}

/// Whether a word can be the name of a user-defined instruction.
fn is_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && word.chars().all(|c| c.is_alphanumeric() || c == '_')
}

/// Whether a word looks like an operand that is not a symbol.
pub(super) fn is_operand(word: &str) -> bool {
    let upper = word.to_ascii_uppercase();
    if SEPARATED_AREAS.contains(&upper.as_str()) || upper.starts_with('#') || upper.starts_with('&')
    {
        return true;
    }
    let body = upper.trim_start_matches(['*', '@', '+', '-']);
    let letters = body.len() - body.trim_start_matches(|c: char| c.is_ascii_uppercase()).len();
    let (area, number) = body.split_at(letters);
    let known = [
        "", "CIO", "W", "H", "A", "D", "E", "T", "C", "TK", "TR", "DR", "IR", "CF", "DM", "HR",
        "AR", "LR", "EM", "TIM", "CNT", "L",
    ];
    known.contains(&area)
        && number.starts_with(|c: char| c.is_ascii_digit())
        && number.bytes().all(|b| b.is_ascii_digit() || b == b'.' || b == b'_')
}

/// The operands, each with its first word; area letters are joined with the number after them.
fn operands<'w>(words: &[&'w str]) -> (Vec<String>, Vec<&'w str>) {
    let (mut out, mut starts): (Vec<String>, Vec<&str>) = (Vec::new(), Vec::new());
    let mut words = words.iter().peekable();
    while let Some(word) = words.next() {
        starts.push(word);
        let upper = word.to_ascii_uppercase();
        // In `# 0020` the prefix is separated from its digits.
        if matches!(upper.as_str(), "#" | "&")
            && let Some(digits) = words.next_if(|next| next.bytes().all(|b| b.is_ascii_hexdigit()))
        {
            out.push(format!("{upper}{}", digits.trim_end_matches(',')));
            continue;
        }
        let joined = SEPARATED_AREAS.contains(&upper.as_str())
            && words.peek().is_some_and(|next| next.starts_with(|c: char| c.is_ascii_digit()));
        match (joined, words.peek()) {
            (true, Some(next)) => {
                out.push(format!("{upper} {next}"));
                words.next();
            }
            _ => out.push(word.trim_end_matches(',').to_owned()),
        }
    }
    (out, starts)
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn instruction(line: &str) -> RawInstruction {
        match read(line, line, 1) {
            Line::Instruction(instruction) => instruction,
            other => panic!("{line}: {other:?}"),
        }
    }

    #[test]
    fn both_spellings_give_the_same() {
        for (c, cx) in [
            ("LD NOT 00300", "LDNOT 00300"),
            ("AND LD", "ANDLD"),
            ("OUT NOT 00500", "OUTNOT 00500"),
            ("MOV(21) #0010 DM 0100", "MOV (21) #0010 DM 0100"),
        ] {
            let (c, cx) = (instruction(c), instruction(cx));
            assert_eq!(
                (&c.mnemonic, &c.number, &c.operands),
                (&cx.mnemonic, &cx.number, &cx.operands)
            );
        }
    }

    #[test]
    fn marks_numbers_and_operands_are_told_apart() {
        let read = instruction("00012 @MOV(021) #1234 D100 ; start");
        assert_eq!(
            (read.step, read.edge, read.mnemonic.as_str()),
            (Some(12), Some(Edge::Rising), "MOV")
        );
        assert_eq!(read.number, Some(FunctionNumber { value: 21, digits: 3 }));
        assert_eq!(read.operands, ["#1234", "D100"]);
        assert_eq!(&*read.text, "@MOV(021) #1234 D100");
        assert_eq!(instruction("--(592) D0").mnemonic, "--");
        assert_eq!(instruction("!%++L(591) D0").edge, Some(Edge::Falling));
        assert_eq!(instruction("/(430) D0 D2 D4").mnemonic, "/");
        assert_eq!(instruction("AND<>L(306) D0 #1").mnemonic, "AND<>L");
        assert_eq!(instruction("FUN(21) #1 DM 0").number.map(|n| n.value), Some(21));
        assert_eq!(instruction("FUN 21 #1 DM 0").operands, ["#1", "DM 0"]);
        assert_eq!(instruction("TIM 000 #0030").operands, ["000", "#0030"]);
        assert_eq!(instruction("LD TIM 000").operands, ["TIM 000"]);
        assert_eq!(instruction("00010 LD NOT      00300 (MAIN :B01)").operands, ["00300"]);
        assert_eq!(instruction("WSFT(--) 010 012").number, None);
        assert_eq!(instruction("MyBlock1 D0").mnemonic, "MyBlock1");
    }

    #[test]
    fn what_is_no_instruction_is_said_so() {
        for line in ["", "  ; note", "' rung 1", "-----TRANSITION MAIN -T01", "// x", "***"] {
            assert_eq!(read(line, line, 1), Line::Empty, "{line}");
        }
        let operands = |line: &str| match read(line, line, 1) {
            Line::Operands(operands, _) => operands,
            other => panic!("{line}: {other:?}"),
        };
        assert_eq!(operands("   DM 0010"), ["DM 0010"]);
        assert_eq!(operands("#0000"), ["#0000"]);
        assert_eq!(read("", "\"what\"", 1), Line::Unknown);
    }
}
