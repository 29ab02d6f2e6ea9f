//! Values on which the bound depends and about which little is known: counts, and targets of writes. Each comes with a
//! fact to state.

use scanbound_base::facts::Facts;
use scanbound_base::location::Location;
use scanbound_base::time::{Picos, Times};
use scanbound_ir::meaning::ChoiceKind;
use scanbound_ir::{Approximated, Counted, Program, Step, WordSource};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A word is listed if its iterations or units take at least the bound divided by this.
const SMALLEST: u64 = 1000;

/// A number of iterations or units whose range is known is listed only if it may still be this large.
const WIDE: i64 = 1000;

/// The largest value of the range that a suggested line states for an index.
pub(super) const INDEX: i64 = 99;

/// The largest number of words that are named as the origin of an index.
const MAX_ORIGINS: usize = 4;

/// A value on which the bound depends, about which nothing or little is known, and which the user can state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// The name of the word that holds the unknown value. If no word holds it: an operand or the text of the
    /// instruction, `index bits` or `indirect addresses`.
    pub word: Arc<str>,
    /// The places where the value matters, with the instructions there. For a count: the longest time first; for
    /// others: in the order of the scan. At least one.
    pub places: Vec<(Location, Arc<str>)>,
    /// What the value is used for.
    pub kind: UnknownKind,
    /// The key of the value in a facts file: a place, or the word if several places read a number from it.
    pub key: String,
    /// The line that states the value in a facts file, with a number that the user replaces.
    pub fact: String,
}

/// What an unknown value is used for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UnknownKind {
    /// A number of iterations or units.
    Count(Counts),
    /// The index of a write: the write is assumed to change any device of its area. The words are those whose values at
    /// the start of the scan the index may be.
    Index(Vec<String>),
    /// Whether an index to file registers has 16 or 32 bits: a parameter of the CPU.
    IndexBits,
    /// The devices that the program writes through indirect addresses (`@`): any are assumed.
    Indirect,
}

/// The number of iterations or units that is assumed where it is unknown, and the time that depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    /// The largest number that is assumed.
    pub most: i64,
    /// The largest time of one iteration or unit, added up over all places that read the word.
    pub each: Picos,
    /// The largest time of all iterations or units, over all executions of the instructions; at most the bound.
    pub cost: Picos,
}

impl Unknown {
    /// The table of the facts file in which the value can be stated.
    #[must_use]
    pub fn table(&self) -> &'static str {
        match self.kind {
            UnknownKind::Count(_) => "counts",
            UnknownKind::Index(_) | UnknownKind::IndexBits | UnknownKind::Indirect => "index",
        }
    }

    /// The assumed number, and its time. `None` if the value is not a number of iterations or units.
    #[must_use]
    pub fn counts(&self) -> Option<&Counts> {
        match &self.kind {
            UnknownKind::Count(counts) => Some(counts),
            _ => None,
        }
    }

    /// The words whose start values an index may have, as the end of a sentence. Empty if they are unknown, or the
    /// value is not an index.
    #[must_use]
    pub fn origin(&self) -> String {
        match &self.kind {
            UnknownKind::Index(from) if !from.is_empty() => {
                let more = if from.len() > MAX_ORIGINS { " and others" } else { "" };
                let from: Vec<&str> = from.iter().map(String::as_str).take(MAX_ORIGINS).collect();
                format!(", from the value of {} at the start of the scan{more}", from.join(", "))
            }
            _ => String::new(),
        }
    }

    /// Whether the value is a number of iterations or units, or an index, so that a limit can be stated for it.
    pub(super) fn is_number(&self) -> bool {
        matches!(self.kind, UnknownKind::Count(_) | UnknownKind::Index(_))
    }

    /// The line for the facts file that limits the value to `most`. If the value is not a number: the suggested line.
    pub(super) fn stated(&self, most: u32) -> String {
        match self.is_number() {
            true => format!("{:?} = [0, {most}]", self.key),
            false => self.fact.clone(),
        }
    }

    /// Adds to the facts that the value is at most `most`, if it is a number. For the bits of an index: 16 is stated.
    /// For indirect addresses, nothing.
    pub(super) fn state(&self, facts: &mut Facts, most: u32) {
        let range = (0, i64::from(most));
        match self.kind {
            UnknownKind::Count(_) => _ = facts.counts.insert(self.key.clone(), range),
            UnknownKind::Index(_) => _ = facts.indices.insert(self.key.clone(), range),
            // The other value is a rare setting of the CPU.
            UnknownKind::IndexBits => facts.index_bits = Some(16),
            UnknownKind::Indirect => {}
        }
    }
}

