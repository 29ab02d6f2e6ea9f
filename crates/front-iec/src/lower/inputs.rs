//! Variables that share bits of inputs, outputs and memory by their addresses: when a scan begins, each bit has one
//! value, whatever name it is read by. The smaller variables are computed from the larger ones there.

use super::Lower;
use super::address::{Located, bits, meeting};
use super::spots::{Instance, Spot, WAYS};
use crate::assembler::whole::copy_cells;
use scanbound_base::code::Code;
use scanbound_front::builder::always;
use scanbound_iec::PouKind;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::declarations::Owner;
use scanbound_iec_tree::types::{Kind, Type as Typed, TypeId};
use scanbound_ir::{BitSource, BitTarget, Cell, ChoiceKind, Logic, Region, Step, Tag, Type, Write};
use std::collections::BTreeSet;

/// Reasons for the report: points on which controllers differ.
const OWN_UNITS: &str = "addresses may count units of their own size, or bytes";
const BITS_OF_WORDS: &str = "the first number of a bit address may count words, or bytes";
const HIGH_FIRST: &str = "the low or the high byte of a word may come first at an address";
const APART: &str = "addresses of different sizes may have the same memory, or one for each size";

/// The most elements of an array that are compared by address one by one. Larger arrays that share bits are refused.
const MAX_SHARED: i64 = 100_000;

/// The most array elements read at run-time indices for which the range of an 8-bit number is stated.
const MAX_CONSTRAINED: usize = 4096;

/// The instruction that gives variables with shared bits their values when a scan begins.
pub(super) struct Image {
    at: usize,
    /// None if it makes no difference.
    readings: Option<Readings>,
}

/// Free bits that say what the controller does.
struct Readings {
    /// Whether addresses count units of their own size.
    units: Logic,
    /// Whether bit addresses then count words.
    bits_of_words: Logic,
    /// Whether words begin with their high byte.
    high_first: Logic,
    /// Whether each size has a memory of its own (OpenPLC).
    apart: Logic,
}

/// A reading of addresses: the way of numbering, and whether the high byte comes first.
type Reading = (usize, bool);

/// The readings in which addresses of different sizes have the same memory.
const READINGS: [Reading; 2 * WAYS] =
    [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)];

impl Readings {
    /// True where the controller reads addresses so.
    fn hold(&self, (way, is_high_first): Reading) -> Logic {
        let is = |reading: &Logic, is: bool| match is {
            true => reading.clone(),
            false => reading.clone().not(),
        };
        let mut all = vec![is(&self.units, way > 0), is(&self.high_first, is_high_first)];
        if way > 0 {
            all.push(is(&self.bits_of_words, way > 1));
        }
        Logic::All(all)
    }
}

/// The shape of a type: one bit (None) or number, or several values.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    One(Option<Kind>),
    Several(TypeId),
}

/// A variable with an address, or an element of an array that has one.
struct Shared {
    area: char,
    spot: Spot,
    /// The shape of its type: one bit or number, or several values.
    kind: Shape,
    /// The address of its first bit, in all ways of numbering.
    first: [u64; WAYS],
    /// Its size in bits. None if it is neither a bit nor an integer nor a REAL.
    size: Option<u64>,
    end: [u64; WAYS],
    number: usize,
}

impl Shared {
    fn meets(&self, other: &Shared) -> bool {
        self.area == other.area
            && (0..WAYS).any(|side| {
                self.first[side] < other.end[side] && other.first[side] < self.end[side]
            })
    }

    fn is_same(&self, other: &Shared) -> bool {
        self.first == other.first && self.kind == other.kind
    }

    /// The address of one of its bits, in a reading of addresses.
    fn address(&self, bit: u64, (way, high_first): Reading) -> u64 {
        let size = self.size.unwrap_or(1);
        let byte = if high_first { (size - 1) / 8 - bit / 8 } else { bit / 8 };
        self.first[way] + 8 * byte + bit % 8
    }

    /// Its bit at an address, in a reading of addresses. None if the address is outside it.
    fn bit_at(&self, address: u64, (way, high_first): Reading) -> Option<BitTarget> {
        let size = self.size?;
        let offset = address.checked_sub(self.first[way]).filter(|&at| at < size)?;
        let byte = if high_first { (size - 1) / 8 - offset / 8 } else { offset / 8 };
        self.bit(8 * byte + offset % 8)
    }

