//! Records, during the symbolic execution, what would violate the assumptions of the bound.

use super::number;
use super::word::{Word, Words};
use rustc_hash::FxHashMap;
use scanbound_ir::{BitTarget, Cell, Program, Region, StartRange, TrustedRange};
use scanbound_model::{Circuit, Lit};
use std::collections::BTreeMap;

/// Something a scan may do that breaks an assumption of the bound. The assumptions are proved if no scan that starts in
/// a state in which all of them hold can do any.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Violation {
    /// The scan writes a value outside its range into a trusted word; the number is its index in
    /// [`Program::trusted_ranges`] (in a check of candidates, the index of the candidate). Every write counts, because
    /// after a power failure in mid-scan a latched word keeps the value that it had then.
    Word(usize),
    /// The scan ends with all of these bits on, although they are mutually exclusive.
    All(Vec<BitTarget>),
    /// At the instruction with this index, the number of iterations or units exceeds the maximum that the analysis
    /// found.
    Count(usize),
    /// The indexed write of the instruction with this index goes outside the cells that the analysis found.
    Reach(usize),
}

/// The violations recorded so far, each with the literal that says whether it occurs.
#[derive(Debug)]
pub struct ViolationLog {
    words: FxHashMap<Cell, Watched>,
    /// For cells that stand for latched ones ([`PowerUp::lent`](scanbound_ir::PowerUp::lent)): these.
    lenders: FxHashMap<Cell, Vec<Cell>>,
    others: BTreeMap<Violation, Lit>,
}

/// A word whose range is assumed when a scan starts, so that its writes are checked.
#[derive(Debug)]
struct Watched {
    /// The index of the word, as used in [`Violation::Word`].
    place: usize,
    range: StartRange,
    /// The literal that says whether a value outside of the word's range was written.
    broken: Lit,
}

impl ViolationLog {
    /// An empty record that watches the program's trusted words.
    pub fn of(program: &Program) -> ViolationLog {
        let word = |one: &TrustedRange| StartRange {
            cells: vec![one.cell],
            low: one.low,
            high: one.high,
            values: one.values.clone(),
        };
        ViolationLog::of_words(program, program.trusted_ranges.iter().map(word).enumerate())
    }

    /// An empty record that watches these words, each with the index used in [`Violation::Word`] and its range. If
    /// several are the same cell, only the last is watched; numbers of two words are not watched.
    pub fn of_words(
        program: &Program,
        words: impl Iterator<Item = (usize, StartRange)>,
    ) -> ViolationLog {
        let word = |(place, range): (usize, StartRange)| match range.cells[..] {
            [cell] => Some((cell, Watched { place, range, broken: Lit::FALSE })),
            _ => None,
        };
        let mut lenders: FxHashMap<Cell, Vec<Cell>> = FxHashMap::default();
        for (&own, copies) in &program.power_up.lent {
            for &copy in copies {
                lenders.entry(copy).or_default().push(own);
            }
        }
        ViolationLog { words: words.filter_map(word).collect(), lenders, others: BTreeMap::new() }
    }

    /// Records a write of a word under `guard`. It breaks the range if the value is outside; if the range lists values,
    /// if it is none of these.
    pub fn written(
        &mut self,
        words: &mut Words,
        circuit: &mut Circuit,
        cell: Cell,
        guard: Lit,
        value: Word,
    ) {
        let lenders = self.lenders.get(&cell).map_or(&[][..], Vec::as_slice);
        for cell in lenders.iter().chain([&cell]) {
            let Some(watched) = self.words.get_mut(cell) else { continue };
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
    }

    /// Records that all cells of a region may get any value if `guard` is true.
    pub fn note_havoc(&mut self, circuit: &mut Circuit, region: Region, guard: Lit) {
        let lent = self.lenders.iter().filter(|(copy, _)| region.contains(**copy));
        let lent: Vec<Cell> = lent.flat_map(|(_, own)| own).copied().collect();
        let is_havocked = |cell: &Cell| region.contains(*cell) || lent.contains(cell);
        for (_, watched) in self.words.iter_mut().filter(|(cell, _)| is_havocked(cell)) {
            watched.broken = circuit.or(watched.broken, guard);
        }
    }

    /// Records one more violation, which occurs if the literal `happens` is true.
    pub fn note(&mut self, circuit: &mut Circuit, violation: Violation, happens: Lit) {
        let all = self.others.entry(violation).or_insert(Lit::FALSE);
        *all = circuit.or(*all, happens);
    }

    /// All recorded violations, each with the literal that says whether it occurs.
    pub fn into_violations(self) -> BTreeMap<Violation, Lit> {
        let words = self.words.into_values().map(|word| (Violation::Word(word.place), word.broken));
        words.chain(self.others).collect()
    }
}
