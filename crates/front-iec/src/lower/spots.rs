//! Where variables lie.

use scanbound_iec_tree::blocks::StandardBlock;
use scanbound_iec_tree::declarations::{RoutineId, UnitId};
use scanbound_iec_tree::types::TypeId;
use scanbound_ir::meaning::{Address, IntegerFormat, Term};
use scanbound_ir::{Cell, Region, Tag, WordSource};
use std::collections::BTreeMap;

/// A variable, or a part of one, where it lies.
#[derive(Debug, Clone)]
pub(super) struct Spot {
    pub(super) name: String,
    pub(super) tag: Tag,
    pub(super) ty: TypeId,
}

/// An instance of a unit.
#[derive(Debug, Clone)]
pub(super) struct Instance {
    pub(super) unit: UnitId,
    pub(super) spot: Spot,
}

/// Where a statement stands.
#[derive(Debug, Clone)]
pub(super) struct Context {
    pub(super) instance: usize,
    /// The variables of the method that is executed.
    pub(super) frame: Option<Spot>,
}

/// An element of an array whose number is worked out.
#[derive(Debug, Clone)]
pub(super) struct Element {
    /// The part that is meant, in the array's first element.
    pub(super) spot: Spot,
    /// Indices, and how many bits and words they count in.
    pub(super) terms: Vec<(Vec<WordSource>, [i64; 2])>,
    /// What the least indices take off, in bits and in words.
    pub(super) base: [i64; 2],
    /// The array that bounds it all.
    pub(super) whole: Spot,
}

/// What a place is.
#[derive(Debug, Clone)]
pub(super) enum Found {
    Spot(Spot),
    Element(Element),
    /// A bit of a word, and the last of those that follow it: the sign of 8 bits fills its word.
    WordBit(Cell, u8, u8),
}

impl Element {
    /// All cells of the array of the kind that is meant.
    pub(super) fn region(&self) -> Option<(Cell, u32)> {
        let own = self.spot.tag.cell()?;
        self.whole.tag.regions().into_iter().find_map(|region| match region {
            Region::Range { first, count } if first.area == own.area => Some((first, count)),
            _ => None,
        })
    }

    pub(super) fn address(&self, is_bit: bool) -> Option<Address> {
        let (first, count) = self.region()?;
        let offset = i64::from(self.spot.tag.cell()?.index - first.index);
        let side = usize::from(!is_bit);
        let term = |(words, sizes): &(Vec<WordSource>, [i64; 2])| Term {
            words: words.clone(),
            format: IntegerFormat::Signed,
            factor: sizes[side],
        };
        let terms = self.terms.iter().map(term).collect();
        Some(Address::within(first, count, self.base[side] + offset, terms))
    }
}

/// The variables whose addresses are taken; the word for each is its number here, from 1.
#[derive(Default)]
pub(super) struct Targets {
    pub(super) spots: Vec<Spot>,
    pub(super) numbers: BTreeMap<SpotKey, usize>,
}

/// What tells variables apart: where they lie, and their types, since the first part of one lies where it does.
pub(super) type SpotKey = ([Cell; 2], TypeId);

impl Spot {
    /// What tells it apart from others.
    pub(super) fn key(&self) -> SpotKey {
        (self.tag.begin(), self.ty)
    }
}

/// Whose parameters are passed, and where they lie.
#[derive(Clone)]
pub(super) enum Callee {
    /// An instance of a unit, or a function.
    Unit(Spot, UnitId),
    /// A method, by its frame.
    Method(Spot, RoutineId),
    /// A standard block.
    Standard(Spot, StandardBlock),
}
