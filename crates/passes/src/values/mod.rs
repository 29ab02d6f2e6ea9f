//! Bounds the values of words that give counts, by abstract interpretation with strided intervals and small sets.
//!
//! A loop count, a block length or an index in a word is computed at the point of use, over all paths to it: constants,
//! moves, arithmetic, conditions, results with a known range. If the range of an index is known, an indexed write
//! affects only the cells in that range. The method is abstract interpretation (P. Cousot and R. Cousot: Abstract
//! interpretation: a unified lattice model for static analysis of programs, POPL 1977); the abstract domain is in
//! `value`.
//!
//! Between scans, other writers may write any word ([`Trust::None`]). With [`Trust::Counts`], nothing else is assumed
//! to write those words that give counts, or from which counts are computed, and that the program writes in every scan;
//! their values are a least fixpoint over scans, from power-up.

mod condition;
mod evaluate;
mod integers;
mod limits;
mod reach;
mod run;
mod scan_fixpoint;
mod skippable;
mod slice;
mod slots;
mod state;
#[cfg(test)]
mod tests;
mod value;
#[cfg(test)]
mod value_tests;
mod write;

use super::loops;
pub use super::pass::Trust;
use super::pass::{Pass, Settings, is_internal};
use evaluate::Evaluation;
use reach::Reach;
use run::{CountLimits, Run};
use scan_fixpoint::{Fixpoint, ScanFixpoint};
use scanbound_ir::meaning::{ChoiceKind, Meaning};
use scanbound_ir::{
    Approximated, BitSource, Cell, ChoiceId, Effect, Program, Region, Source, StartRange, Step,
    TrustedRange, Units, WordSource, Write,
};
use slots::Slots;
use state::Tracked;
use std::collections::{BTreeMap, BTreeSet};
use value::Value;

/// This pass may use 1/`PARTS` of the time limit; the rest is for symbolic execution and search.
const PARTS: u32 = 4;

/// Bounds the iterations of loops, the units of instructions and the targets of indexed writes by the values that words
/// can have.
pub const PASS: Pass = Pass {
    name: "bounding counts and indices",
    run: |program, settings| {
        narrow(program, settings);
        Ok(())
    },
};

/// Stores the results in the program: lower limits for iterations and units, and fewer cells for indexed writes. The
/// ranges of trusted words on which these rely become constraints on the start of the scan. Results that hold with less
/// trust also hold with more, so the results of all levels of trust are combined.
fn narrow(program: &mut Program, settings: &Settings<'_>) {
    let mut known = ValueResults::default();
    // If the user states no internal cells, analysing counts without trust gives nothing that the analysis with trust
    // does not.
    let first = match program.internal.is_empty() {
        true => settings.trust.min(Trust::Counts),
        false => Trust::None,
    };
    for trust in [Trust::None, Trust::Counts, Trust::All] {
        if (first..=settings.trust).contains(&trust) {
            known.closer(analyse(program, trust, settings));
        }
    }
    program.proved_ranges = known.keeps;
    let mut trusted: Vec<TrustedRange> = known.trusted.into_iter().map(of_word).collect();
    writers(program, &mut trusted);
    for TrustedRange { cell, low, high, values, .. } in &trusted {
        let (cells, low, high, values) = (vec![*cell], *low, *high, values.clone());
        program.stated_ranges.push(StartRange { cells, low, high, values });
    }
    program.trusted_ranges = trusted;
    if let Some(found) = known.found {
        apply(program, &found);
    }
}

/// What the analysis of a program's words gave, with one or more levels of trust.
#[derive(Default)]
struct ValueResults {
    /// Limits on counts and indexed writes; `None` if no scan could be analysed.
    found: Option<CountLimits>,
    /// The values of trusted words at the start of a scan.
    trusted: BTreeMap<Cell, Value>,
    /// Words with stated ranges of which it is proved that the program keeps them within these ranges.
    keeps: BTreeSet<Cell>,
}

impl ValueResults {
    /// Adds another result that also holds: the smaller of two limits, the common values of a trusted word.
    fn closer(&mut self, other: ValueResults) {
        match (&mut self.found, other.found) {
            (Some(found), Some(other)) => found.meet(other),
            (found, other) => *found = found.take().or(other),
        }
        for (cell, value) in other.trusted {
            let known = self.trusted.entry(cell).or_insert(value);
            *known = known.closer(value).as_start();
        }
        self.keeps.extend(other.keeps);
    }
}

