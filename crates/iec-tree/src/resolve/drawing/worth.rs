//! Values of element outputs.

use super::super::given::Value;
use super::touched::Held;
use crate::tree::{Expr, ExprKind, Place};
use scanbound_iec::ast;
use std::rc::Rc;

/// The value of an output.
#[derive(Clone)]
pub(super) struct Worth {
    pub(super) expr: Expr,
    pub(super) shape: Shape,
    /// The expression as written, if the value is exactly the expression at an element.
    pub(super) written: Option<Rc<ast::Expr>>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// A known constant `TRUE` or `FALSE`.
    Truth(bool),
    /// Another literal constant.
    Constant,
    /// A read of a variable.
    Variable,
    /// Any other expression.
    Formula,
}

/// A stored value, and the storage whose operands are recorded.
#[derive(Clone)]
pub(super) struct Kept {
    pub(super) value: Worth,
    pub(super) held: Held,
}

impl Worth {
    pub(super) fn formula(expr: Expr) -> Worth {
        Worth { expr, shape: Shape::Formula, written: None }
    }

    pub(super) fn variable(place: Place, line: u32) -> Worth {
        let ty = place.ty;
        Worth {
            expr: Expr { kind: ExprKind::Read(place), ty, line },
            shape: Shape::Variable,
            written: None,
        }
    }

    /// The value as an argument for calls and assignments.
    pub(super) fn value(&self) -> Value<'_> {
        match &self.written {
            Some(written) => Value::Written(written),
            None => Value::Known(self.expr.clone()),
        }
    }

    /// Whether it is the constant `value` in the drawing. Variables declared constant do not count.
    pub(super) fn is(&self, value: bool) -> bool {
        self.shape == Shape::Truth(value)
    }

    pub(super) fn is_constant(&self) -> bool {
        matches!(self.shape, Shape::Truth(_) | Shape::Constant)
    }

    /// The negation as an operation that takes time, also for constants.
    pub(super) fn negated(self) -> Worth {
        let (ty, line) = (self.expr.ty, self.expr.line);
        Worth::formula(Expr { kind: ExprKind::Not(Box::new(self.expr)), ty, line })
    }

    /// The negation; a constant `TRUE` or `FALSE` is negated at once.
    pub(super) fn not(mut self) -> Worth {
        match self.shape {
            Shape::Truth(value) => {
                self.expr.kind = ExprKind::Bool(!value);
                Worth { shape: Shape::Truth(!value), written: None, ..self }
            }
            _ => self.negated(),
        }
    }
}
