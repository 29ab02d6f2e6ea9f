//! Blocks that move by one place, and comparisons that set three bits: followed exactly where their places are known.

use super::access::{BitPlace, WordPlace};
use super::{Decoder, fired};
use crate::dialect::melsec::catalog::{Amount, Entry, Extent};
use crate::dialect::melsec::source::RawInstruction;
use crate::program::{
    BitSource, BitTarget, Cell, Compare, Effect, Logic, Number, Reading, Relation, WordSource,
    WordTarget, Write,
};

/// Blocks of more places than this are forgotten rather than followed.
const MOST_PLACES: i64 = 512;

impl Decoder<'_> {
    /// A block of bits or words, each taking its neighbour's place: towards the higher numbers or the lower ones. What
    /// comes in is zero.
    pub(super) fn slide(
        &mut self,
        raw: &RawInstruction,
        entry: &Entry,
        up: bool,
    ) -> Option<Option<Vec<Effect>>> {
        let Some(count) = self.constant(&raw.operands[1]).filter(|n| (1..=MOST_PLACES).contains(n))
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

    /// The bits that tell whether the first number is larger, equal or smaller.
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
        let reading = match entry.mnemonic.ends_with("_U") {
            true => Reading::Unsigned,
            false => Reading::Signed,
        };
        // The bits may be among what is compared: all are worked out before any is written.
        let reads_them = |number: &Number| match number {
            Number::Words(sources) => sources.iter().any(|source| overlaps(source, first)),
            _ => true,
        };
        if reads_them(&left) || reads_them(&right) {
            return Some(None);
        }
        let relations = [Relation::Greater, Relation::Equal, Relation::Less];
        let bits = (0..).zip(relations).map(|(n, relation)| {
            let compare = Compare { relation, reading, left: left.clone(), right: right.clone() };
            let holds = Logic::Compare(Box::new(compare));
            fired(Write::Bit(BitTarget::Cell(first.plus(n)), holds))
        });
        Some(Some(bits.collect()))
    }
}

/// Whether a word is read from the three bits from one on.
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

/// The moves of bits one by one, in an order in which none is lost.
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
