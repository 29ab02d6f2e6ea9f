//! Values of outputs.

use super::super::given::Value;
use super::touched::Held;
use crate::tree::{Expr, ExprKind, Place};
use scanbound_iec::ast;
use std::rc::Rc;

/// What an output is worth.
#[derive(Clone)]
pub(super) struct Worth {
    pub(super) expr: Expr,
    pub(super) shape: Shape,
    /// How it is written, where it is nothing but what stands at an element.
    pub(super) written: Option<Rc<ast::Expr>>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// A truth value that is known.
    Truth(bool),
    /// A constant that is written.
    Constant,
    /// A variable.
    Variable,
    /// Anything else.
    Formula,
}

/// What an output has been worked out as, and under which id it is kept.
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

    /// As the resolver of calls and assignments takes it.
    pub(super) fn value(&self) -> Value<'_> {
        match &self.written {
            Some(written) => Value::Written(written),
            None => Value::Known(self.expr.clone()),
        }
    }

    /// Whether it is this truth value, as the drawing says it.
    pub(super) fn is(&self, value: bool) -> bool {
        self.shape == Shape::Truth(value)
    }

    pub(super) fn is_constant(&self) -> bool {
        matches!(self.shape, Shape::Truth(_) | Shape::Constant)
    }

    /// The negation, which is charged for constants, too.
    pub(super) fn negated(self) -> Worth {
        let (ty, line) = (self.expr.ty, self.expr.line);
        Worth::formula(Expr { kind: ExprKind::Not(Box::new(self.expr)), ty, line })
    }

    /// The negation; that of a constant is one.
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
