//! What MELSEC instructions really do where the effects say any value: kinds of choices, indexed places, operations.

use super::Decoder;
use crate::dialect::melsec::catalog::Entry;
use crate::dialect::melsec::device::{Family, Kind, area};
use crate::dialect::melsec::operand::{Device, Index, Place};
use crate::dialect::melsec::source::RawInstruction;
use crate::program::meaning::{
    Address, ChoiceKind, Count, Meaning, Operand, Operation, Shape, Target, Term, Unary,
};
use crate::program::{AreaId, BitSource, Cell, ChoiceId, Effect, Logic, When, WordSource, Write};

impl Decoder<'_> {
    /// A bit that the outside may give any value.
    pub(super) fn world_bit(&mut self) -> Logic {
        Logic::Bit(BitSource::Free(self.world()))
    }

    /// A word that the outside may give any value.
    pub(super) fn world_word(&mut self) -> WordSource {
        WordSource::Free(self.world())
    }

    /// A choice of the outside's.
    pub(super) fn world(&mut self) -> ChoiceId {
        let choice = self.choice();
        self.program.kinds.insert(choice, ChoiceKind::World);
        choice
    }

    /// Whether the outside gives a device any value: direct inputs, modules' memory, links, clocks. What instructions
    /// leave in special relays and registers (carry, errors) is not the outside's.
    pub(super) fn is_world(&self, device: &Device) -> bool {
        match device.place {
            // A step of an SFC program is none; its text is not told apart here.
            Place::Foreign(_) => true,
            Place::At(Kind::VolatileBit, index) => match device.name {
                "DX" => true,
                "SM" => (409..=499).contains(&index),
                "M" => (8011..=8014).contains(&index),
                _ => false,
            },
            Place::At(Kind::VolatileWord, index) => match device.name {
                "SD" => (210..=213).contains(&index) || (412..=414).contains(&index),
                "D" => (8013..=8019).contains(&index),
                _ => false,
            },
            _ => false,
        }
    }

    /// A choice that an operation gives.
    pub(super) fn exactly(&mut self, meaning: Meaning) -> ChoiceId {
        let choice = self.choice();
        self.program.kinds.insert(choice, ChoiceKind::Exact(Box::new(meaning)));
        choice
    }

    /// The cells that an indexed device may be, `offset` cells further on; `None` where they are not known.
    pub(super) fn indexed(&self, device: &Device, offset: u32) -> Option<Address> {
        let Index { number, letters, register, .. } = device.index?;
        let cells = match device.place {
            Place::Indexed(kind, _) | Place::IndexedDigits(kind, _) => match kind {
                Kind::Bit(area) | Kind::Word(area) => area,
                Kind::Timed(timed) => timed.contact,
                Kind::VolatileBit | Kind::VolatileWord => return None,
            },
            _ => return None,
        };
        // Whether an index to a file register has 16 or 32 bits is a parameter.
        let count = certain_points(self.family, cells, device.name)?;
        let term = match letters {
            "Z" => {
                Term::signed(WordSource::Cell(Cell { area: const { area("Z") }, index: register }))
            }
            "V" => Term::signed(WordSource::Cell(Cell {
                area: const { area("V index ") },
                index: register,
            })),
            _ => return None,
        };
        let first = Cell { area: cells, index: 0 };
        Some(Address::within(first, count, i64::from(number) + i64::from(offset), vec![term]))
    }

    /// The words of an indexed device, each worked out where it is read.
    pub(super) fn indexed_words(
        &mut self,
        device: &Device,
        words: usize,
    ) -> Option<Vec<WordSource>> {
        if self.family == Family::Fx && words > 1 {
            // There the index of a double word has 32 bits.
            return None;
        }
        let place = match device.place {
            Place::Indexed(Kind::Word(_), false) => device,
            _ => return None,
        };
        let words: Option<Vec<Address>> =
            (0..words as u32).map(|n| self.indexed(place, n)).collect();
        let word = |address| Meaning::of(Operand::Run(address, Shape::Cells, Count::Exactly(1)));
        Some(
            words?
                .into_iter()
                .map(|address| WordSource::Free(self.exactly(word(address))))
                .collect(),
        )
    }

    /// A bit of an indexed device, worked out where it is read.
    pub(super) fn indexed_bit(&mut self, device: &Device) -> Option<Logic> {
        let address = self.indexed(device, 0)?;
        let shape = match device.index?.bit {
            Some(bit) => Shape::WordBits(bit),
            None => Shape::Cells,
        };
        let meaning = Meaning::of(Operand::Run(address, shape, Count::Exactly(1)));
        Some(Logic::Bit(BitSource::Free(self.exactly(meaning))))
    }

    /// The choice of a write to an indexed device: what is written there, if that is known.
    pub(super) fn indexed_write(&mut self, text: &str, input: Operand, words: usize) -> ChoiceId {
        let meaning = self.device(text).and_then(|device| {
            if self.family == Family::Fx && words > 1 {
                return None;
            }
            let address = self.indexed(&device, 0)?;
            let shape = match (device.place, device.index?.bit) {
                (Place::IndexedDigits(..), _) => return None,
                (_, Some(bit)) => Shape::WordBits(bit),
                (_, None) => Shape::Cells,
            };
            let outputs = vec![Target::Run(address, shape)];
            Some(Meaning { operation: Operation::Copy, inputs: vec![input], outputs })
        });
        match meaning {
            Some(meaning) => self.exactly(meaning),
            None => self.choice(),
        }
    }

    /// Gives the effects of an instruction that writes any value their exact meaning, where it has one.
    pub(super) fn mean(&mut self, raw: &RawInstruction, entry: &Entry, effects: &mut [Effect]) {
        // What has no meaning here is none the less right.
        self.quiet = true;
        let meaning = self.meaning(raw, entry);
        self.quiet = false;
        let Some(meaning) = meaning else { return };
        let choice = self.exactly(meaning);
        for effect in effects {
            if let (When::Fired, Write::Forget(_, own)) = (effect.when, &mut effect.write) {
                *own = choice;
            }
        }
    }

    /// The exact meaning of a catalogued instruction; `None` where it has none here.
    fn meaning(&mut self, raw: &RawInstruction, entry: &Entry) -> Option<Meaning> {
        let name = &*entry.mnemonic;
        let operand = |at: usize| raw.operands.get(at).map(String::as_str);
        let value = |decoder: &mut Self, at: usize, words: usize| {
            decoder.number(operand(at)?, words).map(Operand::Number)
        };
        let one =
            |operation, inputs, output| Some(Meaning { operation, inputs, outputs: vec![output] });
        match name {
            "BCD" | "DBCD" | "BIN" | "DBIN" => {
                let words = if name.starts_with('D') { 2 } else { 1 };
                let unary = if name.ends_with("BCD") { Unary::ToBcd } else { Unary::FromBcd };
                let from = value(self, 0, words)?;
                one(Operation::Each(unary), vec![from], self.target(operand(1)?, words)?)
            }
            "SUM" | "DSUM" => {
                let words = if name == "DSUM" { 2 } else { 1 };
                let from = value(self, 0, words)?;
                // How many words the sum of a double word fills differs between families.
                let result = if words == 2 { return None } else { 1 };
                one(Operation::CountBits(result), vec![from], self.target(operand(1)?, 1)?)
            }
            "ROL" | "ROR" if self.family != Family::Fx => {
                // Of a count beyond the word's bits families make different things.
                let places = self.constant(operand(1)?).filter(|n| (0..16).contains(n))?;
                let left = name == "ROL";
                let inputs = vec![
                    value(self, 0, 1)?,
                    Operand::Words(vec![WordSource::Const(places as u16)]),
                    Operand::Words(vec![WordSource::Const(0)]),
                ];
                let outputs = vec![self.target(operand(0)?, 1)?, Target::Nowhere];
                Some(Meaning {
                    operation: Operation::Rotate { left, through: false },
                    inputs,
                    outputs,
                })
            }
            _ => None,
        }
    }

    /// Where a number of so many words goes, as an operation's result.
    pub(super) fn target(&mut self, text: &str, words: usize) -> Option<Target> {
        let device = self.device(text)?;
        if let Place::Indexed(Kind::Word(_), false) = device.place {
            let is_wide = self.family == Family::Fx && words > 1;
            return Some(Target::Run(self.indexed(&device, 0).filter(|_| !is_wide)?, Shape::Cells));
        }
        match self.word_place(text, words)? {
            super::access::WordPlace::All(targets) => Some(Target::Words(targets)),
            _ => None,
        }
    }
}

/// So many devices of an area every CPU of the family surely has.
fn certain_points(family: Family, cells: AreaId, letters: &str) -> Option<u32> {
    if family == Family::Fx || family == Family::Fx5 {
        return match letters {
            "D" => Some(256),
            "M" => Some(512),
            _ => None,
        };
    }
    let points = [
        ("X", 0x2000),
        ("Y", 0x2000),
        ("M", 8192),
        ("L", 8192),
        ("B", 0x2000),
        ("D", 12_288),
        ("W", 0x2000),
    ];
    let found = points.iter().find(|(name, _)| *name == letters && area(name) == cells);
    found.map(|(_, points)| *points)
}
