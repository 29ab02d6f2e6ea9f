//! Where the words of an instruction stand in its file: from the reader to the caret of a diagnostic.

use scanbound_base::code::Code;
use std::ops::Range;

use scanbound_base::diagnostic::Diagnostic;

/// Where each word of an instruction begins: the mnemonic, then the operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Places {
    /// Bytes of the file's text.
    Text(Box<[u32]>),
    /// The physical lines of a table's rows.
    Rows(Box<[u32]>),
}

impl Default for Places {
    fn default() -> Self {
        Places::Rows(Box::default())
    }
}

impl Places {
    /// The places of words that are slices of a text.
    pub fn of_slices<'w>(text: &str, words: impl IntoIterator<Item = &'w str>) -> Places {
        let start = |word: &str| within(text, word).map_or(0, |range| range.start);
        Places::Text(words.into_iter().map(|word| start(word) as u32).collect())
    }

    /// Adds words that follow on further lines of the same text.
    pub fn extend(&mut self, more: Places) {
        if let (Places::Text(all), Places::Text(more)) = (self, more) {
            *all = all.iter().chain(&more).copied().collect();
        }
    }
}

/// The bytes of `whole` that `part` is, if it is a slice of it and not a like text from elsewhere.
pub fn within(whole: &str, part: &str) -> Option<Range<usize>> {
    let from = (part.as_ptr() as usize).checked_sub(whole.as_ptr() as usize)?;
    let to = from + part.len();
    (to <= whole.len() && !part.is_empty()).then_some(from..to)
}

/// The bytes of an instruction's text at which its operands stand: they are its end, each behind a blank.
pub fn spans(text: &str, operands: &[String]) -> Vec<(u32, u32)> {
    let mut end = text.len();
    let mut spans: Vec<(u32, u32)> = Vec::with_capacity(operands.len());
    for operand in operands.iter().rev() {
        let start = end.saturating_sub(operand.len());
        spans.push((start as u32, end as u32));
        end = start.saturating_sub(1);
    }
    spans.reverse();
    spans
}

/// An instruction with all that is needed to point at a part of it.
pub struct Pointer<'a> {
    /// The line on which it begins.
    pub line: u32,
    /// What it consists of, the operands at its end, each behind a blank.
    pub text: &'a str,
    /// The name of the instruction.
    pub mnemonic: &'a str,
    /// Its operands as they are written.
    pub operands: &'a [String],
    /// Where they stand in the source.
    pub places: &'a Places,
    /// The text of its file, where the places are bytes of it.
    pub source: &'a str,
}