/// A number of iterations or units at one place, before those of the same word are combined.
struct CountAtPlace {
    word: Arc<str>,
    places: Vec<(Location, Arc<str>)>,
    counts: Counts,
}

impl Unknown {
    /// The unknown numbers of iterations and units on which a bound depends, the longest time first. Those that take
    /// less than a thousandth of the bound `upper` are left out. `times` is parallel to the program's instructions.
    pub(super) fn counted(program: &Program, times: &[Times], upper: Picos) -> Vec<Unknown> {
        let mut costs = Costs { program, times, routines: BTreeMap::new() };
        let unknown = program.approximations.iter().filter_map(|one| match &one.what {
            Approximated::UnknownCount { word, most, .. } => {
                Some((one.instruction, (word.clone(), *most)))
            }
            _ => None,
        });
        let unknown: BTreeMap<usize, (Arc<str>, i64)> = unknown.collect();
        let found = (0..program.instructions.len()).filter_map(|at| {
            let instruction = &program.instructions[at];
            if program.stated_counts.contains_key(&at) {
                return None;
            }
            let (word, taken) = match unknown.get(&at) {
                Some(told) => told.clone(),
                None => (word(program, at)?, 0),
            };
            let (most, cost) = costs.counted(at, taken)?;
            // A known limit of a count may still be far above its real value.
            if !unknown.contains_key(&at) && most < WIDE {
                return None;
            }
            let each = Picos(cost.0 / most.max(1).unsigned_abs());
            let places = vec![(instruction.place, instruction.text.clone())];
            Some(CountAtPlace { word, places, counts: Counts { most, each, cost } })
        });
        let mut found: Vec<CountAtPlace> = found.collect();
        found.sort_by_key(|one| (std::cmp::Reverse(one.counts.cost), one.places[0].0));
        found.dedup_by_key(|one| one.places[0].0);
        let mut words: Vec<CountAtPlace> = Vec::new();
        let mut known: BTreeMap<Arc<str>, usize> = BTreeMap::new();
        for one in found {
            let at = *known.entry(one.word.clone()).or_insert(words.len());
            match words.get_mut(at) {
                None => words.push(one),
                Some(word) => {
                    word.places.extend(one.places);
                    word.counts = Counts {
                        most: word.counts.most.max(one.counts.most),
                        each: plus(word.counts.each, one.counts.each),
                        cost: plus(word.counts.cost, one.counts.cost),
                    };
                }
            }
        }
        words.retain(|one| one.counts.cost.0 >= upper.0.div_ceil(SMALLEST).max(1));
        words.sort_by_key(|one| (std::cmp::Reverse(one.counts.cost), one.places[0].0));
        let unknown = |CountAtPlace { word, places, counts }: CountAtPlace| {
            let key = match places[..] {
                [(at, _)] => key(program, at),
                _ => word.to_string(),
            };
            // The time of a count cannot exceed the bound.
            let counts = Counts { cost: counts.cost.min(upper), ..counts };
            // A quoted name: the escapes of Rust are valid in TOML, too.
            let fact = format!("{key:?} = [0, 20]");
            Unknown { word, places, kind: UnknownKind::Count(counts), key, fact }
        };
        words.into_iter().map(unknown).collect()
    }
}

/// The name of the word from which an instruction reads its number of iterations or units, or the instruction's last
/// operand if no cell holds the number. `None` if the number is constant or the instruction has none.
pub(super) fn word(program: &Program, at: usize) -> Option<Arc<str>> {
    let instruction = &program.instructions[at];
    let count = match &instruction.step {
        Step::ForBegin { count, .. } => Some(*count),
        Step::Summary(summary) => summary.iterations.map(|(count, ..)| count),
        _ => instruction.counted().and_then(|counted| counted.words.first().copied()),
    };
    let count = match count? {
        WordSource::Free(choice) => match program.kinds.get(&choice) {
            Some(ChoiceKind::Iterations(word) | ChoiceKind::UnsignedIterations(word)) => *word,
            _ => WordSource::Free(choice),
        },
        count => count,
    };
    match count {
        WordSource::Const(_) => None,
        WordSource::Cell(cell) => Some(program.cell_name(cell).into()),
        _ => Some(instruction.text.split_whitespace().last()?.into()),
    }
}

