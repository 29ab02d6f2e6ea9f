//! Block instructions: shifts by one place, element-wise arithmetic and comparisons; also stores of a constant text,
//! and comparisons with three result bits. They are exact if the cells are known.
//!
//! Methods that return `Option<Option<_>>` give `None` after an error that they have reported, and `Some(None)` where
//! the effects are not modelled exactly; the caller then lets everything that the instruction writes have any value.

use super::access::{BitPlace, WordPlace};
use super::state::Lowering;
use crate::catalog::{Amount, Entry, Extent};
use crate::memory::{DeviceType, Family};
use crate::mnemonic::relation;
use crate::operand::{Operand, Place};
use crate::source::RawInstruction;
use scanbound_front::builder::fired;
use scanbound_ir::{
    BitSource, BitTarget, Cell, Compare, Effect, Logic, Number, NumberFormat, Region, Relation,
    WordSource, WordTarget, Write,
};

/// The largest number of cells of a block that is modelled exactly; a larger block is havocked.
const MAX_PLACES: i64 = 512;
/// The largest number of characters of a constant text that is stored exactly.
const LONGEST_CONSTANT: usize = 32;

impl Lowering<'_> {
    /// The effects of an instruction that shifts a block of bits or words by one place, to higher (`up`) or lower
    /// device numbers. The device at the free end becomes zero.
    pub(super) fn slide(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
        up: bool,
    ) -> Option<Option<Vec<Effect>>> {
        let Some(count) = self
            .constant(&raw.operands[1])
            .filter(|n| (1..=MAX_PLACES).contains(n) && self.has_room(*n))
        else {
            return Some(None);
        };
        let text = &raw.operands[0];
        if let Extent::Bits(Amount::Counted { .. }) = entry.operands[0].extent {
            let BitPlace::One(BitTarget::Cell(first)) = self.bit_place(text)? else {
                return Some(None);
            };
            return Some(Some(slid_bits(first, count as u32, up)));
        }
        let WordPlace::All(targets) = self.word_place(text, count as usize)? else {
            return Some(None);
        };
        let is_cell = |target: &WordTarget| matches!(target, WordTarget::Cell(_));
        if !targets.iter().all(is_cell) {
            return Some(None);
        }
        let mut words = self.read_words(text, count as usize)?;
        let nothing = WordSource::Const(0);
        if up {
            words.pop();
            words.insert(0, nothing);
        } else {
            words.remove(0);
            words.push(nothing);
        }
        Some(Some(vec![fired(Write::Words(targets, Number::Words(words)))]))
    }

    /// The effects of an instruction that computes each element of a block from the elements at the same position in
    /// two blocks; either may be a constant instead.
    pub(super) fn pairwise(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
    ) -> Option<Option<Vec<Effect>>> {
        let Extent::Words(Amount::Counted { unit, .. }) = entry.operands[0].extent else {
            return Some(None);
        };
        let Some(count) = self
            .constant(&raw.operands[3])
            .filter(|n| (1..=MAX_PLACES).contains(n) && self.has_room(*n))
        else {
            return Some(None);
        };
        let (unit, count) = (unit as usize, count as usize);
        let name = entry.mnemonic.trim_start_matches('D');
        let is_sum = name.starts_with("BK+") || name.starts_with("BK-");
        // The result after overflow is unknown on the FX and FX5.
        if is_sum && matches!(self.family, Family::Fx | Family::Fx5) {
            return Some(None);
        }
        let mut sides = Vec::new();
        for text in &raw.operands[..2] {
            let words = if self.constant(text).is_some() {
                let one = self.read_words(text, unit)?;
                one.into_iter().cycle().take(unit * count).collect()
            } else {
                self.read_words(text, unit * count)?
            };
            // Only plain words have cells of their own; bits, volatile and computed words do not.
            if !words.iter().all(|word| matches!(word, WordSource::Cell(_) | WordSource::Const(_)))
            {
                return Some(None);
            }
            sides.push(words);
        }
        let elements = (0..count).map(|n| {
            let part = |side: &Vec<WordSource>| Number::Words(side[n * unit..][..unit].to_vec());
            (part(&sides[0]), part(&sides[1]))
        });
        if let Some(symbol) = name.strip_prefix("BKCMP") {
            let unsigned = symbol.strip_suffix("_U");
            let format =
                if unsigned.is_some() { NumberFormat::Unsigned } else { NumberFormat::Signed };
            let Some(relation) = relation(unsigned.unwrap_or(symbol)) else { return Some(None) };
            let BitPlace::One(BitTarget::Cell(first)) = self.bit_place(&raw.operands[2])? else {
                return Some(None);
            };
            let holds: Vec<Logic> = elements
                .map(|(left, right)| {
                    Logic::Compare(Box::new(Compare { relation, format, left, right }))
                })
                .collect();
            let all = self.block_result.map(|cell| (cell, Logic::All(holds.clone())));
            let bits = (0..).zip(holds).map(|(n, holds)| (first.plus(n), holds)).chain(all);
            let bits = bits.map(|(cell, holds)| fired(Write::Bit(BitTarget::Cell(cell), holds)));
            return Some(Some(bits.collect()));
        }
        let WordPlace::All(targets) = self.word_place(&raw.operands[2], unit * count)? else {
            return Some(None);
        };
        if sides.iter().any(|side| is_displaced_overlap(side, &targets)) {
            return Some(None);
        }
        let last = name.trim_end_matches("_U");
        let result = |(a, b): (Number, Number)| {
            let (a, b) = (Box::new(a), Box::new(b));
            match last {
                "BK+" => Number::Add(a, b),
                "BK-" => Number::Sub(a, b),
                "BKAND" => Number::And(a, b),
                "BKOR" => Number::Or(a, b),
                "BKXOR" => Number::Xor(a, b),
                _ => Number::Xor(
                    Box::new(Number::Xor(a, b)),
                    Box::new(Number::Words(vec![WordSource::Const(u16::MAX); unit])),
                ),
            }
        };
        let parts = targets.chunks(unit).zip(elements);
        let write = |(targets, pair): (&[WordTarget], _)| {
            fired(Write::Words(targets.to_vec(), result(pair)))
        };
        Some(Some(parts.map(write).collect()))
    }

    /// The effects of storing a constant text, two characters a word, the first in the low byte. If a word holds only
    /// the closing NUL, its high byte is unknown.
    pub(super) fn constant_text(&mut self, raw: &RawInstruction) -> Option<Option<Vec<Effect>>> {
        let text = match self.parsed(&raw.operands[0]) {
            Ok(Operand::Text(text)) if text.is_ascii() && text.len() <= LONGEST_CONSTANT => text,
            _ => return Some(None),
        };
        let count = text.len() / 2 + 1;
        let Place::At(DeviceType::Word(_), _) = self.device(&raw.operands[1])?.place else {
            return Some(None);
        };
        let WordPlace::All(mut targets) = self.word_place(&raw.operands[1], count)? else {
            return Some(None);
        };
        let is_even = text.len().is_multiple_of(2);
        let last = if is_even { targets.pop() } else { None };
        let mut bytes = text.into_bytes();
        bytes.resize(2 * targets.len(), 0);
        let words =
            bytes.chunks(2).map(|two| WordSource::Const(u16::from_le_bytes([two[0], two[1]])));
        let mut effects = Vec::new();
        if !targets.is_empty() {
            let words = Number::Words(words.collect());
            effects.push(fired(Write::Words(targets, words)));
        }
        if let Some(WordTarget::Cell(cell)) = last {
            let region = Region::Range { first: cell, count: 1 };
            effects.push(fired(Write::Havoc(region, self.choice())));
            let no_bit = |bit| Write::Bit(BitTarget::WordBit(cell, bit), Logic::Const(false));
            effects.extend((0..8).map(|bit| fired(no_bit(bit))));
        }
        Some(Some(effects))
    }

    /// The effects of an instruction that writes three consecutive bits: whether the first number is larger than the
    /// second, equal, or smaller.
    pub(super) fn compare_to_bits(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
    ) -> Option<Option<Vec<Effect>>> {
        let Extent::Words(Amount::Fixed(words)) = entry.operands[0].extent else {
            return Some(None);
        };
        let (left, right) = (
            self.number(&raw.operands[0], words as usize)?,
            self.number(&raw.operands[1], words as usize)?,
        );
        let BitPlace::One(BitTarget::Cell(first)) = self.bit_place(&raw.operands[2])? else {
            return Some(None);
        };
        let format = match entry.mnemonic.ends_with("_U") {
            true => NumberFormat::Unsigned,
            false => NumberFormat::Signed,
        };
        // The result bits may be part of the compared words, so all are computed before any is written.
        let reads_them = |number: &Number| match number {
            Number::Words(sources) => sources.iter().any(|source| overlaps(source, first)),
            _ => true,
        };
        if reads_them(&left) || reads_them(&right) {
            return Some(None);
        }
        let relations = [Relation::Greater, Relation::Equal, Relation::Less];
        let bits = (0..).zip(relations).map(|(n, relation)| {
            let compare = Compare { relation, format, left: left.clone(), right: right.clone() };
            let holds = Logic::Compare(Box::new(compare));
            fired(Write::Bit(BitTarget::Cell(first.plus(n)), holds))
        });
        Some(Some(bits.collect()))
    }
}

