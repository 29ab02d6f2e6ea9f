//! Which relays occur together in rungs: their pairs are candidates for mutual exclusion.

use scanbound_ir::{BitSource, BitTarget, Cell, Join, Program, Source, Step, WordSource, Write};
use std::collections::{BTreeMap, BTreeSet};

/// A relay with more related relays than this is a mode flag: it says nothing about single pairs.
const MAX_RELATED: usize = 40;
/// An input or word on which more relays than this depend says nothing about single pairs.
const MAX_SHARED: usize = 24;
/// The maximum number of pairs that are considered.
const MAX_PAIRS: usize = 20_000;

/// Something that is read: a relay or word, or a bit of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct ReadDevice(Cell, Option<u8>);

impl From<BitTarget> for ReadDevice {
    fn from(bit: BitTarget) -> ReadDevice {
        match bit {
            BitTarget::Cell(cell) => ReadDevice(cell, None),
            BitTarget::WordBit(cell, bit) => ReadDevice(cell, Some(bit)),
        }
    }
}

/// Which relays occur together in a rung. Relays are given by their index in the list passed to [`RelatedRelays::of`].
pub struct RelatedRelays {
    /// For each relay: the relays that are read in rungs which write it.
    read: Vec<BTreeSet<usize>>,
    /// For each relay: those that occur with it in a rung that writes one of the two, or that depend on the same input
    /// or word.
    related: Vec<BTreeSet<usize>>,
}

impl RelatedRelays {
    /// Finds from the program's rungs which of these relays are related.
    pub fn of(program: &Program, bits: &[BitTarget]) -> RelatedRelays {
        let place: BTreeMap<ReadDevice, usize> =
            bits.iter().enumerate().map(|(place, &bit)| (ReadDevice::from(bit), place)).collect();
        let none = vec![BTreeSet::new(); bits.len()];
        let mut related = RelatedRelays { read: none.clone(), related: none };
        let mut shared: BTreeMap<ReadDevice, BTreeSet<usize>> = BTreeMap::new();
        let (mut read, mut written) = (BTreeSet::new(), BTreeSet::new());
        let mut close = |read: &mut BTreeSet<ReadDevice>, written: &mut BTreeSet<usize>| {
            let own = read.iter().filter_map(|one| place.get(one).copied()).collect();
            related.add(&own, written);
            for one in std::mem::take(read) {
                shared.entry(one).or_default().extend(written.iter());
            }
            written.clear();
        };
        for instruction in &program.instructions {
            if let Step::Logic { join: Join::Start, .. } = instruction.step {
                close(&mut read, &mut written);
            }
            instruction.each_read(&mut |source| {
                read.extend(match source {
                    Source::Bit(BitSource::WordBit(cell, bit)) => Some(ReadDevice(cell, Some(bit))),
                    Source::Bit(BitSource::Cell(cell)) | Source::Word(WordSource::Cell(cell)) => {
                        Some(ReadDevice(cell, None))
                    }
                    Source::Bit(_) | Source::Word(_) => None,
                });
            });
            for effect in &instruction.effects {
                if let Write::Bit(bit, _) = &effect.write {
                    written.extend(place.get(&ReadDevice::from(*bit)));
                }
            }
        }
        close(&mut read, &mut written);
        for relays in shared.into_values().filter(|relays| relays.len() <= MAX_SHARED) {
            for &relay in &relays {
                related.related[relay].extend(relays.iter().filter(|&&other| other != relay));
            }
        }
        related
    }

    fn add(&mut self, read: &BTreeSet<usize>, written: &BTreeSet<usize>) {
        for &a in written {
            self.read[a].extend(read);
            for &b in read.iter().chain(written).filter(|&&b| b != a) {
                self.related[a].insert(b);
                self.related[b].insert(a);
            }
        }
    }

    /// Selects the relays that other relays must turn on first. `never` are relays that no scan turns on. A relay needs
    /// the relays that are read in rungs that write it, and those that they need. A relay of `never` is selected if it
    /// needs no others of `never`, or only others that also need it.
    pub fn first(&self, never: &[usize]) -> Vec<usize> {
        let needs = |&from: &usize| {
            let mut found = BTreeSet::new();
            let mut open = vec![from];
            while let Some(relay) = open.pop() {
                let more = self.read[relay].iter().filter(|one| never.contains(one));
                open.extend(more.copied().filter(|&one| found.insert(one)));
            }
            found
        };
        let all: BTreeMap<usize, BTreeSet<usize>> =
            never.iter().map(|one| (*one, needs(one))).collect();
        let is_first = |one: &usize| all[one].iter().all(|other| all[other].contains(one));
        never.iter().copied().filter(is_first).collect()
    }

    /// Pairs of related relays, at most 20,000: they occur together in a rung that writes one of them, or depend on the
    /// same input or word.
    pub fn directly_related(&self) -> Vec<Vec<usize>> {
        let pairs = self
            .related
            .iter()
            .enumerate()
            .flat_map(|(a, others)| others.range(a + 1..).map(move |&b| vec![a, b]));
        pairs.take(MAX_PAIRS).collect()
    }

    /// Pairs of relays that may be mutually exclusive, at most 20,000: related relays, and relays connected by a chain
    /// of such relations. Chains do not pass through mode flags: relays with many related ones.
    pub fn pairs(&self) -> Vec<Vec<usize>> {
        let few: Vec<Vec<usize>> = self
            .related
            .iter()
            .map(|others| others.iter().copied().filter(|_| others.len() <= MAX_RELATED).collect())
            .collect();
        let mut found: BTreeSet<(usize, usize)> = BTreeSet::new();
        let mut near: Vec<BTreeSet<usize>> = self.related.clone();
        let mut before = usize::MAX;
        // Each round adds pairs whose chain is one relay longer.
        while found.len() != before && found.len() < MAX_PAIRS {
            before = found.len();
            let all = near.iter().enumerate().flat_map(|(a, others)| {
                let others = others.iter().filter(move |&&b| b != a);
                others.map(move |&b| (a.min(b), a.max(b)))
            });
            for pair in all {
                if found.len() >= MAX_PAIRS {
                    break;
                }
                found.insert(pair);
            }
            let further = |others: &BTreeSet<usize>| {
                let next = others.iter().flat_map(|&other| few[other].iter().copied());
                next.chain(others.iter().copied()).collect()
            };
            near = near.iter().map(further).collect();
        }
        found.into_iter().map(|(a, b)| vec![a, b]).collect()
    }
}
