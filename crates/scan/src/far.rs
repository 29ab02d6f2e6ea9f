//! Writes of which it is not known where they go: what they may write is any value from there on.

use super::run::Run;
use super::term::{Node, Word};
use super::word::Words;
use rustc_hash::FxHashSet;
use scanbound_base::ring::stretches;
use scanbound_ir::{Cell, ChoiceId, Indexed, Region};
use scanbound_model::{FarWrite, Origin, VarId};
use std::collections::BTreeSet;

/// An index that may be so many numbers or more is not known.
const WIDE: i64 = 1000;
/// So many parts of a word are looked at to find out what it is made of.
const MOST_PARTS: usize = 500;
/// So many executions of one write are looked at.
const MOST_EXECUTIONS: u32 = 64;

impl Run<'_> {
    /// Takes note of a write of any value that may go nearly anywhere, and of what that comes from.
    pub(super) fn note_far(&mut self, choice: ChoiceId, region: Region, at: usize) {
        let program = self.program;
        let indexed = program.indexed.get(&choice).filter(|indexed| indexed.is_unknown_in(region));
        let index = match indexed {
            Some(indexed) if indexed.stated.is_some() || !self.is_far(indexed, at) => return,
            Some(indexed) => indexed.readings.concat(),
            None if region == Region::Everything => Vec::new(),
            None => return,
        };
        let before = self.memory.model.far_writes.iter().position(|far| far.choice == choice);
        let place = before.unwrap_or(self.memory.model.far_writes.len());
        if before.is_none() {
            self.memory.model.far_writes.push(FarWrite {
                instruction: at,
                choice,
                has_index: indexed.is_some(),
                executions: 0,
                is_first: false,
                starts: BTreeSet::new(),
                follows: BTreeSet::new(),
            });
        }
        let far = &mut self.memory.model.far_writes[place];
        far.executions += 1;
        if far.executions > MOST_EXECUTIONS {
            return;
        }
        let index: Vec<Word> = index.iter().map(|&word| self.word(word, at)).collect();
        let (starts, follows) = self.comes_from(&index, choice);
        let far = &mut self.memory.model.far_writes[place];
        far.is_first |= follows.is_empty();
        far.starts.extend(starts);
        far.follows.extend(follows);
    }

    /// Whether it is not known where a write by an index goes.
    fn is_far(&mut self, indexed: &Indexed, at: usize) -> bool {
        let mut ends: Vec<(i64, i64)> = Vec::new();
        for reading in &indexed.readings {
            let Some(index) = self.may_hold(reading, at) else { return true };
            ends.extend(stretches(&index));
        }
        ends.iter().map(|(low, high)| high - low).sum::<i64>() >= WIDE
    }

    /// The cells whose values at the start of the scan words may hold, and the writes that went nearly anywhere and may
    /// have left what they hold.
    fn comes_from(&self, words: &[Word], own: ChoiceId) -> (BTreeSet<Cell>, BTreeSet<ChoiceId>) {
        let (mut starts, mut follows) = (BTreeSet::new(), BTreeSet::new());
        let model = &self.memory.model;
        for variable in parts(&self.memory.words, words) {
            match &model.variables[variable.0 as usize].origin {
                Origin::Start(cell) => _ = starts.insert(*cell),
                Origin::Choice(_) => {}
                &Origin::Havocked { cell, since, until } => {
                    let moments = model.havocs.concerning(cell, since, until);
                    let choices = moments.map(|moment| moment.choice);
                    let is_far = |choice: &ChoiceId| {
                        *choice != own && model.far_writes.iter().any(|far| far.choice == *choice)
                    };
                    follows.extend(choices.filter(is_far));
                }
            }
        }
        (starts, follows)
    }
}

/// The free words that words may be or are put together from, whatever decides which.
pub(super) fn parts(words: &Words, from: &[Word]) -> Vec<VarId> {
    let (mut open, mut seen, mut found) = (from.to_vec(), FxHashSet::default(), Vec::new());
    while let Some(word) = open.pop().filter(|_| seen.len() < MOST_PARTS) {
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
