//! What an S-net states about the relays of the code made from it, converted to the bits of a program.

use super::stated;
use scanbound_ir::{BitSource, BitTarget, Program};
use scanbound_nets::relays::Relays;

/// The sets of elements (places and transitions) that an S-net makes mutually exclusive, and for each element the bit
/// of the program that represents it. An element is named by its index.
pub struct Hints<'a> {
    net: &'a Relays,
    /// For each element of the net, the program's bit that represents it. `None` if the program has none. Empty if the
    /// net does not name relays for this type of CPU.
    bits: Vec<Option<BitTarget>>,
}

impl<'a> Hints<'a> {
    /// Converts a net's relays to the bits of a program.
    #[must_use]
    pub fn of(net: &'a Relays, program: &Program) -> Hints<'a> {
        let has = |sign: &str| stated::cell(program, sign).is_some();
        let spelling = net.spellings.iter().find(|one| one.sign.is_none_or(has));
        let bit = |device: &Option<String>| match stated::bit(program, device.as_ref()?)? {
            BitSource::Cell(cell) => Some(BitTarget::Cell(cell)),
            BitSource::WordBit(cell, bit) => Some(BitTarget::WordBit(cell, bit)),
            BitSource::Const(_) | BitSource::Free(_) => None,
        };
        let devices = spelling.map_or(&[][..], |one| &one.devices);
        Hints { net, bits: devices.iter().map(bit).collect() }
    }

    /// The mutually exclusive sets, as bits of the program. Sets with an element without a bit are left out.
    #[must_use]
    pub fn bits(&self) -> Vec<Vec<BitTarget>> {
        self.net.exclusive.iter().filter_map(|set| self.bits_of(set)).collect()
    }

    /// All sets of elements that the net makes mutually exclusive, also those with elements without a bit.
    #[must_use]
    pub fn sets(&self) -> &'a [Vec<usize>] {
        &self.net.exclusive
    }

    /// The bit that represents an element. `None` if there is none.
    #[must_use]
    pub fn bit(&self, element: usize) -> Option<BitTarget> {
        self.bits.get(element).copied().flatten()
    }

    /// The bits that represent the elements of a set. `None` if an element has no bit.
    #[must_use]
    pub fn bits_of(&self, set: &[usize]) -> Option<Vec<BitTarget>> {
        set.iter().map(|&element| self.bit(element)).collect()
    }

    /// The name of an element in the net.
    #[must_use]
    pub fn name(&self, element: usize) -> String {
        self.net.elements[element].name.clone()
    }

    /// Whether an element is a place of the net, not a transition.
    #[must_use]
    pub fn is_place(&self, element: usize) -> bool {
        self.net.elements[element].is_place
    }

    /// The indices of the net's places, ascending.
    pub fn places(&self) -> impl Iterator<Item = usize> {
        (0..self.net.elements.len()).filter(|&element| self.is_place(element))
    }
}
