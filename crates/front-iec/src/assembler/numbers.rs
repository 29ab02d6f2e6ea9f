//! Expressions, as what the analysis follows.

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

/// The value that stands in a place.
pub(crate) fn read(cell: Cell, ty: &Ty) -> Value {
    match ty {
        Ty::Bit => Value::Bit(Logic::cell(cell)),
        Ty::Number(kind) => Value::Number(*kind, Number::Words(sources(cell, kind.words()))),
        _ => Value::Any,
    }
}

/// What is told where addresses are compared that are no variables' own.
const ADDRESSES: &str = "a comparison of addresses may come out either way";

/// The word of a reference, of one that is compared with nothing, too.
fn address_word(value: &Value) -> Option<Number> {
    match value {
        Value::Address(number, _) => Some(number.clone()),
        Value::Constant(0) => Some(constant(0, 1)),
        _ => None,
    }
}

/// What is told of literals that REAL does not hold.
pub(crate) const ROUNDED: &str = "a literal that REAL does not hold may be a long real: compared, it is larger or smaller than that REAL";

/// The kind of the word that a reference is.
const WORD: Kind = Kind::Whole { bits: 16, signed: false };

impl Assembler {
    /// Two values and what is done with them.
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
        let (one, two) = match (one, two) {
            // TRUE and 1 are the same where bits are asked for.
            (Value::Bit(bit), Value::Constant(value)) => {
                (Value::Bit(bit), Value::Bit(Logic::Const(value != 0)))
            }
            (Value::Constant(value), Value::Bit(bit)) => {
                (Value::Bit(Logic::Const(value != 0)), Value::Bit(bit))
            }
            (Value::Constant(one), Value::Constant(two)) => {
                let kind = holding(holding(DINT, one), two);
                // What constants make has the type of what it is used with, as they have.
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
                    Some(_) => Value::Bit(self.any_bit(
                        "a comparison of texts, dates or long reals may come out either way",
                    )),
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
            // A quotient shows all bits of what is divided.
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
                self.any_bit("a comparison of long reals or dates may come out either way"),
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

    /// A value as a number of a kind.
    pub(crate) fn as_number(&mut self, value: Value, kind: Kind) -> Number {
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
                self.any_number(kind, "a value that is not followed: it may be any number")
            }
            Value::Bit(logic) => self.bit_number(logic, kind),
        }
    }

    /// 1 or 0.
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
                Ok(self.any_bit("a value that is not followed: it may be true or false"))
            }
            Value::Constant(_) | Value::Number(..) | Value::Open(..) => {
                Err(Fault::new(line, "a number stands where a truth value is asked for")
                    .code(Code::Operand))
            }
        }
    }
}

/// The row that prices an operator.
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

/// The class that prices an operator.
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
