//! The lexer of the textual languages.

use super::comment::{Comments, Skipped, newlines, quoted, skipped, without_comments};
use super::fault::Fault;

/// The kinds of tokens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Token {
    /// A name or a keyword, as written.
    Word(String),
    /// A number or a typed literal (`T#5s`, `16#FF`, `INT#3`, `1.5e3`), as written.
    Number(String),
    /// A quoted string, without its quotes.
    Text(String),
    /// A direct address: `%IX0.1`.
    Direct(String),
    /// An operator, bracket or other punctuation.
    Sign(&'static str),
    /// A pragma that a controller may execute, with its braces.
    Pragma(String),
    /// The end of a line, in texts where line ends matter.
    Line,
    /// The end of the text.
    End,
}

/// A token and its line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Placed {
    pub(crate) token: Token,
    pub(crate) line: u32,
}

const SIGNS: &[&str] = &[
    ":=", "=>", "<=", ">=", "<>", "**", "..", "(", ")", "[", "]", ",", ";", ":", "+", "-", "*",
    "/", "=", "<", ">", "&", ".", "^", "#",
];

/// Splits a text into tokens; its first line has the number `first`. If `lines` is set, line ends are tokens.
pub(crate) fn tokens(text: &str, first: u32, lines: bool) -> Result<Vec<Placed>, Fault> {
    let bytes = text.as_bytes();
    let (mut at, mut line) = (0, first);
    let mut found = Vec::new();
    while at < bytes.len() {
        let rest = &text[at..];
        let Some(next) = rest.chars().next() else { break };
        let begins_at = line;
        if next == '\n' {
            if lines {
                found.push(Placed { token: Token::Line, line });
            }
            line += 1;
            at += 1;
            continue;
        }
        if next.is_whitespace() || next == '\u{feff}' {
            at += next.len_utf8();
            continue;
        }
        if let Some((skipped, length)) = skipped(rest, line)? {
            if matches!(skipped, Skipped::Code) {
                let token = Token::Pragma(rest[..length].to_owned());
                found.push(Placed { token, line });
            }
            line += newlines(&rest[..length]);
            at += length;
            continue;
        }
        let (token, length) = if next == '\'' || next == '"' {
            let length =
                quoted(rest).ok_or_else(|| Fault::new(line, "the string is not closed"))?;
            (Token::Text(rest[1..length - 1].to_owned()), length)
        } else if next == '%' {
            let length = run(rest, |c| c.is_ascii_alphanumeric() || "%.*_".contains(c));
            (Token::Direct(rest[..length].trim_end_matches('.').to_owned()), length)
        } else if next.is_ascii_digit() {
            number(rest)
        } else if next.is_alphabetic() || next == '_' {
            word(rest)
        } else if let Some(sign) = SIGNS.iter().find(|sign| rest.starts_with(**sign)) {
            (Token::Sign(sign), sign.len())
        } else {
            return Err(Fault::new(line, format!("unexpected character '{next}'")));
        };
        found.push(Placed { token, line: begins_at });
        line += newlines(&rest[..length]);
        at += length;
    }
    found.push(Placed { token: Token::Line, line });
    if !lines {
        found.pop();
    }
    found.push(Placed { token: Token::End, line });
    Ok(found)
}

fn run(text: &str, holds: impl Fn(char) -> bool) -> usize {
    text.find(|c| !holds(c)).unwrap_or(text.len())
}

/// A number at the start of the text, with its base or exponent; the token and its length in bytes.
fn number(rest: &str) -> (Token, usize) {
    let mut length = run(rest, |c| c.is_ascii_digit() || c == '_');
    let tail = &rest[length..];
    if let Some(digits) = tail.strip_prefix('#') {
        length += 1 + run(digits, |c| c.is_ascii_alphanumeric() || c == '_');
        return (Token::Number(rest[..length].to_owned()), length);
    }
    if tail.starts_with('.') && tail[1..].starts_with(|c: char| c.is_ascii_digit()) {
        length += 1 + run(&tail[1..], |c| c.is_ascii_digit() || c == '_');
    }
    if rest[length..].starts_with(['e', 'E']) {
        let exponent = rest[length + 1..].trim_start_matches(['+', '-']);
        let signs = rest[length + 1..].len() - exponent.len();
        let digits = run(exponent, |c| c.is_ascii_digit());
        if digits > 0 && signs <= 1 {
            length += 1 + signs + digits;
        }
    }
    (Token::Number(rest[..length].to_owned()), length)
}

