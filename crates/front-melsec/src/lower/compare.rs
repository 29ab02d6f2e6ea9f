//! Lowers comparison contacts: integers of 16 and 32 bits, unsigned, real numbers and strings.

use super::state::{Lowering, timing};
use super::units::LONGEST_TEXT;
use crate::mnemonic::OperandType;
use crate::operand::Operand;
use crate::source::RawInstruction;
use scanbound_ir::{
    BitSource, Compare, Join, Logic, Number, NumberFormat, Relation, Step, Units, WordSource,
};

impl Lowering<'_> {
    pub(super) fn comparison(
        &mut self,
        mnemonic: &str,
        raw: &RawInstruction,
        join: Join,
        sort: OperandType,
        relation: Relation,
    ) {
        let class = match sort {
            OperandType::Integer { words: 1, .. } => "compare",
            OperandType::Integer { .. } => "compare-double",
            OperandType::Real { .. } => "compare-real",
            OperandType::Text => "compare-string",
            OperandType::Clock => "clock",
        };
        let join = self.join(join, mnemonic);
        let units =
            if sort == OperandType::Text { Units::AtMost(LONGEST_TEXT) } else { Units::None };
        let key = timing(mnemonic, false, None, class, units, true);
        let value = if self.takes(raw, if sort == OperandType::Clock { 3 } else { 2 }) {
            self.compared(raw, sort, relation)
        } else {
            None
        };
        let value = value.unwrap_or(Logic::Const(false));
        self.add(Some(key), Vec::new(), Step::Logic { join, value });
    }

    fn compared(
        &mut self,
        raw: &RawInstruction,
        sort: OperandType,
        relation: Relation,
    ) -> Option<Logic> {
        let (left, right) = (&raw.operands[0], &raw.operands[1]);
        let (words, format) = match sort {
            OperandType::Integer { words, signed } => {
                (words, if signed { NumberFormat::Signed } else { NumberFormat::Unsigned })
            }
            OperandType::Real { words: 2 } => (2, NumberFormat::Real(self.choice())),
            OperandType::Real { .. } => {
                return self.unknown_comparison(raw, "a double-precision comparison");
            }
            OperandType::Text => return self.compared_text(raw, left, right, relation),
            OperandType::Clock => {
                return self.unknown_comparison(raw, "a comparison of dates or times");
            }
        };
        let (left, right) = (self.number(left, words), self.number(right, words));
        let (left, right) = (left?, right?);
        Some(Logic::Compare(Box::new(Compare { relation, format, left, right })))
    }

    fn unknown_comparison(&mut self, raw: &RawInstruction, what: &str) -> Option<Logic> {
        for text in &raw.operands {
            self.operand(text)?;
        }
        self.approximate(format!("the result of {what} is not computed: both results, true and false, are assumed possible"));
        Some(self.free_bit())
    }

    /// The comparison, for equal or not equal, of a string with a constant. They are equal if their words are equal:
    /// two characters a word, the first in the low byte, and a zero byte at the end. Other comparisons of strings are
    /// not computed and may be true or false. `None` after an error that was reported.
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
            return self.unknown_comparison(raw, "a comparison that asks which string is larger");
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
                // Only the closing zero byte is compared: the high byte may be anything.
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
