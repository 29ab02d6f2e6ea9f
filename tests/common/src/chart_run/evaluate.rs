//! Expressions and statements carried out on named values: as far as charts that are run by themselves need it.

use scanbound::iec::ast::{Expr, Kind, Literal, Operator, Part, Path, Statement};
use scanbound::iec::show;
use std::collections::BTreeMap;

/// A value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Value {
    /// A truth value.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// Nanoseconds.
    Time(i64),
}

/// Named values; a name that was never written is false, or 0.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Memory(BTreeMap<String, Value>);

/// How many statements a body may carry out.
const STEPS: u32 = 100_000;

impl Memory {
    /// What stands under a name.
    pub fn get(&self, name: &str) -> Option<Value> {
        self.0.get(&name.to_ascii_lowercase()).copied()
    }

    /// Whether the value of this name is true.
    pub fn is(&self, name: &str) -> bool {
        self.get(name) == Some(Value::Bool(true))
    }

    /// Puts a value under a name.
    pub fn set(&mut self, name: &str, value: Value) {
        self.0.insert(name.to_ascii_lowercase(), value);
    }

    /// The value of an expression.
    ///
    /// # Errors
    /// What cannot be carried out here, in words.
    pub fn value(&self, expr: &Expr) -> Result<Value, String> {
        match expr {
            Expr::Literal(Literal::Bool(value)) => Ok(Value::Bool(*value)),
            Expr::Literal(Literal::Int(value, _)) => i64::try_from(*value)
                .map(Value::Int)
                .map_err(|_| "a number is too large".to_owned()),
            Expr::Literal(Literal::Time(value)) => Ok(Value::Time(*value)),
            Expr::Variable(path) => Ok(self.get(&self.key(path)?).unwrap_or(Value::Bool(false))),
            Expr::Not(inner) => Ok(Value::Bool(!self.truth(inner)?)),
            Expr::Negate(inner) => match self.value(inner)? {
                Value::Int(value) => value.checked_neg().map(Value::Int).ok_or_else(overflow),
                Value::Time(value) => value.checked_neg().map(Value::Time).ok_or_else(overflow),
                Value::Bool(_) => Err("a truth value has no sign".to_owned()),
            },
            Expr::Binary(operator, left, right) => {
                binary(*operator, self.value(left)?, self.value(right)?)
            }
            Expr::Literal(_)
            | Expr::Call(..)
            | Expr::List(..)
            | Expr::Kept(_)
            | Expr::Held(_)
            | Expr::Unread(_) => Err(format!("{} is not carried out here", show::expr(expr))),
        }
    }

    /// Whether an expression is true.
    ///
    /// # Errors
    /// As with [`Memory::value`].
    pub fn truth(&self, expr: &Expr) -> Result<bool, String> {
        match self.value(expr)? {
            Value::Bool(value) => Ok(value),
            other => Err(format!("{} is {other:?}, and no truth value", show::expr(expr))),
        }
    }

    fn number(&self, expr: &Expr) -> Result<i64, String> {
        match self.value(expr)? {
            Value::Int(value) | Value::Time(value) => Ok(value),
            // What was never written is 0.
            Value::Bool(value) => Ok(i64::from(value)),
        }
    }

    fn key(&self, path: &Path) -> Result<String, String> {
        let mut key = path.first.clone();
        for part in &path.rest {
            match part {
                Part::Name(name) => key = format!("{key}.{name}"),
                Part::Bit(bit) => key = format!("{key}.{bit}"),
                Part::Dereference => return Err("pointers are not followed".to_owned()),
                Part::Index(indices) => {
                    for index in indices {
                        key = format!("{key}[{}]", self.number(index)?);
                    }
                }
            }
        }
        Ok(key)
    }

    /// Carries out statements.
    ///
    /// # Errors
    /// What cannot be carried out here, in words.
    pub fn run(&mut self, statements: &[Statement]) -> Result<(), String> {
        let mut left = STEPS;
        self.all(statements, &mut left).map(|_| ())
    }

