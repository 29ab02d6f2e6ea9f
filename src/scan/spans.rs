//! What each symbolic word may hold in any scan, worked out once for each.

use super::implied::Implied;
use super::term::{Carry, Node, Word};
use super::word::Words;
use crate::base::ring::Ring;
use crate::scan::model::Circuit;

/// What words were found to hold, by their numbers.
#[derive(Debug, Default)]
pub(super) struct Spans(Vec<Option<Ring>>);

impl Spans {
    /// What a word may hold, as far as that was worked out.
    pub fn known(&self, word: Word) -> Ring {
        self.0.get(word.0 as usize).copied().flatten().unwrap_or(Ring::TOP)
    }

    /// Works out what a word may hold and all that it is made of, where `always` holds.
    pub fn work_out(&mut self, circuit: &Circuit, words: &Words, always: &Implied, word: Word) {
        let mut open = vec![word];
        while let Some(&word) = open.last() {
            let is_open = |word: &Word| !matches!(self.0.get(word.0 as usize), Some(Some(_)));
            let parts: [Option<Word>; 2] = match words.node(word) {
                _ if !is_open(&word) => [None, None],
                Node::Plus(inner, _) => [Some(inner), None],
                Node::Sum(a, b, Carry::NONE) | Node::Either(_, a, b) => [Some(a), Some(b)],
                _ => [None, None],
            };
            let before = open.len();
            open.extend(parts.into_iter().flatten().filter(is_open));
            if open.len() > before {
                continue;
            }
            open.pop();
            if is_open(&word) {
                let found = always.span(circuit, words, self, word);
                let place = word.0 as usize;
                if self.0.len() <= place {
                    self.0.resize(place + 1, None);
                }
                self.0[place] = Some(found);
            }
        }
    }
}
