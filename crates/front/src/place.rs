//! The positions of an instruction's words in its source file, for the carets of diagnostics.

use scanbound_base::code::Code;
use std::ops::Range;

use scanbound_base::diagnostic::Diagnostic;

/// The position of each word of an instruction: first the mnemonic, then the operands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WordPositions {
    /// The byte offsets of the words in the text of the file.
    Text(Box<[u32]>),
    /// The line on which each word is, from 1, for words in rows of a CSV table.
    Rows(Box<[u32]>),
}

impl Default for WordPositions {
    fn default() -> Self {
        WordPositions::Rows(Box::default())
    }
}

impl WordPositions {
    /// The byte offsets of words that are slices of `text`; 0 for a word that is not.
    pub fn of_slices<'w>(text: &str, words: impl IntoIterator<Item = &'w str>) -> WordPositions {
        let start = |word: &str| slice_range(text, word).map_or(0, |range| range.start);
        WordPositions::Text(words.into_iter().map(|word| start(word) as u32).collect())
    }

    /// Appends the byte offsets of words that follow on further lines of the same text. Does nothing if either side
    /// holds line numbers.
    pub fn extend(&mut self, more: WordPositions) {
        if let (WordPositions::Text(all), WordPositions::Text(more)) = (self, more) {
            *all = all.iter().chain(&more).copied().collect();
        }
    }
}

/// The byte range of `part` in `whole`. `None` if it is empty or not a slice of it (an equal text elsewhere does not
/// count).
pub fn slice_range(whole: &str, part: &str) -> Option<Range<usize>> {
    let from = (part.as_ptr() as usize).checked_sub(whole.as_ptr() as usize)?;
    let to = from + part.len();
    (to <= whole.len() && !part.is_empty()).then_some(from..to)
}

/// The byte range of each operand in an instruction's text. The operands are at its end, each after one blank.
pub fn operand_spans(text: &str, operands: &[String]) -> Vec<(u32, u32)> {
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

/// An instruction and its position in the source, from which a diagnostic finds the place of its caret.
pub struct Caret<'a> {
    /// The line on which the instruction begins.
    pub line: u32,
    /// The text of the instruction. The operands are at its end, each after one blank.
    pub text: &'a str,
    /// The mnemonic of the instruction.
    pub mnemonic: &'a str,
    /// The operands of the instruction as they are written.
    pub operands: &'a [String],
    /// The positions of the instruction's words in the source.
    pub places: &'a WordPositions,
    /// The text of the instruction's file, if the positions are byte offsets.
    pub source: &'a str,
}

impl Caret<'_> {
    /// A diagnostic whose caret is at `part`: a slice of the mnemonic or of an operand, or a word equal to one of them
    /// in upper or lower case. For positions in text it shows the source line on which that word is; for rows of a
    /// table, the instruction's text with the word's line number. If `part` is neither, it shows the instruction
    /// without a caret.
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
            WordPositions::Text(starts) => match starts.get(word) {
                Some(&start) => self.in_source(whole, start as usize, part, &range),
                None => self.in_text(whole, word, &range),
            },
            WordPositions::Rows(rows) => {
                let line = rows.get(word).map_or(self.line, |&row| row);
                Diagnostic { line: Some(line), ..self.in_text(whole, word, &range) }
            }
        }
    }

    /// The index of the word (0: the mnemonic) of which `part` is a slice, and the byte range of `part` in it. If it is
    /// a slice of none: a word equal to it in upper or lower case, the first operand before the mnemonic, as a whole.
    /// `None` if there is neither.
    fn word(&self, part: &str) -> Option<(usize, Range<usize>)> {
        let words =
            || std::iter::once(self.mnemonic).chain(self.operands.iter().map(String::as_str));
        let own = words().enumerate().find_map(|(n, word)| Some((n, slice_range(word, part)?)));
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

    /// Places the caret under a word of the instruction's text: under `range` of an operand, or under the whole
    /// mnemonic.
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

    /// Places the caret under `part` in the line of the source. `start` is the offset of its word in the file, and
    /// `range` the range of `part` in this word.
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
            WordPositions::Text(starts) => starts.first().map_or(start, |&first| first as usize),
            WordPositions::Rows(_) => start,
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

/// The length in bytes of `word` at the beginning of `text`, which may have more or fewer blanks within the word.
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
        assert_eq!(slice_range(&whole, &whole[7..]), Some(7..9));
        assert_eq!(slice_range(&whole, &whole[..0]), None);
        assert_eq!(slice_range(&whole, "K1"), None);
    }

    #[test]
    fn the_caret_is_at_the_word_and_its_line() {
        let source = "  12 MOV   DM 1\n\tDM   2 ; x\n".to_owned();
        let operands = ["DM 1".to_owned(), "DM 2".to_owned()];
        let at = |places: &WordPositions, part: &str| {
            let pointer = Caret {
                line: 1,
                text: "MOV DM 1 DM 2",
                mnemonic: "MOV",
                operands: &operands,
                places,
                source: &source,
            };
            pointer.at(part, Code::Operand, "f", "m", "h")
        };
        let shown = |places: &WordPositions, part: &str| {
            let found = at(places, part);
            let (from, to) = found.span.expect("a span");
            (found.line, found.text[from..to].to_owned(), from)
        };
        let text = WordPositions::Text([5, 11, 17].into());
        assert_eq!(shown(&text, &operands[1]), (Some(2), "DM   2".to_owned(), 1));
        assert_eq!(shown(&text, "mov"), (Some(1), "MOV".to_owned(), 5));
        let rows = WordPositions::Rows([4, 4, 6].into());
        assert_eq!(shown(&rows, &operands[1]), (Some(6), "DM 2".to_owned(), 9));
        assert_eq!(shown(&rows, &operands[0][3..]), (Some(4), "1".to_owned(), 7));
        assert_eq!(at(&rows, "X0").span, None);
        assert_eq!(at(&rows, "").span, None);
    }
}
