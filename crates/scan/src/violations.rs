//! Checks what the bound assumes besides the program: that every scan keeps the trusted words in their ranges and the
//! exclusive bits exclusive, and that no count and no indexed write exceeds the range that was found.

use super::memory::Memory;
use super::run::Run;
use super::settings::{Purpose, ScanError, ScanSettings, SizeLimits};
pub use super::violation_log::Violation;
use super::violation_log::ViolationLog;
use super::word::Word;
use super::{is_on, number, run};
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::Knowledge;
use scanbound_ir::{
    BitTarget, Cell, ChoiceId, Effect, IndexedWrite, Length, Program, StartRange, Step, WordSource,
    Write,
};
use scanbound_model::{Atom, Charge, Lit, Origin, ScanModel, VarId};

/// The scan's model with violations in place of costs: one charge of 1 ps for each possible violation, which is reached
/// if the violation happens. Also returns the violations, in the order of the charges.
///
/// # Errors
/// As for [`scan_model_within`](crate::scan_model_within).
pub fn scan_model_of_violations(
    program: &Program,
    times: &[Times],
    limits: &SizeLimits<'_>,
) -> Result<(ScanModel, Vec<Violation>), ScanError> {
    let settings = ScanSettings::of_upper_bounds(times, limits);
    let watch = Some(Box::new(ViolationLog::of(program)));
    let end = |memory: &mut Memory<'_>| violations(program, memory);
    let (mut model, found) = run(program, settings, watch, end)?;
    let charge = |(violation, happens): &(Violation, Lit)| Charge {
        instruction: match *violation {
            Violation::Count(at) | Violation::Reach(at) => at,
            Violation::Word(_) | Violation::All(_) => 0,
        },
        frames: Vec::new(),
        reached: *happens,
        fires: *happens,
        on: Picos(1),
        off: Picos(1),
        counted: None,
    };
    model.charges = found.iter().map(charge).collect();
    Ok((model, found.into_iter().map(|(violation, _)| violation).collect()))
}

/// A statement that may hold in the state at the start of every scan, and is to be checked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Candidate {
    /// The signed number in these words, low word first, is in the range from the second to the third field
    /// (inclusive).
    Within(Vec<Cell>, i64, i64),
    /// At most one of these bits is on.
    Exclusive(Vec<BitTarget>),
}

/// In which scans a [`Candidate`] does not hold at the end or in mid-scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CandidateOutcome {
    /// The literal that says whether the statement is false at the end of the scan.
    pub violated_at_end: Lit,
    /// The literal that says whether the statement is false at the end or, for a range with a latched word, possibly at
    /// some moment before. If the power fails at that moment, a latched word keeps the value that it has then.
    pub violated: Lit,
    /// For each bit of the statement, or once for its number, the literal that it was off or 0 at the start of the scan
    /// and is not at the end. A start value on which the model does not depend counts as off or 0.
    pub changed: Vec<Lit>,
}

/// A scan's model without charges, and for each statement of `all`, in this order, how the scan may violate it.
///
/// # Errors
/// As for [`scan_model_of_violations`].
pub fn scan_model_of_candidates(
    program: &Program,
    times: &[Times],
    (knowledge, purpose): (&Knowledge, Purpose),
    limits: &SizeLimits<'_>,
    all: &[Candidate],
) -> Result<(ScanModel, Vec<CandidateOutcome>), ScanError> {
    let settings = ScanSettings { times, knowledge, purpose, limits };
    let single = |(place, one): (usize, &Candidate)| match one {
        Candidate::Within(cells, low, high) => {
            let (cells, low, high) = (cells.clone(), *low, *high);
            Some((place, StartRange { cells, low, high, values: Vec::new() }))
        }
        Candidate::Exclusive(_) => None,
    };
    let watch = ViolationLog::of_words(program, all.iter().enumerate().filter_map(single));
    let end = |memory: &mut Memory<'_>| {
        let watched = memory.watch.take().map(|watch| watch.into_violations()).unwrap_or_default();
        let stay = |(place, one): (usize, &Candidate)| {
            let mut found = stay(memory, one);
            let forgets = |cell: &Cell| program.power_up.is_lost_at_power_failure(*cell);
            if matches!(one, Candidate::Within(cells, ..) if !cells.iter().all(forgets)) {
                // The values of cells that are not watched are unknown during the scan.
                let midst = watched.get(&Violation::Word(place)).copied().unwrap_or(Lit::TRUE);
                found.violated = memory.circuit().or(found.violated_at_end, midst);
            }
            found
        };
        all.iter().enumerate().map(stay).collect()
    };
    let (mut model, found) = run(program, settings, Some(Box::new(watch)), end)?;
    model.charges.clear();
    Ok((model, found))
}

