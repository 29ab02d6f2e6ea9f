//! Lowers the standard functions for shifting, selection, limits and BCD conversion.

use super::Assembler;
use super::mixed::{below_zero, mixed, typed};
use super::numbers::{common, row};
use super::open::{opened, parted};
use super::types::{DINT, INT, Kind, holding};
use super::value::{Value, constant, sources, targets, unsigned, within, wrapped};
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_ir::meaning::{Operation, OperationInput as Input, Unary};
use scanbound_ir::{BitTarget, Logic, Number, Region, Relation, WordSource, Write};

impl Assembler {
    /// Lowers SHL, SHR, ROL and ROR. The result is any value for as many places as there are bits, or more, since
    /// controllers differ. [`Value::Any`] for operands that are not modelled.
    pub(crate) fn moved(&mut self, name: &str, of: Value, places: Value) -> Value {
        let rotates = name.starts_with('R');
        let (kind, number) = match of {
            Value::Number(kind, number) => (kind, number),
            // Compilers differ in the size of an untyped number.
            _ => return Value::Any,
        };
        let by = match places {
            Value::Constant(by) => Some(by),
            _ => None,
        };
        let places = match places {
            Value::Constant(value) if (0..=0xFFFF).contains(&value) => constant(value, 1),
            Value::Number(kind @ Kind::Whole { .. }, number) if kind.words() == 1 => number,
            _ => return Value::Any,
        };
        let Kind::Whole { bits, signed } = kind else { return Value::Any };
        let left = name.ends_with('L');
        // Controllers differ in what SHR moves into the top of a signed number.
        if bits > 32 || (rotates && bits == 8) || (signed && !left) {
            return Value::Any;
        }
        let operation = match rotates {
            true => Operation::Rotate { left, through: false },
            false => Operation::Shift { left, signed: false },
        };
        let places = Number::Words(self.copied(places, 1));
        let words = kind.words();
        let moving = Number::Words(self.copied(number, words));
        let inputs = vec![Input::Number(moving.clone()), Input::Number(places.clone())];
        let moved = self.worked_out(words, Some((operation, inputs, words)));
        let words = self.copied(moved, words);
        let beyond = unsigned(Relation::GreaterOrEqual, places, constant(i64::from(bits), 1));
        self.open_where(beyond, &words);
        let found = Value::Number(kind, wrapped(kind, Number::Words(words)));
        if rotates || !left {
            return found;
        }
        // Some compilers keep bits that SHL moves beyond the type if the result becomes a longer type.
        let lost = match by.filter(|by| !signed && (0..bits.into()).contains(by)) {
            Some(by) => {
                let most = ((1_i64 << bits) - 1) >> by;
                unsigned(Relation::Greater, moving, constant(most, kind.words()))
            }
            None => Logic::Const(true),
        };
        opened(found, Some(lost))
    }

    /// Lowers MUX: the first value selects one of the others, counted from 0. Any value for a selector out of range,
    /// since controllers differ.
    pub(crate) fn multiplexed(
        &mut self,
        mut values: Vec<Value>,
        line: u32,
    ) -> Result<Value, Fault> {
        let which = values.remove(0);
        if let Value::Constant(number) = which {
            let own = usize::try_from(number).ok().filter(|&number| number < values.len());
            return match own {
                Some(number) => Ok(values.swap_remove(number)),
                None => Err(Fault::new(line, format!("MUX has no input {number}"))),
            };
        }
        let Value::Number(kind @ Kind::Whole { .. }, number) = which else {
            return Ok(Value::Any);
        };
        let which = Number::Words(self.copied(number, kind.words()));
        let mut fits = Vec::new();
        for number in 0..values.len() {
            let number = constant(i64::try_from(number).unwrap_or(i64::MAX), kind.words());
            fits.push(self.keep_bit(unsigned(Relation::Equal, which.clone(), number)));
        }
        let none = Logic::Any(fits.clone()).not();
        if values.iter().all(|value| matches!(value, Value::Bit(_))) {
            let cell = self.bit_between();
            let choice = self.builder.choice();
            self.program().statements.undefined_by_language.insert(choice);
            let any = Write::Havoc(Region::Range { first: cell, count: 1 }, choice);
            self.write_if(none, vec![any], None);
            for (fit, value) in fits.into_iter().zip(values) {
                let Value::Bit(logic) = value else { continue };
                self.write_if(fit, vec![Write::Bit(BitTarget::Cell(cell), logic)], None);
            }
            return Ok(Value::Bit(Logic::cell(cell)));
        }
        let Some(kind) = kind_of(&values) else { return Ok(Value::Any) };
        let first = self.words_between(kind.words());
        for (fit, value) in fits.into_iter().zip(values) {
            let number = self.as_number(value, kind);
            self.write_if(fit, vec![Write::Words(targets(first, kind.words()), number)], None);
        }
        let words = sources(first, kind.words());
        self.open_where(none, &words);
        Ok(Value::Number(kind, wrapped(kind, Number::Words(words))))
    }

