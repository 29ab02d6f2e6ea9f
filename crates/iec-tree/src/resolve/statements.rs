//! Resolution of statements.

use super::given::{Given, Side, Value};
use super::paths::{Found, property_here};
use super::resolver::{Resolver, Scope};
use crate::tree::{Expr, ExprKind, ForLoop, Place, Selector, Statement, StatementKind, Step};
use crate::types::{Refers, Type};
use scanbound_base::code::Code;
use scanbound_iec::ast::{self, Kind};
use scanbound_iec::drawing::Drawing;
use scanbound_iec::fault::Fault;
use scanbound_iec::{Body, show};
use std::collections::{BTreeMap, BTreeSet};

/// The labels of one body.
#[derive(Default)]
pub(super) struct Labels {
    /// The number of each label, by its name in capitals.
    numbers: BTreeMap<String, u32>,
    /// The labels that have occurred so far, so that a jump to one of them goes back.
    pub(super) passed: BTreeSet<u32>,
}

impl Labels {
    fn number(&mut self, name: &str) -> u32 {
        let next = u32::try_from(self.numbers.len()).unwrap_or(u32::MAX);
        *self.numbers.entry(name.to_ascii_uppercase()).or_insert(next)
    }

    /// A jump to a label, if the condition is true; a fault if the label has already occurred.
    pub(super) fn jump(
        &mut self,
        label: &str,
        condition: Expr,
        line: u32,
    ) -> Result<StatementKind, Fault> {
        let number = self.number(label);
        if self.passed.contains(&number) {
            let help = "only jumps to labels further down are followed: write it as FOR";
            return Err(Fault::new(line, format!("the jump to {label} goes back"))
                .code(Code::JumpBack)
                .help(help));
        }
        Ok(StatementKind::Jump(condition, number))
    }

    /// Declares a label at the current position.
    pub(super) fn label(&mut self, label: &str) -> StatementKind {
        let number = self.number(label);
        self.passed.insert(number);
        StatementKind::Label(number)
    }
}

