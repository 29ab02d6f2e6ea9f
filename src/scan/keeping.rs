//! What a bound rests on besides the program, asked of the scan itself: that scans keep words in their ranges and relays
//! apart, and that nothing counts or reaches further than was found.

use super::fit::SizeLimits;
use super::memory::Memory;
pub use super::watch::Breach;
use super::watch::Watch;
use super::word::Word;
use super::{Run, ScanError, Settings, held, number, run};
use crate::base::time::{Picos, Times};
use crate::program::{ChoiceId, Effect, Indexed, Length, Program, Step, WordSource, Write};
use crate::scan::model::{Charge, Lit, ScanModel};

/// The scan's model with what breaks something in place of what costs: a charge for each.
///
/// # Errors
/// If it grows beyond the limits.
pub fn scan_model_keeping(
    program: &Program,
    times: &[Times],
    limits: &SizeLimits<'_>,
) -> Result<(ScanModel, Vec<Breach>), ScanError> {
    let settings = Settings::of_upper_bounds(times, limits);
    let watch = Some(Box::new(Watch::of(program)));
    let end = |memory: &mut Memory<'_>| breaches(program, memory);
    let (mut model, found) = run(program, settings, watch, end)?;
    let charge = |(breach, happens): &(Breach, Lit)| Charge {
        instruction: match *breach {
            Breach::Count(at) | Breach::Reach(at) => at,
            Breach::Word(_) | Breach::All(_) => 0,
        },
        frames: Vec::new(),
        reached: *happens,
        fires: *happens,
        on: Picos(1),
        off: Picos(1),
        counted: None,
    };
    model.charges = found.iter().map(charge).collect();
    Ok((model, found.into_iter().map(|(breach, _)| breach).collect()))
}

/// All that may be broken, each with where it is.
fn breaches(program: &Program, memory: &mut Memory<'_>) -> Vec<(Breach, Lit)> {
    let mut all = memory.watch.take().map(|watch| watch.found()).unwrap_or_default();
    for apart in &program.apart {
        for bits in apart.never() {
            let on: Vec<Lit> = bits.iter().map(|&bit| held(memory, bit)).collect();
            let happens = memory.circuit().all(on);
            all.insert(Breach::All(bits), happens);
        }
    }
    // What is summarised is not followed, so nothing was asked there.
    let summaries = program.instructions.iter().filter_map(|one| match &one.step {
        Step::Summary(summary) => Some(summary),
        _ => None,
    });
    for &(at, _) in summaries.flat_map(|summary| &summary.charges) {
        if program.narrowed.contains(&at) {
            all.insert(Breach::Count(at), Lit::TRUE);
        }
        let is_found = |effect: &Effect| match &effect.write {
            Write::Havoc(_, choice) => {
                program.indexed.get(choice).is_some_and(|indexed| !indexed.found.is_empty())
            }
            _ => false,
        };
        if program.instructions[at].effects.iter().any(is_found) {
            all.insert(Breach::Reach(at), Lit::TRUE);
        }
    }
    all.into_iter().collect()
}

impl Run<'_> {
    fn note(&mut self, breach: Breach, happens: Lit) {
        if let Some(watch) = &mut self.memory.watch {
            watch.note(&mut self.memory.model.circuit, breach, happens);
        }
    }

    /// A loop begins that makes at most so many iterations.
    pub(super) fn note_iterations(
        &mut self,
        reached: Lit,
        at: usize,
        count: WordSource,
        most: u32,
    ) {
        if self.memory.watch.is_none() || !self.program.narrowed.contains(&at) {
            return;
        }
        let (count, is_signed) = self.count(count);
        let least = if is_signed { i16::MIN.into() } else { 0 };
        let count = self.word(count, at);
        let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
        let within = number::within(words, circuit, &[count], is_signed, least, most.into());
        let more = circuit.and(reached, !within);
        self.note(Breach::Count(at), more);
    }

    /// More units are counted than the most that were found.
    pub(super) fn note_units(&mut self, at: usize, over: Lit) {
        if self.program.narrowed.contains(&at) {
            self.note(Breach::Count(at), over);
        }
    }

    /// Something is written by an index, where this holds.
    pub(super) fn note_reach(&mut self, guard: Lit, choice: ChoiceId, at: usize) {
        let program = self.program;
        if self.memory.watch.is_none() {
            return;
        }
        let Some(indexed) = program.indexed.get(&choice) else { return };
        if indexed.found.is_empty() {
            return;
        }
        let mut inside = Lit::FALSE;
        for &(least, largest) in &indexed.found {
            let within = self.is_inside(indexed, least, largest, at);
            inside = self.memory.circuit().or(inside, within);
        }
        let beyond = self.memory.circuit().and(guard, !inside);
        self.note(Breach::Reach(at), beyond);
    }

    /// Whether what is written by an index surely lies between two cells of its area.
    fn is_inside(&mut self, indexed: &Indexed, least: u32, largest: u32, at: usize) -> Lit {
        let first = i64::from(indexed.first.index);
        let (low, high) = (i64::from(least) - first, i64::from(largest) - first);
        let constant =
            |words: &[WordSource]| words.iter().all(|word| *word == WordSource::Const(0));
        match indexed.length {
            Length::Exactly(count) => {
                let high = high - (i64::from(count) - 1).max(0);
                let mut all = Lit::TRUE;
                for reading in &indexed.readings {
                    let index: Vec<Word> =
                        reading.iter().map(|word| self.word(*word, at)).collect();
                    let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
                    let mut holds = number::within(words, circuit, &index, true, low, high);
                    if let Some((least, largest)) = indexed.stated {
                        let stated = number::within(words, circuit, &index, true, least, largest);
                        holds = circuit.or(holds, !stated);
                    }
                    all = circuit.and(all, holds);
                }
                all
            }
            Length::Counted(word, unit)
                if low <= 0 && indexed.readings.iter().all(|one| constant(one)) =>
            {
                let count = self.word(word, at);
                let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
                let most = (high + 1) / i64::from(unit.max(1));
                number::within(words, circuit, &[count], false, 0, most)
            }
            // An index and a count together are not asked for.
            Length::Counted(..) | Length::Unknown => Lit::FALSE,
        }
    }
}
