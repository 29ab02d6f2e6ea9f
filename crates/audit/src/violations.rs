//! What real runs break of what is stated to hold whenever a scan starts.

use scanbound_ir::{BitSource, Effect, Logic, Number, Program, Region, WordSource, Write, flow};
use scanbound_replay::RealRun;
use std::collections::BTreeMap;

/// What is stated to hold whenever a scan starts and does not hold when a real run ends, each with what breaks it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Violations {
    /// Ranges, by their places in `Program::stated_ranges`.
    pub ranges: BTreeMap<usize, RangeViolation>,
    /// Bits that are stated not to be on together, by their places in `Program::invariants`.
    pub exclusions: BTreeMap<usize, ExclusionViolation>,
}

impl Violations {
    /// Notes what is stated and a run does not keep; what a program writes of itself comes before what it works out. The
    /// run may be the scan of this number from power-up on, in which nothing is known of what the outside gives.
    pub fn note(&mut self, program: &Program, one: &RealRun, scan: Option<usize>) {
        if !one.is_possible() {
            return;
        }
        for &(range, value) in &one.range_violations {
            let cells = &program.stated_ranges[range].cells;
            let Some(by) = last_to_write(program, one, &|region| {
                cells.iter().any(|&cell| region.contains(cell))
            }) else {
                continue;
            };
            let known = self.ranges.entry(range).or_insert(RangeViolation { value, by, scan });
            if known.scan.is_none() && !writes_constant(program, known.by) {
                *known = RangeViolation { value, by, scan };
            }
        }
        for &pair in &one.exclusion_violations {
            let bits = bits_of(&program.invariants[pair]);
            let by = bits.iter().filter_map(|bit| {
                let (BitSource::Cell(cell) | BitSource::WordBit(cell, _)) = *bit else {
                    return None;
                };
                last_to_write(program, one, &|region| region.contains(cell))
            });
            let mut by: Vec<usize> = by.collect();
            by.sort_unstable();
            by.dedup();
            if by.is_empty() {
                continue;
            }
            let known = self
                .exclusions
                .entry(pair)
                .or_insert_with(|| ExclusionViolation { by: by.clone(), scan });
            if known.scan.is_none() && scan.is_some() {
                *known = ExclusionViolation { by, scan };
            }
        }
    }
}

/// What a real run leaves in a word that is stated to hold something else whenever a scan starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RangeViolation {
    /// What it holds.
    pub value: i64,
    /// The last instruction that wrote it.
    pub by: usize,
    /// Which scan from power-up on it is that leaves it, whatever the outside gives, if that is known.
    pub scan: Option<usize>,
}

/// Two bits that a real run leaves on together, and that are stated never to be so.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExclusionViolation {
    /// The last instructions that wrote them.
    pub by: Vec<usize>,
    /// As in [`RangeViolation`].
    pub scan: Option<usize>,
}

/// The last instruction of a run that wrote what is asked for.
fn last_to_write(
    program: &Program,
    one: &RealRun,
    asked: &dyn Fn(&Region) -> bool,
) -> Option<usize> {
    let writes = |at: usize| flow::written(program, at).iter().any(asked);
    let mut events = one.replay.events.iter().rev();
    events.find(|event| event.fired && writes(event.instruction)).map(|event| event.instruction)
}

/// The bits of which it is stated that they are not on together.
pub fn bits_of(invariant: &Logic) -> Vec<BitSource> {
    match invariant {
        Logic::Bit(bit) => vec![*bit],
        Logic::Not(inner) => bits_of(inner),
        Logic::All(parts) => parts.iter().flat_map(bits_of).collect(),
        _ => Vec::new(),
    }
}

/// Whether all that an instruction writes are constants of the program.
pub fn writes_constant(program: &Program, at: usize) -> bool {
    let is_constant = |effect: &Effect| match &effect.write {
        Write::Words(_, Number::Words(words)) => {
            words.iter().all(|word| matches!(word, WordSource::Const(_)))
        }
        _ => false,
    };
    program.instructions[at].effects.iter().all(is_constant)
}
