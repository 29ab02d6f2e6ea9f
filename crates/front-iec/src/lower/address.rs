//! Direct addresses: a write to a variable is passed on to all variables that share its memory, or may share it.

use super::spots::{Bits, Spot, WAYS};
use crate::assembler::Assembler;
use scanbound_base::code::Code;
use scanbound_front::builder::always;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::tree::Tree;
use scanbound_iec_tree::types::{Kind, Type, TypeId};
use scanbound_ir::{
    BitTarget, Cell, Effect, Logic, Number, Region, RegionSet, WordSource, WordTarget, Write, flow,
};
use std::collections::BTreeSet;

/// The bits that an address covers in all ways of numbering. None if it is not an I, Q or M address with numbers.
pub(super) fn bits(address: &str) -> Option<Bits> {
    let rest = address.strip_prefix('%')?;
    let area = rest.chars().next().filter(|area| matches!(area, 'I' | 'Q' | 'M'))?;
    let rest = &rest[1..];
    let digits = rest.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let size = match rest[..rest.len() - digits.len()].chars().next() {
        None | Some('X') => 1,
        Some('B') => 8,
        Some('W') => 16,
        Some('D') => 32,
        Some(_) => 64,
    };
    let numbers: Option<Vec<u64>> = digits.split('.').map(|part| part.parse().ok()).collect();
    let numbers = numbers.filter(|numbers| !numbers.is_empty())?;
    let (first, last) = (numbers[0], numbers[numbers.len() - 1]);
    let at = match (size, numbers.len()) {
        // A bit of a byte, such as `%MX0.3`, or of a word.
        (1, 2..) => {
            let [bytes, words] = [8, 16].map(|unit| first.checked_mul(unit)?.checked_add(last));
            [bytes?, bytes?, words?]
        }
        (1, _) => [first; WAYS],
        _ => [first.checked_mul(8)?, first.checked_mul(size)?, first.checked_mul(size)?],
    };
    Some((area, at.map(|at| (at, at.saturating_add(size)))))
}

/// The bits that a variable of a type takes at an address. None if the address cannot be read.
pub(super) fn taken(tree: &Tree, ty: TypeId, address: &str) -> Option<Bits> {
    let (area, mut taken) = bits(&address.to_ascii_uppercase())?;
    // A structure or an array takes more than its first part, and so does a type larger than the address says.
    let most_bits = match tree.types.get(ty) {
        Type::Elementary(of) if of.kind().is_none() => 1,
        _ => Extent::of(tree, ty).bits,
    };
    taken.iter_mut().for_each(|(from, to)| *to = (*to).max(from.saturating_add(most_bits)));
    Some((area, taken))
}

/// A variable with a direct address.
pub(super) struct Located {
    pub(super) spot: Spot,
    /// The kind of the variable, if it is a number.
    kind: Option<Kind>,
    address: String,
    pub(super) taken: Bits,
}

impl Located {
    /// A variable at a direct address. None if the address cannot be read.
    pub(super) fn new(tree: &Tree, spot: &Spot, address: &str) -> Option<Located> {
        let address = address.to_ascii_uppercase();
        let (spot, kind) = (spot.clone(), tree.types.kind(spot.ty));
        let taken = taken(tree, spot.ty, &address)?;
        Some(Located { spot, kind, address, taken })
    }

    /// Whether the same content of both variables' memory is the same value in the modelled words.
    fn is_alike(&self, other: &Located) -> bool {
        let is_byte = |kind: Kind| matches!(kind, Kind::Whole { bits: ..16, .. });
        match self.kind.zip(other.kind) {
            // Controllers represent TIME differently. A number of eight bits is extended by its sign to a word.
            Some((one, of)) => {
                let differs = |kind: Kind| is_byte(kind) || kind == Kind::Time;
                one == of || one.words() == of.words() && !differs(one) && !differs(of)
            }
            None => self.spot.ty == other.spot.ty,
        }
    }

    /// What another variable becomes when this one is written: the same value if both have the same address and layout,
    /// else any value.
    fn passes_to(&self, other: &Located) -> Passes {
        let one = self.spot.tag.cell().zip(other.spot.tag.cell());
        match one.filter(|_| self.address == other.address && self.is_alike(other)) {
            None => Passes::Any(other.spot.tag.regions()),
            Some((from, to)) => match self.spot.tag.of.size() {
                Some([1, 0]) => {
                    Passes::Same(vec![Write::Bit(BitTarget::Cell(to), Logic::cell(from))])
                }
                Some([0, words]) => {
                    let targets = (0..words).map(|at| WordTarget::Cell(to.plus(at))).collect();
                    let sources = (0..words).map(|at| WordSource::Cell(from.plus(at))).collect();
                    Passes::Same(vec![Write::Words(targets, Number::Words(sources))])
                }
                _ => Passes::Any(other.spot.tag.regions()),
            },
        }
    }
}

