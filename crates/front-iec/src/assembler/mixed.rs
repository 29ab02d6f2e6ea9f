//! Operators on a signed and an unsigned integer of the same size, or a longer unsigned one. The standard has no such
//! operations. Compilers that allow them compute mathematically, or on the bits as signed or unsigned numbers. The
//! results agree if all operands and results are below half of the unsigned range; elsewhere they may be any value.

use super::Assembler;
use super::open::opened;
use super::types::{Kind, holding};
use super::value::{Value, constant, signed, unsigned};
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_ir::{Logic, Number, Relation};

/// The kind in which a compiler combines a signed and an unsigned integer. None if they can be combined without a
/// difference: both have the same signedness, or the signed one is longer and holds both.
pub(crate) fn mixed(one: Kind, two: Kind) -> Option<Kind> {
    let (Kind::Whole { bits, signed }, Kind::Whole { bits: other, signed: also }) = (one, two)
    else {
        return None;
    };
    let (with, without) = if signed { (bits, other) } else { (other, bits) };
    let crosses = signed != also && with <= without && without < 64;
    crosses.then_some(Kind::Whole { bits: without, signed: true })
}

/// Gives a constant beside a number the kind of the smallest size, not below that of the number, in which it fits, if
/// it fits there only with the opposite signedness. Other values are unchanged.
pub(crate) fn typed(one: Value, two: Value) -> (Value, Value) {
    let turned = |kind: Kind, value: i64| {
        let Kind::Whole { bits: own, signed } = kind else { return None };
        let holds = |kind: Kind| holding(kind, value) == kind;
        let sizes = [8, 16, 32].into_iter().filter(|&bits| bits >= own);
        let kinds = sizes.map(|bits| [signed, !signed].map(|signed| Kind::Whole { bits, signed }));
        let [alike, other] = { kinds }.find(|kinds| kinds.iter().any(|&kind| holds(kind)))?;
        (!holds(alike)).then(|| Value::Number(other, constant(value, other.words())))
    };
    match (one, two) {
        (Value::Number(kind, number), Value::Constant(value)) => {
            let other = turned(kind, value).unwrap_or(Value::Constant(value));
            (Value::Number(kind, number), other)
        }
        (Value::Constant(value), Value::Number(kind, number)) => {
            let other = turned(kind, value).unwrap_or(Value::Constant(value));
            (other, Value::Number(kind, number))
        }
        both => both,
    }
}

/// True where a number, read as signed, is negative.
pub(crate) fn below_zero(kind: Kind, number: &Number) -> Logic {
    signed(Relation::Less, number.clone(), constant(0, kind.words()))
}

impl Assembler {
    /// Lowers an operator on a signed and an unsigned number, which are converted to their common `kind` already.
    pub(crate) fn mixed_numbers(
        &mut self,
        operator: Operator,
        relation: Option<Relation>,
        kind: Kind,
        (left, open): (Number, Option<Logic>),
        (right, also): (Number, Option<Logic>),
    ) -> Result<Value, Fault> {
        let words = kind.words();
        let [left, right] = [left, right].map(|one| Number::Words(self.copied(one, words)));
        let signs = vec![below_zero(kind, &left), below_zero(kind, &right)];
        if let Some(relation) = relation {
            let differ = match relation {
                Relation::Equal | Relation::NotEqual => {
                    // Equal bits stand for different numbers only if both have the top bit set.
                    let same = unsigned(Relation::Equal, left.clone(), right.clone());
                    Logic::All([signs, vec![same]].concat())
                }
                _ => Logic::Any(signs),
            };
            let open = Logic::Any(open.into_iter().chain([differ]).collect());
            return self.numbers(operator, Some(relation), kind, (left, Some(open)), (right, also));
        }
        let result = self.numbers(operator, None, kind, (left, open), (right, also))?;
        let result = self.frozen(result);
        let (Value::Number(_, Number::Words(found)) | Value::Open(_, Number::Words(found), _)) =
            &result
        else {
            return Ok(result);
        };
        let below = below_zero(kind, &Number::Words(found.clone()));
        let beyond = match operator {
            Operator::And | Operator::Or => below,
            Operator::Divide | Operator::Modulo | Operator::Power => {
                let differ = Logic::Any(signs);
                self.open_where(differ.clone(), found);
                differ
            }
            _ => Logic::Any([signs, vec![below]].concat()),
        };
        let beyond = self.keep_bit(beyond);
        Ok(opened(result, Some(beyond)))
    }
}