/// Whether a block may be written over cells that the same instruction reads at other positions, so that the order of
/// its steps matters. True for targets that are not whole cells, which are not compared.
fn is_displaced_overlap(read: &[WordSource], written: &[WordTarget]) -> bool {
    let cell = |word: &WordSource| match word {
        WordSource::Cell(cell) => Some(*cell),
        _ => None,
    };
    written.iter().enumerate().any(|(at, target)| match target {
        WordTarget::Cell(target) => {
            read.iter().enumerate().any(|(n, word)| n != at && cell(word) == Some(*target))
        }
        WordTarget::Bits { .. } | WordTarget::Discard => true,
    })
}

/// Whether a word contains one of the three bits that begin at `bits`.
fn overlaps(source: &WordSource, bits: Cell) -> bool {
    match *source {
        WordSource::Bits { first, count } => {
            first.area == bits.area
                && first.index < bits.index + 3
                && bits.index < first.index + u32::from(count)
        }
        _ => false,
    }
}

/// The effects that shift `count` bits by one place, bit by bit, in an order in which none is overwritten before it is
/// read.
fn slid_bits(first: Cell, count: u32, up: bool) -> Vec<Effect> {
    let set = |n, value| fired(Write::Bit(BitTarget::Cell(first.plus(n)), value));
    let bit = |n| Logic::Bit(BitSource::Cell(first.plus(n)));
    let mut effects: Vec<Effect> = if up {
        (1..count).rev().map(|n| set(n, bit(n - 1))).collect()
    } else {
        (1..count).map(|n| set(n - 1, bit(n))).collect()
    };
    effects.push(set(if up { 0 } else { count - 1 }, Logic::Const(false)));
    effects
}