    /// The value `first` where `which` is true, else `second`.
    pub(crate) fn chosen(&mut self, which: Logic, first: Value, second: Value) -> Value {
        let (first, second) = typed(self.settled(first), self.settled(second));
        let mut crosses = None;
        if let (Value::Bit(one), Value::Bit(two)) = (&first, &second) {
            let which = self.keep_bit(which);
            let yes = Logic::All(vec![which.clone(), one.clone()]);
            return Value::Bit(Logic::Any(vec![yes, Logic::All(vec![which.not(), two.clone()])]));
        }
        let kind = match (&first, &second) {
            (Value::Number(one, _), Value::Number(two, _)) => {
                crosses = mixed(*one, *two);
                crosses.unwrap_or_else(|| common(*one, *two))
            }
            (Value::Number(kind, _), Value::Constant(value))
            | (Value::Constant(value), Value::Number(kind, _)) => holding(*kind, *value),
            (Value::Number(kind, _), _) | (_, Value::Number(kind, _)) => *kind,
            (Value::Constant(one), Value::Constant(two)) => holding(holding(INT, *one), *two),
            _ => return Value::Any,
        };
        let which = self.keep_bit(which);
        let (first, second) = (self.as_number(first, kind), self.as_number(second, kind));
        let (cell, words) = (self.words_between(kind.words()), kind.words());
        self.write(vec![Write::Words(targets(cell, words), second)]);
        self.write_if(which, vec![Write::Words(targets(cell, words), first)], None);
        let number = Number::Words(sources(cell, words));
        // If one is signed and the other unsigned, the same bits may stand for two numbers.
        let beyond = crosses.map(|kind| below_zero(kind, &number));
        opened(Value::Number(kind, number), beyond)
    }

    /// Lowers LIMIT. If the lower limit is above the upper one, controllers return one or the other.
    pub(crate) fn limited(
        &mut self,
        low: Value,
        value: Value,
        high: Value,
        line: u32,
    ) -> Result<Value, Fault> {
        if let Some(found) = self.between_constants(&low, &value, &high) {
            return Ok(found);
        }
        let [low, value, high] = [low, value, high].map(|value| self.frozen(value));
        let least = self.better(low.clone(), value, true, line)?;
        let found = self.better(least, high.clone(), false, line)?;
        let is_right =
            matches!((&low, &high), (Value::Constant(low), Value::Constant(high)) if low <= high);
        if is_right || matches!(found, Value::Any) {
            return Ok(found);
        }
        let found = self.frozen(found);
        let crossed =
            self.charged_already(|own| own.combined(Operator::Greater, low.clone(), high, line))?;
        let Value::Bit(crossed) = crossed else { return Ok(Value::Any) };
        let other =
            self.differs("LIMIT returns the lower limit if its limits are in the wrong order");
        Ok(self.chosen(Logic::All(vec![crossed, other]), low, found))
    }

    /// LIMIT of an integer between constants of its own type, in order, as one operation whose result later passes
    /// know. None if it is not such a LIMIT.
    fn between_constants(&mut self, low: &Value, value: &Value, high: &Value) -> Option<Value> {
        let limits = limits(low, value, high)?;
        let Limits { kind, wide, .. } = limits;
        let (value, beyond) = parted(value.clone());
        let Value::Number(_, number) = value else { return None };
        for operator in [Operator::GreaterOrEqual, Operator::LessOrEqual] {
            self.cost(&[row(operator, Some(kind))], "compare");
        }
        let number = self.converted(number, kind, wide);
        let mut found = self.limited_number(number, &limits);
        if let (Some(beyond), Number::Words(words)) = (beyond, &found) {
            // A value that overflows its type is any value between the limits.
            self.open_where(beyond, words);
            found = self.limited_number(found, &limits);
        }
        Some(Value::Number(kind, self.converted(found, wide, kind)))
    }

