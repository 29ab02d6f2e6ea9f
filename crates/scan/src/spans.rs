//! What each symbolic word may hold in any scan, once it was worked out.

use super::term::Word;
use scanbound_base::ring::Ring;

/// What words were found to hold, by their numbers.
#[derive(Debug, Default)]
pub struct Spans(Vec<Option<Ring>>);

impl Spans {
    /// What a word may hold, as far as that was worked out.
    pub fn known(&self, word: Word) -> Ring {
        self.0.get(word.0 as usize).copied().flatten().unwrap_or(Ring::TOP)
    }

    /// Whether that is still to be worked out.
    pub fn is_open(&self, word: Word) -> bool {
        !matches!(self.0.get(word.0 as usize), Some(Some(_)))
    }

    /// Takes note of it.
    pub fn found(&mut self, word: Word, span: Ring) {
        let place = word.0 as usize;
        if self.0.len() <= place {
            self.0.resize(place + 1, None);
        }
        self.0[place] = Some(span);
    }
}