/// The range of a trusted word at the start of a scan, in the form in which the program stores it, still without its
/// writers.
fn of_word((cell, value): (Cell, Value)) -> TrustedRange {
    let (low, high) = value.signed();
    let values = value.list_for_start().unwrap_or_default();
    TrustedRange { cell, low, high, values, writers: Vec::new() }
}

/// Analyses the program with this level of trust. The result is empty, or has only what holds without trust, if the
/// time is over or no fixpoint was found.
fn analyse(program: &Program, trust: Trust, settings: &Settings<'_>) -> ValueResults {
    let cut = |open: &str| {
        if let Some(budget) = settings.budget {
            budget.record_stop_at_part(PARTS, PASS.name, open);
        }
    };
    let is_over = || settings.budget.is_some_and(|budget| budget.must_stop_at_part(PARTS));
    let counting = slice::slice(program, &program.volatile, false);
    let words = match trust {
        Trust::Counts if program.internal.is_empty() => counting.clone(),
        Trust::Counts | Trust::All => slice::slice(program, &program.volatile, true),
        Trust::None => counting.clone(),
    };
    let words = Slots::of(words);
    if words.cells().is_empty() {
        return ValueResults::default();
    }
    let bits = Slots::of(slice::contacts(program, &program.volatile, &words));
    let followed = Tracked::of(program, words, bits);
    let slots = &followed.words;
    let free = stated_values(program, slots);
    let mut run = Run::new(program, &followed, &is_over);
    let Ok(end) = run.scan(followed.holding(free.clone())) else {
        cut("each number of iterations or units is assumed to be as large as its word allows");
        return ValueResults::default();
    };
    let keeps = keeps(program, slots, &run.written);
    let mut known = ValueResults { found: Some(run.found), keeps, ..ValueResults::default() };
    let Some(end) = end.filter(|_| trust != Trust::None) else { return known };
    let cell = |slot: usize| slots.cells()[slot];
    // If stated values differ from those at power-up, another writer must have set them before the first scan.
    let at_first = |slot: usize| Value::constant(program.power_up.initial_value(cell(slot)));
    let may_begin = |slot: usize| free[slot].contains(&at_first(slot));
    let ours: Vec<usize> = (0..slots.cells().len())
        .filter(|&slot| has_no_other_writer(program, cell(slot)) && may_begin(slot))
        .collect();
    let (alone, others): (Vec<usize>, Vec<usize>) =
        ours.into_iter().partition(|&slot| trust.trusts_exclusive_cell(program, cell(slot)));
    let counts = |slot: &usize| counting.binary_search(&cell(*slot)).is_ok();
    let others = others.into_iter().filter(|&slot| end.has_new_value(slot) && counts(&slot));
    let all: Vec<usize> = alone.iter().copied().chain(others).collect();
    let always: Vec<usize> = all.iter().copied().filter(|&slot| end.has_new_value(slot)).collect();
    let is_constant = |slot: &usize| end.value(*slot).as_constant().is_some();
    let steady = always.iter().copied().filter(is_constant).collect();
    let (followed, free, given) = (&followed, &free, &run.given);
    let search = ScanFixpoint { program, followed, free, given, steady, is_over: &is_over };
    let over = search.of(&all);
    let fewer = all.len() > always.len();
    let over = over.or_else(|| fewer.then(|| search.of(&always)).flatten());
    let Some(mut over) = over else {
        cut(
            "at the start of a scan, each word is assumed to have any value, except for stated ranges",
        );
        return known;
    };
    if trust == Trust::Counts {
        // Facts about internal cells exclude scans, so these results apply even if no count becomes smaller.
        over = match known.found.as_ref() == Some(&over.found) {
            true if alone.is_empty() => Fixpoint::default(),
            true => search.of(&alone).unwrap_or_default(),
            false => search.needed(over, &alone),
        };
    }
    let found = Some(over.found);
    let trusted = over.trusted.iter().map(|&slot| (cell(slot), over.start[slot])).collect();
    known.closer(ValueResults { found, trusted, ..ValueResults::default() });
    known
}

