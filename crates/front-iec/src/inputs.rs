//! Inputs, outputs and memory that several variables name by their addresses: each bit has one value as the scan begins, whatever
//! name it is read by. All but the largest of these variables are worked out from the others there.

use super::address::{Located, bits, meeting};
use super::assembler::Assembler;
use super::emit::{Emit, Place};
use super::reach::each_path;
use super::types::{Kind, Ty, elementary, same_type};
use super::whole::copies;
use scanbound_base::code::Code;
use scanbound_front::builder::always;
use scanbound_iec::fault::Fault;
use scanbound_iec::{PouKind, Project, TypeRef, Variable};
use scanbound_ir::{BitSource, BitTarget, Cell, Logic, Step, Write};
use std::collections::BTreeSet;

/// What differs by controller.
const OWN_UNITS: &str =
    "whether numbers of addresses count units of their own size, or bytes: either";
const HIGH_FIRST: &str = "which byte of a word at an address comes first: either";

/// Of more variables it is not told what they cannot hold.
const MAX_CONSTRAINED: usize = 4096;

/// Where variables that share bits get their values as the scan begins.
pub(super) struct Image {
    at: usize,
    /// Whether addresses count their own units, and whether words begin with their high byte, where it makes a difference.
    readings: Option<[Logic; 2]>,
}

/// How the addresses of bits are worked out: in units of their own size, with the high byte first.
type Reading = (bool, bool);

const READINGS: [Reading; 4] = [(false, false), (false, true), (true, false), (true, true)];

/// A variable with an address, or an element of an array.
struct Shared {
    area: char,
    place: Place,
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
        self.first == other.first && same_type(&self.place.ty, &other.place.ty)
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
        let cell = self.place.tag.cell()?;
        if matches!(self.place.ty, Ty::Bit) {
            return Some(BitTarget::Cell(cell));
        }
        let word = cell.plus(u32::try_from(number / 16).ok()?);
        Some(BitTarget::WordBit(word, u8::try_from(number % 16).ok()?))
    }
}

impl Assembler {
    /// Where variables that share bits get their values, if there are any.
    pub(super) fn begin_image(&mut self, project: &Project) -> Option<Image> {
        let (shares, differs) = shared_addresses(project);
        if !shares {
            return None;
        }
        self.at(1, "addresses with several names");
        let readings = differs.then(|| [OWN_UNITS, HIGH_FIRST].map(|why| self.any_bit(why)));
        Some(Image { at: self.builder.add(None, Vec::new(), Step::Nothing), readings })
    }

