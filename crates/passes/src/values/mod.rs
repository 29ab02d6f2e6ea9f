//! What words can hold where they count: abstract interpretation of the scan over ranges with strides and small sets.
//!
//! A loop count, a block length or an index that stands in a word is worked out where it is used, over every way that
//! leads there: constants, moves, arithmetic, guards, results in a known range. Where an index has a range, what is
//! written by it is those cells and no more. The method is abstract interpretation (P. Cousot and R. Cousot: Abstract
//! interpretation: a unified lattice model for static analysis of programs, POPL 1977); its domain is in `value`.
//!
//! Between scans anybody may write a word ([`Trust::None`]), or, of the words that count and those that they are worked
//! out from, those keep what this program wrote that it writes in every scan, whatever happens ([`Trust::Counts`]): a
//! least fixpoint over scans, from power-up.

mod across;
mod condition;
mod evaluate;
mod integers;
mod limits;
mod reach;
mod run;
mod rungs;
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
use across::{Across, Kept};
use evaluate::Evaluation;
use reach::Reach;
use run::{Found, Run};
use scanbound_ir::meaning::{ChoiceKind, Meaning};
use scanbound_ir::{
    Approximated, BitSource, Cell, ChoiceId, Effect, Program, Region, Source, StartRange, Step,
    TrustedRange, Units, WordSource, Write,
};
use slots::Slots;
use state::Followed;
use std::collections::{BTreeMap, BTreeSet};
use value::Value;

/// One part of so many of the time allowed is theirs: with the rest the scan is followed and searched.
const PARTS: u32 = 4;

/// What words can hold where they count bounds turns, units and indices.
pub const PASS: Pass = Pass {
    name: "bounding what words count",
    run: |program, settings| {
        narrow(program, settings);
        Ok(())
    },
};

/// Takes into the program what its words can hold: fewer iterations and units, fewer cells that an index may reach. The
/// ranges of trusted words on which this rests are constraints on the scan's start then. What holds where less is trusted
/// holds where more is, too: each kind of trust takes what is known closer.
fn narrow(program: &mut Program, settings: &Settings<'_>) {
    let mut known = Known::default();
    // Where nothing is stated to be the program's own, the words that count say the same without trust and with it.
    let first = match program.internal.is_empty() {
        true => settings.trust.min(Trust::Counts),
        false => Trust::None,
    };
    for trust in [Trust::None, Trust::Counts, Trust::All] {
        if (first..=settings.trust).contains(&trust) {
            known.closer(worked_out(program, trust, settings));
        }
    }
    program.kept = known.keeps;
    let mut kept: Vec<TrustedRange> = known.trusted.into_iter().map(of_word).collect();
    writers(program, &mut kept);
    for TrustedRange { cell, low, high, values, .. } in &kept {
        let (cells, low, high, values) = (vec![*cell], *low, *high, values.clone());
        program.ranges.push(StartRange { cells, low, high, values });
    }
    program.trusted = kept;
    if let Some(found) = known.found {
        apply(program, &found);
    }
}

/// What is known of a program's words.
#[derive(Default)]
struct Known {
    /// What a scan counts and reaches; none if no scan was followed.
    found: Option<Found>,
    /// What trusted words hold when a scan starts.
    trusted: BTreeMap<Cell, Value>,
    /// The stated words that the program keeps as stated.
    keeps: BTreeSet<Cell>,
}

impl Known {
    /// Takes what is known closer to what else is: both hold.
    fn closer(&mut self, other: Known) {
        match (&mut self.found, other.found) {
            (Some(found), Some(other)) => found.closer(other),
            (found, other) => *found = found.take().or(other),
        }
        for (cell, value) in other.trusted {
            let known = self.trusted.entry(cell).or_insert(value);
            *known = known.closer(value).as_start();
        }
        self.keeps.extend(other.keeps);
    }
}

