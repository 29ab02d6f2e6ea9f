//! The results that were computed so far for choices, with the conditions under which they hold.

use super::implied::Implications;
use super::intervals::Intervals;
use super::word::{Word, Words};
use rustc_hash::FxHashMap;
use scanbound_base::word_interval::WordInterval;
use scanbound_ir::{ChoiceId, Frame};
use scanbound_model::{Circuit, Lit};
use std::rc::Rc;

/// The largest number of conditions for which simplified words are cached.
pub(super) const MAX_CACHED: usize = 4096;

/// Ranges of cells in an area: first index and number of cells.
pub(super) type Stretches = Vec<(u32, u32)>;

/// What has been computed so far about choices, so that nothing is computed twice.
#[derive(Debug)]
pub(super) struct KnownChoices {
    /// The bits and words of choices that were read, by call context.
    pub(super) bits: FxHashMap<(Vec<Frame>, ChoiceId), Lit>,
    pub(super) words: FxHashMap<(Vec<Frame>, ChoiceId), Word>,
    /// The words that were computed from operations, with the condition under which they are valid.
    pub(super) settled: FxHashMap<(Vec<Frame>, ChoiceId), (Lit, Word)>,
    /// The choices with which the current instruction havocs: the choice, the guard of the havoc, and the part of the
    /// guard for which no result was observed, so that the havoc remains necessary.
    pub(super) written: Vec<(ChoiceId, Lit, Lit)>,
    /// The choice of the current indexed write, and the ranges of cells that this write may reach.
    pub(super) reach: Option<(ChoiceId, Option<Stretches>)>,
    /// The condition of the current instruction.
    pub(super) condition: Lit,
    /// The condition under which the current instruction is reached. Where it is false, values that are read do not
    /// matter.
    pub(super) reached: Lit,
    /// What `reached` implies, once computed.
    pub(super) implied: Option<(Lit, Implications)>,
    /// What holds in every scan.
    pub(super) always: Rc<Implications>,
    /// The intervals of words that are valid in every scan.
    pub(super) spans: Intervals,
    /// For simplified words: the original word, and the condition under which both are equal. Conditions refer to the
    /// simplified word.
    pub(super) before: FxHashMap<Word, (Word, Lit)>,
    /// Simplified words, by the condition under which they are equal to the original.
    pub(super) fewer: FxHashMap<Lit, FxHashMap<Word, Word>>,
}

impl Default for KnownChoices {
    fn default() -> KnownChoices {
        KnownChoices {
            bits: FxHashMap::default(),
            words: FxHashMap::default(),
            settled: FxHashMap::default(),
            written: Vec::new(),
            reach: None,
            condition: Lit::TRUE,
            reached: Lit::TRUE,
            implied: None,
            always: Rc::default(),
            spans: Intervals::default(),
            before: FxHashMap::default(),
            fewer: FxHashMap::default(),
        }
    }
}

impl KnownChoices {
    /// Starts the next instruction, which has this condition.
    pub(super) fn begin(&mut self, condition: Lit) {
        self.written.clear();
        self.reach = None;
        self.condition = condition;
    }

    /// Stores the constraints on the start of the scan. This is called once, after all of them were added.
    pub(super) fn start(&mut self, circuit: &Circuit, words: &Words, constraints: &[Lit]) {
        self.always = Rc::new(Implications::always(circuit, words, constraints));
        self.implied = None;
        self.spans = Intervals::default();
    }

    /// The condition of the current instruction.
    pub(super) fn condition(&self) -> Lit {
        self.condition
    }

    /// Sets the condition under which the current instruction is reached. Where it is false, values that are read do
    /// not matter.
    pub(super) fn reach(&mut self, reached: Lit) {
        self.reached = reached;
    }

    /// What is implied by the condition under which the current instruction is reached.
    pub(super) fn implications(&mut self, circuit: &Circuit, words: &Words) -> &Implications {
        let KnownChoices { reached, ref always, ref before, ref mut implied, .. } = *self;
        let known = implied.take().filter(|(by, _)| *by == reached);
        let known = known.unwrap_or_else(|| {
            let mut given = Implications::by(circuit, words, always, reached);
            given.apply_to_originals(before, circuit, words);
            (reached, given)
        });
        &implied.insert(known).1
    }

    /// A word simplified under the current `reached` condition.
    pub(super) fn simplified(&mut self, circuit: &Circuit, words: &mut Words, word: Word) -> Word {
        let reached = self.reached;
        if self.fewer.len() > MAX_CACHED {
            self.fewer.clear();
        }
        let mut known = self.fewer.remove(&reached).unwrap_or_default();
        let short = self.implications(circuit, words).simplified(circuit, words, word, &mut known);
        self.fewer.insert(reached, known);
        short
    }

    /// The interval of a word under the current `reached` condition.
    pub(super) fn span(&mut self, circuit: &Circuit, words: &Words, word: Word) -> WordInterval {
        self.always.compute(circuit, words, &mut self.spans, word);
        let spans = std::mem::take(&mut self.spans);
        let found = self.implications(circuit, words).span(circuit, words, &spans, word);
        self.spans = spans;
        found
    }
}
