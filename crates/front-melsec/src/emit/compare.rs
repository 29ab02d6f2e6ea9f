//! Comparison contacts: 16 and 32 bits, unsigned, real and string.

use super::units::LONGEST_TEXT;
use super::{Emitter, timing};
use crate::mnemonic::Sort;
use crate::operand::Operand;
use crate::source::RawInstruction;
use scanbound_ir::{
    BitSource, Compare, Join, Logic, Number, NumberFormat, Relation, Step, Units, WordSource,
};

impl Emitter<'_> {
    pub(super) fn comparison(
        &mut self,
        mnemonic: &str,
        raw: &RawInstruction,
        join: Join,
        sort: Sort,
        relation: Relation,
    ) {
        let class = match sort {
            Sort::Integer { words: 1, .. } => "compare",
            Sort::Integer { .. } => "compare-double",
            Sort::Real { .. } => "compare-real",
            Sort::Text => "compare-string",
            Sort::Clock => "clock",
        };
        let join = self.join(join, mnemonic);
        let units = if sort == Sort::Text { Units::AtMost(LONGEST_TEXT) } else { Units::None };
        let key = timing(mnemonic, false, None, class, units, true);
        let value = if self.takes(raw, if sort == Sort::Clock { 3 } else { 2 }) {
            self.compared(raw, sort, relation)
        } else {
            None
        };
        let value = value.unwrap_or(Logic::Const(false));
        self.add(Some(key), Vec::new(), Step::Logic { join, value });
    }

    fn compared(&mut self, raw: &RawInstruction, sort: Sort, relation: Relation) -> Option<Logic> {
        let (left, right) = (&raw.operands[0], &raw.operands[1]);
        let (words, format) = match sort {
            Sort::Integer { words, signed } => {
                (words, if signed { NumberFormat::Signed } else { NumberFormat::Unsigned })
            }
            Sort::Real { words: 2 } => (2, NumberFormat::Real(self.choice())),
            Sort::Real { .. } => {
                return self.unknown_comparison(raw, "a double-precision comparison");
            }
            Sort::Text => return self.compared_text(raw, left, right, relation),
            Sort::Clock => return self.unknown_comparison(raw, "a comparison of dates or times"),
        };
        let (left, right) = (self.number(left, words), self.number(right, words));
        let (left, right) = (left?, right?);
        Some(Logic::Compare(Box::new(Compare { relation, format, left, right })))
    }

    fn unknown_comparison(&mut self, raw: &RawInstruction, what: &str) -> Option<Logic> {
        for text in &raw.operands {
            self.operand(text)?;
        }
        self.approximate(format!("{what} is taken as true or false"));
        Some(self.free_bit())
    }

    /// Equality with a constant is equality of the words that hold it: two characters a word, the first in
    /// the low byte, a zero byte behind the last.
    fn compared_text(
        &mut self,
        raw: &RawInstruction,
        left: &str,
        right: &str,
        relation: Relation,
    ) -> Option<Logic> {
        let text = |operand: &str| match self.parsed(operand) {
            Ok(Operand::Text(text)) if text.is_ascii() => Some(text),
            _ => None,
        };
        let (constant, device) = match (text(left), text(right)) {
            (Some(constant), None) => (constant, right),
            (None, Some(constant)) => (constant, left),
            _ => return self.unknown_comparison(raw, "a comparison of strings"),
        };
        if !matches!(relation, Relation::Equal | Relation::NotEqual) {
            return self.unknown_comparison(raw, "a comparison of strings by order");
        }
        let mut bytes = constant.into_bytes();
        bytes.push(0);
        let words = self.read_words(device, bytes.len().div_ceil(2))?;
        let mut parts = Vec::new();
        for (pair, &source) in bytes.chunks(2).zip(&words) {
            match (pair, source) {
                (&[low, high], _) => {
                    let right = WordSource::Const(u16::from_le_bytes([low, high]));
                    parts.push(Logic::Compare(Box::new(Compare {
                        relation: Relation::Equal,
                        format: NumberFormat::Unsigned,
                        left: Number::Words(vec![source]),
                        right: Number::Words(vec![right]),
                    })));
                }
                // Only the zero byte is left: the high byte may be anything.
                (_, WordSource::Cell(cell)) => {
                    parts.extend((0..8).map(|bit| Logic::Bit(BitSource::WordBit(cell, bit)).not()));
                }
                _ => parts.push(self.free_bit()),
            }
        }
        let equal = Logic::All(parts);
        Some(if relation == Relation::Equal { equal } else { equal.not() })
    }
}