/// The most memory that a value takes on any controller, and the multiple of bits at which it begins: parts of
/// structures are aligned to their own size, and packed closer on some controllers. A bit in a structure or an array
/// may take a byte.
#[derive(Clone, Copy)]
struct Extent {
    bits: u64,
    aligned_to: u64,
}

impl Extent {
    fn of(tree: &Tree, ty: TypeId) -> Extent {
        let simple = |bits: u64| Extent { bits, aligned_to: bits.clamp(8, 64) };
        match tree.types.get(ty) {
            Type::Elementary(of) => simple(match of.kind() {
                None => 8,
                Some(Kind::Whole { bits, .. }) => bits.into(),
                Some(kind) => 16 * u64::from(kind.words()),
            }),
            // Characters of two bytes, an end and a length. Some controllers give every string the same room.
            Type::Text(characters) => {
                Extent { bits: 16 * u64::from((*characters).max(126) + 2), aligned_to: 16 }
            }
            Type::Array(dimensions, of) => {
                let counts = dimensions.iter().map(|(low, high)| high.abs_diff(low - 1));
                let Extent { bits, aligned_to } = Extent::of(tree, *of);
                Extent { bits: counts.fold(bits, u64::saturating_mul), aligned_to }
            }
            Type::Struct(id) => {
                let parts = tree.types.parts(*id).iter().map(|(_, of)| *of);
                Extent::of_parts(parts.map(|part| Extent::of(tree, part)))
            }
            Type::Block(unit) => {
                let parts = tree.members(*unit).into_iter().map(|id| tree.variable(id).ty);
                let methods = simple(64);
                Extent::of_parts(
                    [methods].into_iter().chain(parts.map(|part| Extent::of(tree, part))),
                )
            }
            Type::Standard(block) => Extent::of_parts(block.pins().map(|_| simple(64))),
            Type::Interface(_)
            | Type::Reference(..)
            | Type::Untyped
            | Type::Unknown
            | Type::Nothing
            | Type::Faulty(_) => simple(64),
        }
    }

    fn of_parts(parts: impl Iterator<Item = Extent>) -> Extent {
        let whole = parts.fold(Extent { bits: 0, aligned_to: 8 }, |whole, part| Extent {
            bits: whole.bits.next_multiple_of(part.aligned_to).saturating_add(part.bits),
            aligned_to: whole.aligned_to.max(part.aligned_to),
        });
        Extent { bits: whole.bits.next_multiple_of(whole.aligned_to), ..whole }
    }
}

/// The new content of a variable that shares memory with a written one.
enum Passes {
    Same(Vec<Write>),
    Any(Vec<Region>),
}

/// An index from cells to the pairs of variables whose first variable contains the cell.
struct Index {
    /// First cell, cell count and pair number, sorted by cell. The variables have no cells in common.
    all: Vec<(Cell, u32, usize)>,
}

impl Index {
    fn new(pairs: &[(&Located, &Located)]) -> Index {
        let mut all = Vec::new();
        for (pair, (one, _)) in pairs.iter().enumerate() {
            for region in one.spot.tag.regions() {
                if let Region::Range { first, count } = region {
                    all.push((first, count, pair));
                }
            }
        }
        all.sort_unstable();
        Index { all }
    }

    /// The pairs whose first variable a write changes.
    fn written(&self, write: &Write) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for region in flow::written_by(write) {
            let Region::Range { first, count } = region else {
                let is_it = |(cell, ..): &&(Cell, u32, usize)| region.contains(*cell);
                found.extend(self.all.iter().filter(is_it).map(|(.., pair)| *pair));
                continue;
            };
            let is_before = |(cell, many, _): &(Cell, u32, usize)| {
                cell.area < first.area
                    || (cell.area == first.area && cell.index.saturating_add(*many) <= first.index)
            };
            let begin = self.all.partition_point(is_before);
            let end = Cell { index: first.index.saturating_add(count), ..first };
            let within = self.all[begin..].iter().take_while(|(cell, ..)| *cell < end);
            found.extend(within.map(|(.., pair)| *pair));
        }
        found
    }
}

