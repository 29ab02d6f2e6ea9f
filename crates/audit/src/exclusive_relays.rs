//! Exclusive relays: only the program writes them, so at the start of a scan they hold what the scan before left in
//! them.

use scanbound_ir::{
    AreaKind, BitSource, BitTarget, Cell, ChoiceKind, Logic, Number, Program, Region, Source,
    WordSource, WordTarget, Write,
};
use scanbound_passes::values::{Trust, is_unwritten_elsewhere};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Why the value of a relay at the start of a scan is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StartUnknown {
    /// According to `--trust`, other writers than the program may write the relay.
    NotTrusted,
    /// The relay is an input, or in a word of I/O points of which the program reads bits that it does not write.
    Input,
    /// The relay is latched: after a power failure it keeps the value that it had in the middle of a scan.
    Latched,
    /// Other writers write the relay: the facts state so, or the CPU, a network, a module or an interrupt may do so at
    /// any moment. Also if it is not known to be 0 at power-up.
    Others,
    /// No instruction of the program writes the relay as a single bit.
    NotWritten,
    /// An instruction writes a value into the relay, or into a region that contains it, that the analysis does not
    /// know.
    AnyValue,
}

impl fmt::Display for StartUnknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            StartUnknown::NotTrusted => {
                "other writers than the program may write the relay; if only the program writes the relay, state that with --trust all, or under [internal] in a facts file (--facts)"
            }
            StartUnknown::Input => {
                "the relay is an input, or shares a word of I/O points with bits that the program reads but does not write"
            }
            StartUnknown::Latched => "the relay is latched: after a power failure it keeps the value that it had in the middle of a scan",
            StartUnknown::Others => "other writers than the program may write the relay (the CPU, a network, a module, an interrupt, or those under [external]), or the relay may be on before the first scan ([ranges], its initial value, or power-up does not clear it)",
            StartUnknown::NotWritten => "no instruction of the program writes this relay individually",
            StartUnknown::AnyValue => "an instruction of the program writes to the relay a value that the analysis does not know",
        })
    }
}

/// An instruction that writes the result of an operation to a range of cells is taken to write each of them as a word
/// only if there are at most this many.
const LONGEST_RESULT: u32 = 64;

/// The most words of one number. An instruction that writes more words at once copies a block.
const LONGEST_NUMBER: usize = 4;

/// The relays of a program that only the program writes, so that it determines their values.
pub struct ExclusiveRelays<'p> {
    program: &'p Program,
    trust: Trust,
    /// The bits that instructions write as single bits.
    written: BTreeSet<BitTarget>,
    /// The bits of `written` into which an instruction writes a nondeterministic value.
    unknown: BTreeSet<BitTarget>,
    /// The words that instructions write as a whole.
    words: BTreeSet<Cell>,
    /// The words of `words` into which an instruction writes the result of an operation.
    computed: BTreeSet<Cell>,
    /// The upper words of numbers: each is written together with the word before it.
    upper: BTreeSet<Cell>,
    /// Regions that a module or network may write at any moment after an instruction has requested it.
    later: Vec<Region>,
    /// The words of I/O points that serve outputs: the program writes bits of them and reads no bit of them that it
    /// does not write.
    outputs: BTreeSet<Cell>,
}

