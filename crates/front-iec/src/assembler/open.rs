//! Overflow of integer arithmetic within an expression. Compilers differ in how many bits they keep of a sum,
//! difference, product or complement: some wrap at the size of the type, others compute in 32 or 64 bits. If only the
//! bits of the type are used, the result is the same on all of them. Otherwise it is any value where it overflows.

use super::Assembler;
use super::types::{DINT, Kind};
use super::value::{Value, constant, differ, wrapped};
use scanbound_iec::ast::Operator;
use scanbound_ir::{
    BitTarget, Cell, Logic, Number, NumberFormat, Region, Relation, WordSource, Write,
};

/// Splits a value into its number and the condition under which it overflows its type (None: never).
pub(crate) fn parted(value: Value) -> (Value, Option<Logic>) {
    match value {
        Value::Open(kind, number, beyond) => (Value::Number(kind, number), Some(beyond)),
        other => (other, None),
    }
}

/// Adds a condition under which an integer overflows its type. Other values are unchanged.
pub(crate) fn opened(value: Value, beyond: Option<Logic>) -> Value {
    match (value, beyond) {
        (Value::Number(kind @ Kind::Whole { .. }, number), Some(beyond)) => {
            Value::Open(kind, number, beyond)
        }
        (Value::Open(kind, number, own), Some(beyond)) => {
            Value::Open(kind, number, Logic::Any(vec![own, beyond]))
        }
        (value, _) => value,
    }
}

/// The result of NOT. The complement of an unsigned integer never fits its type if a compiler computes in more bits,
/// since these become 1.
pub(crate) fn complement(value: Value) -> Value {
    let (value, beyond) = parted(value);
    match value {
        Value::Bit(logic) => Value::Bit(logic.not()),
        // A constant 0 or 1 may be a bit or a number.
        Value::Constant(0 | 1) | Value::Any | Value::Open(..) | Value::Address(..) => Value::Any,
        // Controllers represent TIME differently.
        Value::Number(Kind::Time, _) => Value::Any,
        Value::Constant(value) => Value::Constant(!value),
        Value::Number(kind, number) => {
            let ones = constant(-1, kind.words());
            let flipped = Number::Xor(Box::new(number), Box::new(ones));
            let found = Value::Number(kind, wrapped(kind, flipped));
            let is_shorter = matches!(kind, Kind::Whole { bits: ..64, signed: false });
            let never = is_shorter.then_some(Logic::Const(true));
            opened(found, never.or(beyond))
        }
    }
}

/// The condition under which the result of an operator may overflow because an operand overflows. None if neither
/// operand can, or if AND masks the excess bits.
pub(crate) fn joined(
    operator: Operator,
    kind: Kind,
    (left, open): (&Number, Option<Logic>),
    (right, also): (&Number, Option<Logic>),
) -> Option<Logic> {
    if operator == Operator::And {
        // AND keeps no bits beyond the other operand, unless that is negative.
        let fits = |number: &Number| {
            !kind.is_signed() || known(number, kind).is_some_and(|value| value >= 0)
        };
        match (&open, &also) {
            (None, Some(_)) if fits(left) => return None,
            (Some(_), None) if fits(right) => return None,
            (Some(one), Some(two)) if !kind.is_signed() => {
                return Some(Logic::All(vec![one.clone(), two.clone()]));
            }
            _ => {}
        }
    }
    match (open, also) {
        (Some(one), Some(two)) => Some(Logic::Any(vec![one, two])),
        (one, two) => one.or(two),
    }
}