/// The pairs that may share bits in at least one way of numbering, as two indices.
pub(super) fn meeting(all: impl Iterator<Item = Bits>) -> BTreeSet<(usize, usize)> {
    let all: Vec<Bits> = all.collect();
    let mut found = BTreeSet::new();
    for side in 0..WAYS {
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by_key(|&at| (all[at].0, all[at].1[side].0));
        for (at, &one) in order.iter().enumerate() {
            let (area, taken) = (all[one].0, all[one].1[side]);
            let behind = order[at + 1..]
                .iter()
                .take_while(|&&other| all[other].0 == area && all[other].1[side].0 < taken.1);
            found.extend(behind.map(|&other| (one.min(other), one.max(other))));
        }
    }
    found
}

/// Extends every write of a variable to the variables that share its memory. Returns the cells of all variables that
/// share memory. Refuses a VAR_IN_OUT argument that shares memory.
pub(super) fn share(
    assembler: &mut Assembler,
    all: &[Located],
    given_back: &[(std::ops::Range<usize>, usize, u32)],
) -> RegionSet {
    let pairs = meeting(all.iter().map(|one| one.taken)).into_iter();
    let pairs = pairs.flat_map(|(one, other)| [(one, other), (other, one)]);
    let pairs: Vec<(&Located, &Located)> =
        pairs.map(|(one, other)| (&all[one], &all[other])).collect();
    if pairs.is_empty() {
        return RegionSet::default();
    }
    let index = Index::new(&pairs);
    for at in 0..assembler.builder.next() {
        let mut more: Vec<Effect> = Vec::new();
        let mut told = Vec::new();
        for effect in &assembler.builder.program.instructions[at].effects.clone() {
            let written: Vec<_> =
                index.written(&effect.write).into_iter().map(|pair| pairs[pair]).collect();
            // Of several variables, an index may select the one that is written.
            let is_one = written.windows(2).all(|two| std::ptr::eq(two[0].0, two[1].0));
            for (one, other) in written {
                let passes = match is_one {
                    true => one.passes_to(other),
                    false => Passes::Any(other.spot.tag.regions()),
                };
                let writes = match passes {
                    Passes::Same(writes) => writes,
                    Passes::Any(regions) => {
                        told.push(format!(
                            "{} at {} may share memory with {} at {}: a write to the first may give the second any value",
                            one.spot.name, one.address, other.spot.name, other.address
                        ));
                        let choice = assembler.builder.choice();
                        regions.into_iter().map(|region| Write::Havoc(region, choice)).collect()
                    }
                };
                let when = effect.when;
                more.extend(writes.into_iter().map(|write| Effect { when, ..always(write) }));
            }
        }
        assembler.builder.program.instructions[at].effects.extend(more);
        told.dedup();
        told.into_iter().for_each(|what| assembler.builder.program.approximate(at, what));
    }
    let mut faults = Vec::new();
    for (range, file, line) in given_back {
        let effects =
            range.clone().flat_map(|at| &assembler.builder.program.instructions[at].effects);
        let mut written = effects.flat_map(|effect| index.written(&effect.write));
        if let Some((one, other)) = written.next().map(|pair| pairs[pair]) {
            let told = format!(
                "{} at {} is passed as VAR_IN_OUT, and may share memory with {} at {}, which is not modelled",
                one.spot.name, one.address, other.spot.name, other.address
            );
            let help =
                "copy it to a variable without an address before the call, and back after it";
            faults.push((*file, Fault::new(*line, told).code(Code::NotModelled).help(help)));
        }
    }
    assembler.faults.extend(faults);
    pairs.iter().flat_map(|(one, _)| one.spot.tag.regions()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_meet_in_either_way_of_counting() {
        let meet = |one: &str, other: &str| {
            let both = [one, other].map(|address| bits(address).expect("an address"));
            !meeting(both.into_iter()).is_empty()
        };
        assert!(meet("%MW0", "%MX0.3"));
        assert!(meet("%MW1", "%MB2"));
        assert!(meet("%QW1", "%QW2"));
        assert!(meet("%QX0.0", "%QX0.0"));
        assert!(meet("%MX3.1", "%MB6"));
        assert!(!meet("%QX0.0", "%QX0.1"));
        assert!(!meet("%QX0.0", "%MX0.0"));
        assert!(!meet("%MW0", "%MW8"));
    }
}