fn stay(memory: &mut Memory<'_>, one: &Candidate) -> CandidateOutcome {
    match one {
        Candidate::Within(cells, low, high) => {
            let end: Vec<Word> = cells.iter().map(|&cell| memory.read_word(cell)).collect();
            let start: Option<Vec<Word>> =
                cells.iter().map(|&cell| start_word(memory, cell)).collect();
            let Memory { words, model, .. } = memory;
            let circuit = &mut model.circuit;
            let ends = !number::within(words, circuit, &end, true, *low, *high);
            let mut moves = !number::within(words, circuit, &end, true, 0, 0);
            if let Some(start) = start {
                let was_zero = number::within(words, circuit, &start, true, 0, 0);
                moves = circuit.and(was_zero, moves);
            }
            CandidateOutcome { violated_at_end: ends, violated: ends, changed: vec![moves] }
        }
        Candidate::Exclusive(bits) => {
            let end: Vec<Lit> = bits.iter().map(|&bit| is_on(memory, bit)).collect();
            let moves = bits.iter().zip(&end).map(|(&bit, &end)| {
                let was_on = start_bit(memory, bit);
                memory.circuit().and(!was_on, end)
            });
            let moves = moves.collect();
            let (mut any, mut two) = (Lit::FALSE, Lit::FALSE);
            for one in end {
                let both = memory.circuit().and(any, one);
                two = memory.circuit().or(two, both);
                any = memory.circuit().or(any, one);
            }
            CandidateOutcome { violated_at_end: two, violated: two, changed: moves }
        }
    }
}

/// The variable of a cell's value at the start of the scan; `None` if the model has none, because nothing read it.
fn start_of(memory: &Memory<'_>, cell: Cell) -> Option<VarId> {
    let at = memory.model.variables.iter().position(|one| one.origin == Origin::Start(cell))?;
    u32::try_from(at).ok().map(VarId)
}

/// The value of a word at the start of the scan. `None` if the model does not depend on it.
fn start_word(memory: &mut Memory<'_>, cell: Cell) -> Option<Word> {
    start_of(memory, cell).map(|variable| memory.words.free(variable))
}

/// The literal that says whether a bit was on at the start of the scan; false if the model does not depend on it.
fn start_bit(memory: &mut Memory<'_>, bit: BitTarget) -> Lit {
    match bit {
        BitTarget::Cell(cell) => match start_of(memory, cell) {
            Some(variable) => memory.circuit().atom(Atom::Bit(variable)),
            None => Lit::FALSE,
        },
        BitTarget::WordBit(cell, bit) => match start_word(memory, cell) {
            Some(word) => memory.words.bits(&mut memory.model.circuit, word)[usize::from(bit)],
            None => Lit::FALSE,
        },
    }
}
/// All violations that were recorded, exclusive bits that end the scan together, and counts and indexed writes inside
/// summaries (which are not followed, so they always count); each with the literal that says whether it occurs.
fn violations(program: &Program, memory: &mut Memory<'_>) -> Vec<(Violation, Lit)> {
    let mut all = memory.watch.take().map(|watch| watch.into_violations()).unwrap_or_default();
    for apart in &program.mutually_exclusive {
        for bits in apart.forbidden_sets() {
            let on: Vec<Lit> = bits.iter().map(|&bit| is_on(memory, bit)).collect();
            let happens = memory.circuit().all(on);
            all.insert(Violation::All(bits), happens);
        }
    }
    // Counts and indices in summarised loops and routines were not checked, because these are not followed. So they
    // count as violations.
    let summaries = program.instructions.iter().filter_map(|one| match &one.step {
        Step::Summary(summary) => Some(summary),
        _ => None,
    });
    for &(at, _) in summaries.flat_map(|summary| &summary.charges) {
        if program.limited_counts.contains(&at) {
            all.insert(Violation::Count(at), Lit::TRUE);
        }
        let is_found = |effect: &Effect| match &effect.write {
            Write::Havoc(_, choice) => {
                program.indexed.get(choice).is_some_and(|indexed| !indexed.proved.is_empty())
            }
            _ => false,
        };
        if program.instructions[at].effects.iter().any(is_found) {
            all.insert(Violation::Reach(at), Lit::TRUE);
        }
    }
    all.into_iter().collect()
}

