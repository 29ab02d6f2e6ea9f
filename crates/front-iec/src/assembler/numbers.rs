//! Lowers operators on values.

use super::Assembler;
use super::mixed::{mixed, typed};
use super::open::{joined, opened, parted};
use super::types::{ANY_UNIT, DINT, Kind, Ty, holding};
use super::value::{Value, constant, differ, real, sources, targets, unsigned, within};
use scanbound_base::code::Code;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
pub(crate) use scanbound_iec_tree::types::common;
use scanbound_ir::{Cell, Logic, Number, NumberFormat, Relation, Write};

/// The value in a cell of this type. [`Value::Any`] if its content is not modelled.
pub(crate) fn read(cell: Cell, ty: &Ty) -> Value {
    match ty {
        Ty::Bit => Value::Bit(Logic::cell(cell)),
        Ty::Number(kind) => Value::Number(*kind, Number::Words(sources(cell, kind.words()))),
        _ => Value::Any,
    }
}

/// Reason for the report where a comparison of addresses is not modelled.
const ADDRESSES: &str = "a comparison of addresses may be true or false";

/// The word of a reference, or of NULL. None for other values.
fn address_word(value: &Value) -> Option<Number> {
    match value {
        Value::Address(number, _) => Some(number.clone()),
        Value::Constant(0) => Some(constant(0, 1)),
        _ => None,
    }
}

/// Reason for the report where REAL cannot represent a literal exactly.
pub(crate) const ROUNDED: &str = "some compilers take a literal that REAL cannot represent as LREAL: a comparison with it may be true or false";

/// The kind of a reference's word.
const WORD: Kind = Kind::Whole { bits: 16, signed: false };