    fn bit(&self, number: u64) -> Option<BitTarget> {
        let cell = self.spot.tag.cell()?;
        if self.kind == Shape::One(None) {
            return Some(BitTarget::Cell(cell));
        }
        let word = cell.plus(u32::try_from(number / 16).ok()?);
        Some(BitTarget::WordBit(word, u8::try_from(number % 16).ok()?))
    }
}

impl Lower<'_> {
    /// Adds the instruction that gives variables with shared bits their values. None if no addresses share bits.
    pub(super) fn begin_image(&mut self) -> Option<Image> {
        let (shares, differs) = self.shared_addresses();
        if !shares {
            return None;
        }
        self.at(1, "addresses with several names");
        let readings = differs.then(|| Readings {
            units: self.any_bit(OWN_UNITS),
            bits_of_words: self.any_bit(BITS_OF_WORDS),
            high_first: self.any_bit(HIGH_FIRST),
            apart: self.any_bit(APART),
        });
        Some(Image { at: self.assembler().builder.add(None, Vec::new(), Step::Nothing), readings })
    }

    /// Adds invariants that 8-bit variables, as far as they are read, hold only 8-bit values when a scan begins: their
    /// words have 16 bits.
    pub(super) fn bound_bytes(&mut self, located: &[Located]) {
        let read = self.words_read();
        let mut all: Vec<Spot> = located.iter().map(|one| one.spot.clone()).collect();
        for Instance { unit, spot } in self.instances.clone() {
            for id in self.tree.members(unit) {
                all.extend(self.member(&spot, unit, id));
            }
        }
        all.extend(self.memory.globals.values().chain(self.memory.addresses.values()).cloned());
        let mut found = BTreeSet::new();
        all.iter().for_each(|spot| self.bytes(spot, &read, &mut found));
        for (cell, signed) in found {
            let bit = |bit| Logic::Bit(BitSource::WordBit(cell, bit));
            let low: Vec<Logic> = (8..16).map(|at| bit(at).not()).collect();
            let within = match signed {
                false => Logic::All(low),
                true => Logic::Any(vec![
                    Logic::All(low.into_iter().chain([bit(7).not()]).collect()),
                    Logic::All((7..16).map(bit).collect()),
                ]),
            };
            self.program().invariants.push(within);
        }
    }

    /// Adds the writes that give all names of a bit one value, when all variables with addresses are known.
    pub(super) fn begin_shared(&mut self, image: Option<Image>, located: &[Located]) {
        let Some(image) = image else { return };
        let mut all: Vec<Shared> = Vec::new();
        for (number, one) in located.iter().enumerate() {
            self.parts(one, number, &mut all);
        }
        // A variable is computed from variables that are at least as large.
        let length = |one: &Shared| one.end[0] - one.first[0];
        all.sort_by_key(|one| (std::cmp::Reverse(length(one)), one.number));
        let taken =
            |one: &Shared| (one.area, std::array::from_fn(|side| (one.first[side], one.end[side])));
        let pairs = meeting(all.iter().map(taken));
        let mut writes = Vec::new();
        let mut later = vec![Vec::new(); all.len()];
        for (one, other) in pairs {
            later[one.max(other)].push(one.min(other));
        }
        for (number, others) in later.iter().enumerate() {
            let own = &all[number];
            let others: Vec<&Shared> =
                others.iter().map(|&at| &all[at]).filter(|other| own.meets(other)).collect();
            if others.is_empty() {
                continue;
            }
            if let Some(same) = others.iter().find(|other| own.is_same(other))
                && let Some(copied) = copy_cells(&same.spot.tag, &own.spot.tag)
            {
                writes.extend(copied);
                continue;
            }
            match &image.readings {
                Some(readings)
                    if own.size.is_some() && others.iter().all(|one| one.size.is_some()) =>
                {
                    writes.extend(self.worked_out_by_bits(own, &others, readings));
                }
                _ => {
                    let told = format!(
                        "{} shares bits with {}: this is modelled only for bits, integers and REAL",
                        own.spot.name, others[0].spot.name
                    );
                    let help = "declare one of them without an address, and assign what it holds";
                    let fault = Fault::new(1, told).code(Code::NotModelled).help(help);
                    self.assembler().faults.push((0, fault));
                }
            }
        }
        let effects = writes.into_iter().map(always);
        self.program().instructions[image.at].effects.extend(effects);
    }

    /// The writes that compute each bit of a variable from the other variables that contain it.
    fn worked_out_by_bits(
        &mut self,
        own: &Shared,
        others: &[&Shared],
        readings: &Readings,
    ) -> Vec<Write> {
        let is_apart = others.iter().any(|other| other.size != own.size);
        let mut writes = Vec::new();
        for bit in 0..own.size.unwrap_or(0) {
            let Some(target) = own.bit(bit) else { continue };
            let sources = READINGS.map(|reading| {
                let address = own.address(bit, reading);
                others.iter().find_map(|other| other.bit_at(address, reading))
            });
            let shared = if sources.iter().all(|source| source == &sources[0]) {
                self.shared_bit(own.area, sources[0], target)
            } else {
                let mut ways = Vec::new();
                for (source, reading) in sources.into_iter().zip(READINGS) {
                    let value = self.shared_bit(own.area, source, target);
                    ways.push(Logic::All(vec![readings.hold(reading), value]));
                }
                Logic::Any(ways)
            };
            let value = match is_apart {
                false => shared,
                true => Logic::Any(vec![
                    Logic::All(vec![
                        readings.apart.clone(),
                        self.shared_bit(own.area, None, target),
                    ]),
                    Logic::All(vec![readings.apart.clone().not(), shared]),
                ]),
            };
            writes.push(Write::Bit(target, value));
        }
        // The sign of an 8-bit number fills its word.
        if let (Shape::One(Some(Kind::Whole { bits: 8, signed })), Some(cell)) =
            (own.kind, own.spot.tag.cell())
        {
            let sign = match signed {
                true => Logic::Bit(BitSource::WordBit(cell, 7)),
                false => Logic::Const(false),
            };
            writes
                .extend((8..16).map(|bit| Write::Bit(BitTarget::WordBit(cell, bit), sign.clone())));
        }
        writes
    }

    /// The value of a bit: from another variable if that contains it, else a free bit for an input, or its own value.
    fn shared_bit(&mut self, area: char, source: Option<BitTarget>, own: BitTarget) -> Logic {
        match source {
            None if area == 'I' => self.world_bit(),
            found => Logic::Bit(found.unwrap_or(own).source()),
        }
    }

    fn shape(&self, ty: TypeId) -> Shape {
        match self.tree.types.get(ty) {
            Typed::Elementary(of) => Shape::One(of.kind()),
            _ => Shape::Several(ty),
        }
    }

    /// Two answers: whether any addresses may share bits, and whether any addresses that share bits differ in text or
    /// type. An array or structure with an address, beside another address, counts as both.
    fn shared_addresses(&self) -> (bool, bool) {
        let tree = self.tree;
        let mut all = Vec::new();
        for one in &tree.variables {
            // A function block may have several instances.
            let times = match one.owner {
                Owner::Unit(unit) if tree.unit(unit).kind != PouKind::Program => 2,
                Owner::Unit(_) | Owner::Global(_) => 1,
                Owner::Routine(_) => 0,
            };
            let Some(at) = one.at.as_ref().map(|at| at.to_ascii_uppercase()) else { continue };
            let Some(taken) = bits(&at) else { continue };
            let shape = self.shape(one.ty);
            (0..times).for_each(|_| all.push((at.clone(), shape, taken)));
        }
        for one in &tree.addresses {
            let taken = bits(&one.text);
            all.extend(taken.map(|taken| (one.text.clone(), self.shape(one.ty), taken)));
        }
        let is_whole = |shape: &Shape| match shape {
            Shape::One(_) => false,
            Shape::Several(ty) => !matches!(tree.types.get(*ty), Typed::Text(_)),
        };
        let is_whole = all.iter().any(|(_, shape, _)| is_whole(shape));
        let pairs = meeting(all.iter().map(|(.., taken)| *taken));
        let differs = pairs.iter().any(|&(one, other)| {
            let (one, other) = (&all[one], &all[other]);
            one.0 != other.0 || one.1 != other.1
        });
        let several = all.len() > 1;
        (!pairs.is_empty() || (is_whole && several), differs || (is_whole && several))
    }

    /// The words that instructions read, including up to [`MAX_CONSTRAINED`] words at computed addresses.
    fn words_read(&mut self) -> BTreeSet<Cell> {
        let program = self.program();
        let (mut read, mut computed) = (BTreeSet::new(), BTreeSet::new());
        for one in &program.instructions {
            one.each_read(&mut |source| match source.region() {
                Some(Region::Range { first, count }) => {
                    read.extend((0..count).map(|at| first.plus(at)));
                }
                Some(Region::Area(_) | Region::Everything) | None => {}
            });
        }
        for kind in program.kinds.values() {
            let ChoiceKind::Exact(meaning) = kind else { continue };
            meaning.each_read(&mut |region| {
                if let Region::Range { first, count } = region {
                    let left = MAX_CONSTRAINED.saturating_sub(computed.len());
                    computed.extend((0..count).map(|at| first.plus(at)).take(left));
                }
            });
        }
        read.extend(computed);
        read
    }

    /// Collects the 8-bit numbers in a variable whose words are read, each with whether it is signed.
    fn bytes(&mut self, spot: &Spot, read: &BTreeSet<Cell>, found: &mut BTreeSet<(Cell, bool)>) {
        if !is_read(&spot.tag, read) {
            return;
        }
        let tree = self.tree;
        let part = |tag, ty| Spot { name: String::new(), tag, ty };
        match tree.types.get(spot.ty) {
            Typed::Elementary(of) => {
                if let Some(Kind::Whole { bits: 8, signed }) = of.kind() {
                    found.extend(spot.tag.cell().map(|cell| (cell, signed)));
                }
            }
            Typed::Struct(id) => {
                for (at, (_, ty)) in tree.types.parts(*id).iter().enumerate() {
                    let Some(tag) = spot.tag.part_at(at) else { continue };
                    self.bytes(&part(tag, *ty), read, found);
                }
            }
            Typed::Array(dimensions, of) => {
                let mut tags = vec![spot.tag.clone()];
                for _ in dimensions {
                    tags = tags.iter().flat_map(|tag| elements_read(tag, read)).collect();
                }
                tags.into_iter().for_each(|tag| self.bytes(&part(tag, *of), read, found));
            }
            Typed::Block(unit) => {
                for id in tree.members(*unit) {
                    if let Some(part) = self.member(spot, *unit, id) {
                        self.bytes(&part, read, found);
                    }
                }
            }
            _ => {}
        }
    }

    /// Adds a variable with an address, or each element of a one-dimensional array of numbers.
    fn parts(&self, one: &Located, number: usize, found: &mut Vec<Shared>) {
        let (area, taken) = one.taken;
        let size = |shape: Shape| match shape {
            Shape::One(None) => Some(1),
            Shape::One(Some(Kind::Whole { bits, .. })) => Some(u64::from(bits)),
            Shape::One(Some(Kind::Real)) => Some(32),
            // Controllers represent TIME differently.
            Shape::One(Some(Kind::Time | Kind::Opaque(_))) | Shape::Several(_) => None,
        };
        let first = taken.map(|(from, _)| from);
        let kind = self.shape(one.spot.ty);
        if let Typed::Array(dimensions, of) = self.tree.types.get(one.spot.ty)
            && let ([(low, high)], kind) = (&dimensions[..], self.shape(*of))
            && let Some(bits @ 2..) = size(kind)
            && high - low < MAX_SHARED
        {
            for (at, index) in (0..).zip(*low..=*high) {
                let Some(tag) = one.spot.tag.element(index) else { continue };
                let name = format!("{}[{index}]", one.spot.name);
                let spot = Spot { name, tag, ty: *of };
                let first = first.map(|first| first.saturating_add(bits * at));
                let end = first.map(|first| first.saturating_add(bits));
                found.push(Shared { area, spot, kind, first, size: Some(bits), end, number });
            }
            return;
        }
        let (spot, size, end) = (one.spot.clone(), size(kind), taken.map(|(_, to)| to));
        found.push(Shared { area, spot, kind, first, size, end, number });
    }
}

/// Whether any word of a tag is read.
fn is_read(tag: &Tag, read: &BTreeSet<Cell>) -> bool {
    let words = tag.of.size().map_or(0, |size| size[1]);
    let begin = tag.begin()[1];
    read.range(begin..begin.plus(words)).next().is_some()
}

/// The elements of an array that have words which are read. Empty if the tag is not an array.
fn elements_read(tag: &Tag, read: &BTreeSet<Cell>) -> Vec<Tag> {
    let Type::Array { first, count, of } = &tag.of else { return Vec::new() };
    let words = of.size().map_or(0, |size| size[1]);
    let begin = tag.begin()[1];
    let end = begin.plus(words.saturating_mul(*count));
    let (mut at, mut found) = (begin, Vec::new());
    while let Some(cell) = read.range(at..end).next().filter(|_| words > 0) {
        let place = (cell.index - begin.index) / words;
        found.extend(tag.element(first + i64::from(place)));
        at = begin.plus((place + 1) * words);
    }
    found
}