/// What a trusted word holds when a scan starts.
fn of_word((cell, value): (Cell, Value)) -> TrustedRange {
    let (low, high) = value.signed();
    let values = value.apart().unwrap_or_default();
    TrustedRange { cell, low, high, values, written: Vec::new() }
}

/// What is known where this is trusted.
fn worked_out(program: &Program, trust: Trust, settings: &Settings<'_>) -> Known {
    let cut = |open: &str| {
        if let Some(budget) = settings.budget {
            budget.cut_part(PARTS, PASS.name, open);
        }
    };
    let is_over = || settings.budget.is_some_and(|budget| budget.reached_part(PARTS));
    let counting = slice::slice(program, &program.volatile, false);
    let words = match trust {
        Trust::Counts if program.internal.is_empty() => counting.clone(),
        Trust::Counts | Trust::All => slice::slice(program, &program.volatile, true),
        Trust::None => counting.clone(),
    };
    let words = Slots::of(words);
    if words.cells().is_empty() {
        return Known::default();
    }
    let bits = Slots::of(slice::contacts(program, &program.volatile, &words));
    let followed = Followed::of(program, words, bits);
    let slots = &followed.words;
    let free = stated(program, slots);
    let mut run = Run::new(program, &followed, &is_over);
    let Ok(end) = run.scan(followed.holding(free.clone())) else {
        cut("counts are taken as up to what their words can hold");
        return Known::default();
    };
    let keeps = keeps(program, slots, &run.written);
    let mut known = Known { found: Some(run.found), keeps, ..Known::default() };
    let Some(end) = end.filter(|_| trust != Trust::None) else { return known };
    let cell = |slot: usize| slots.cells()[slot];
    // What is stated not to be as at power-up somebody else set before the first scan.
    let at_first = |slot: usize| Value::constant(program.power_up.word(cell(slot)));
    let may_begin = |slot: usize| free[slot].holds(&at_first(slot));
    let ours: Vec<usize> = (0..slots.cells().len())
        .filter(|&slot| is_ours(program, cell(slot)) && may_begin(slot))
        .collect();
    let (alone, others): (Vec<usize>, Vec<usize>) =
        ours.into_iter().partition(|&slot| trust.holds_alone(program, cell(slot)));
    let counts = |slot: &usize| counting.binary_search(&cell(*slot)).is_ok();
    let others = others.into_iter().filter(|&slot| end.is_written(slot) && counts(&slot));
    let alone_always = alone.iter().copied().filter(|&slot| end.is_written(slot));
    let always: Vec<usize> = alone_always.chain(others.clone()).collect();
    let all: Vec<usize> = alone.iter().copied().chain(others).collect();
    let search = Across { program, followed: &followed, free: &free, always, is_over: &is_over };
    let over = search.of(&all);
    let fewer = all.len() > search.always.len();
    let over = over.or_else(|| fewer.then(|| search.of(&search.always)).flatten());
    let Some(mut over) = over else {
        cut("no word is trusted to hold what this program wrote");
        return known;
    };
    if trust == Trust::Counts {
        // What is stated to be the program's own tells which scans there are, not only what they count.
        over = match known.found.as_ref() == Some(&over.found) {
            true if alone.is_empty() => Kept::default(),
            true => search.of(&alone).unwrap_or_default(),
            false => search.needed(over, &alone),
        };
    }
    let found = Some(over.found);
    let trusted = over.trusted.iter().map(|&slot| (cell(slot), over.start[slot])).collect();
    known.closer(Known { found, trusted, ..Known::default() });
    known
}

/// What is known of the words when a scan starts, whoever wrote them: what the user states.
fn stated(program: &Program, slots: &Slots) -> Vec<Value> {
    let mut start = vec![Value::TOP; slots.cells().len()];
    for range in &program.ranges {
        if let [cell] = range.cells[..]
            && let Some(slot) = slots.slot(cell)
            && let Some(value) = start[slot].meet(Value::range(range.low, range.high))
        {
            start[slot] = value;
        }
    }
    start
}

