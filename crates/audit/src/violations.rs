//! Stated facts about the start of a scan that are not true at the end of a real run.

use scanbound_ir::{BitSource, Effect, Logic, Number, Program, Region, WordSource, Write, flow};
use scanbound_replay::RealRun;
use std::collections::BTreeMap;

/// The stated facts that should be true whenever a scan starts and that real runs violate, each with the instructions
/// that cause it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Violations {
    /// Violated ranges, by index into `Program::stated_ranges`.
    pub ranges: BTreeMap<usize, RangeViolation>,
    /// Violated exclusions, by index into `Program::invariants`.
    pub exclusions: BTreeMap<usize, ExclusionViolation>,
}

impl Violations {
    /// Records what a run violates, if the run is possible. Of a range, the first violation by a constant that the
    /// program writes, or with a `scan`, is kept; others are replaced by later ones. `scan` is the number of the scan
    /// since power-up, if the run is a scan that has the same violations whatever the values from outside are;
    /// otherwise `None`.
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

/// A word whose value at the end of a real run is outside its stated range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RangeViolation {
    /// The value at the end of the scan, outside the range.
    pub value: i64,
    /// The index of the last instruction that wrote the word.
    pub by: usize,
    /// The number of the scan since power-up that ends with this value for any values from outside. `None` if no such
    /// scan is known.
    pub scan: Option<usize>,
}

/// Two bits that are stated to be mutually exclusive and are both on at the end of a real run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExclusionViolation {
    /// The indices of the last instructions that wrote the bits, ascending.
    pub by: Vec<usize>,
    /// The number of the scan since power-up that ends with both bits on for any values from outside. `None` if no such
    /// scan is known.
    pub scan: Option<usize>,
}

/// The last instruction of a run that fired and writes a region for which `asked` is true. `None` if there is none.
fn last_to_write(
    program: &Program,
    one: &RealRun,
    asked: &dyn Fn(&Region) -> bool,
) -> Option<usize> {
    let writes = |at: usize| flow::written(program, at).iter().any(asked);
    let mut events = one.replay.events.iter().rev();
    events.find(|event| event.fired && writes(event.instruction)).map(|event| event.instruction)
}

/// The bits that occur in an invariant that states that they are mutually exclusive.
pub fn bits_of(invariant: &Logic) -> Vec<BitSource> {
    match invariant {
        Logic::Bit(bit) => vec![*bit],
        Logic::Not(inner) => bits_of(inner),
        Logic::All(parts) => parts.iter().flat_map(bits_of).collect(),
        _ => Vec::new(),
    }
}

/// Whether the instruction only writes constants to words. Also true if it writes nothing.
pub fn writes_constant(program: &Program, at: usize) -> bool {
    let is_constant = |effect: &Effect| match &effect.write {
        Write::Words(_, Number::Words(words)) => {
            words.iter().all(|word| matches!(word, WordSource::Const(_)))
        }
        _ => false,
    };
    program.instructions[at].effects.iter().all(is_constant)
}
