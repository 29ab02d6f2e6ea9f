//! Results of functions and calls whose content is not modelled, and chains of operators.

use super::Assembler;
use super::mixed::{mixed, typed};
use super::open::opened;
use super::types::{ANY_UNIT, DINT, Extent, INT, Kind, Ty, holding};
use super::value::Value;
use scanbound_iec::ast::Operator;
use scanbound_iec::fault::Fault;
use scanbound_ir::{Logic, Step};

/// Functions whose result is REAL or LREAL, as their argument is.
const OF_REALS: &[&str] =
    &["SQRT", "LN", "LOG", "EXP", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN"];

impl Assembler {
    /// The result of a function that is not modelled: any value of its result type, or [`Value::Any`] if that type is
    /// not known. Reported as over-approximated.
    pub(crate) fn any_result(
        &mut self,
        name: &str,
        given: Option<&Value>,
        extent: Extent,
        line: u32,
    ) -> Result<Value, Fault> {
        let why = format!("the result of {name} may be any value");
        let kind = match (name, given) {
            (name, Some(Value::Number(kind @ (Kind::Real | Kind::Opaque(_)), _)))
                if name == "ABS" || OF_REALS.contains(&name) =>
            {
                Some(*kind)
            }
            ("LEN" | "FIND", _) if matches!(extent, Extent::Characters(..=0x7FFF)) => Some(INT),
            ("TRUNC" | "LEN" | "FIND" | "SIZEOF", _) => Some(DINT),
            ("TIME", _) => Some(Kind::Time),
            ("LTIME", _) => Some(Kind::Opaque(4)),
            (name, given) => {
                // The argument is converted first: controllers differ in whether that gives a REAL or an LREAL.
                if OF_REALS.contains(&name) && matches!(given, Some(Value::Number(..))) {
                    self.cost(&["CONVERT"], "conversion");
                }
                None
            }
        };
        let Some(kind) = kind else {
            let at = self.builder.add(None, Vec::new(), Step::Nothing);
            self.program().approximate(at, why);
            return Ok(Value::Any);
        };
        let any = Value::Number(kind, self.any_number(kind, &why));
        match (name, extent) {
            ("LEN" | "FIND", Extent::Characters(most)) => {
                let most = Value::Constant(i64::try_from(most).unwrap_or(i64::MAX));
                self.charged_already(|own| own.limited(Value::Constant(0), any, most, line))
            }
            // Controllers whose TRUNC gives other integers than a DINT keep more bits.
            _ if name == "TRUNC" => Ok(opened(any, Some(Logic::Const(true)))),
            _ => Ok(any),
        }
    }

    pub(crate) fn folded(
        &mut self,
        operator: Operator,
        values: Vec<Value>,
        line: u32,
    ) -> Result<Value, Fault> {
        let is_relation = operator.binding() == 4 || operator.binding() == 5;
        if is_relation && values.len() > 2 {
            // A relation of several values compares each with the next.
            let pairs: Vec<_> =
                values.windows(2).map(|pair| (pair[0].clone(), pair[1].clone())).collect();
            let mut all = Vec::new();
            for (one, two) in pairs {
                if let Value::Bit(logic) = self.combined(operator, one, two, line)? {
                    all.push(logic);
                }
            }
            return Ok(Value::Bit(Logic::All(all)));
        }
        let mut rest = values.into_iter();
        let Some(mut sum) = rest.next() else { return Ok(Value::Any) };
        for next in rest {
            sum = self.combined(operator, sum, next, line)?;
        }
        Ok(sum)
    }

    /// The result of a conversion between TIME and another type: any value, since controllers differ in the unit.
    pub(crate) fn of_any_unit(&mut self, to: &Ty) -> Value {
        match to {
            Ty::Bit => Value::Bit(self.any_bit(ANY_UNIT)),
            Ty::Number(kind) => Value::Number(*kind, self.any_number(*kind, ANY_UNIT)),
            _ => Value::Any,
        }
    }
}

/// These values, with the kind of a number for each constant that one of the numbers gives one (see [`typed`]).
pub(crate) fn beside_numbers(values: &[Value]) -> Vec<Value> {
    let given = |one: &Value| {
        let beside = values.iter().map(|other| typed(other.clone(), one.clone()).1);
        { beside }.find(|given| matches!(given, Value::Number(..))).unwrap_or_else(|| one.clone())
    };
    values.iter().map(given).collect()
}

/// Whether two of these numbers, one signed and one unsigned, have no common type that holds both (see [`mixed`]).
pub(crate) fn crosses(values: &[Value]) -> bool {
    let kinds: Vec<Kind> = values
        .iter()
        .filter_map(|value| match value {
            Value::Number(kind, _) | Value::Open(kind, ..) => Some(*kind),
            _ => None,
        })
        .collect();
    let pairs = kinds.iter().flat_map(|one| kinds.iter().map(move |other| (*one, *other)));
    { pairs }.any(|(one, other)| mixed(one, other).is_some())
}

impl Assembler {
    /// The result of a call with EN: `result` where the condition is true, else any value. Without a condition,
    /// `result`.
    pub(crate) fn result_if(&mut self, condition: Option<Logic>, result: Value) -> Value {
        let Some(condition) = condition else { return result };
        let result = self.settled(result);
        let why = "the result of a call whose EN is false may be any value";
        let other = match &result {
            Value::Bit(_) => Value::Bit(self.any_bit(why)),
            Value::Number(kind, _) => Value::Number(*kind, self.any_number(*kind, why)),
            Value::Constant(value) => {
                let kind = holding(INT, *value);
                Value::Number(kind, self.any_number(kind, why))
            }
            Value::Any | Value::Open(..) | Value::Address(..) => return Value::Any,
        };
        self.chosen(condition, result, other)
    }
}
