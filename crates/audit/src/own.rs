//! The relays that nobody but the program writes, and only in ways that are known: what they hold when a scan starts is
//! what the scan before left in them.

use scanbound_ir::{
    AreaKind, BitSource, BitTarget, Cell, ChoiceKind, Logic, Number, Program, Region, Source,
    WordSource, WordTarget, Write,
};
use scanbound_passes::values::{Trust, is_unwritten_elsewhere};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Why nothing is known of what a relay holds when a scan starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NotOwn {
    /// By `--trust`, anybody may write it.
    NotTrusted,
    /// It is an input, or lies in a word of which the program reads bits that it does not write.
    Input,
    /// It keeps its state without power: a power failure leaves what stood there in the midst of a scan.
    Latched,
    /// Others write it, as is stated; or the CPU, a network, a unit or an interrupt may at any moment.
    Others,
    /// Nothing in the program writes it.
    NotWritten,
    /// Something writes any value into it.
    AnyValue,
}

impl fmt::Display for NotOwn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NotOwn::NotTrusted => {
                "anybody may write it: --trust all says that only the program does, or [internal] devices in --facts"
            }
            NotOwn::Input => {
                "it is an input, or in a word of inputs: the program reads bits there that it does not write"
            }
            NotOwn::Latched => "a power failure in mid-scan leaves what stood there by then",
            NotOwn::Others => "others may write it: a network, a unit, an interrupt, or as [external] or [ranges] say",
            NotOwn::NotWritten => "no instruction of the program writes it by itself",
            NotOwn::AnyValue => "an instruction writes what is not known into it",
        })
    }
}

/// Who writes the relays of a program.
pub struct Owners<'p> {
    program: &'p Program,
    trust: Trust,
    /// Bits that single instructions write.
    written: BTreeSet<BitTarget>,
    /// Those into which one of them writes what is not known.
    unknown: BTreeSet<BitTarget>,
    /// What is written at any moment once it was asked for.
    later: Vec<Region>,
    /// The words of points that the program writes, of which it reads no bit that it does not write: they serve outputs.
    outputs: BTreeSet<Cell>,
}

impl<'p> Owners<'p> {
    /// Looks through a program.
    #[must_use]
    pub fn of(program: &'p Program, trust: Trust) -> Owners<'p> {
        let mut owners = Owners {
            program,
            trust,
            written: BTreeSet::new(),
            unknown: BTreeSet::new(),
            later: Vec::new(),
            outputs: BTreeSet::new(),
        };
        for instruction in &program.instructions {
            for effect in &instruction.effects {
                match &effect.write {
                    Write::Bit(bit, value) => {
                        owners.written.insert(*bit);
                        if mentions_choice(value) {
                            owners.unknown.insert(*bit);
                        }
                    }
                    Write::Havoc(region, choice) => {
                        // What is delivered later is written at any moment from then on.
                        let at_once = program.indexed.contains_key(choice)
                            || matches!(program.kinds.get(choice), Some(ChoiceKind::Exact(_)));
                        if !at_once {
                            owners.later.push(*region);
                        }
                    }
                    Write::Words(targets, number) => {
                        if takes_any_value(program, number) {
                            owners.later.extend(targets.iter().filter_map(range));
                        }
                    }
                }
            }
        }
        owners.outputs = outputs(program, &owners.written);
        owners
    }

    /// Whether a cell is a word that serves outputs, as the program shows.
    #[must_use]
    pub fn is_output(&self, cell: Cell) -> bool {
        self.outputs.contains(&cell)
    }

    /// Why nothing is known of what a bit holds when a scan starts; `None` if it holds what the scan before left.
    #[must_use]
    pub fn refuses(&self, bit: BitTarget) -> Option<NotOwn> {
        let (program, cell) = (self.program, bit.cell());
        let within = |regions: &[Region]| regions.iter().any(|region| region.contains(cell));
        if !self.trust.trusts_exclusive_cell(program, cell) {
            return Some(NotOwn::NotTrusted);
        }
        if within(&program.power_up.latched) {
            return Some(NotOwn::Latched);
        }
        if within(&program.power_up.inputs) && !self.is_output(cell) {
            return Some(NotOwn::Input);
        }
        // What is stated never to be 0 somebody else set before the first scan.
        let is_set = program
            .stated_ranges
            .iter()
            .any(|range| range.cells.contains(&cell) && !(range.low..=range.high).contains(&0));
        let is_other = program.power_up.initial_value(cell) != 0;
        if is_set || is_other || !is_unwritten_elsewhere(program, cell) {
            return Some(NotOwn::Others);
        }
        if !self.written.contains(&bit) {
            return Some(NotOwn::NotWritten);
        }
        (self.unknown.contains(&bit) || within(&self.later)).then_some(NotOwn::AnyValue)
    }
}

/// The words of points that serve outputs. A word serves either; which, the program tells: one that it writes serves
/// outputs. Where it also reads bits there that it does not write, somebody else may set them, and so all of them.
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

/// Whether a number has words of which nothing is known, not even that a result of this moment is in them.
fn takes_any_value(program: &Program, number: &Number) -> bool {
    match number {
        Number::Words(words) => words.iter().any(|word| match word {
            WordSource::Free(choice) => {
                !matches!(program.kinds.get(choice), Some(ChoiceKind::Exact(_)))
            }
            _ => false,
        }),
        Number::Add(a, b)
        | Number::Sub(a, b)
        | Number::And(a, b)
        | Number::Or(a, b)
        | Number::Xor(a, b) => takes_any_value(program, a) || takes_any_value(program, b),
    }
}

fn mentions_choice(logic: &Logic) -> bool {
    match logic {
        Logic::Bit(BitSource::Free(_)) => true,
        Logic::Condition | Logic::Const(_) | Logic::Bit(_) | Logic::Compare(_) => false,
        Logic::Not(inner) => mentions_choice(inner),
        Logic::All(parts) | Logic::Any(parts) => parts.iter().any(mentions_choice),
    }
}