impl Assembler {
    /// Lowers a binary operator on two values and charges it. A fault if Booleans do not have this operator.
    pub(crate) fn combined(
        &mut self,
        operator: Operator,
        one: Value,
        two: Value,
        line: u32,
    ) -> Result<Value, Fault> {
        use Operator as O;
        let operator = operator.eager();
        let relation = match operator {
            O::Equal => Some(Relation::Equal),
            O::NotEqual => Some(Relation::NotEqual),
            O::Less => Some(Relation::Less),
            O::LessOrEqual => Some(Relation::LessOrEqual),
            O::Greater => Some(Relation::Greater),
            O::GreaterOrEqual => Some(Relation::GreaterOrEqual),
            _ => None,
        };
        if relation.is_none() {
            [&one, &two].into_iter().for_each(|value| self.note_address(value));
        }
        let (one, two) = match (one, two) {
            // Beside a bit, a constant is a Boolean: 0 is FALSE, all else TRUE.
            (Value::Bit(bit), Value::Constant(value)) => {
                (Value::Bit(bit), Value::Bit(Logic::Const(value != 0)))
            }
            (Value::Constant(value), Value::Bit(bit)) => {
                (Value::Bit(Logic::Const(value != 0)), Value::Bit(bit))
            }
            (Value::Constant(one), Value::Constant(two)) => {
                let kind = holding(holding(DINT, one), two);
                // The result of two constants is again an untyped constant.
                if let (None, Some(value)) = (relation, operator.of_constants(one, two)) {
                    let names = [row(operator, Some(kind)), row(operator, None)];
                    self.cost(&names, class_of(operator, kind));
                    return Ok(Value::Constant(value));
                }
                let number = |value| Value::Number(kind, constant(value, kind.words()));
                (number(one), number(two))
            }
            other => other,
        };
        if let (Some(relation @ (Relation::Equal | Relation::NotEqual)), Some(left), Some(right)) =
            (relation, address_word(&one), address_word(&two))
            && matches!((&one, &two), (Value::Address(..), _) | (_, Value::Address(..)))
        {
            self.cost(&[row(operator, Some(WORD)), row(operator, None)], "compare");
            return Ok(Value::Bit(unsigned(relation, left, right)));
        }
        let ((one, open), (two, also)) = (parted(one), parted(two));
        match typed(one, two) {
            (Value::Bit(one), Value::Bit(two)) => {
                self.cost(&[row(operator, None)], "logic");
                Ok(Value::Bit(match operator {
                    O::And => Logic::All(vec![one, two]),
                    O::Or => Logic::Any(vec![one, two]),
                    O::Xor | O::NotEqual => differ(&one, &two),
                    O::Equal => differ(&one, &two).not(),
                    _ => {
                        return Err(Fault::new(
                            line,
                            format!("bits have no {}", operator.symbol()),
                        ));
                    }
                }))
            }
            (Value::Number(own, one), Value::Constant(two)) => {
                let kind = holding(own, two);
                let one = self.operand((own, one, open), kind, relation);
                let two = (self.constant_as(kind, two), None);
                self.numbers(operator, relation, kind, one, two)
            }
            (Value::Constant(one), Value::Number(own, two)) => {
                let kind = holding(own, one);
                let one = (self.constant_as(kind, one), None);
                let two = self.operand((own, two, also), kind, relation);
                self.numbers(operator, relation, kind, one, two)
            }
            (Value::Address(..), _) | (_, Value::Address(..)) if relation.is_some() => {
                self.cost(&[row(operator, Some(WORD)), row(operator, None)], "compare");
                Ok(Value::Bit(self.any_bit(ADDRESSES)))
            }
            (Value::Number(one, _), Value::Number(two, _))
                if (one == Kind::Time) != (two == Kind::Time)
                    && (relation.is_some()
                        || matches!(operator, O::Add | O::Subtract)
                            && ![one, two].iter().any(|kind| matches!(kind, Kind::Opaque(_)))) =>
            {
                let names = [row(operator, Some(Kind::Time)), row(operator, None)];
                self.cost(&names, class_of(operator, Kind::Time));
                Ok(match relation {
                    Some(_) => Value::Bit(self.any_bit(ANY_UNIT)),
                    None => Value::Number(Kind::Time, self.any_number(Kind::Time, ANY_UNIT)),
                })
            }
            (Value::Number(one_kind, one), Value::Number(two_kind, two)) => {
                if let Some(kind) = mixed(one_kind, two_kind) {
                    let one = self.operand((one_kind, one, open), kind, relation);
                    let two = self.operand((two_kind, two, also), kind, relation);
                    return self.mixed_numbers(operator, relation, kind, one, two);
                }
                let kind = common(one_kind, two_kind);
                let one = self.operand((one_kind, one, open), kind, relation);
                let two = self.operand((two_kind, two, also), kind, relation);
                self.numbers(operator, relation, kind, one, two)
            }
            _ => {
                self.cost(&[row(operator, None), "FUNCTION"], "special");
                Ok(match relation {
                    Some(_) => Value::Bit(
                        self.any_bit("a comparison of texts, dates or LREAL may be true or false"),
                    ),
                    None => Value::Any,
                })
            }
        }
    }

    fn constant_as(&mut self, kind: Kind, value: i64) -> Number {
        match kind {
            Kind::Real => real(&value.to_string()).unwrap_or_else(|| constant(0, 2)),
            Kind::Time if value != 0 => self.any_number(kind, ANY_UNIT),
            _ => within(kind, value),
        }
    }

