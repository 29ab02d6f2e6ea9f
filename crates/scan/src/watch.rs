//! What is noted of what would break that on which a bound rests, while a scan is followed.

use super::number;
use super::word::{Word, Words};
use rustc_hash::FxHashMap;
use scanbound_ir::{BitTarget, Cell, Program, Region, StartRange, TrustedRange};
use scanbound_model::{Circuit, Lit};
use std::collections::BTreeMap;

/// What no scan does that starts in a state in which all of it holds.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Breach {
    /// It writes a value into a trusted word that is not in its range: an index into `Program::trusted`. Every write
    /// counts: of a latched word a power failure leaves what stood there in the midst of a scan.
    Word(usize),
    /// It ends with relays all on of which that is never so.
    All(Vec<BitTarget>),
    /// At this instruction more iterations or units are counted than was found.
    Count(usize),
    /// This instruction writes by an index where it was found not to reach.
    Reach(usize),
}

/// What was noted so far.
#[derive(Debug)]
pub struct Watch {
    words: FxHashMap<Cell, Watched>,
    others: BTreeMap<Breach, Lit>,
}

/// A trusted word.
#[derive(Debug)]
struct Watched {
    /// Its place in `Program::trusted`.
    place: usize,
    range: StartRange,
    /// Where another value was written.
    broken: Lit,
}

impl Watch {
    /// Nothing yet.
    pub fn of(program: &Program) -> Watch {
        let word = |one: &TrustedRange| StartRange {
            cells: vec![one.cell],
            low: one.low,
            high: one.high,
            values: one.values.clone(),
        };
        Watch::of_words(program.trusted.iter().map(word).enumerate())
    }

    /// Nothing yet of words, each with what [`Breach::Word`] calls it, and what it may hold. Of several that are one cell only
    /// the last is watched; of numbers of two words none is.
    pub fn of_words(words: impl Iterator<Item = (usize, StartRange)>) -> Watch {
        let word = |(place, range): (usize, StartRange)| match range.cells[..] {
            [cell] => Some((cell, Watched { place, range, broken: Lit::FALSE })),
            _ => None,
        };
        Watch { words: words.filter_map(word).collect(), others: BTreeMap::new() }
    }

    /// A word is written where `guard` holds.
    pub fn written(
        &mut self,
        words: &mut Words,
        circuit: &mut Circuit,
        cell: Cell,
        guard: Lit,
        value: Word,
    ) {
        let Some(watched) = self.words.get_mut(&cell) else { return };
        let StartRange { low, high, values, .. } = &watched.range;
        let mut within = number::within(words, circuit, &[value], true, *low, *high);
        if !values.is_empty() {
            let is = |&one: &u16| words.in_range(circuit, value, one, one);
            let is_one: Vec<Lit> = values.iter().map(is).collect();
            within = is_one.into_iter().fold(Lit::FALSE, |any, one| circuit.or(any, one));
        }
        let outside = circuit.and(guard, !within);
        watched.broken = circuit.or(watched.broken, outside);
    }

    /// Any values are written into a region where `guard` holds.
    pub fn lost(&mut self, circuit: &mut Circuit, region: Region, guard: Lit) {
        for (_, watched) in self.words.iter_mut().filter(|(cell, _)| region.holds(**cell)) {
            watched.broken = circuit.or(watched.broken, guard);
        }
    }

    /// Something else is broken where this holds.
    pub fn note(&mut self, circuit: &mut Circuit, breach: Breach, happens: Lit) {
        let all = self.others.entry(breach).or_insert(Lit::FALSE);
        *all = circuit.or(*all, happens);
    }

    /// All that may be broken, each with where it is.
    pub fn found(self) -> BTreeMap<Breach, Lit> {
        let words = self.words.into_values().map(|word| (Breach::Word(word.place), word.broken));
        words.chain(self.others).collect()
    }
}
