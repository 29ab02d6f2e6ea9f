//! Resolution and typing of expressions.

use super::given::Given;
use super::paths::{Found, property_here, start};
use super::resolver::{Resolver, Scope, unknown_name};
use crate::blocks::Pin;
use crate::standard::{beside, operated};
use crate::tree::{Expr, ExprKind, Place, Root, Step};
use crate::types::{Elementary, Kind, Refers, Type, TypeId};
use scanbound_base::code::Code;
use scanbound_iec::ast::{self, Literal, Operator};
use scanbound_iec::fault::Fault;
use scanbound_iec::{same, show};

impl Resolver<'_> {
    /// Resolves an expression. A fault becomes an [`ExprKind::Fault`].
    pub(super) fn expression(&mut self, scope: Scope, one: &ast::Expr, line: u32) -> Expr {
        let around = self.before.len();
        let found = match self.found(scope, one, line) {
            Ok(found) => found,
            Err(fault) => self.faulty(fault, line),
        };
        self.after_calls(around, found)
    }

    pub(super) fn faulty(&mut self, fault: Fault, line: u32) -> Expr {
        let ty = self.unknown();
        Expr { kind: ExprKind::Fault(Box::new(fault)), ty, line }
    }

    fn found(&mut self, scope: Scope, one: &ast::Expr, line: u32) -> Result<Expr, Fault> {
        let (kind, ty) = match one {
            ast::Expr::Literal(literal) => self.literal(literal, one, line)?,
            ast::Expr::Variable(path) if self.is_null(scope, path) => {
                return Ok(self.null(line));
            }
            ast::Expr::Variable(path) if path.as_name().is_some_and(|name| same(name, "THIS")) => {
                return Ok(self.address(scope, one, line));
            }
            ast::Expr::Variable(path) => match self.path(scope, path, line)? {
                Found::Constant(constant) => return Ok(constant),
                Found::Property(property) => {
                    let found = self.property_read(scope, &property, line)?;
                    if !matches!(
                        self.tree.types.get(found.ty),
                        Type::Reference(Refers::Reference, _)
                    ) {
                        return Ok(found);
                    }
                    let place = self.given_whole(scope, property, line)?;
                    let ty = place.ty;
                    (ExprKind::Read(place), ty)
                }
                Found::Place(place) => {
                    let ty = place.ty;
                    (ExprKind::Read(place), ty)
                }
            },
            ast::Expr::Not(inner) => {
                let inner = self.expression(scope, inner, line);
                let ty = inner.ty;
                (ExprKind::Not(Box::new(inner)), ty)
            }
            ast::Expr::Negate(inner) => {
                let inner = self.expression(scope, inner, line);
                let ty = inner.ty;
                (ExprKind::Negate(Box::new(inner)), ty)
            }
            ast::Expr::Binary(operator, left, right) => {
                let left = self.expression(scope, left, line);
                let right = self.expression(scope, right, line);
                return Ok(self.operation(*operator, left, right));
            }
            ast::Expr::Kept(kept) => {
                let Some(&id) = self.listed.get(&kept.number) else {
                    return Err(unknown_name(line, &kept.text));
                };
                let ty = self.tree.temporaries[id.index()].ty;
                let place = start(Root::Temporary(id), ty);
                (ExprKind::Read(Place { text: kept.text.as_str().into(), ..place }), ty)
            }
            ast::Expr::Held(held) => {
                let known = scope.unit.and_then(|unit| self.held.get(&(unit, (**held).clone())));
                let Some(&known) = known else { return Err(unknown_name(line, &show::expr(one))) };
                let mut place = self.start(known);
                if held.output.is_none() {
                    place.steps.push(Step::Pin(Pin::Q));
                    place.ty = self.bool();
                }
                let ty = place.ty;
                (ExprKind::Read(place), ty)
            }
            ast::Expr::Unread(why) => {
                let told = format!("a condition cannot be read: {why}");
                return Err(Fault::new(line, told).code(Code::NotModelled));
            }
            // Lists occur only as initial values in declarations.
            ast::Expr::List(..) => {
                let told = format!("{} is not a value of a single variable", show::expr(one));
                return Err(Fault::new(line, told).code(Code::NotModelled));
            }
            ast::Expr::Call(path, given) => {
                return self.called(scope, path, &Given::written(given), line);
            }
        };
        Ok(Expr { kind, ty, line })
    }

    /// A binary operation whose operands are converted to their common type.
    pub(super) fn operation(&mut self, operator: Operator, left: Expr, right: Expr) -> Expr {
        let line = left.line;
        let types = &mut self.tree.types;
        let ty = operated(types, operator, left.ty, right.ty);
        let mut meet = operated(types, Operator::Add, left.ty, right.ty);
        for one in [&left, &right] {
            if let (Some(value), Type::Untyped) = (one.whole(), types.get(one.ty)) {
                meet = beside(types, meet, value);
            }
        }
        let ty = if (4..=5).contains(&operator.binding()) { ty } else { meet };
        let [left, right] = [left, right].map(|one| Box::new(self.converted(one, meet)));
        Expr { kind: ExprKind::Binary(operator, left, right), ty, line }
    }

    /// Converts a value to an elementary or string type. It stays unchanged if it has that type, if `to` is another
    /// kind of type, or if it is a fault.
    pub(super) fn converted(&mut self, one: Expr, to: TypeId) -> Expr {
        let types = &self.tree.types;
        let is_value = |ty| matches!(types.get(ty), Type::Elementary(_) | Type::Text(_));
        let is_same = one.ty == to || !is_value(to);
        if is_same || matches!(one.kind, ExprKind::Fault(_)) {
            return one;
        }
        let line = one.line;
        Expr { kind: ExprKind::Convert(Box::new(one)), ty: to, line }
    }

    fn literal(
        &mut self,
        literal: &Literal,
        of: &ast::Expr,
        line: u32,
    ) -> Result<(ExprKind, TypeId), Fault> {
        let elementary = |own: &Self, one| own.tree.types.elementary(one);
        Ok(match literal {
            Literal::Bool(value) => (ExprKind::Bool(*value), self.bool()),
            Literal::Int(value, name) => {
                let small =
                    i64::try_from(*value).or_else(|_| u64::try_from(*value).map(u64::cast_signed));
                let value = small.map_err(|_| {
                    let told = format!("{} is too large", show::expr(of));
                    Fault::new(line, told).code(Code::Operand)
                })?;
                match name.as_deref().and_then(Elementary::named) {
                    Some(Elementary::Bool) => (ExprKind::Bool(value != 0), self.bool()),
                    Some(one) if matches!(one.kind(), Some(Kind::Whole { .. })) => {
                        (ExprKind::Typed(value), elementary(self, one))
                    }
                    _ => (ExprKind::Whole(value), self.tree.types.id(Type::Untyped)),
                }
            }
            Literal::Real(text, name) if name.as_deref() != Some("LREAL") => {
                (ExprKind::Real(text.clone()), elementary(self, Elementary::Real))
            }
            Literal::Real(..) => (ExprKind::Opaque, elementary(self, Elementary::Lreal)),
            Literal::Date(_) => (ExprKind::Opaque, elementary(self, Elementary::Date)),
            Literal::Time(time) => (ExprKind::Time(*time), elementary(self, Elementary::Time)),
            Literal::Text(text) => {
                let length = u32::try_from(text.len()).unwrap_or(u32::MAX);
                (ExprKind::Text(text.clone()), self.tree.types.id(Type::Text(length)))
            }
        })
    }

    /// The place that a path names; a fault if it names a property, a constant or a step's flag.
    pub(super) fn place(
        &mut self,
        scope: Scope,
        path: &ast::Path,
        line: u32,
    ) -> Result<Place, Fault> {
        match self.path(scope, path, line)? {
            Found::Place(place) => Ok(place),
            Found::Property(_) => Err(property_here(line, &show::path(path))),
            Found::Constant(_) => {
                Err(Fault::new(line, "a constant or a step's flag cannot be written")
                    .code(Code::Operand))
            }
        }
    }
}
