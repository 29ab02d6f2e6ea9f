//! What words can hold where they count: abstract interpretation of the scan over intervals.
//!
//! A loop count, a block length or an index that stands in a word is worked out where it is used, over every way that
//! leads there: constants, moves, arithmetic, guards, results in a known range. Where an index has a range, what is
//! written by it is those cells and no more. The method is abstract interpretation (P. Cousot and R. Cousot: Abstract
//! interpretation: a unified lattice model for static analysis of programs, POPL 1977); its domain is in `ring`.
//!
//! Between scans anybody may write a word ([`Trust::None`]), or, of the words that count and those that they are worked
//! out from, those keep what this program wrote that it writes in every scan, whatever happens ([`Trust::Counts`]): a
//! least fixpoint over scans, from power-up.

mod condition;
mod evaluate;
mod ring;
mod run;
mod rungs;
mod slice;
mod slots;
mod state;
mod write;

use super::{Pass, Settings, loops};
use crate::program::{
    Approximated, Cell, ChoiceId, Program, Region, StartRange, Step, TrustedRange, Units, Write,
};
use ring::Ring;
use run::{Found, Run};
use slots::Slots;
use state::Followed;
use std::collections::{BTreeMap, BTreeSet};

/// So many scans follow each other until nothing new comes; what grows beyond some of them grows to an end.
const MOST_SCANS: usize = 12;
const EXACT_SCANS: usize = 4;
/// So many instructions are carried out in all of them.
const MOST_ACROSS: u64 = 3_000_000;
/// One part of so many of the time allowed is theirs: with the rest the scan is followed and searched.
const PARTS: u32 = 4;
/// So many instructions are carried out to find out which trusted words matter.
const MOST_REDUCING: u64 = 300_000;

/// What words can hold where they count bounds turns, units and indices.
pub const PASS: Pass = Pass {
    name: "bounding what words count",
    run: |program, settings| {
        narrow(program, settings);
        Ok(())
    },
};

/// Whose writes between scans are reckoned with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Trust {
    /// Anybody's, to every device.
    None,
    /// Anybody's, but to the words that serve as counts, lengths or indices, or that these are worked out from, and that
    /// the program writes in every scan.
    #[default]
    Counts,
}

impl Trust {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Trust::None => "none",
            Trust::Counts => "counts",
        }
    }
}

/// Takes into the program what its words can hold: fewer iterations and units, fewer cells that an index may reach. The
/// ranges of trusted words on which this rests are constraints on the scan's start then.
fn narrow(program: &mut Program, settings: &Settings<'_>) {
    let cut = |open: &str| {
        if let Some(budget) = settings.budget {
            budget.cut_part(PARTS, PASS.name, open);
        }
    };
    let is_over = || settings.budget.is_some_and(|budget| budget.reached_part(PARTS));
    let changing = program.volatile.clone();
    let words = Slots::of(slice::slice(program, &changing));
    if words.cells().is_empty() {
        return;
    }
    let bits = Slots::of(slice::contacts(program, &changing, &words));
    let followed = Followed::of(program, words, bits);
    let slots = &followed.words;
    let free = stated(program, slots);
    let mut run = Run::new(program, &followed, &is_over);
    let Ok(end) = run.scan(followed.holding(free.clone())) else {
        cut("counts are taken as up to what their words can hold");
        return;
    };
    let mut found = run.found;
    let mut kept = Vec::new();
    if let (Trust::Counts, Some(end)) = (settings.trust, &end) {
        let trusted: Vec<usize> = (0..slots.cells().len())
            .filter(|&slot| end.is_written(slot) && is_ours(program, slots.cells()[slot]))
            .collect();
        let over = across(program, &followed, &free, &trusted, &is_over);
        if over.is_none() {
            cut("no word is trusted to hold what this program wrote");
        }
        if let Some(over) = over.filter(|over| over.found != found) {
            let needed = needed(program, &followed, &free, over, &is_over);
            let range = |&slot: &usize| {
                let (low, high) = needed.start[slot].signed();
                TrustedRange { cell: slots.cells()[slot], low, high, written: Vec::new() }
            };
            kept = needed.trusted.iter().map(range).collect();
            found.closer(needed.found);
        }
    }
    writers(program, &mut kept);
    for TrustedRange { cell, low, high, .. } in &kept {
        program.ranges.push(StartRange { cells: vec![*cell], low: *low, high: *high });
    }
    program.trusted = kept;
    apply(program, &found);
}

/// What scans from power-up on keep to, where some words are trusted.
struct Kept {
    /// These words of which then more is known than that they hold anything, by slot.
    trusted: Vec<usize>,
    /// What was found in any of the scans.
    found: Found,
    /// What the words hold when one starts.
    start: Vec<Ring>,
    /// What it took, in instructions.
    work: u64,
}

/// The same with as few trusted words as it takes, as far as there is time to find out: many at once are left out, then
/// fewer.
fn needed(
    program: &Program,
    followed: &Followed,
    free: &[Ring],
    all: Kept,
    is_over: &dyn Fn() -> bool,
) -> Kept {
    let mut kept = all;
    let mut work = 0;
    let mut many = kept.trusted.len().div_ceil(2);
    while many > 0 {
        let mut from = 0;
        while from < kept.trusted.len() {
            work += kept.work;
            if work > MOST_REDUCING {
                return kept;
            }
            let to = (from + many).min(kept.trusted.len());
            let fewer = [&kept.trusted[..from], &kept.trusted[to..]].concat();
            match across(program, followed, free, &fewer, is_over) {
                Some(less) if less.found == kept.found => {
                    // What is left before `from` stays needed.
                    from = from.min(less.trusted.len());
                    kept = less;
                }
                _ => from = to,
            }
        }
        many /= 2;
    }
    kept
}

