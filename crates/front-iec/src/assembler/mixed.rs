//! Numbers with a sign together with those without, of the same size or a longer one. The standard has no such
//! operations, and compilers that have take them as mathematical numbers or by their bits, with a sign or without: the
//! result is the same where all of them are below the half of what the bits hold.

use super::Assembler;
use super::open::opened;
use super::types::{Kind, holding};
use super::value::{Value, constant, signed, unsigned};
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_ir::{Logic, Number, Relation};

/// The kind in which the bits of two such numbers meet. One with a sign that is the longer one holds both as they are.
pub(crate) fn mixed(one: Kind, two: Kind) -> Option<Kind> {
    let (Kind::Whole { bits, signed }, Kind::Whole { bits: other, signed: also }) = (one, two)
    else {
        return None;
    };
    let (with, without) = if signed { (bits, other) } else { (other, bits) };
    let crosses = signed != also && with <= without && without < 64;
    crosses.then_some(Kind::Whole { bits: without, signed: true })
}

/// Two values, of which a constant that the other one's type holds only without its sign, or with one, has that type.
pub(crate) fn typed(one: Value, two: Value) -> (Value, Value) {
    let turned = |kind: Kind, value: i64| match kind {
        Kind::Whole { bits: bits @ ..64, signed } => {
            let other = Kind::Whole { bits, signed: !signed };
            let crosses = holding(kind, value) != kind && holding(other, value) == other;
            crosses.then(|| Value::Number(other, constant(value, other.words())))
        }
        _ => None,
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

/// Where a number is below 0, its bits being read with a sign.
pub(crate) fn below_zero(kind: Kind, number: &Number) -> Logic {
    signed(Relation::Less, number.clone(), constant(0, kind.words()))
}

impl Assembler {
    /// What an operator makes of such numbers, which have the kind in which they meet.
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
                    // Only the bits may be the same, and then both have the highest one.
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
