//! Types for the memory places of variables, instances and array elements.

use scanbound_iec_tree::blocks::StandardBlock;
use scanbound_iec_tree::declarations::{RoutineId, UnitId};
use scanbound_iec_tree::types::TypeId;
use scanbound_ir::meaning::{Address, IntegerFormat, Term};
use scanbound_ir::{Cell, Region, RegionSet, Tag, WordSource};
use std::collections::BTreeMap;

/// The number of ways in which controllers number addresses: all count bytes; each counts units of its own size, and
/// bit addresses bytes; each counts units of its own size, and bit addresses words.
pub(super) const WAYS: usize = 3;

/// An area (I, Q or M), and the half-open range of bits in it, once for each way of numbering.
pub(super) type Bits = (char, [(u64, u64); WAYS]);

/// A variable or a part of one, with its cells and its type.
#[derive(Debug, Clone)]
pub(super) struct Spot {
    pub(super) name: String,
    pub(super) tag: Tag,
    pub(super) ty: TypeId,
}

/// An instance of a unit, with the memory of its variables.
#[derive(Debug, Clone)]
pub(super) struct Instance {
    pub(super) unit: UnitId,
    pub(super) spot: Spot,
}

/// The instance, and the method if any, whose code is being lowered.
#[derive(Debug, Clone)]
pub(super) struct Context {
    pub(super) instance: usize,
    /// The memory of the method's variables, if the code is that of a method.
    pub(super) frame: Option<Spot>,
}

/// An array element whose index is computed at run time.
#[derive(Debug, Clone)]
pub(super) struct Element {
    /// The selected part, as it is in the array's first element.
    pub(super) spot: Spot,
    /// For each index: its words, and the size of one step of it, in bits and in words.
    pub(super) terms: Vec<(Vec<WordSource>, [i64; 2])>,
    /// The offset that makes the lowest index 0, in bits and in words.
    pub(super) base: [i64; 2],
    /// The outermost array: the element lies within its cells.
    pub(super) whole: Spot,
}

/// The result of looking up a place.
#[derive(Debug, Clone)]
pub(super) enum Found {
    Spot(Spot),
    Element(Element),
    /// A bit of a word, and the last bit that gets the same value. Usually both are the same bit; the sign of an 8-bit
    /// number fills the rest of its word.
    WordBit(Cell, u8, u8),
}

impl Element {
    /// The first cell and the count of the array's cells in the area (bits or words) of the selected part. None if
    /// there is no such area.
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

/// The variables whose addresses the code takes. The word of a reference is its target's number here, from 1; 0 is
/// NULL.
#[derive(Default)]
pub(super) struct Targets {
    pub(super) spots: Vec<Spot>,
    pub(super) numbers: BTreeMap<SpotKey, usize>,
    /// For each of `spots`: the memory of the variables with an address (AT) to which it belongs. Empty until all
    /// targets are known.
    pub(super) addresses: Vec<Vec<Bits>>,
    /// The cells of all of `spots`. Empty until all targets are known.
    pub(super) regions: RegionSet,
    /// Whether the address of an element with a calculated index is taken, so that a reference may lead outside of an
    /// array.
    pub(super) may_be_outside: bool,
}

/// Identifies a variable by its first cells and its type, since a variable and its first part begin at the same cells.
pub(super) type SpotKey = ([Cell; 2], TypeId);

impl Spot {
    /// The key that identifies this variable: its first cells and its type.
    pub(super) fn key(&self) -> SpotKey {
        (self.tag.begin(), self.ty)
    }
}

/// What a call calls, with the memory of its parameters.
#[derive(Clone)]
pub(super) enum Callee {
    /// An instance of a unit (a program, function block or function), with its memory.
    Unit(Spot, UnitId),
    /// A method, with the memory of its variables.
    Method(Spot, RoutineId),
    /// A standard function block, with its memory.
    Standard(Spot, StandardBlock),
}