impl Run<'_> {
    fn note(&mut self, violation: Violation, happens: Lit) {
        if let Some(watch) = &mut self.memory.watch {
            watch.note(&mut self.memory.model.circuit, violation, happens);
        }
    }

    /// Records a violation if a loop whose limit the analysis found makes more than `most` iterations.
    pub(super) fn check_iterations(
        &mut self,
        reached: Lit,
        at: usize,
        count: WordSource,
        most: u32,
    ) {
        if self.memory.watch.is_none() || !self.program.limited_counts.contains(&at) {
            return;
        }
        let (count, is_signed) = self.count(count);
        let least = if is_signed { i16::MIN.into() } else { 0 };
        let count = self.word(count, at);
        let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
        let within = number::within(words, circuit, &[count], is_signed, least, most.into());
        let more = circuit.and(reached, !within);
        self.note(Violation::Count(at), more);
    }

    /// Records a violation under the literal `over`, which says that an instruction processes more units than the
    /// maximum that the analysis found; nothing if the analysis found none.
    pub(super) fn check_units(&mut self, at: usize, over: Lit) {
        if self.program.limited_counts.contains(&at) {
            self.note(Violation::Count(at), over);
        }
    }

    /// Records a violation if an indexed write, executed under `guard`, goes outside the cells that the analysis found.
    pub(super) fn check_reach(&mut self, guard: Lit, choice: ChoiceId, at: usize) {
        let program = self.program;
        if self.memory.watch.is_none() {
            return;
        }
        let Some(indexed) = program.indexed.get(&choice) else { return };
        if indexed.proved.is_empty() {
            return;
        }
        let mut inside = Lit::FALSE;
        for &(least, largest) in &indexed.proved {
            let within = self.is_inside(indexed, least, largest, at);
            inside = self.memory.circuit().or(inside, within);
        }
        let beyond = self.memory.circuit().and(guard, !inside);
        self.note(Violation::Reach(at), beyond);
    }

    /// A literal that implies that an indexed write stays between two cells of its area (inclusive). An index outside
    /// the range that the user stated counts as inside; a length that cannot be judged counts as outside.
    fn is_inside(&mut self, indexed: &IndexedWrite, least: u32, largest: u32, at: usize) -> Lit {
        let first = i64::from(indexed.first.index);
        let (low, high) = (i64::from(least) - first, i64::from(largest) - first);
        let constant =
            |words: &[WordSource]| words.iter().all(|word| *word == WordSource::Const(0));
        match indexed.length {
            Length::Exactly(count) => {
                let high = high - (i64::from(count) - 1).max(0);
                let mut all = Lit::TRUE;
                for reading in &indexed.indices {
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
                if low <= 0 && indexed.indices.iter().all(|one| constant(one)) =>
            {
                let count = self.word(word, at);
                let (words, circuit) = (&mut self.memory.words, &mut self.memory.model.circuit);
                let most = (high + 1) / i64::from(unit.max(1));
                number::within(words, circuit, &[count], false, 0, most)
            }
            // Not determined for lengths that are counted or unknown.
            Length::Counted(..) | Length::Unknown => Lit::FALSE,
        }
    }
}