/// A name, or a literal with a type prefix, at the start of the text: `T#1m30s`, `INT#-5`, `BOOL#1`,
/// `DT#2020-01-01-00:00:00`. Returns the token and its length in bytes.
fn word(rest: &str) -> (Token, usize) {
    let mut length = run(rest, |c| c.is_alphanumeric() || c == '_');
    let (word, tail) = rest.split_at(length);
    let of = word.to_ascii_uppercase();
    // Blanks may separate `#` from a number: `T# 30000ms`.
    let (blanks, behind) = tail.strip_prefix('#').map_or((0, ""), blanks);
    let literal = Some(behind).filter(|literal| {
        let may_begin = |c: char| match blanks {
            0 => c.is_ascii_alphanumeric() || "+-".contains(c),
            _ => c.is_ascii_digit(),
        };
        TYPED.contains(&of.as_str()) && literal.starts_with(may_begin)
    });
    let Some(literal) = literal else { return (Token::Word(word.to_owned()), length) };
    let signed = usize::from(literal.starts_with(['+', '-']));
    let is_date = matches!(
        of.as_str(),
        "D" | "DATE" | "DT" | "DATE_AND_TIME" | "TOD" | "TIME_OF_DAY" | "LDT" | "LTOD" | "LDATE"
    );
    let part =
        |c: char| c.is_ascii_alphanumeric() || "._#".contains(c) || is_date && "-:".contains(c);
    let mut digits = signed + run(&literal[signed..], part);
    let mut text = format!("{word}#{}", &literal[..digits]);
    if matches!(of.as_str(), "T" | "TIME" | "LT" | "LTIME") {
        // `T#1m 30s`
        while let Some(more) = duration_part(&literal[digits..]) {
            text += literal[digits..digits + more].trim_start();
            digits += more;
        }
    }
    length += 1 + blanks + digits;
    (Token::Number(text), length)
}

/// The number of blanks and tabs at the start of a text, and the rest of the text.
fn blanks(text: &str) -> (usize, &str) {
    let behind = text.trim_start_matches([' ', '\t']);
    (text.len() - behind.len(), behind)
}

/// The length of blanks followed by a number with a time unit; `None` if the text does not begin so.
fn duration_part(text: &str) -> Option<usize> {
    let (skipped, rest) = blanks(text);
    let digits = run(rest, |c| c.is_ascii_digit() || c == '.');
    let unit = run(&rest[digits..], |c| c.is_ascii_alphanumeric() || c == '_');
    let of = rest[digits..digits + unit].to_ascii_lowercase();
    let is_unit = ["d", "h", "m", "s", "ms", "us", "ns"].contains(&of.as_str());
    (skipped > 0 && digits > 0 && is_unit).then_some(skipped + digits + unit)
}

/// Up to two words at the start of a text, after comments and pragmas, under this nesting rule. The text may be
/// truncated.
pub(super) fn first_words(text: &str, reading: Comments) -> Vec<String> {
    let plain = without_comments(text, reading);
    let mut rest = plain.trim_start_matches('\u{feff}').trim_start();
    let mut found = Vec::new();
    while found.len() < 2 {
        if rest.starts_with('{') {
            let Some(end) = rest.find('}') else { break };
            rest = rest[end..].trim_start_matches('}').trim_start();
            continue;
        }
        let length = run(rest, |c| c.is_alphanumeric() || c == '_');
        if length == 0 {
            break;
        }
        found.push(rest[..length].to_owned());
        rest = rest[length..].trim_start();
    }
    found
}

/// The type prefixes of literals.
const TYPED: &[&str] = &[
    "T",
    "TIME",
    "LT",
    "LTIME",
    "D",
    "DATE",
    "LDATE",
    "TOD",
    "TIME_OF_DAY",
    "LTOD",
    "DT",
    "DATE_AND_TIME",
    "LDT",
    "BOOL",
    "BYTE",
    "WORD",
    "DWORD",
    "LWORD",
    "SINT",
    "INT",
    "DINT",
    "LINT",
    "USINT",
    "UINT",
    "UDINT",
    "ULINT",
    "REAL",
    "LREAL",
    "STRING",
    "WSTRING",
];

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> Vec<String> {
        let name = |placed: Placed| match placed.token {
            Token::Word(text) | Token::Number(text) | Token::Direct(text) => text,
            Token::Text(text) => format!("'{text}'"),
            Token::Sign(sign) => sign.to_owned(),
            Token::Pragma(text) => text,
            Token::Line => "line".to_owned(),
            Token::End => "end".to_owned(),
        };
        tokens(text, 1, false).expect("tokens").into_iter().map(name).collect()
    }

    #[test]
    fn literals_names_and_signs_are_told_apart() {
        assert_eq!(
            shown("a.b[1..2]:=T#1m30s_5ms+16#FF*1.5e-3;//x\n(* y *) 'it$'s' %IX0.1 s1.X"),
            [
                "a",
                ".",
                "b",
                "[",
                "1",
                "..",
                "2",
                "]",
                ":=",
                "T#1m30s_5ms",
                "+",
                "16#FF",
                "*",
                "1.5e-3",
                ";",
                "'it$'s'",
                "%IX0.1",
                "s1",
                ".",
                "X",
                "end"
            ]
        );
        assert_eq!(
            shown("INT#-5 color#red D#2020-01-02"),
            ["INT#-5", "color", "#", "red", "D#2020-01-02", "end"]
        );
    }

    #[test]
    fn blanks_may_stand_in_durations() {
        assert_eq!(shown("T# 30000ms;"), ["T#30000ms", ";", "end"]);
        assert_eq!(shown("T#1m 30s + TIME#1h  5ms"), ["T#1m30s", "+", "TIME#1h5ms", "end"]);
        assert_eq!(shown("T#1m\n30 INT# 5 T # x"), ["T#1m", "30", "INT#5", "T", "#", "x", "end"]);
    }

    #[test]
    fn what_has_no_end_is_told_with_its_line() {
        assert_eq!(tokens("a\n(* b", 5, false).expect_err("a fault").line, 6);
        assert!(tokens("'a", 1, false).is_err() && tokens("a ? b", 1, false).is_err());
    }
}