/// The key for a place of the program in a facts file: `FILE:LINE`, with the file's directory only if two files have
/// the same name.
pub(super) fn key(program: &Program, at: Location) -> String {
    let whole = |index: usize| program.files.get(index).map_or("", |file| file.name.as_str());
    let last = |name: &'_ str| name.rsplit(['/', '\\']).next().map_or(0, str::len);
    let file = whole(at.file as usize);
    let short = &file[file.len() - last(file)..];
    let alike = (0..program.files.len())
        .filter(|&other| whole(other)[whole(other).len() - last(whole(other))..] == *short)
        .count();
    let file = if alike == 1 { short } else { file };
    format!("{file}:{}", at.line)
}

/// Upper bounds on the times of parts of a program, in which every instruction takes its larger time.
struct Costs<'a> {
    program: &'a Program,
    times: &'a [Times],
    /// For each routine, by its first instruction, its time. Zero while the time is being computed.
    routines: BTreeMap<usize, Picos>,
}

impl Costs<'_> {
    /// The largest number of iterations or units of an instruction, and the time of that many. `most` is the number for
    /// an instruction that reads none from a word; its time is then that of the whole instruction. `None` for a summary
    /// without a number of iterations.
    fn counted(&mut self, at: usize, most: i64) -> Option<(i64, Picos)> {
        match &self.program.instructions[at].step {
            Step::ForBegin { most, end, .. } => {
                let iteration = self.span(at + 1, end + 1);
                Some((i64::from(*most), times(iteration, u64::from(*most))))
            }
            Step::Summary(summary) => {
                let (.., most) = summary.iterations?;
                Some((i64::from(most), self.summary(&summary.charges)))
            }
            _ => {
                let per_unit = self.times[at].per_unit;
                match self.program.instructions[at].counted() {
                    Some(counted) => {
                        let cost = times(per_unit, counted.most_units());
                        Some((i64::try_from(counted.most).unwrap_or(i64::MAX), cost))
                    }
                    // If the count is not in a word, its time is part of the instruction's own time.
                    None => Some((most, self.largest_time(at))),
                }
            }
        }
    }

    /// The time of a loop or routine that is not followed: its instructions, and how often each is charged.
    fn summary(&self, charges: &[(usize, u64)]) -> Picos {
        let all = charges.iter().map(|&(at, often)| times(self.largest_time(at), often));
        all.fold(Picos::ZERO, plus)
    }

    /// The longest time of one execution of an instruction.
    fn largest_time(&self, at: usize) -> Picos {
        let units = self.program.instructions[at].counted().map_or(0, Counted::most_units);
        self.times[at].with(units).max(self.times[at].off)
    }

    /// The time of a routine from its first instruction to the first return after it. 0 in a recursive call, and if no
    /// return follows.
    fn routine(&mut self, entry: usize) -> Picos {
        if let Some(&known) = self.routines.get(&entry) {
            return known;
        }
        self.routines.insert(entry, Picos::ZERO);
        let instructions = self.program.instructions.iter().enumerate().skip(entry);
        let end = instructions
            .filter(|(_, one)| matches!(one.step, Step::Return | Step::End))
            .map(|(at, _)| at)
            .next();
        let cost = end.map_or(Picos::ZERO, |end| self.span(entry, end + 1));
        self.routines.insert(entry, cost);
        cost
    }

    /// The time of a range of instructions, including its loops and calls.
    fn span(&mut self, from: usize, to: usize) -> Picos {
        let program = self.program;
        let (mut cost, mut at) = (Picos::ZERO, from);
        while at < to.min(program.instructions.len()) {
            cost = plus(cost, self.largest_time(at));
            let (more, next) = match &program.instructions[at].step {
                Step::ForBegin { most, end, .. } => {
                    (times(self.span(at + 1, end + 1), u64::from(*most)), end + 1)
                }
                Step::Summary(summary) => (self.summary(&summary.charges), summary.end + 1),
                Step::Call { target, .. } => (self.routine(*target), at + 1),
                _ => (Picos::ZERO, at + 1),
            };
            (cost, at) = (plus(cost, more), next);
        }
        cost
    }
}

fn plus(a: Picos, b: Picos) -> Picos {
    Picos(a.0.saturating_add(b.0))
}

fn times(a: Picos, n: u64) -> Picos {
    Picos(a.0.saturating_mul(n))
}
