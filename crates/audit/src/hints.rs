//! What a net knows of its code's relays, as sets of a program's bits.

use super::stated;
use scanbound_ir::{BitSource, BitTarget, Program};
use scanbound_snet::knowledge::knowledge;
use scanbound_snet::translate::{Operand, Spelling};
use scanbound_snet::{Diagram, Head};
use std::collections::BTreeMap;

/// What a net knows, as sets of a program's bits.
pub struct Hints<'a> {
    diagram: &'a Diagram,
    sets: Vec<Vec<Operand>>,
    bits: BTreeMap<Operand, BitTarget>,
}

impl<'a> Hints<'a> {
    /// A net's hints for a program.
    #[must_use]
    pub fn of(diagram: &'a Diagram, program: &Program) -> Hints<'a> {
        let sets = knowledge(diagram).apart;
        let spelling = Spelling::of(&|cell| stated::cell(program, cell).is_some());
        let bit = |operand: &Operand| {
            let address = head(diagram, *operand)?.address?;
            match stated::bit(program, &spelling.device(address)?)? {
                BitSource::Cell(cell) => Some(BitTarget::Cell(cell)),
                BitSource::WordBit(cell, bit) => Some(BitTarget::WordBit(cell, bit)),
                BitSource::Const(_) | BitSource::Free(_) => None,
            }
        };
        let places = (0..diagram.places.len()).map(Operand::Place);
        let all = places.chain((0..diagram.transitions.len()).map(Operand::Transition));
        let bits = all.filter_map(|operand| Some((operand, bit(&operand)?))).collect();
        Hints { diagram, sets, bits }
    }

    /// The sets of which every element has a relay.
    #[must_use]
    pub fn bits(&self) -> Vec<Vec<BitTarget>> {
        self.sets.iter().filter_map(|set| self.bits_of(set)).collect()
    }

    /// The sets.
    #[must_use]
    pub fn sets(&self) -> &[Vec<Operand>] {
        &self.sets
    }

    /// An element's relay.
    #[must_use]
    pub fn bit(&self, operand: Operand) -> Option<BitTarget> {
        self.bits.get(&operand).copied()
    }

    /// The relays of a set, if every element has one.
    #[must_use]
    pub fn bits_of(&self, set: &[Operand]) -> Option<Vec<BitTarget>> {
        set.iter().map(|operand| self.bits.get(operand).copied()).collect()
    }

    /// What the net calls an element.
    #[must_use]
    pub fn name(&self, operand: Operand) -> String {
        match operand {
            Operand::Place(at) => self.diagram.place_name(at),
            Operand::Transition(at) => self.diagram.transition_name(at),
            Operand::Contact(_) | Operand::Outer(_) | Operand::FirstScan => String::new(),
        }
    }
}

fn head(diagram: &Diagram, operand: Operand) -> Option<&Head> {
    match operand {
        Operand::Place(at) => Some(&diagram.places[at].head),
        Operand::Transition(at) => Some(&diagram.transitions[at].head),
        Operand::Contact(_) | Operand::Outer(_) | Operand::FirstScan => None,
    }
}