/// For each slot, the values that the user's ranges of single words allow at the start of a scan, whoever wrote them;
/// all values for other slots, even in the range of a double word.
fn stated_values(program: &Program, slots: &Slots) -> Vec<Value> {
    let mut start = vec![Value::TOP; slots.cells().len()];
    for range in &program.stated_ranges {
        if let [cell] = range.cells[..]
            && let Some(slot) = slots.slot(cell)
            && let Some(value) = start[slot].meet(Value::range(range.low, range.high))
        {
            start[slot] = value;
        }
    }
    start
}

/// The words with stated ranges that contain the value at power-up, into which the program writes only values within
/// the range, if a scan starts within all these ranges. Words that other writers are known to write are excluded, such
/// as those that the program only clears.
fn keeps(program: &Program, slots: &Slots, written: &[Option<Value>]) -> BTreeSet<Cell> {
    let keeps_range = |range: &&StartRange| {
        let [cell] = range.cells[..] else { return false };
        let first = program.power_up.initial_value(cell);
        let is_stated = (range.low..=range.high).contains(&first.cast_signed().into());
        if !has_no_other_writer(program, cell) || !is_stated {
            return false;
        }
        let written = slots.slot(cell).and_then(|slot| written[slot]);
        written.filter(|written| *written != Value::constant(first)).is_some_and(|written| {
            let (low, high) = written.signed();
            range.low <= low && high <= range.high
        })
    };
    // One word may be stated under two names.
    let (internal, others): (Vec<&StartRange>, Vec<&StartRange>) =
        program.stated_ranges.iter().partition(keeps_range);
    let other = |cell: &Cell| others.iter().any(|range| range.cells == [*cell]);
    internal.into_iter().map(|range| range.cells[0]).filter(|cell| !other(cell)).collect()
}

/// Whether nothing but the program is known to write a cell (it is no input, not volatile, not external, and refreshed
/// by no network unless the user states it as internal), and its value at power-up is known.
///
/// Cells that may change at any moment are excluded here, although no bound could rely on them: every read of them
/// gives any value (`passes::interrupts`).
#[must_use]
pub fn has_no_other_writer(program: &Program, cell: Cell) -> bool {
    let holds = |region: &Region| region.contains(cell);
    is_unwritten_elsewhere(program, cell) && !program.power_up.inputs.iter().any(holds)
}

/// As [`has_no_other_writer`], for a cell that is known not to be an input.
#[must_use]
pub fn is_unwritten_elsewhere(program: &Program, cell: Cell) -> bool {
    let holds = |region: &Region| region.contains(cell);
    program.power_up.cleared.iter().any(holds)
        && !program.volatile.iter().any(holds)
        && !program.external.iter().any(holds)
        && (is_internal(program, cell)
            || !program.networks.iter().any(|(region, _)| region.contains(cell)))
}

/// Records for each of these words which instructions may write it, so that reports can name them.
fn writers(program: &Program, ranges: &mut [TrustedRange]) {
    let place: BTreeMap<Cell, usize> =
        ranges.iter().enumerate().map(|(place, one)| (one.cell, place)).collect();
    for at in 0..program.instructions.len() {
        for region in scanbound_ir::flow::written(program, at) {
            if let Region::Range { first, count } = region {
                let end = Cell { index: first.index.saturating_add(count), ..first };
                for (_, &place) in place.range(first..end) {
                    ranges[place].writers.push(at);
                }
            }
        }
    }
}

/// For each indexed write whose reach is known, the ranges of cells that it reaches, each as first and last index. They
/// are kept separate only if an instruction reads a cell between them.
fn stretches(program: &Program, found: &CountLimits) -> BTreeMap<ChoiceId, Vec<(u32, u32)>> {
    let mut read: Option<BTreeSet<Cell>> = None;
    let mut stretches = |(&choice, reach): (&ChoiceId, &Option<Reach>)| {
        let (all, indexed) = ((*reach)?.stretches(), program.indexed.get(&choice)?);
        let (&(low, _), &(_, high)) = (all.first()?, all.last()?);
        let read = match all.len() {
            1 => return Some((choice, all)),
            _ => read.get_or_insert_with(|| reads(program)),
        };
        let cell = |index: u32| Cell { index, ..indexed.first };
        let is_reached = |index: u32| all.iter().any(|&(low, high)| (low..=high).contains(&index));
        let spares = read.range(cell(low)..=cell(high)).any(|cell| !is_reached(cell.index));
        Some((choice, if spares { all } else { vec![(low, high)] }))
    };
    found.reaches.iter().filter_map(&mut stretches).collect()
}