impl Pointer<'_> {
    /// A diagnostic whose caret is at `part`: a slice of the mnemonic or of an operand, or a word equal to one
    /// of them. It has the line on which that word stands, and that line's text.
    pub fn at(
        &self,
        part: &str,
        code: Code,
        file: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Diagnostic {
        let whole = Diagnostic::line(code, file, self.line, self.text, message, help);
        let Some((word, range)) = self.word(part) else { return whole };
        match self.places {
            Places::Text(starts) => match starts.get(word) {
                Some(&start) => self.in_source(whole, start as usize, part, &range),
                None => self.in_text(whole, word, &range),
            },
            Places::Rows(rows) => {
                let line = rows.get(word).map_or(self.line, |&row| row);
                Diagnostic { line: Some(line), ..self.in_text(whole, word, &range) }
            }
        }
    }

    /// The word that `part` belongs to, 0 being the mnemonic, and the bytes of the word that it is.
    fn word(&self, part: &str) -> Option<(usize, Range<usize>)> {
        let words =
            || std::iter::once(self.mnemonic).chain(self.operands.iter().map(String::as_str));
        let own = words().enumerate().find_map(|(n, word)| Some((n, within(word, part)?)));
        let like = || {
            let mut alike = words()
                .enumerate()
                .filter(|(_, word)| !part.is_empty() && word.eq_ignore_ascii_case(part));
            let first = alike.next()?;
            let (n, word) = if first.0 == 0 { alike.next().unwrap_or(first) } else { first };
            Some((n, 0..word.len()))
        };
        own.or_else(like)
    }

    /// Points into the instruction as it is put together.
    fn in_text(&self, whole: Diagnostic, word: usize, range: &Range<usize>) -> Diagnostic {
        let behind =
            |from: usize| self.operands[from..].iter().map(|one| one.len() + 1).sum::<usize>();
        let head = self.text.len().saturating_sub(behind(0));
        match word.checked_sub(1) {
            None => whole.span(0..head),
            Some(operand) => {
                let from = self.text.len().saturating_sub(behind(operand)) + 1;
                whole.span(from + range.start..from + range.end)
            }
        }
    }

    /// Points into the line of the file.
    fn in_source(
        &self,
        whole: Diagnostic,
        start: usize,
        part: &str,
        range: &Range<usize>,
    ) -> Diagnostic {
        let Some(tail) = self.source.get(start..) else { return whole };
        let from = start + range.start;
        let to = from + extent(&tail[range.start.min(tail.len())..], part);
        let begin = self.source[..start].rfind('\n').map_or(0, |at| at + 1);
        let text = self.source[begin..].lines().next().unwrap_or_default();
        let first = match self.places {
            Places::Text(starts) => starts.first().map_or(start, |&first| first as usize),
            Places::Rows(_) => start,
        };
        let lines =
            self.source.get(first..start).map_or(0, |between| between.matches('\n').count());
        Diagnostic {
            line: Some(self.line.saturating_add(lines as u32)),
            text: text.trim_end().to_owned(),
            ..whole
        }
        .span(from - begin..to - begin)
    }
}

/// How far a word reaches into a text that begins with it, where blanks may stand apart in other numbers.
fn extent(text: &str, word: &str) -> usize {
    let mut rest = text.char_indices();
    let mut end = 0;
    for _ in word.chars().filter(|c| !c.is_whitespace()) {
        if let Some((at, c)) = rest.by_ref().find(|(_, c)| !c.is_whitespace()) {
            end = at + c.len_utf8();
        }
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slice_is_found_where_it_is_and_nothing_else() {
        let whole = "MOV K1 K1".to_owned();
        assert_eq!(within(&whole, &whole[7..]), Some(7..9));
        assert_eq!(within(&whole, &whole[..0]), None);
        assert_eq!(within(&whole, "K1"), None);
    }

    #[test]
    fn the_caret_is_at_the_word_and_its_line() {
        let source = "  12 MOV   DM 1\n\tDM   2 ; x\n".to_owned();
        let operands = ["DM 1".to_owned(), "DM 2".to_owned()];
        let at = |places: &Places, part: &str| {
            let pointer = Pointer {
                line: 1,
                text: "MOV DM 1 DM 2",
                mnemonic: "MOV",
                operands: &operands,
                places,
                source: &source,
            };
            pointer.at(part, Code::Operand, "f", "m", "h")
        };
        let shown = |places: &Places, part: &str| {
            let found = at(places, part);
            let (from, to) = found.span.expect("a span");
            (found.line, found.text[from..to].to_owned(), from)
        };
        let text = Places::Text([5, 11, 17].into());
        assert_eq!(shown(&text, &operands[1]), (Some(2), "DM   2".to_owned(), 1));
        assert_eq!(shown(&text, "mov"), (Some(1), "MOV".to_owned(), 5));
        let rows = Places::Rows([4, 4, 6].into());
        assert_eq!(shown(&rows, &operands[1]), (Some(6), "DM 2".to_owned(), 9));
        assert_eq!(shown(&rows, &operands[0][3..]), (Some(4), "1".to_owned(), 7));
        assert_eq!(at(&rows, "X0").span, None);
        assert_eq!(at(&rows, "").span, None);
    }
}
