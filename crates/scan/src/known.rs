//! What choices of which something is known were found to be so far.

use super::implied::Implied;
use super::spans::Spans;
use super::word::{Word, Words};
use rustc_hash::FxHashMap;
use scanbound_base::ring::Ring;
use scanbound_ir::{ChoiceId, Frame};
use scanbound_model::{Circuit, Lit};
use std::rc::Rc;

/// The short forms of words are kept for so many conditions.
pub(super) const MOST_SHORT: usize = 4096;

/// Stretches of an area's cells: the first, and how many.
pub(super) type Stretches = Vec<(u32, u32)>;

/// What choices of which something is known were found to be so far, so that each is worked out once.
#[derive(Debug)]
pub(super) struct Known {
    /// Values of choices that were read, by the moment.
    pub(super) bits: FxHashMap<(Vec<Frame>, ChoiceId), Lit>,
    pub(super) words: FxHashMap<(Vec<Frame>, ChoiceId), Word>,
    /// Those that were worked out here, and where that holds.
    pub(super) settled: FxHashMap<(Vec<Frame>, ChoiceId), (Lit, Word)>,
    /// Choices with which the current instruction havocs: the choice, under which guard, and the part of that guard
    /// under which nothing was learned, so that the havoc stays.
    pub(super) written: Vec<(ChoiceId, Lit, Lit)>,
    /// A choice with which it writes by an index, and the stretches of cells that it may reach so.
    pub(super) reach: Option<(ChoiceId, Option<Stretches>)>,
    /// The current instruction's condition.
    pub(super) condition: Lit,
    /// Where what is read now matters.
    pub(super) reached: Lit,
    /// What that implies, once it was asked.
    pub(super) implied: Option<(Lit, Implied)>,
    /// What holds in every scan.
    pub(super) always: Rc<Implied>,
    /// What words hold there.
    pub(super) spans: Spans,
    /// Of words in their short form, where something was known: what they were before, and where they are the same.
    /// Conditions speak of the short form.
    pub(super) before: FxHashMap<Word, (Word, Lit)>,
    /// The short forms of words, by where they are the same.
    pub(super) fewer: FxHashMap<Lit, FxHashMap<Word, Word>>,
}

impl Default for Known {
    fn default() -> Known {
        Known {
            bits: FxHashMap::default(),
            words: FxHashMap::default(),
            settled: FxHashMap::default(),
            written: Vec::new(),
            reach: None,
            condition: Lit::TRUE,
            reached: Lit::TRUE,
            implied: None,
            always: Rc::default(),
            spans: Spans::default(),
            before: FxHashMap::default(),
            fewer: FxHashMap::default(),
        }
    }
}

impl Known {
    /// The next instruction begins, with this condition.
    pub(super) fn begin(&mut self, condition: Lit) {
        self.written.clear();
        self.reach = None;
        self.condition = condition;
    }

    /// The constraints on the scan's start are all there.
    pub(super) fn start(&mut self, circuit: &Circuit, words: &Words, constraints: &[Lit]) {
        self.always = Rc::new(Implied::always(circuit, words, constraints));
        self.implied = None;
        self.spans = Spans::default();
    }

    /// The current instruction's condition.
    pub(super) fn condition(&self) -> Lit {
        self.condition
    }

    /// From now on what is read matters only where this holds.
    pub(super) fn reach(&mut self, reached: Lit) {
        self.reached = reached;
    }

    /// What is given wherever what is read now matters.
    pub(super) fn given(&mut self, circuit: &Circuit, words: &Words) -> &Implied {
        let Known { reached, ref always, ref before, ref mut implied, .. } = *self;
        let known = implied.take().filter(|(by, _)| *by == reached);
        let known = known.unwrap_or_else(|| {
            let mut given = Implied::by(circuit, words, always, reached);
            given.keep_also(before, circuit, words);
            (reached, given)
        });
        &implied.insert(known).1
    }

    /// A word's short form where what is read now matters.
    pub(super) fn short(&mut self, circuit: &Circuit, words: &mut Words, word: Word) -> Word {
        let reached = self.reached;
        if self.fewer.len() > MOST_SHORT {
            self.fewer.clear();
        }
        let mut known = self.fewer.remove(&reached).unwrap_or_default();
        let short = self.given(circuit, words).without_others(circuit, words, word, &mut known);
        self.fewer.insert(reached, known);
        short
    }

    /// What a word may hold wherever what is read now matters.
    pub(super) fn span(&mut self, circuit: &Circuit, words: &Words, word: Word) -> Ring {
        self.always.work_out(circuit, words, &mut self.spans, word);
        let spans = std::mem::take(&mut self.spans);
        let found = self.given(circuit, words).span(circuit, words, &spans, word);
        self.spans = spans;
        found
    }
}
