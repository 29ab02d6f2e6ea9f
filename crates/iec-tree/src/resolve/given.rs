//! What calls and assignments are given: as it is written, or as a drawing has resolved it.

use super::resolver::{Resolver, Scope};
use crate::declarations::{TempId, VarId};
use crate::tree::{Expr, Place};
use crate::types::TypeId;
use scanbound_base::code::Code;
use scanbound_iec::ast::{self, Argument, Path};
use scanbound_iec::fault::Fault;
use scanbound_iec::same;

/// A value as it is written, or what a drawing has made of it.
#[derive(Clone)]
pub(super) enum Value<'a> {
    /// As it is written.
    Written(&'a ast::Expr),
    /// Resolved.
    Known(Expr),
}

/// Where a result goes.
#[derive(Clone)]
pub(super) enum Taker<'a> {
    /// As it is written.
    Written(&'a ast::Expr),
    /// What a drawing keeps.
    Kept(TempId),
    /// A variable that a drawing declares.
    Variable(VarId),
}

/// What is handed over to what is called, or taken from it.
#[derive(Clone)]
pub(super) struct Given<'a> {
    /// The parameter's name, where it is given.
    pub(super) name: Option<&'a str>,
    /// A value, or where a result goes.
    pub(super) side: Side<'a>,
}

#[derive(Clone)]
pub(super) enum Side<'a> {
    In(Value<'a>),
    Out(Taker<'a>),
}

impl<'a> Given<'a> {
    /// Arguments as they are written.
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

/// Where a result goes, and whether it is negated on the way.
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
    /// A value as an expression.
    pub(super) fn value(&mut self, scope: Scope, value: &Value<'_>, line: u32) -> Expr {
        match value {
            Value::Written(value) => self.expression(scope, value, line),
            Value::Known(value) => value.clone(),
        }
    }

    /// A value for what has a type: of references their addresses.
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
                let told = "what a drawing gives a reference is not followed";
                self.faulty(Fault::new(line, told).code(Code::NotModelled), line)
            }
            value => self.value(scope, value, line),
        }
    }

    /// Where a result of a type goes, and whether it is negated on the way; nothing, if it goes nowhere.
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