/// The condition under which an operator on two operands that fit their type overflows it. None if it cannot.
pub(crate) fn beyond(
    operator: Operator,
    kind: Kind,
    left: &Number,
    right: &Number,
) -> Option<Logic> {
    // No compiler keeps more than 64 bits.
    let Kind::Whole { bits: bits @ ..64, signed } = kind else { return None };
    let (least, most) = match signed {
        true => (-(1_i64 << (bits - 1)), (1_i64 << (bits - 1)) - 1),
        false => (0, (1_i64 << bits) - 1),
    };
    let is = |relation, left: &Number, right: &Number| {
        let format = if signed { NumberFormat::Signed } else { NumberFormat::Unsigned };
        Logic::compare(relation, format, left.clone(), right.clone())
    };
    let to = |relation, number: &Number, value: i64| {
        is(relation, number, &constant(value, kind.words()))
    };
    let boxed = || (Box::new(left.clone()), Box::new(right.clone()));
    let ends = (known(left, kind), known(right, kind));
    Some(match (operator, ends) {
        (Operator::Add | Operator::Subtract, (Some(one), Some(two))) => {
            let found = if operator == Operator::Add { one + two } else { one - two };
            let fits = (least..=most).contains(&found);
            return (!fits).then_some(Logic::Const(true));
        }
        (Operator::Add, (Some(by), None)) if by >= 0 => to(Relation::Greater, right, most - by),
        (Operator::Add, (Some(by), None)) => to(Relation::Less, right, least - by),
        (Operator::Add, (None, Some(by))) if by >= 0 => to(Relation::Greater, left, most - by),
        (Operator::Add, (None, Some(by))) => to(Relation::Less, left, least - by),
        (Operator::Subtract, (None, Some(by))) if by >= 0 => to(Relation::Less, left, least + by),
        (Operator::Subtract, (None, Some(by))) => to(Relation::Greater, left, most + by),
        (Operator::Subtract, (Some(from), None)) if !signed => to(Relation::Greater, right, from),
        (Operator::Subtract, (Some(from), None)) if from >= 0 => {
            to(Relation::Less, right, from - most)
        }
        (Operator::Subtract, (Some(from), None)) => to(Relation::Greater, right, from - least),
        (Operator::Subtract, _) if !signed => is(Relation::Less, left, right),
        (Operator::Add | Operator::Subtract, _) => {
            let (one, two) = boxed();
            let found = match operator {
                Operator::Add => Number::Add(one, two),
                _ => Number::Sub(one, two),
            };
            if bits == 8 {
                // The 16-bit word of an 8-bit number holds the full result.
                let below = to(Relation::Less, &found, least);
                return Some(Logic::Any(vec![below, to(Relation::Greater, &found, most)]));
            }
            if !signed {
                return Some(is(Relation::Less, &found, left));
            }
            let negative = |number: &Number| to(Relation::Less, number, 0);
            let turned = differ(&negative(left), &negative(&found));
            let sides = differ(&negative(left), &negative(right));
            let sides = if operator == Operator::Add { sides.not() } else { sides };
            Logic::All(vec![sides, turned])
        }
        (Operator::Divide, (_, by)) if signed && by.is_none_or(|by| by == -1) => {
            let by = to(Relation::Equal, right, -1);
            Logic::All(vec![to(Relation::Equal, left, least), by])
        }
        _ => return None,
    })
}

/// The value of a constant number. None if it is not constant.
fn known(number: &Number, kind: Kind) -> Option<i64> {
    let Number::Words(words) = number else { return None };
    let mut value: i64 = 0;
    for word in words.iter().rev() {
        let WordSource::Const(word) = word else { return None };
        value = value << 16 | i64::from(*word);
    }
    let bits = 16 * words.len();
    let is_negative = kind.is_signed() && bits < 64 && value >> (bits - 1) & 1 == 1;
    Some(if is_negative { value - (1 << bits) } else { value })
}

impl Assembler {
    /// Replaces an intermediate result by any value, reported as over-approximated, because compilers differ in how
    /// many bits they keep. An integer gets at least 32 bits and may still overflow these.
    pub(crate) fn between(&mut self, value: Value) -> Value {
        let why = "compilers keep more or fewer bits of a sum or product within an expression: it may be any value";
        match value {
            Value::Number(kind @ Kind::Whole { bits, .. }, _)
            | Value::Open(kind @ Kind::Whole { bits, .. }, ..) => {
                let kind = if bits < 32 { DINT } else { kind };
                // Compilers may keep even more bits.
                Value::Open(kind, self.any_number(kind, why), Logic::Const(true))
            }
            Value::Number(Kind::Real, _) => {
                Value::Number(Kind::Real, self.any_number(Kind::Real, why))
            }
            Value::Bit(_) => Value::Bit(self.any_bit(why)),
            value => value,
        }
    }