impl<'p> ExclusiveRelays<'p> {
    /// Finds the exclusive relays of a program.
    #[must_use]
    pub fn of(program: &'p Program, trust: Trust) -> ExclusiveRelays<'p> {
        let mut exclusive = ExclusiveRelays {
            program,
            trust,
            written: BTreeSet::new(),
            unknown: BTreeSet::new(),
            words: BTreeSet::new(),
            computed: BTreeSet::new(),
            upper: BTreeSet::new(),
            later: Vec::new(),
            outputs: BTreeSet::new(),
        };
        for instruction in &program.instructions {
            for effect in &instruction.effects {
                match &effect.write {
                    Write::Bit(bit, value) => {
                        exclusive.written.insert(*bit);
                        if mentions_choice(value) {
                            exclusive.unknown.insert(*bit);
                        }
                    }
                    Write::Havoc(region, choice) => {
                        // Data that is delivered later is written at any moment after the request.
                        let at_once = program.indexed.contains_key(choice)
                            || matches!(program.kinds.get(choice), Some(ChoiceKind::Exact(_)));
                        match *region {
                            _ if !at_once => exclusive.later.push(*region),
                            Region::Range { first, count } if count <= LONGEST_RESULT => {
                                exclusive.words.extend((0..count).map(|n| first.plus(n)));
                                exclusive.computed.extend((0..count).map(|n| first.plus(n)));
                            }
                            _ => {}
                        }
                    }
                    Write::Words(targets, number) => {
                        let words = || {
                            targets.iter().filter_map(|target| match *target {
                                WordTarget::Cell(cell) => Some(cell),
                                WordTarget::Bits { .. } | WordTarget::Discard => None,
                            })
                        };
                        exclusive.words.extend(words());
                        if targets.len() <= LONGEST_NUMBER {
                            let pairs = words().zip(words().skip(1));
                            let pairs = pairs.filter(|(word, next)| *next == word.plus(1));
                            exclusive.upper.extend(pairs.map(|(_, next)| next));
                        }
                        if number.words().any(|word| matches!(word, WordSource::Free(_))) {
                            exclusive.computed.extend(words());
                        }
                        if takes_any_value(program, number) {
                            exclusive.later.extend(targets.iter().filter_map(range));
                        }
                    }
                }
            }
        }
        exclusive.outputs = outputs(program, &exclusive.written);
        exclusive
    }

    /// Whether a cell is a word that serves outputs: the program writes bits of it, and reads only bits that it writes.
    #[must_use]
    pub fn is_output(&self, cell: Cell) -> bool {
        self.outputs.contains(&cell)
    }

    /// Whether a bit holds at the start of a scan what the scan before left, even if that scan wrote an unknown value
    /// to it, as timers do to their contacts. A latched bit may hold what an earlier run left.
    #[must_use]
    pub fn is_left_by_scan(&self, bit: BitTarget) -> bool {
        let cell = bit.cell();
        let is_own = self.is_own(cell).is_ok() || self.is_own_flag(cell);
        self.written.contains(&bit) && is_own && !self.is_written_later(cell)
    }

    /// As [`Self::is_left_by_scan`], of a word that the program writes as a whole.
    #[must_use]
    pub fn is_word_left_by_scan(&self, cell: Cell) -> bool {
        self.words.contains(&cell) && self.is_own(cell).is_ok() && !self.is_written_later(cell)
    }

    /// Whether this is an upper word of a number: an instruction writes it together with the word before it.
    #[must_use]
    pub fn is_upper_word(&self, cell: Cell) -> bool {
        self.upper.contains(&cell)
    }

    /// Whether an instruction writes a value to this bit that is not known before it is executed.
    #[must_use]
    pub fn takes_any_value(&self, bit: BitTarget) -> bool {
        self.unknown.contains(&bit) || self.computed.contains(&bit.cell())
    }

    /// Whether a cell is a flag of a timer or counter that nothing else writes, even if power-up does not clear it.
    fn is_own_flag(&self, cell: Cell) -> bool {
        let program = self.program;
        let within = |regions: &[Region]| regions.iter().any(|region| region.contains(cell));
        let mut flags = program.timekeeping.instructions.values().map(|timed| timed.flag);
        self.trust.trusts_exclusive_cell(program, cell)
            && flags.any(|flag| flag == cell)
            && !within(&program.volatile)
            && !within(&program.external)
    }

    fn is_written_later(&self, cell: Cell) -> bool {
        self.later.iter().any(|region| region.contains(cell))
    }

    /// Why the value of a bit at the start of a scan is unknown. `None` if it is a known value that the scan before
    /// left.
    #[must_use]
    pub fn start_unknown(&self, bit: BitTarget) -> Option<StartUnknown> {
        if let Err(unknown) = self.is_own(bit.cell()) {
            return Some(unknown);
        }
        let power_up = &self.program.power_up;
        if power_up.latched.iter().any(|region| region.contains(bit.cell())) {
            return Some(StartUnknown::Latched);
        }
        if power_up.initial_value(bit.cell()) != 0 {
            return Some(StartUnknown::Others);
        }
        if !self.written.contains(&bit) {
            return Some(StartUnknown::NotWritten);
        }
        let is_unknown = self.unknown.contains(&bit) || self.is_written_later(bit.cell());
        is_unknown.then_some(StartUnknown::AnyValue)
    }

    /// `Err` if others than the program may write a cell, or wrote it before the first scan; also for inputs.
    fn is_own(&self, cell: Cell) -> Result<(), StartUnknown> {
        let program = self.program;
        let within = |regions: &[Region]| regions.iter().any(|region| region.contains(cell));
        if !self.trust.trusts_exclusive_cell(program, cell) {
            return Err(StartUnknown::NotTrusted);
        }
        if within(&program.power_up.inputs) && !self.is_output(cell) {
            return Err(StartUnknown::Input);
        }
        // A bit that is stated never to be 0 was set by others before the first scan.
        let is_set = program
            .stated_ranges
            .iter()
            .any(|range| range.cells.contains(&cell) && !(range.low..=range.high).contains(&0));
        if is_set || !is_unwritten_elsewhere(program, cell) {
            return Err(StartUnknown::Others);
        }
        Ok(())
    }
}

/// The words of I/O points that serve outputs. A word serves either inputs or outputs. One that the program writes
/// serves outputs. If the program also reads bits of it that it does not write, others may set these bits and therefore
/// the whole word.
fn outputs(program: &Program, written: &BTreeSet<BitTarget>) -> BTreeSet<Cell> {
    let mut bits: BTreeMap<Cell, (u16, u16)> = BTreeMap::new();
    let is_point = |cell: Cell| {
        program.area(cell.area).kind == AreaKind::Word
            && program.power_up.inputs.iter().any(|region| region.contains(cell))
    };
    for bit in written {
        if let BitTarget::WordBit(cell, bit) = *bit
            && is_point(cell)
        {
            bits.entry(cell).or_default().0 |= 1 << bit;
        }
    }
    let mut read = |cell: Cell, mask: u16| {
        if let Some((_, read)) = bits.get_mut(&cell) {
            *read |= mask;
        }
    };
    for instruction in &program.instructions {
        instruction.each_read(&mut |source| match source {
            Source::Bit(BitSource::WordBit(cell, bit)) => read(cell, 1 << bit),
            Source::Word(WordSource::Cell(cell)) => read(cell, u16::MAX),
            Source::Bit(_) | Source::Word(_) => {}
        });
    }
    for kind in program.kinds.values() {
        kind.each_word(&mut |word| {
            if let WordSource::Cell(cell) = word {
                read(cell, u16::MAX);
            }
        });
    }
    let serves = |&(_, (written, read)): &(Cell, (u16, u16))| read & !written == 0;
    bits.into_iter().filter(serves).map(|(cell, _)| cell).collect()
}

fn range(target: &WordTarget) -> Option<Region> {
    match *target {
        WordTarget::Cell(first) => Some(Region::Range { first, count: 1 }),
        WordTarget::Bits { first, count } => Some(Region::Range { first, count: count.into() }),
        WordTarget::Discard => None,
    }
}

/// Whether a number contains a nondeterministic value that is not the exact result of an operation.
fn takes_any_value(program: &Program, number: &Number) -> bool {
    number.words().any(|word| match word {
        WordSource::Free(choice) => {
            !matches!(program.kinds.get(&choice), Some(ChoiceKind::Exact(_)))
        }
        _ => false,
    })
}

fn mentions_choice(logic: &Logic) -> bool {
    match logic {
        Logic::Bit(BitSource::Free(_)) => true,
        Logic::Condition | Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => false,
        Logic::Not(inner) => mentions_choice(inner),
        Logic::All(parts) | Logic::Any(parts) => parts.iter().any(mentions_choice),
    }
}