/// The stated words of which what is stated holds at power-up and into which the program writes nothing else, from whatever
/// start keeps all of that. Not those of which it is known that others write them, as what the program only ever clears.
fn keeps(program: &Program, slots: &Slots, written: &[Option<Value>]) -> BTreeSet<Cell> {
    let is_kept = |range: &&StartRange| {
        let [cell] = range.cells[..] else { return false };
        let first = program.power_up.word(cell);
        let is_stated = (range.low..=range.high).contains(&first.cast_signed().into());
        if !is_ours(program, cell) || !is_stated {
            return false;
        }
        let written = slots.slot(cell).and_then(|slot| written[slot]);
        written.filter(|written| *written != Value::constant(first)).is_some_and(|written| {
            let (low, high) = written.signed();
            range.low <= low && high <= range.high
        })
    };
    // A word may be stated by two names.
    let (kept, others): (Vec<&StartRange>, Vec<&StartRange>) =
        program.ranges.iter().partition(is_kept);
    let other = |cell: &Cell| others.iter().any(|range| range.cells == [*cell]);
    kept.into_iter().map(|range| range.cells[0]).filter(|cell| !other(cell)).collect()
}

/// Whether nobody but the program has reason to write a cell, of which it is known what it holds at power-up.
///
/// What may change at any moment is named here so that nothing is said of it. No bound can rest on what is believed of it
/// either way: every read of it is any value (`passes::interrupts`).
#[must_use]
pub fn is_ours(program: &Program, cell: Cell) -> bool {
    let holds = |region: &Region| region.holds(cell);
    is_kept(program, cell) && !program.power_up.inputs.iter().any(holds)
}

/// The same of a cell of which it is known that it is no input.
#[must_use]
pub fn is_kept(program: &Program, cell: Cell) -> bool {
    let holds = |region: &Region| region.holds(cell);
    program.power_up.cleared.iter().any(holds)
        && !program.volatile.iter().any(holds)
        && !program.external.iter().any(holds)
        && (is_internal(program, cell)
            || !program.networks.iter().any(|(region, _)| region.holds(cell)))
}

/// Notes who writes the words, as evidence.
fn writers(program: &Program, kept: &mut [TrustedRange]) {
    let place: BTreeMap<Cell, usize> =
        kept.iter().enumerate().map(|(place, one)| (one.cell, place)).collect();
    for at in 0..program.instructions.len() {
        for region in scanbound_ir::flow::written(program, at) {
            if let Region::Range { first, count } = region {
                let end = Cell { index: first.index.saturating_add(count), ..first };
                for (_, &place) in place.range(first..end) {
                    kept[place].written.push(at);
                }
            }
        }
    }
}

/// The stretches of cells that writes by an index reach, each apart only where a word that is read lies between them.
fn stretches(program: &Program, found: &Found) -> BTreeMap<ChoiceId, Vec<(u32, u32)>> {
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

/// The cells that instructions read by their names.
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

/// Puts into the program what was found.
fn apply(program: &mut Program, found: &Found) {
    let indexed = &program.indexed;
    let reached = stretches(program, found);
    // Beyond the end of its area it reaches nothing, as README says of what is not modelled.
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
                let write = |&ends| Write::Havoc(indexed.stretch(ends), choice);
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
        if let (Some(most), Some(&known)) = (turns, found.turns.get(&at))
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
            indexed.found.clone_from(stretches);
        }
    }
    program.narrowed.append(&mut counted);
    loops::lower(program, &found.turns);
}

/// Whether a range of what an operation gives is worked out where its inputs are known.
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
    let followed = Followed::of(program, words, Slots::of(Vec::new()));
    let state = followed.holding(known);
    let stamp = std::cell::Cell::new(0);
    let evaluation =
        Evaluation { program, followed: &followed, state: &state, holds: &[], stamp: &stamp };
    let results = evaluation.operation(meaning);
    results.is_some_and(|all| all.iter().flatten().any(|word| *word != Value::TOP))
}
