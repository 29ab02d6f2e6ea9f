//! Splits a line into words.

/// A word or sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Token<'a> {
    /// A name, a keyword, an address or a number.
    Word(&'a str),
    /// `=`
    Equals,
    /// `:`
    Colon,
    /// `->`
    Arrow,
    /// `*->`
    Stop,
}

impl<'a> Token<'a> {
    /// The word, if it is not a sign.
    pub(super) fn word(self) -> Option<&'a str> {
        match self {
            Token::Word(word) => Some(word),
            _ => None,
        }
    }

    /// The source text.
    pub(super) fn text(self) -> &'a str {
        match self {
            Token::Word(word) => word,
            Token::Equals => "=",
            Token::Colon => ":",
            Token::Arrow => "->",
            Token::Stop => "*->",
        }
    }
}

/// Words with a meaning in a statement, which cannot be names.
const KEYWORDS: [&str; 6] = ["marked", "if", "not", "at", "TIM", "CNT"];

/// Whether this can be the name of an element or page: letters and digits of any script, and `_ - / ( ) '`; not a
/// keyword.
#[must_use]
pub fn is_name(name: &str) -> bool {
    let fits = |c: char| c.is_alphanumeric() || "_-/()'ー・".contains(c);
    !name.is_empty() && name.chars().all(fits) && !name.contains("->") && !KEYWORDS.contains(&name)
}

/// The words of a line, without its comment. Commas count as blanks.
pub(super) fn tokens(line: &str) -> Vec<Token<'_>> {
    let code = line.split('#').next().unwrap_or_default();
    let mut found = Vec::new();
    let mut rest = code;
    loop {
        rest = rest.trim_start_matches(|c: char| c.is_whitespace() || c == ',');
        let Some(first) = rest.chars().next() else { return found };
        let symbols =
            [("*->", Token::Stop), ("->", Token::Arrow), ("=", Token::Equals), (":", Token::Colon)];
        if let Some((text, token)) = symbols.into_iter().find(|(text, _)| rest.starts_with(text)) {
            found.push(token);
            rest = &rest[text.len()..];
            continue;
        }
        let ends = |(at, c): (usize, char)| {
            let stops = c.is_whitespace()
                || matches!(c, ',' | '=' | ':')
                || rest[at..].starts_with("->")
                || rest[at..].starts_with("*->");
            (at > 0 && stops).then_some(at)
        };
        let end = rest.char_indices().find_map(ends).unwrap_or(rest.len());
        let end = end.max(first.len_utf8());
        found.push(Token::Word(&rest[..end]));
        rest = &rest[end..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_cut_into_words() {
        let line = "transition T-1=00305 at 3,-4:搬送->B01 if E01,not P.B2 # so";
        let found: Vec<&str> = tokens(line).into_iter().map(Token::text).collect();
        let all = "transition T-1 = 00305 at 3 -4 : 搬送 -> B01 if E01 not P.B2";
        assert_eq!(found.join(" "), all);
        assert_eq!(tokens("B01*->T00"), [Token::Word("B01"), Token::Stop, Token::Word("T00")]);
        assert_eq!(tokens("# all"), []);
    }

    #[test]
    fn names_are_words_without_meaning() {
        assert!(["B01", "部品・到着", "T-TM(1)", "a_b"].into_iter().all(is_name));
        assert!(
            ["", "a b", "a.b", "marked", "a->b", "a=b", "a:b", "a#b"]
                .into_iter()
                .all(|n| !is_name(n))
        );
    }
}