/// The cells that instructions and the operands of choices name directly, not by an index.
fn reads(program: &Program) -> BTreeSet<Cell> {
    let mut found = BTreeSet::new();
    for instruction in &program.instructions {
        instruction.each_read(&mut |source| match source {
            Source::Bit(BitSource::Cell(cell) | BitSource::WordBit(cell, _))
            | Source::Word(WordSource::Cell(cell)) => _ = found.insert(cell),
            Source::Word(WordSource::Bits { first, count }) => {
                found.extend((0..count).map(|place| first.plus(place.into())));
            }
            Source::Bit(_) | Source::Word(_) => {}
        });
    }
    for kind in program.kinds.values() {
        kind.each_word(&mut |word| {
            if let WordSource::Cell(cell) = word {
                found.insert(cell);
            }
        });
    }
    found
}

/// Stores the limits in the program: fewer units and iterations, and fewer cells that indexed writes havoc. Records
/// which instructions got lower limits.
fn apply(program: &mut Program, found: &CountLimits) {
    let indexed = &program.indexed;
    let reached = stretches(program, found);
    // A write beyond the end of its area reaches nothing (see README, what is not modelled).
    let reach = |choice: ChoiceId, region: Region| {
        let indexed = indexed.get(&choice).filter(|indexed| indexed.may_reach(region))?;
        Some((indexed, reached.get(&choice)?))
    };
    let mut counted: BTreeSet<usize> = BTreeSet::new();
    let mut taken: BTreeSet<ChoiceId> = BTreeSet::new();
    for (at, instruction) in program.instructions.iter_mut().enumerate() {
        let closer = |effect: &Effect| match effect.write {
            Write::Havoc(region, choice) => reach(choice, region).is_some(),
            _ => false,
        };
        if instruction.effects.iter().any(closer) {
            for effect in std::mem::take(&mut instruction.effects) {
                let Write::Havoc(region, choice) = effect.write else {
                    instruction.effects.push(effect);
                    continue;
                };
                let Some((indexed, stretches)) = reach(choice, region) else {
                    instruction.effects.push(effect);
                    continue;
                };
                taken.insert(choice);
                let write = |&ends| Write::Havoc(indexed.range(ends), choice);
                let writes = stretches.iter().map(write);
                instruction.effects.extend(writes.map(|write| Effect { when: effect.when, write }));
            }
        }
        if let Some(Units::Counted(units)) = instruction.timing.as_mut().map(|key| &mut key.units)
            && let Some(&most) = found.units.get(&at)
            && most < units.most
        {
            units.most = most;
            counted.insert(at);
        }
        let turns = match &instruction.step {
            Step::ForBegin { most, .. } => Some(*most),
            Step::Summary(summary) => summary.iterations.map(|(.., most)| most),
            _ => None,
        };
        if let (Some(most), Some(&known)) = (turns, found.iterations.get(&at))
            && known < i64::from(most)
        {
            counted.insert(at);
        }
    }
    program.approximations.retain(|one| {
        !(counted.contains(&one.instruction)
            && matches!(one.what, Approximated::UnknownCount { .. }))
    });
    for choice in taken {
        if let (Some(indexed), Some(stretches)) =
            (program.indexed.get_mut(&choice), reached.get(&choice))
        {
            indexed.proved.clone_from(stretches);
        }
    }
    program.limited_counts.append(&mut counted);
    loops::without_unreached(program, &found.unreached);
    loops::lower(program, &found.iterations);
}

/// Whether the abstract interpretation can compute the operation: with every word 1 as input, it knows more than any
/// value of at least one word of the result.
#[must_use]
pub fn follows(program: &Program, meaning: &Meaning) -> bool {
    let mut cells = BTreeSet::new();
    ChoiceKind::Exact(Box::new(meaning.clone())).each_word(&mut |word| {
        if let WordSource::Cell(cell) = word {
            cells.insert(cell);
        }
    });
    let words = Slots::of(cells.into_iter().collect());
    let known = vec![Value::constant(1); words.cells().len()];
    let followed = Tracked::of(program, words, Slots::of(Vec::new()));
    let state = followed.holding(known);
    let stamp = std::cell::Cell::new(0);
    let evaluation =
        Evaluation { program, followed: &followed, state: &state, holds: &[], stamp: &stamp };
    let results = evaluation.operation(meaning);
    results.is_some_and(|all| all.iter().flatten().any(|word| *word != Value::TOP))
}
