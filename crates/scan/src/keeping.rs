//! What a bound rests on besides the program, asked of the scan itself: that scans keep words in their ranges and relays
//! apart, and that nothing counts or reaches further than was found.

use super::fit::SizeLimits;
use super::memory::Memory;
use super::run::Run;
use super::settings::{Purpose, ScanError, Settings};
pub use super::watch::Breach;
use super::watch::Watch;
use super::word::Word;
use super::{held, number, run};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{
    BitTarget, Cell, ChoiceId, Effect, Indexed, Length, Program, StartRange, Step, WordSource,
    Write,
};
use scanbound_model::{Atom, Charge, Lit, Origin, ScanModel, VarId};

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

/// Something that is stated to hold whenever a scan starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Stays {
    /// A number of these words, least first, is in a range.
    Within(Vec<Cell>, i64, i64),
    /// No two of these bits are on.
    Apart(Vec<BitTarget>),
}

/// What may become of it in a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stay {
    /// It does not hold when the scan ends.
    pub ends: Lit,
    /// It does not hold then or, of a single word, may not have held at some moment before: if the power fails then, that
    /// is what a latched word is left with.
    pub breaks: Lit,
    /// For each of its bits, or its number: it was off or 0 when the scan started, and is not when it ends.
    pub moves: Vec<Lit>,
}

/// A scan's model, without its charges, and what may become of each of these.
///
/// # Errors
/// The same.
pub fn scan_model_staying(
    program: &Program,
    times: &[Times],
    (knowledge, purpose): (&Knowledge, Purpose),
    limits: &SizeLimits<'_>,
    all: &[Stays],
) -> Result<(ScanModel, Vec<Stay>), ScanError> {
    let settings = Settings { times, knowledge, purpose, limits };
    let single = |(place, one): (usize, &Stays)| match one {
        Stays::Within(cells, low, high) => {
            let (cells, low, high) = (cells.clone(), *low, *high);
            Some((place, StartRange { cells, low, high, values: Vec::new() }))
        }
        Stays::Apart(_) => None,
    };
    let watch = Watch::of_words(all.iter().enumerate().filter_map(single));
    let end = |memory: &mut Memory<'_>| {
        let watched = memory.watch.take().map(|watch| watch.found()).unwrap_or_default();
        let stay = |(place, one): (usize, &Stays)| {
            let mut found = stay(memory, one);
            let forgets = |cell: &Cell| program.power_up.forgets(*cell);
            if matches!(one, Stays::Within(cells, ..) if !cells.iter().all(forgets)) {
                // What is not watched may be anything by then.
                let midst = watched.get(&Breach::Word(place)).copied().unwrap_or(Lit::TRUE);
                found.breaks = memory.circuit().or(found.ends, midst);
            }
            found
        };
        all.iter().enumerate().map(stay).collect()
    };
    let (mut model, found) = run(program, settings, Some(Box::new(watch)), end)?;
    model.charges.clear();
    Ok((model, found))
}

fn stay(memory: &mut Memory<'_>, one: &Stays) -> Stay {
    match one {
        Stays::Within(cells, low, high) => {
            let end: Vec<Word> = cells.iter().map(|&cell| memory.read_word(cell)).collect();
            let start: Option<Vec<Word>> =
                cells.iter().map(|&cell| started(memory, cell)).collect();
            let Memory { words, model, .. } = memory;
            let circuit = &mut model.circuit;
            let ends = !number::within(words, circuit, &end, true, *low, *high);
            let mut moves = !number::within(words, circuit, &end, true, 0, 0);
            if let Some(start) = start {
                let was_zero = number::within(words, circuit, &start, true, 0, 0);
                moves = circuit.and(was_zero, moves);
            }
            Stay { ends, breaks: ends, moves: vec![moves] }
        }
        Stays::Apart(bits) => {
            let end: Vec<Lit> = bits.iter().map(|&bit| held(memory, bit)).collect();
            let moves = bits.iter().zip(&end).map(|(&bit, &end)| {
                let was_on = bit_started(memory, bit);
                memory.circuit().and(!was_on, end)
            });
            let moves = moves.collect();
            let (mut any, mut two) = (Lit::FALSE, Lit::FALSE);
            for one in end {
                let both = memory.circuit().and(any, one);
                two = memory.circuit().or(two, both);
                any = memory.circuit().or(any, one);
            }
            Stay { ends: two, breaks: two, moves }
        }
    }
}

/// The variable that is a cell's value when the scan starts; none where the scan never asks for it.
fn start_of(memory: &Memory<'_>, cell: Cell) -> Option<VarId> {
    let at = memory.model.variables.iter().position(|one| one.origin == Origin::Start(cell))?;
    u32::try_from(at).ok().map(VarId)
}

/// The word that the scan started with.
fn started(memory: &mut Memory<'_>, cell: Cell) -> Option<Word> {
    start_of(memory, cell).map(|variable| memory.words.free(variable))
}

/// Whether a bit was on when the scan started; where nothing depends on that, it was not.
fn bit_started(memory: &mut Memory<'_>, bit: BitTarget) -> Lit {
    match bit {
        BitTarget::Cell(cell) => match start_of(memory, cell) {
            Some(variable) => memory.circuit().atom(Atom::Bit(variable)),
            None => Lit::FALSE,
        },
        BitTarget::WordBit(cell, bit) => match started(memory, cell) {
            Some(word) => memory.words.bits(&mut memory.model.circuit, word)[usize::from(bit)],
            None => Lit::FALSE,
        },
    }
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
