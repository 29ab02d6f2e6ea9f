//! The values of choices (nondeterministic values) that were computed so far, and what is known where the current
//! instruction is reached.

use super::implied::Implications;
use super::intervals::Intervals;
use super::word::{Word, Words};
use rustc_hash::FxHashMap;
use scanbound_base::word_interval::WordInterval;
use scanbound_ir::{ChoiceId, Frame};
use scanbound_model::{Circuit, Lit};
use std::rc::Rc;

/// The largest number of guards for which simplified words are cached. Beyond it, the cache is emptied.
pub(super) const MAX_CACHED: usize = 4096;

/// Ranges of cells in an area, each with the index of its first cell and its number of cells.
pub(super) type Stretches = Vec<(u32, u32)>;

/// The values of choices that were computed so far, so that nothing is computed twice, and what is known while the
/// current instruction is executed.
#[derive(Debug)]
pub(super) struct KnownChoices {
    /// The literals of choices that were read as bits, by call context and choice.
    pub(super) bits: FxHashMap<(Vec<Frame>, ChoiceId), Lit>,
    /// The words of choices that were read as words, by call context and choice.
    pub(super) words: FxHashMap<(Vec<Frame>, ChoiceId), Word>,
    /// The words that were computed by executing the choices' operations, each with the guard under which it is valid.
    pub(super) settled: FxHashMap<(Vec<Frame>, ChoiceId), (Lit, Word)>,
    /// The choices with which the current instruction havocs: the choice, the guard of the havoc, and the part of the
    /// guard under which no result was computed or observed, so that the havoc remains necessary.
    pub(super) written: Vec<(ChoiceId, Lit, Lit)>,
    /// The choice of the indexed write that the current instruction executes, and the ranges of cells that this write
    /// may reach (inner `None`: unknown). `None` while the instruction has executed no indexed write.
    pub(super) reach: Option<(ChoiceId, Option<Stretches>)>,
    /// The value of `Logic::Condition` for the current instruction: the rung's result, together with the conditions of
    /// the open master control regions where they matter. It does not say whether the instruction is reached or fires.
    pub(super) condition: Lit,
    /// The guard of what is being executed now: that the instruction is reached, or that it also fires. Where it is
    /// false, values that are read do not matter.
    pub(super) reached: Lit,
    /// The guard for which implications were computed last, and what it implies. Used again while `reached` is this
    /// guard. `None` if none were computed yet.
    pub(super) implied: Option<(Lit, Implications)>,
    /// What the constraints imply; it is true in every scan.
    pub(super) always: Rc<Implications>,
    /// The intervals of words that are valid in every scan, as far as computed.
    pub(super) spans: Intervals,
    /// For each simplified word, the original word and the guard under which both are equal. Guards test the simplified
    /// word; this map carries what they say over to the original.
    pub(super) before: FxHashMap<Word, (Word, Lit)>,
    /// The simplified form of words, by the guard under which both are equal.
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
    /// Starts the next instruction, for which `Logic::Condition` has this value.
    pub(super) fn begin(&mut self, condition: Lit) {
        self.written.clear();
        self.reach = None;
        self.condition = condition;
    }

    /// Stores what the constraints on the start of the scan imply. To be called once, after all of them were added.
    pub(super) fn start(&mut self, circuit: &Circuit, words: &Words, constraints: &[Lit]) {
        self.always = Rc::new(Implications::always(circuit, words, constraints));
        self.implied = None;
        self.spans = Intervals::default();
    }

    /// The value of `Logic::Condition` for the current instruction.
    pub(super) fn condition(&self) -> Lit {
        self.condition
    }

    /// Sets the guard of what is executed next. Where it is false, values that are read do not matter.
    pub(super) fn reach(&mut self, reached: Lit) {
        self.reached = reached;
    }

    /// What the current guard `reached` implies, in addition to the constraints.
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

    /// A word that is equal to `word` wherever the guard `reached` is true, with fewer if-then-else branches if
    /// possible.
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

    /// An interval that contains the values of a word wherever the guard `reached` is true.
    pub(super) fn span(&mut self, circuit: &Circuit, words: &Words, word: Word) -> WordInterval {
        self.always.compute(circuit, words, &mut self.spans, word);
        let spans = std::mem::take(&mut self.spans);
        let found = self.implications(circuit, words).span(circuit, words, &spans, word);
        self.spans = spans;
        found
    }
}