    pub(crate) fn numbers(
        &mut self,
        operator: Operator,
        relation: Option<Relation>,
        kind: Kind,
        (left, open): (Number, Option<Logic>),
        (right, also): (Number, Option<Logic>),
    ) -> Result<Value, Fault> {
        let names = [row(operator, Some(kind)), row(operator, None)];
        self.cost(&names, class_of(operator, kind));
        let Some(relation) = relation else {
            let beyond = joined(operator, kind, (&left, open), (&right, also));
            let found = self.arithmetic(operator, kind, left, right)?;
            // A quotient depends on all bits of the dividend.
            return Ok(match operator {
                Operator::Divide | Operator::Modulo | Operator::Power => {
                    let beyond = beyond.map(|beyond| self.keep_bit(beyond));
                    self.any_where(found, beyond)
                }
                _ => opened(found, beyond),
            });
        };
        if matches!(kind, Kind::Opaque(_)) {
            return Ok(Value::Bit(
                self.any_bit("a comparison of LREAL or dates may be true or false"),
            ));
        }
        let format = match kind {
            Kind::Real => {
                let choice = self.builder.choice();
                NumberFormat::Real(choice)
            }
            kind if kind.is_signed() => NumberFormat::Signed,
            _ => NumberFormat::Unsigned,
        };
        let (mut left, mut right) = (left, right);
        let edge = match kind {
            Kind::Time => self.edge_of_comparison(&mut left, &mut right),
            _ => None,
        };
        let compare = Logic::compare(relation, format, left, right);
        let beyond: Vec<Logic> = open.into_iter().chain(also).chain(edge).collect();
        Ok(Value::Bit(match beyond.is_empty() {
            true => compare,
            false => self.open_bit(compare, Logic::Any(beyond)),
        }))
    }

    /// Converts a value to a number of a kind. Any number where the value is not modelled.
    pub(crate) fn as_number(&mut self, value: Value, kind: Kind) -> Number {
        self.note_address(&value);
        match value {
            Value::Number(from, _) if (from == Kind::Time) != (kind == Kind::Time) => {
                self.any_number(kind, ANY_UNIT)
            }
            Value::Number(from, number) => self.converted(number, from, kind),
            Value::Open(from, number, beyond) => {
                self.operand((from, number, Some(beyond)), kind, None).0
            }
            Value::Constant(value) => self.constant_as(kind, value),
            Value::Any | Value::Address(..) => {
                self.charge_any_conversion(kind);
                self.any_number(kind, "a value that is not modelled: it may be any number")
            }
            Value::Bit(logic) => self.bit_number(logic, kind),
        }
    }

    /// A bit as the number 1 or 0.
    fn bit_number(&mut self, logic: Logic, kind: Kind) -> Number {
        let words = kind.words();
        let first = self.words_between(words);
        self.write(vec![Write::Words(targets(first, words), constant(0, words))]);
        let one = self.constant_as(kind, 1);
        self.write_if(logic, vec![Write::Words(targets(first, words), one)], None);
        Number::Words(sources(first, words))
    }

    pub(crate) fn as_bit(&mut self, value: Value, line: u32) -> Result<Logic, Fault> {
        match value {
            Value::Bit(logic) => Ok(logic),
            Value::Constant(value @ (0 | 1)) => Ok(Logic::Const(value != 0)),
            Value::Any | Value::Address(..) => {
                Ok(self.any_bit("a value that is not modelled: it may be true or false"))
            }
            Value::Constant(_) | Value::Number(..) | Value::Open(..) => {
                Err(Fault::new(line, "a number is used where a Boolean is required")
                    .code(Code::Operand))
            }
        }
    }
}

/// The name of the timing row of an operator. `kind` is that of its operands; None gives the general row.
pub(crate) fn row(operator: Operator, kind: Option<Kind>) -> &'static str {
    use Operator as O;
    match (operator, kind) {
        (O::Add, Some(Kind::Real | Kind::Opaque(_))) => "ADD:REAL",
        (O::Subtract, Some(Kind::Real | Kind::Opaque(_))) => "SUB:REAL",
        (O::Multiply, Some(Kind::Real | Kind::Opaque(_))) => "MUL:REAL",
        (O::Divide, Some(Kind::Real | Kind::Opaque(_))) => "DIV:REAL",
        (operator, _) => operator.name(),
    }
}

/// The timing class of an operator.
fn class_of(operator: Operator, kind: Kind) -> &'static str {
    use Operator as O;
    match (kind, operator) {
        (_, O::Power) => "special",
        (Kind::Real | Kind::Opaque(_), _) => "real",
        (_, O::Multiply) => "multiply",
        (_, O::Divide | O::Modulo) => "divide",
        (_, O::Equal | O::NotEqual | O::Less | O::LessOrEqual | O::Greater | O::GreaterOrEqual) => {
            "compare"
        }
        _ => "arithmetic",
    }
}
