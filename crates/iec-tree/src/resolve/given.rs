//! Arguments of calls and assigned values, from the syntax tree or already resolved by a drawing.

use super::resolver::{Resolver, Scope};
use crate::declarations::{TempId, VarId};
use crate::tree::{Expr, Place};
use crate::types::TypeId;
use scanbound_base::code::Code;
use scanbound_iec::ast::{self, Argument, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::same;

/// An input value, from the syntax tree or already resolved.
#[derive(Clone)]
pub(super) enum Value<'a> {
    /// From the syntax tree, not yet resolved.
    Written(&'a ast::Expr),
    /// Resolved by a drawing.
    Known(Expr),
}

/// The receiver of an output.
#[derive(Clone)]
pub(super) enum Taker<'a> {
    /// From the syntax tree, not yet resolved.
    Written(&'a ast::Expr),
    /// A temporary of a drawing.
    Kept(TempId),
    /// A variable that the reader declared for a drawing.
    Variable(VarId),
}

/// One argument of a call.
#[derive(Clone)]
pub(super) struct Given<'a> {
    /// The parameter's name; `None` for a positional argument.
    pub(super) name: Option<&'a str>,
    /// An input value or the receiver of an output.
    pub(super) side: Side<'a>,
}

#[derive(Clone)]
pub(super) enum Side<'a> {
    In(Value<'a>),
    Out(Taker<'a>),
}

impl<'a> Given<'a> {
    /// The arguments of a call in the syntax tree.
    pub(super) fn written(all: &'a [Argument]) -> Vec<Given<'a>> {
        let one = |one: &'a Argument| Given {
            name: one.name.as_deref(),
            side: match one.is_output {
                true => Side::Out(Taker::Written(&one.value)),
                false => Side::In(Value::Written(&one.value)),
            },
        };
        all.iter().map(one).collect()
    }

    pub(super) fn is_named(&self, name: &str) -> bool {
        self.name.is_some_and(|own| same(own, name))
    }

    pub(super) fn is_output(&self) -> bool {
        matches!(self.side, Side::Out(_))
    }

    pub(super) fn value(&self) -> Option<&Value<'a>> {
        match &self.side {
            Side::In(value) => Some(value),
            Side::Out(_) => None,
        }
    }
}

/// The variable that receives an output, and whether the value is negated. `None` if the expression is not a variable.
fn taken(value: &ast::Expr) -> Option<(&Path, bool)> {
    let (value, negated) = match value {
        ast::Expr::Not(inner) => (&**inner, true),
        other => (other, false),
    };
    match value {
        ast::Expr::Variable(path) if !path.first.is_empty() => Some((path, negated)),
        _ => None,
    }
}

impl Resolver<'_> {
    /// Resolves an input value.
    pub(super) fn value(&mut self, scope: Scope, value: &Value<'_>, line: u32) -> Expr {
        match value {
            Value::Written(value) => self.expression(scope, value, line),
            Value::Known(value) => value.clone(),
        }
    }

    /// Resolves an input value for a variable of type `ty`; if that is a reference, takes the address.
    pub(super) fn value_for(
        &mut self,
        scope: Scope,
        value: &Value<'_>,
        ty: TypeId,
        line: u32,
    ) -> Expr {
        match value {
            Value::Written(value) if self.tree.types.is_reference(ty) => {
                self.address(scope, value, line)
            }
            Value::Known(value)
                if self.tree.types.is_reference(ty) && !self.tree.types.is_reference(value.ty) =>
            {
                let told = "the value that a drawing gives a reference is not followed";
                self.faulty(Fault::new(line, told).code(Code::NotModelled), line)
            }
            value => self.value(scope, value, line),
        }
    }

    /// Resolves the receiver of an output of type `ty`, with whether the value is negated; `None` if the output is
    /// dropped.
    pub(super) fn taken(
        &mut self,
        scope: Scope,
        taker: &Taker<'_>,
        ty: TypeId,
        line: u32,
    ) -> Result<Option<(Place, bool)>, Fault> {
        let place = match taker {
            Taker::Written(value) => {
                let Some((path, negated)) = taken(value) else { return Ok(None) };
                let place = match self.tree.types.is_reference(ty) {
                    true => self.reference_place(scope, path, line)?,
                    false => self.target(scope, path, line)?,
                };
                return Ok(Some((place, negated)));
            }
            Taker::Kept(id) => {
                self.tree.temporaries[id.index()].ty = ty;
                self.kept_place(*id)
            }
            Taker::Variable(id) => self.start(*id),
        };
        Ok(Some((place, false)))
    }
}
