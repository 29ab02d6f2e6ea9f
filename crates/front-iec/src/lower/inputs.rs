//! Inputs, outputs and memory that several variables name by their addresses: each bit has one value as the scan
//! begins, whatever name it is read by. All but the largest of these variables are worked out from the others there.

use super::Lower;
use super::address::{Located, bits, meeting};
use super::spots::{Instance, Spot};
use crate::assembler::whole::copy_cells;
use scanbound_base::code::Code;
use scanbound_front::builder::always;
use scanbound_iec::PouKind;
use scanbound_iec::fault::Fault;
use scanbound_iec_tree::declarations::Owner;
use scanbound_iec_tree::types::{Kind, Type as Typed, TypeId};
use scanbound_ir::{BitSource, BitTarget, Cell, ChoiceKind, Logic, Region, Step, Tag, Type, Write};
use std::collections::BTreeSet;

/// What differs by controller.
const OWN_UNITS: &str =
    "whether numbers of addresses count units of their own size, or bytes: either";
const HIGH_FIRST: &str = "which byte of a word at an address comes first: either";

/// Elements of larger arrays are not looked at one by one: that they share bits is refused.
const MAX_SHARED: i64 = 100_000;

/// Of more elements that are found by an index it is not told what they cannot hold.
const MAX_CONSTRAINED: usize = 4096;

/// Where variables that share bits get their values as the scan begins.
pub(super) struct Image {
    at: usize,
    /// Whether addresses count their own units, and whether words begin with their high byte, where it makes a
    /// difference.
    readings: Option<[Logic; 2]>,
}

/// How the addresses of bits are worked out: in units of their own size, with the high byte first.
type Reading = (bool, bool);

const READINGS: [Reading; 4] = [(false, false), (false, true), (true, false), (true, true)];

/// What the values of a type are: one, of a kind of number or a bit, or several.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    One(Option<Kind>),
    Several(TypeId),
}

/// A variable with an address, or an element of an array.
struct Shared {
    area: char,
    spot: Spot,
    /// Its type, as far as values are of one type.
    kind: Shape,
    /// Its first bit, in both ways of counting.
    first: [u64; 2],
    /// None, where it is no bit and no number.
    size: Option<u64>,
    end: [u64; 2],
    number: usize,
}

impl Shared {
    fn meets(&self, other: &Shared) -> bool {
        self.area == other.area
            && (0..2).any(|side| {
                self.first[side] < other.end[side] && other.first[side] < self.end[side]
            })
    }

    fn is_same(&self, other: &Shared) -> bool {
        self.first == other.first && self.kind == other.kind
    }

    /// The address of one of its bits.
    fn address(&self, bit: u64, (units, high_first): Reading) -> u64 {
        let size = self.size.unwrap_or(1);
        let byte = if high_first { (size - 1) / 8 - bit / 8 } else { bit / 8 };
        self.first[usize::from(units)] + 8 * byte + bit % 8
    }

    /// Its bit at an address.
    fn bit_at(&self, address: u64, (units, high_first): Reading) -> Option<BitTarget> {
        let size = self.size?;
        let offset = address.checked_sub(self.first[usize::from(units)]).filter(|&at| at < size)?;
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
    /// Where variables that share bits get their values, if there are any.
    pub(super) fn begin_image(&mut self) -> Option<Image> {
        let (shares, differs) = self.shared_addresses();
        if !shares {
            return None;
        }
        self.at(1, "addresses with several names");
        let readings = differs.then(|| [OWN_UNITS, HIGH_FIRST].map(|why| self.any_bit(why)));
        Some(Image { at: self.assembler().builder.add(None, Vec::new(), Step::Nothing), readings })
    }

    /// Lets variables of 8 bits begin a scan with no more than these, as far as they are read: their words have 16.
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

    /// Lets all names of a bit have one value, when it is known which variables there are.
    pub(super) fn begin_shared(&mut self, image: Option<Image>, located: &[Located]) {
        let Some(image) = image else { return };
        let mut all: Vec<Shared> = Vec::new();
        for (number, one) in located.iter().enumerate() {
            self.parts(one, number, &mut all);
        }
        // What is worked out is worked out from what is at least as large.
        let length = |one: &Shared| one.end[0] - one.first[0];
        all.sort_by_key(|one| (std::cmp::Reverse(length(one)), one.number));
        let taken = |one: &Shared| (one.area, [0, 1].map(|side| (one.first[side], one.end[side])));
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
                    let readings = readings.clone();
                    writes.extend(self.worked_out_by_bits(own, &others, &readings));
                }
                _ => {
                    let told = format!(
                        "{} shares bits with {}: that is followed of bits and numbers alone",
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

    /// What writes each bit of a variable from those that have it, too.
    fn worked_out_by_bits(
        &mut self,
        own: &Shared,
        others: &[&Shared],
        readings: &[Logic; 2],
    ) -> Vec<Write> {
        let mut writes = Vec::new();
        for bit in 0..own.size.unwrap_or(0) {
            let Some(target) = own.bit(bit) else { continue };
            let sources = READINGS.map(|reading| {
                let address = own.address(bit, reading);
                others.iter().find_map(|other| other.bit_at(address, reading))
            });
            let value = if sources.iter().all(|source| source == &sources[0]) {
                self.shared_bit(own.area, sources[0], target)
            } else {
                let mut ways = Vec::new();
                for (source, (units, high_first)) in sources.into_iter().zip(READINGS) {
                    let holds = |reading: &Logic, is: bool| match is {
                        true => reading.clone(),
                        false => reading.clone().not(),
                    };
                    let value = self.shared_bit(own.area, source, target);
                    let [first, second] = readings;
                    ways.push(Logic::All(vec![
                        holds(first, units),
                        holds(second, high_first),
                        value,
                    ]));
                }
                Logic::Any(ways)
            };
            writes.push(Write::Bit(target, value));
        }
        // The sign of 8 bits fills its word.
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

    /// A bit that another variable has, or one of its own.
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

    /// Whether some addresses may share bits, and whether others than the same ones do.
    fn shared_addresses(&self) -> (bool, bool) {
        let tree = self.tree;
        let mut all = Vec::new();
        for one in &tree.variables {
            // A block may have several instances.
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

    /// The words that instructions read; of those at computed addresses not more than are told what they cannot hold.
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

    /// The words of 8 bits among those that are read in a variable, and whether they have a sign.
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

    /// The parts of what has an address that have values of their own.
    fn parts(&self, one: &Located, number: usize, found: &mut Vec<Shared>) {
        let (area, taken) = one.taken;
        let size = |shape: Shape| match shape {
            Shape::One(None) => Some(1),
            Shape::One(Some(Kind::Whole { bits, .. })) => Some(u64::from(bits)),
            Shape::One(Some(Kind::Real)) => Some(32),
            // Controllers differ in the bits of a time.
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

/// Whether any word of it is read.
fn is_read(tag: &Tag, read: &BTreeSet<Cell>) -> bool {
    let words = tag.of.size().map_or(0, |size| size[1]);
    let begin = tag.begin()[1];
    read.range(begin..begin.plus(words)).next().is_some()
}

/// The elements of an array of which words are read.
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