    /// Lets variables of 8 bits begin a scan with no more than these: their words have 16.
    /// `located`: those with addresses; `all`: instances and global variables.
    pub(super) fn bound_bytes(&mut self, located: &[Located], all: &[Place]) {
        let mut found = BTreeSet::new();
        for one in located {
            bytes(&one.place, true, &mut found);
        }
        for place in all {
            match &place.ty {
                Ty::Parts(parts) | Ty::Block(_, parts) => {
                    for (name, _) in parts.iter() {
                        let part = Emit::part(place, name);
                        part.iter().for_each(|part| bytes(part, false, &mut found));
                    }
                }
                _ => bytes(place, false, &mut found),
            }
        }
        for (cell, signed) in found.into_iter().take(MAX_CONSTRAINED) {
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
            parts(one, number, &mut all);
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
                && let Some(copied) = copies(&same.place, &own.place)
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
                        own.place.name, others[0].place.name
                    );
                    let help = "declare one of them without an address, and assign what it holds";
                    self.faults.push((0, Fault::new(1, told).code(Code::NotModelled).help(help)));
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
        if let (Ty::Number(Kind::Whole { bits: 8, signed }), Some(cell)) =
            (&own.place.ty, own.place.tag.cell())
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
}

/// Whether some addresses may share bits, and whether others than the same ones do.
fn shared_addresses(project: &Project) -> (bool, bool) {
    let mut all = Vec::new();
    let is_one =
        |one: &Variable| matches!(&one.of, TypeRef::Named(name) if elementary(name).is_some());
    let mut add = |one: &Variable, times: usize| {
        let Some(at) = one.at.as_deref() else { return };
        let Some(taken) = bits(&at.to_ascii_uppercase()) else { return };
        let kind = is_one(one).then(|| one.of.clone());
        (0..times).for_each(|_| all.push((at.to_ascii_uppercase(), kind.clone(), taken)));
    };
    let mut direct = BTreeSet::new();
    for pou in &project.pous {
        // A block may have several instances.
        let times = if pou.kind == PouKind::Program { 1 } else { 2 };
        pou.variables.iter().for_each(|one| add(one, times));
        each_path(pou, &mut |path, _| {
            if path.first.starts_with('%') {
                direct.insert(path.first.to_ascii_uppercase());
            }
        });
    }
    project.globals.iter().flat_map(|(_, all)| all).for_each(|one| add(one, 1));
    let direct = direct.into_iter().filter_map(|at| Some((bits(&at)?, at)));
    all.extend(direct.map(|(taken, at)| (at, Some(TypeRef::Text(None)), taken)));
    let is_whole = all.iter().any(|(_, kind, _)| kind.is_none());
    let pairs = meeting(all.iter().map(|(.., taken)| *taken));
    let differs = pairs.iter().any(|&(one, other)| {
        let (one, other) = (&all[one], &all[other]);
        one.0 != other.0 || one.1 != other.1
    });
    let several = all.len() > 1;
    (!pairs.is_empty() || (is_whole && several), differs || (is_whole && several))
}

/// The words of 8 bits in a variable, and whether they have a sign; of arrays, if they are asked for.
fn bytes(place: &Place, with_arrays: bool, found: &mut BTreeSet<(Cell, bool)>) {
    if found.len() >= MAX_CONSTRAINED {
        return;
    }
    match &place.ty {
        Ty::Number(Kind::Whole { bits: 8, signed }) => {
            found.extend(place.tag.cell().map(|cell| (cell, *signed)));
        }
        Ty::Parts(parts) => {
            let parts = parts.iter().filter_map(|(name, _)| Emit::part(place, name));
            parts.for_each(|part| bytes(&part, with_arrays, found));
        }
        Ty::Array { dimensions, of } if with_arrays => {
            let [(low, high)] = dimensions[..] else { return };
            for index in (low..=high).take(MAX_CONSTRAINED) {
                let Some(tag) = place.tag.element(index) else { return };
                bytes(&Place { name: String::new(), tag, ty: (**of).clone() }, true, found);
            }
        }
        _ => {}
    }
}

/// Elements of larger arrays are not looked at one by one: that they share bits is refused.
const MAX_SHARED: i64 = 100_000;

/// The parts of what has an address that have values of their own.
fn parts(one: &Located, number: usize, found: &mut Vec<Shared>) {
    let (area, taken) = one.taken;
    let size = |ty: &Ty| match ty {
        Ty::Bit => Some(1),
        Ty::Number(Kind::Whole { bits, .. }) => Some(u64::from(*bits)),
        // Controllers differ in the bits of a time.
        Ty::Number(Kind::Real) => Some(32),
        _ => None,
    };
    let first = taken.map(|(from, _)| from);
    if let Ty::Array { dimensions, of } = &one.place.ty
        && let ([(low, high)], Some(bits @ 2..)) = (&dimensions[..], size(of))
        && high - low < MAX_SHARED
    {
        for (at, index) in (0..).zip(*low..=*high) {
            let Some(tag) = one.place.tag.element(index) else { continue };
            let name = format!("{}[{index}]", one.place.name);
            let place = Place { name, tag, ty: (**of).clone() };
            let first = first.map(|first| first.saturating_add(bits * at));
            let end = first.map(|first| first.saturating_add(bits));
            found.push(Shared { area, place, first, size: Some(bits), end, number });
        }
        return;
    }
    let (place, size, end) = (one.place.clone(), size(&one.place.ty), taken.map(|(_, to)| to));
    found.push(Shared { area, place, first, size, end, number });
}