/// What is known of the words when a scan starts, whoever wrote them: what the user states.
fn stated(program: &Program, slots: &Slots) -> Vec<Ring> {
    let mut start = vec![Ring::TOP; slots.cells().len()];
    for range in &program.ranges {
        if let [cell] = range.cells[..]
            && let Some(slot) = slots.slot(cell)
            && let Some(value) = start[slot].within(true, range.low, range.high)
        {
            start[slot] = value;
        }
    }
    start
}

/// Whether nobody but the program has reason to write a word, which is 0 at power-up.
fn is_ours(program: &Program, cell: Cell) -> bool {
    let holds = |region: &Region| region.holds(cell);
    program.power_up.cleared.iter().any(holds)
        && !program.power_up.inputs.iter().any(holds)
        && !program.networks.iter().any(|(region, _)| region.holds(cell))
}

/// The least fixpoint over scans from power-up. `None` if it is not come by, or a scan has no end.
fn across(
    program: &Program,
    followed: &Followed,
    free: &[Ring],
    trusted: &[usize],
    is_over: &dyn Fn() -> bool,
) -> Option<Kept> {
    let mut start = free.to_vec();
    for &slot in trusted {
        // Stated ranges hold for every start.
        start[slot] = Ring::constant(0);
    }
    let mut work = 0;
    for scan in 0..MOST_SCANS {
        let mut run = Run::new(program, followed, is_over);
        run.scan(followed.holding(start.clone())).ok()??;
        work += run.work;
        let mut next = start.clone();
        for &slot in trusted {
            // A latched word may hold what stood there in the midst of a scan, when the power failed.
            let Some(value) = run.written[slot] else { continue };
            next[slot] = match scan {
                0..EXACT_SCANS => next[slot].join(value),
                _ => next[slot].widen(value),
            };
        }
        if next == start {
            let mut trusted = trusted.to_vec();
            trusted.retain(|&slot| start[slot] != Ring::TOP);
            return Some(Kept { trusted, found: run.found, start, work });
        }
        // Without a fixpoint nothing is trusted.
        if work > MOST_ACROSS {
            return None;
        }
        start = next;
    }
    None
}

/// Notes who writes the words, as evidence.
fn writers(program: &Program, kept: &mut [TrustedRange]) {
    let place: BTreeMap<Cell, usize> =
        kept.iter().enumerate().map(|(place, one)| (one.cell, place)).collect();
    for at in 0..program.instructions.len() {
        for region in crate::program::flow::written(program, at) {
            if let Region::Range { first, count } = region {
                let end = Cell { index: first.index.saturating_add(count), ..first };
                for (_, &place) in place.range(first..end) {
                    kept[place].written.push(at);
                }
            }
        }
    }
}

/// Puts into the program what was found.
fn apply(program: &mut Program, found: &Found) {
    let points = points(program);
    let reach = |choice: ChoiceId, region: Region| match found.reaches.get(&choice) {
        // Beyond the last device that the program names there may be none, and the CPU may do otherwise.
        Some(&Some((low, high))) => {
            let area = match region {
                Region::Area(area) => area,
                Region::Range { first, .. } => first.area,
                Region::Everything => return None,
            };
            points.get(&area.0).filter(|&&points| high < points)?;
            let first = Cell { area, index: low };
            Some(Region::Range { first, count: high - low + 1 })
        }
        _ => None,
    };
    let mut counted: BTreeSet<usize> = BTreeSet::new();
    for (at, instruction) in program.instructions.iter_mut().enumerate() {
        for effect in &mut instruction.effects {
            if let Write::Havoc(region, choice) = &mut effect.write
                && let Some(closer) = reach(*choice, *region)
            {
                *region = closer;
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
    loops::lower(program, &found.turns);
}

/// How many devices of each area there are at least: up to the last that the program names.
fn points(program: &Program) -> BTreeMap<u16, u32> {
    let mut points: BTreeMap<u16, u32> = BTreeMap::new();
    let mut name = |cell: Cell| {
        let known = points.entry(cell.area.0).or_default();
        *known = (*known).max(cell.index.saturating_add(1));
    };
    for instruction in &program.instructions {
        instruction.each_read(&mut |source| {
            use crate::program::{BitSource, Source, WordSource};
            match source {
                Source::Bit(BitSource::Cell(cell) | BitSource::WordBit(cell, _))
                | Source::Word(WordSource::Cell(cell)) => name(cell),
                Source::Word(WordSource::Bits { first, count }) => {
                    name(first.plus(u32::from(count) - 1));
                }
                _ => {}
            }
        });
        for effect in &instruction.effects {
            for region in crate::program::flow::written_by(&effect.write) {
                if let Region::Range { first, .. } = region {
                    name(first);
                }
            }
        }
    }
    program.indexed.values().for_each(|indexed| name(indexed.first));
    points
}
