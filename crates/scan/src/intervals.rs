//! For each symbolic word, the interval of values that it may have in any scan, as far as computed.

use super::term::Word;
use scanbound_base::word_interval::WordInterval;

/// The intervals by the number of the word; `None` if not yet computed.
#[derive(Debug, Default)]
pub struct Intervals(Vec<Option<WordInterval>>);

impl Intervals {
    /// The interval of a word ([`WordInterval::TOP`], all values, if it is not yet computed).
    pub fn known(&self, word: Word) -> WordInterval {
        self.0.get(word.0 as usize).copied().flatten().unwrap_or(WordInterval::TOP)
    }

    /// Whether the interval has not been computed yet.
    pub fn is_open(&self, word: Word) -> bool {
        !matches!(self.0.get(word.0 as usize), Some(Some(_)))
    }

    /// Stores the interval of a word.
    pub fn store(&mut self, word: Word, span: WordInterval) {
        let place = word.0 as usize;
        if self.0.len() <= place {
            self.0.resize(place + 1, None);
        }
        self.0[place] = Some(span);
    }
}