impl Resolver<'_> {
    /// Resolves the statements of a body. `line` is used for faults of the whole body.
    pub(super) fn body(&mut self, scope: Scope, body: &Body, line: u32) -> Vec<Statement> {
        let mut labels = Labels::default();
        self.listed.clear();
        let mut found = match body {
            Body::Code(_, all) => self.statements(scope, all, &mut labels),
            Body::Drawn(_, all) => {
                let all: Vec<_> =
                    all.iter().map(|one| self.drawn(scope, one, &mut labels)).collect();
                let apart = self.drawings_are_apart(&all, line);
                let fault = apart.err().map(|fault| {
                    let kind = StatementKind::Fault(Box::new(fault));
                    Statement { kind, text: "".into(), line }
                });
                fault.into_iter().chain(all.into_iter().flatten()).collect()
            }
            Body::Chart(_) | Body::Unread(..) => Vec::new(),
        };
        for (name, number) in &labels.numbers {
            if !labels.passed.contains(number) {
                let help = "only jumps to labels further down are followed";
                let told = format!("there is no label {name} further down");
                let fault = Fault::new(line, told).code(Code::NoLabel).help(help);
                let kind = StatementKind::Fault(Box::new(fault));
                found.push(Statement { kind, text: "".into(), line });
            }
        }
        found
    }

    pub(super) fn statements(
        &mut self,
        scope: Scope,
        all: &[ast::Statement],
        labels: &mut Labels,
    ) -> Vec<Statement> {
        all.iter().map(|one| self.statement(scope, one, labels)).collect()
    }

    fn drawn(&mut self, scope: Scope, one: &Drawing, labels: &mut Labels) -> Vec<Statement> {
        self.drawing(scope, one, labels).unwrap_or_else(|fault| {
            let line = fault.line;
            let kind = StatementKind::Fault(Box::new(fault));
            vec![Statement { kind, text: "".into(), line }]
        })
    }

    pub(super) fn statement(
        &mut self,
        scope: Scope,
        one: &ast::Statement,
        labels: &mut Labels,
    ) -> Statement {
        let text = show::statements(std::slice::from_ref(one), 0);
        let text = text.lines().next().unwrap_or_default().into();
        let line = one.line;
        let around = self.before.len();
        let kind = self.kind(scope, one, labels);
        let kind = kind.unwrap_or_else(|fault| StatementKind::Fault(Box::new(fault)));
        self.statement_after(around, Statement { kind, text, line })
    }

    fn kind(
        &mut self,
        scope: Scope,
        one: &ast::Statement,
        labels: &mut Labels,
    ) -> Result<StatementKind, Fault> {
        let line = one.line;
        Ok(match &one.kind {
            Kind::Keep(kept, value) => {
                let value = self.expression(scope, value, line);
                if let ExprKind::Fault(fault) = value.kind {
                    return Err(*fault);
                }
                StatementKind::Keep(self.listed(kept, value.ty), value)
            }
            Kind::Assign(path, value) => self.assign(scope, path, &Value::Written(value), line)?,
            Kind::Chained(path, value) => {
                self.is_evaluated_once(scope, path, line)?;
                if let ast::Expr::Variable(path) = value {
                    self.is_evaluated_once(scope, path, line)?;
                }
                self.assign(scope, path, &Value::Written(value), line)?
            }
            Kind::Latch(path, set, condition) => {
                self.latch(scope, path, *set, &Value::Written(condition), line)?
            }
            Kind::Call(target, given) => {
                self.call_statement(scope, target, &Given::written(given), line)?
            }
            Kind::CallIf(condition, target, given) => {
                let condition = match condition.is(true) {
                    true => None,
                    false => Some(self.expression(scope, condition, line)),
                };
                self.call_if(scope, condition, target, &Given::written(given), line)?
            }
            Kind::If(arms, otherwise) => {
                let arms = arms.iter().map(|(condition, body)| {
                    let condition = self.expression(scope, condition, line);
                    (condition, self.statements(scope, body, labels))
                });
                let arms = arms.collect();
                StatementKind::If(arms, self.statements(scope, otherwise, labels))
            }
            Kind::Case(of, arms, otherwise) => {
                let of = self.expression(scope, of, line);
                let arms = arms.iter().map(|(selectors, body)| {
                    let selectors = selectors.iter().map(|one| Selector {
                        low: self.expression(scope, &one.low, line),
                        high: one.high.as_ref().map(|high| self.expression(scope, high, line)),
                    });
                    let selectors = selectors.collect();
                    (selectors, self.statements(scope, body, labels))
                });
                let arms = arms.collect();
                StatementKind::Case(of, arms, self.statements(scope, otherwise, labels))
            }
            Kind::For(variable, from, to, by, body) => {
                self.one_path(scope, variable, line)?;
                let variable = self.place(scope, variable, line)?;
                let from = self.expression(scope, from, line);
                let from = self.converted(from, variable.ty);
                let to = self.expression(scope, to, line);
                let by = match by {
                    None => Some(1),
                    Some(by) => self.expression(scope, by, line).whole(),
                };
                let body = self.statements(scope, body, labels);
                StatementKind::For(Box::new(ForLoop { variable, from, to, by, body }))
            }
            Kind::While(condition, body) => {
                let condition = self.expression(scope, condition, line);
                StatementKind::While(condition, self.statements(scope, body, labels))
            }
            Kind::Repeat(body, until) => {
                let body = self.statements(scope, body, labels);
                StatementKind::Repeat(body, self.expression(scope, until, line))
            }
            Kind::Exit => StatementKind::Exit,
            Kind::Continue => StatementKind::Continue,
            Kind::Return(condition) => {
                StatementKind::Return(self.expression(scope, condition, line))
            }
            Kind::Jump(condition, label) => {
                let condition = self.expression(scope, condition, line);
                labels.jump(label, condition, line)?
            }
            Kind::Label(label) => labels.label(label),
            Kind::Unread(what) => {
                return Err(Fault::new(line, what.clone()).code(Code::NotModelled));
            }
            Kind::Refer(target, value) => {
                let target = self.reference_place(scope, target, line)?;
                if !self.tree.types.is_reference(target.ty) {
                    let told = format!("{} is not a reference", target.text);
                    return Err(Fault::new(line, told).code(Code::Operand));
                }
                StatementKind::Assign(target, self.address(scope, value, line))
            }
            Kind::Foreign(text) => self.foreign(scope, text, line)?,
        })
    }

    /// Refuses a variable of a chained assignment for which it matters when and how often it is evaluated.
    fn is_evaluated_once(
        &mut self,
        scope: Scope,
        path: &ast::Path,
        line: u32,
    ) -> Result<(), Fault> {
        let around = self.before.len();
        let found = self.path(scope, path, line)?;
        self.before.truncate(around);
        let what = match found {
            Found::Property(_) => "is a property",
            Found::Place(place) if place.has_open_index() => "has a calculated index",
            Found::Place(place) if place.steps.contains(&Step::Dereference) => "is a reference",
            Found::Place(_) | Found::Constant(_) => return Ok(()),
        };
        let told = format!("{}, which a chained assignment writes, {what}", show::path(path));
        let help = "write one assignment for each variable, the last one first";
        Err(Fault::new(line, told).code(Code::NotModelled).help(help))
    }

    /// Resolves an assignment.
    pub(super) fn assign(
        &mut self,
        scope: Scope,
        path: &ast::Path,
        value: &Value<'_>,
        line: u32,
    ) -> Result<StatementKind, Fault> {
        if self.takes_address(scope, path, line) {
            let target = self.reference_place(scope, path, line)?;
            return Ok(match self.value_for(scope, value, target.ty, line) {
                Expr { kind: ExprKind::Fault(fault), .. } => StatementKind::Fault(fault),
                value => StatementKind::Assign(target, value),
            });
        }
        let target = match self.path(scope, path, line)? {
            Found::Property(property) => {
                return self.property_written(scope, &property, value, line);
            }
            Found::Place(place) => place,
            Found::Constant(_) => self.place(scope, path, line)?,
        };
        let value = self.value(scope, value, line);
        self.assigned(target, value, line)
    }

    /// Resolves a set or reset of a variable, property or block input under a condition.
    pub(super) fn latch(
        &mut self,
        scope: Scope,
        path: &ast::Path,
        set: bool,
        condition: &Value<'_>,
        line: u32,
    ) -> Result<StatementKind, Fault> {
        if let Found::Property(property) = self.one_path(scope, path, line)? {
            // A property's setter is called only if the condition is true.
            let value = ast::Expr::bool(set);
            let kind = self.property_written(scope, &property, &Value::Written(&value), line)?;
            let condition = self.value(scope, condition, line);
            let text = show::path(path).into();
            let inner = Box::new(Statement { kind, text, line });
            return Ok(StatementKind::CallIf(condition, inner));
        }
        let target = self.place(scope, path, line)?;
        match self.tree.types.get(target.ty) {
            // On an instance, the IL instructions S and R are calls with the input of that name.
            Type::Block(_) | Type::Standard(_) => {
                let name = Some(if set { "S" } else { "R" });
                let given = [Given { name, side: Side::In(condition.clone()) }];
                return self.call_statement(scope, path, &given, line);
            }
            Type::Elementary(of) if of.kind().is_some() => {
                let told = format!("{} is a number, which is not set or reset", target.text);
                return Err(Fault::new(line, told).code(Code::Operand));
            }
            _ => {}
        }
        let condition = self.value(scope, condition, line);
        Ok(StatementKind::Latch(target, set, condition))
    }

    /// Resolves a call, executed only if the condition, if any, is true.
    pub(super) fn call_if(
        &mut self,
        scope: Scope,
        condition: Option<Expr>,
        target: &ast::Path,
        given: &[Given<'_>],
        line: u32,
    ) -> Result<StatementKind, Fault> {
        let around = self.before.len();
        let kind = self.call_statement(scope, target, given, line)?;
        let Some(condition) = condition else { return Ok(kind) };
        if self.before.len() > around {
            return Err(property_here(line, &show::path(target)));
        }
        let text = show::path(target).into();
        Ok(StatementKind::CallIf(condition, Box::new(Statement { kind, text, line })))
    }

    /// Whether an assignment to this path changes the target of a pointer or interface, so that the value is an
    /// address.
    fn takes_address(&mut self, scope: Scope, path: &ast::Path, line: u32) -> bool {
        let around = self.before.len();
        let found = self.reference(scope, path, line);
        self.before.truncate(around);
        let Ok(Found::Place(place)) = found else { return false };
        matches!(
            self.tree.types.get(place.ty),
            Type::Reference(Refers::Pointer, _) | Type::Interface(_)
        )
    }

    /// Assigns a resolved value: a conversion to an elementary type, or a copy of an array, structure or instance.
    pub(super) fn assigned(
        &mut self,
        target: Place,
        value: Expr,
        line: u32,
    ) -> Result<StatementKind, Fault> {
        if let ExprKind::Fault(fault) = value.kind {
            return Ok(StatementKind::Fault(fault));
        }
        let is_whole = |own: &Self, place: &Place| {
            matches!(
                own.tree.types.get(place.ty),
                Type::Array(..) | Type::Struct(_) | Type::Block(_) | Type::Standard(_)
            )
        };
        if let ExprKind::Read(from) = &value.after_calls().kind
            && is_whole(self, from)
            && is_whole(self, &target)
        {
            self.has_own_type("a variable", target.ty, from.ty, line)?;
            // A copy after a getter's call is kept as an assignment, which may write any value.
            if let ExprKind::Read(from) = value.kind {
                return Ok(StatementKind::Copy(target, from));
            }
        }
        let value = self.converted(value, target.ty);
        Ok(StatementKind::Assign(target, value))
    }
}