    /// Carries out statements; false if they are left early.
    fn all(&mut self, statements: &[Statement], left: &mut u32) -> Result<bool, String> {
        for statement in statements {
            *left = left.checked_sub(1).ok_or("the body does not end")?;
            let goes_on = match &statement.kind {
                Kind::Assign(target, value) => {
                    let value = self.value(value)?;
                    let key = self.key(target)?;
                    self.set(&key, value);
                    true
                }
                Kind::Latch(target, value, condition) => {
                    if self.truth(condition)? {
                        let key = self.key(target)?;
                        self.set(&key, Value::Bool(*value));
                    }
                    true
                }
                Kind::If(arms, otherwise) => {
                    let mut chosen = otherwise;
                    for (condition, body) in arms {
                        if self.truth(condition)? {
                            chosen = body;
                            break;
                        }
                    }
                    self.all(chosen, left)?
                }
                Kind::For(variable, from, to, by, body) => {
                    let (from, to) = (self.number(from)?, self.number(to)?);
                    let by = by.as_ref().map_or(Ok(1), |by| self.number(by))?;
                    let key = self.key(variable)?;
                    self.set(&key, Value::Int(from));
                    let mut goes_on = true;
                    while goes_on && by != 0 {
                        let Some(Value::Int(now)) = self.get(&key) else { break };
                        if by > 0 && now > to || by < 0 && now < to {
                            break;
                        }
                        goes_on = self.all(body, left)?;
                        let Some(Value::Int(now)) = self.get(&key) else { break };
                        self.set(&key, Value::Int(now.checked_add(by).ok_or_else(overflow)?));
                        *left = left.checked_sub(1).ok_or("the body does not end")?;
                    }
                    goes_on
                }
                Kind::Return(condition) => !self.truth(condition)?,
                Kind::Label(_) => true,
                _ => return Err(format!("line {} is not carried out here", statement.line)),
            };
            if !goes_on {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

fn overflow() -> String {
    "a number is too large".to_owned()
}

fn binary(operator: Operator, left: Value, right: Value) -> Result<Value, String> {
    use Operator as O;
    let operator = operator.eager();
    if let (Value::Bool(left), Value::Bool(right)) = (left, right) {
        return Ok(Value::Bool(match operator {
            O::Or => left || right,
            O::And => left && right,
            O::Xor | O::NotEqual => left != right,
            O::Equal => left == right,
            _ => return Err(format!("truth values have no {}", operator.symbol())),
        }));
    }
    let plain = |value| match value {
        Value::Int(value) | Value::Time(value) => value,
        Value::Bool(value) => i64::from(value),
    };
    let is_time = matches!(left, Value::Time(_)) || matches!(right, Value::Time(_));
    let (left, right) = (plain(left), plain(right));
    let number = |value: Option<i64>| {
        let value = value.ok_or_else(overflow)?;
        Ok(if is_time { Value::Time(value) } else { Value::Int(value) })
    };
    match operator {
        O::Equal => Ok(Value::Bool(left == right)),
        O::NotEqual => Ok(Value::Bool(left != right)),
        O::Less => Ok(Value::Bool(left < right)),
        O::LessOrEqual => Ok(Value::Bool(left <= right)),
        O::Greater => Ok(Value::Bool(left > right)),
        O::GreaterOrEqual => Ok(Value::Bool(left >= right)),
        O::Add => number(left.checked_add(right)),
        O::Subtract => number(left.checked_sub(right)),
        O::Multiply => number(left.checked_mul(right)),
        O::Divide => number(left.checked_div(right)),
        O::Modulo => number(left.checked_rem(right)),
        O::Or => Ok(Value::Int(left | right)),
        O::And => Ok(Value::Int(left & right)),
        O::Xor => Ok(Value::Int(left ^ right)),
        O::Power | O::AndThen | O::OrElse => Err("powers are not carried out here".to_owned()),
    }
}
