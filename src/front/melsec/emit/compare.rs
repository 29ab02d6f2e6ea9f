//! Comparison contacts: 16 and 32 bits, unsigned, real and string.

use super::units::LONGEST_TEXT;
use super::{Emitter, timing};
use crate::front::melsec::operand::Operand;
use crate::front::melsec::source::RawInstruction;
use crate::program::{
    BitSource, Compare, Join, Logic, Number, Reading, Relation, Step, Units, WordSource,
};

/// As what a comparison contact reads its operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sort {
    Integer {
        words: usize,
        signed: bool,
    },
    Real {
        words: usize,
    },
    Text,
    /// Dates or times of day, three words each, and which parts of them.
    Clock,
}

impl Emitter<'_> {
    /// Decodes comparison contacts; false if it is none.
    pub(super) fn comparison(&mut self, mnemonic: &str, raw: &RawInstruction) -> bool {
        let Some((join, sort, relation)) = recognise(mnemonic) else { return false };
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
        true
    }

    fn compared(&mut self, raw: &RawInstruction, sort: Sort, relation: Relation) -> Option<Logic> {
        let (left, right) = (&raw.operands[0], &raw.operands[1]);
        let (words, reading) = match sort {
            Sort::Integer { words, signed } => {
                (words, if signed { Reading::Signed } else { Reading::Unsigned })
            }
            Sort::Real { words: 2 } => (2, Reading::Real(self.choice())),
            Sort::Real { .. } => {
                return self.unknown_comparison(raw, "a double-precision comparison");
            }
            Sort::Text => return self.compared_text(raw, left, right, relation),
            Sort::Clock => return self.unknown_comparison(raw, "a comparison of dates or times"),
        };
        let (left, right) = (self.number(left, words), self.number(right, words));
        let (left, right) = (left?, right?);
        Some(Logic::Compare(Box::new(Compare { relation, reading, left, right })))
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
                        reading: Reading::Unsigned,
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

/// The relation of a symbol.
pub(super) fn relation(symbol: &str) -> Option<Relation> {
    Some(match symbol {
        "=" => Relation::Equal,
        "<>" => Relation::NotEqual,
        "<" => Relation::Less,
        "<=" | "=<" => Relation::LessOrEqual,
        ">" => Relation::Greater,
        ">=" | "=>" => Relation::GreaterOrEqual,
        _ => return None,
    })
}

/// Splits a comparison contact into how it joins, what it compares, and the relation.
pub(super) fn recognise(mnemonic: &str) -> Option<(Join, Sort, Relation)> {
    let at = mnemonic.find(['=', '<', '>'])?;
    let (head, rest) = mnemonic.split_at(at);
    let (symbol, unsigned) = match rest.strip_suffix("_U") {
        Some(symbol) => (symbol, true),
        None => (rest, false),
    };
    let relation = relation(symbol)?;
    let (join, kind) = if let Some(kind) = head.strip_prefix("LD") {
        (Join::Load, kind)
    } else if let Some(kind) = head.strip_prefix("AND") {
        (Join::And, kind)
    } else {
        (Join::Or, head.strip_prefix("OR")?)
    };
    let sort = match (kind, unsigned) {
        ("", _) => Sort::Integer { words: 1, signed: !unsigned },
        ("D", _) => Sort::Integer { words: 2, signed: !unsigned },
        ("E", false) => Sort::Real { words: 2 },
        ("ED", false) => Sort::Real { words: 4 },
        ("$", false) => Sort::Text,
        ("DT" | "TM", false) => Sort::Clock,
        _ => return None,
    };
    Some((join, sort, relation))
}