    /// Resolves a possible overflow: where the value does not fit its type, it becomes any number of at least 32 bits.
    /// Other values are unchanged.
    pub(crate) fn settled(&mut self, value: Value) -> Value {
        let Value::Open(kind, number, beyond) = value else { return value };
        let to = match kind {
            Kind::Whole { bits: ..32, .. } => DINT,
            kind => kind,
        };
        let number = self.widened(number, kind, to, beyond);
        Value::Number(to, number)
    }

    /// Where `beyond` is true, replaces a value by any value of its kind, which may also overflow that kind. With None,
    /// the value is unchanged.
    pub(crate) fn any_where(&mut self, value: Value, beyond: Option<Logic>) -> Value {
        let Some(beyond) = beyond else { return value };
        let (value, own) = parted(value);
        match value {
            Value::Number(kind, number) => {
                let words = self.copied(number, kind.words());
                self.open_where(beyond.clone(), &words);
                opened(opened(Value::Number(kind, Number::Words(words)), own), Some(beyond))
            }
            Value::Bit(logic) => Value::Bit(self.open_bit(logic, beyond)),
            value => value,
        }
    }

    /// A number converted to a longer kind. It is any value where `beyond` is true, that is, where it does not fit its
    /// own kind.
    fn widened(&mut self, number: Number, from: Kind, to: Kind, beyond: Logic) -> Number {
        let number = self.converted(number, from, to);
        let words = self.copied(number, to.words());
        self.open_where(beyond, &words);
        Number::Words(words)
    }

    /// Converts an operand to the kind `to`, and returns the condition under which it does not fit that kind. For a
    /// comparison (`relation`), an overflowing operand is not widened: the caller lets the comparison have either
    /// result there.
    pub(crate) fn operand(
        &mut self,
        (from, number, beyond): (Kind, Number, Option<Logic>),
        to: Kind,
        relation: Option<Relation>,
    ) -> (Number, Option<Logic>) {
        let is_longer = match (from, to) {
            (Kind::Whole { bits: own, .. }, Kind::Whole { bits, .. }) => bits > own,
            _ => true,
        };
        match beyond {
            Some(beyond) if is_longer && relation.is_none() => {
                let beyond = self.keep_bit(beyond);
                let number = self.widened(number, from, to, beyond.clone());
                // Compilers may keep even more bits.
                let is_open = matches!(to, Kind::Whole { bits: ..64, .. });
                (number, is_open.then_some(beyond))
            }
            beyond => (self.converted(number, from, to), beyond),
        }
    }

    /// A bit that is either true or false where `beyond` is true.
    pub(crate) fn open_bit(&mut self, bit: Logic, beyond: Logic) -> Logic {
        let cell = self.bit_between();
        self.write(vec![Write::Bit(BitTarget::Cell(cell), bit)]);
        let any = self.unsettled(cell);
        self.write_if(beyond, vec![any], None);
        Logic::cell(cell)
    }

    /// A free bit for something that the language does not define. No real run depends on it.
    pub(crate) fn left_open(&mut self) -> Logic {
        let cell = self.bit_between();
        let any = self.unsettled(cell);
        self.write(vec![any]);
        Logic::cell(cell)
    }

    /// The write that makes a bit true or false freely, because the language does not define it.
    pub(crate) fn unsettled(&mut self, cell: Cell) -> Write {
        let choice = self.builder.choice();
        self.program().statements.undefined_by_language.insert(choice);
        Write::Havoc(Region::Range { first: cell, count: 1 }, choice)
    }

    /// Copies a number to temporary cells, together with a bit that says where it does not fit its type.
    pub(crate) fn kept_open(&mut self, kind: Kind, number: Number, beyond: Logic) -> Value {
        let words = self.copied(number, kind.words());
        let cell = self.bit_between();
        self.write(vec![Write::Bit(BitTarget::Cell(cell), beyond)]);
        Value::Open(kind, Number::Words(words), Logic::cell(cell))
    }
}