    /// A number of the kind in which LIMIT is computed, moved to the nearer limit if it lies outside.
    fn limited_number(&mut self, number: Number, limits: &Limits) -> Number {
        let words = limits.wide.words();
        let ends = [limits.low, limits.high].map(|end| within(limits.wide, end));
        let inputs = ends.into_iter().chain([number]).map(Input::Number).collect();
        self.worked_out(words, Some((Operation::Limit, inputs, words)))
    }

    /// The larger of two values if `larger`, else the smaller.
    pub(crate) fn better(
        &mut self,
        one: Value,
        two: Value,
        larger: bool,
        line: u32,
    ) -> Result<Value, Fault> {
        let operator = if larger { Operator::GreaterOrEqual } else { Operator::LessOrEqual };
        match self.combined(operator, one.clone(), two.clone(), line)? {
            Value::Bit(which) => Ok(self.chosen(which, one, two)),
            _ => Ok(Value::Any),
        }
    }

    /// Converts a number from BCD if `reads`, else to BCD. Any value for invalid digits or too large a number.
    pub(crate) fn decimal(&mut self, value: Value, reads: bool) -> Value {
        let (kind, number) = match value {
            Value::Number(kind @ Kind::Whole { .. }, number) if kind.words() <= 2 => (kind, number),
            _ => return Value::Any,
        };
        let Kind::Whole { bits, .. } = kind else { return Value::Any };
        if bits == 8 && !reads {
            return Value::Any;
        }
        let unary = if reads { Unary::FromBcd } else { Unary::ToBcd };
        let inputs = vec![Input::Number(number)];
        let words = kind.words();
        let found = self.worked_out(words, Some((Operation::Each(unary), inputs, words)));
        Value::Number(Kind::Whole { bits, signed: false }, found)
    }

    /// Overwrites words with any value where `condition` is true, because the language does not define them there.
    pub(crate) fn open_where(&mut self, condition: Logic, words: &[WordSource]) {
        let Some(&WordSource::Cell(first)) = words.first() else { return };
        let count = u32::try_from(words.len()).unwrap_or(1);
        let choice = self.builder.choice();
        self.program().statements.undefined_by_language.insert(choice);
        let any = Write::Havoc(Region::Range { first, count }, choice);
        self.write_if(condition, vec![any], None);
    }
}

/// The constant limits of a LIMIT of an integer.
pub(crate) struct Limits {
    low: i64,
    high: i64,
    kind: Kind,
    /// The signed kind in which LIMIT is computed.
    wide: Kind,
}

/// The limits of a LIMIT with constant limits. `None` if a limit is not constant, if they are not in order, or if one
/// may not fit the type.
pub(crate) fn limits(low: &Value, value: &Value, high: &Value) -> Option<Limits> {
    let (&Value::Constant(low), &Value::Constant(high)) = (low, high) else { return None };
    let (&Value::Number(kind, _) | &Value::Open(kind, ..)) = value else { return None };
    let Kind::Whole { bits: bits @ ..=32, signed } = kind else { return None };
    let wide = match (bits, signed) {
        (32, false) => return None,
        (16, false) => DINT,
        _ => kind,
    };
    let fit = low <= high && [low, high].iter().all(|&end| holding(kind, end) == kind);
    fit.then_some(Limits { low, high, kind, wide })
}

/// The common kind of several values. `None` if one of them is neither a number nor a constant, or if signed and
/// unsigned numbers meet.
fn kind_of(values: &[Value]) -> Option<Kind> {
    let mut found: Option<Kind> = None;
    for value in values {
        found = Some(match (found, value) {
            (None, Value::Number(kind, _)) => *kind,
            (None, Value::Constant(value)) => holding(INT, *value),
            // Compilers differ in how they read the bits.
            (Some(own), Value::Number(kind, _)) if mixed(own, *kind).is_some() => return None,
            (Some(own), Value::Number(kind, _)) => common(own, *kind),
            (Some(own), Value::Constant(value)) => holding(own, *value),
            (_, Value::Bit(_) | Value::Open(..) | Value::Address(..) | Value::Any) => return None,
        });
    }
    found
}
