//! Records the havocs whose targets are unknown: after one, nearly any cell may have any value.

use super::run::Run;
use super::term::{Node, Word};
use super::word::Words;
use rustc_hash::FxHashSet;
use scanbound_base::word_interval::signed_ranges;
use scanbound_ir::{Cell, ChoiceId, IndexedWrite, Region};
use scanbound_model::{Origin, UnknownWrite, VarId};
use std::collections::BTreeSet;

/// A write whose index may range over about this many values or more counts as a write to an unknown target.
const WIDE: i64 = 1000;
/// The largest number of parts of words that are examined to find on what an index depends.
const MAX_PARTS: usize = 500;
/// The largest number of executions of one write whose index is examined; further ones are only counted.
const MAX_EXECUTIONS: u32 = 64;

impl Run<'_> {
    /// Records a havoc if it may write nearly anywhere, and on what its index depends. Writes with a stated index
    /// range, or with few possible indices, are not recorded.
    pub(super) fn note_unknown_write(&mut self, choice: ChoiceId, region: Region, at: usize) {
        let program = self.program;
        let indexed = program.indexed.get(&choice).filter(|indexed| indexed.is_unknown_in(region));
        let (index, values) = match indexed {
            Some(indexed) if indexed.stated.is_some() => return,
            Some(indexed) => (indexed.indices.concat(), self.index_values(indexed, at)),
            None if region == Region::Everything => (Vec::new(), i64::MAX),
            None => return,
        };
        if values < WIDE {
            return;
        }
        let before = self.memory.model.unknown_writes.iter().position(|far| far.choice == choice);
        let place = before.unwrap_or(self.memory.model.unknown_writes.len());
        if before.is_none() {
            self.memory.model.unknown_writes.push(UnknownWrite {
                instruction: at,
                choice,
                has_index: indexed.is_some(),
                executions: 0,
                is_independent: false,
                most_values: 0,
                start_cells: BTreeSet::new(),
                depends_on: BTreeSet::new(),
            });
        }
        let far = &mut self.memory.model.unknown_writes[place];
        far.executions += 1;
        if far.executions > MAX_EXECUTIONS {
            return;
        }
        let index: Vec<Word> = index.iter().map(|&word| self.word(word, at)).collect();
        let (starts, follows) = self.dependencies(&index, choice);
        let far = &mut self.memory.model.unknown_writes[place];
        if follows.is_empty() {
            far.is_independent = true;
            far.most_values = far.most_values.max(values);
        }
        far.start_cells.extend(starts);
        far.depends_on.extend(follows);
    }

    /// The number of values that the index of a write may have; `i64::MAX` if it is unknown.
    fn index_values(&mut self, indexed: &IndexedWrite, at: usize) -> i64 {
        let mut all = 0;
        for reading in &indexed.indices {
            let Some(index) = self.may_hold(reading, at) else { return i64::MAX };
            all += signed_ranges(&index).iter().map(|(low, high)| high - low + 1).sum::<i64>();
        }
        all
    }

    /// The cells on whose start values these words may depend, and the other unknown writes from which their values may
    /// come.
    fn dependencies(&self, words: &[Word], own: ChoiceId) -> (BTreeSet<Cell>, BTreeSet<ChoiceId>) {
        let (mut starts, mut follows) = (BTreeSet::new(), BTreeSet::new());
        let model = &self.memory.model;
        for variable in parts(&self.memory.words, words) {
            match &model.variables[variable.0 as usize].origin {
                Origin::Start(cell) => _ = starts.insert(*cell),
                Origin::Choice(_) => {}
                &Origin::Havocked { cell, since, until } => {
                    let moments = model.havocs.concerning(cell, since, until);
                    let choices = moments.map(|moment| moment.choice);
                    let has_unknown_target = |choice: &ChoiceId| {
                        *choice != own
                            && model.unknown_writes.iter().any(|far| far.choice == *choice)
                    };
                    follows.extend(choices.filter(has_unknown_target));
                }
            }
        }
        (starts, follows)
    }
}

/// The free words of which words are composed or among which they are selected. Not those in conditions or in single
/// bits, and not those beyond [`MAX_PARTS`] examined parts.
pub(super) fn parts(words: &Words, from: &[Word]) -> Vec<VarId> {
    let (mut open, mut seen, mut found) = (from.to_vec(), FxHashSet::default(), Vec::new());
    while let Some(word) = open.pop().filter(|_| seen.len() < MAX_PARTS) {
        if !seen.insert(word) {
            continue;
        }
        match words.node(word) {
            Node::Const(_) | Node::Bits(_) => {}
            Node::Free(variable) => found.push(variable),
            Node::Either(_, a, b) | Node::Bitwise(_, a, b) | Node::Sum(a, b, _) => {
                open.extend([a, b]);
            }
            Node::Plus(a, _) | Node::Carried(a, ..) => open.push(a),
            Node::Derived(number, _) => open.extend(words.derived_of(number).operands()),
        }
    }
    found
}
