//! A visitor for what code reads, writes and calls. Analyses implement [`Accesses`] and share this one traversal.

use crate::charts::{ActionBody, Chart, Code};
use crate::code::{
    Applied, Call, Enable, Expr, ExprKind, Passed, Place, Statement, StatementKind, StepFlag,
    Target,
};
use std::slice::from_ref;

/// The callbacks of the traversal. The indices of a place are visited before the place itself; so are the indices in
/// the path of a called instance or of a step's chart. Otherwise the order is not the order of execution.
pub trait Accesses {
    /// Code reads a variable.
    fn reads(&mut self, place: &Place);
    /// Code writes a variable.
    fn writes(&mut self, place: &Place);
    /// Code takes the address of a variable.
    fn takes_address(&mut self, place: &Place);
    /// Code reads a step's flag or elapsed time.
    fn asks(&mut self, flag: &StepFlag);
    /// A call, visited after all of its arguments.
    fn calls(&mut self, call: &Call);
    /// A statement, visited before its contents. Does nothing by default.
    fn begins(&mut self, _: &Statement) {}
    /// Code that could not be read, which may do anything. Does nothing by default.
    fn unread(&mut self) {}
}

/// Visits a routine's code.
pub fn of_code(code: &Code, see: &mut dyn Accesses) {
    match code {
        Code::Statements(all) => of_statements(all, see),
        Code::Chart(chart) => of_chart_code(chart, see),
        Code::Unread(_) => see.unread(),
    }
}

/// Visits a chart: conditions, step code and actions. The variables `SFCInit` and `SFCReset` are not visited.
pub fn of_chart_code(chart: &Chart, see: &mut dyn Accesses) {
    chart.conditions.iter().for_each(|one| of_expr(one, see));
    let hooks = chart.steps.iter().flat_map(|step| [&step.exit, &step.entry, &step.active]);
    hooks.flatten().for_each(|one| of_statements(from_ref(one), see));
    for action in &chart.actions {
        action.times.iter().flatten().for_each(|time| of_expr(time, see));
        match &action.body {
            ActionBody::Inline(_, code) => of_code(code, see),
            ActionBody::Variable(place) => {
                of_read(place, see);
                of_write(place, see);
            }
            ActionBody::Call(call) | ActionBody::Computed(call, _) => {
                of_statements(from_ref(call), see);
            }
        }
    }
}

/// Visits statements and everything nested in them. All branches are visited.
pub fn of_statements(all: &[Statement], see: &mut dyn Accesses) {
    for one in all {
        see.begins(one);
        match &one.kind {
            StatementKind::Assign(target, value) | StatementKind::Latch(target, _, value) => {
                of_expr(value, see);
                of_write(target, see);
            }
            StatementKind::Copy(target, from) => {
                of_read(from, see);
                of_write(target, see);
            }
            StatementKind::Keep(_, value)
            | StatementKind::Return(value)
            | StatementKind::Jump(value, _) => of_expr(value, see),
            StatementKind::Call(call) => of_call(call, see),
            StatementKind::Standard(applied) => of_applied(applied, see),
            StatementKind::CallIf(condition, inner) => {
                of_expr(condition, see);
                of_statements(from_ref(inner), see);
            }
            StatementKind::After(both) => {
                of_call(&both.0, see);
                of_statements(from_ref(&both.1), see);
            }
            StatementKind::Foreign(stated) => {
                stated.writes.iter().flatten().for_each(|place| of_write(place, see));
            }
            StatementKind::If(arms, otherwise) => {
                arms.iter().for_each(|(condition, _)| of_expr(condition, see));
                arms.iter().for_each(|(_, body)| of_statements(body, see));
                of_statements(otherwise, see);
            }
            StatementKind::Case(of, arms, otherwise) => {
                of_expr(of, see);
                for one in arms.iter().flat_map(|(selectors, _)| selectors) {
                    of_expr(&one.low, see);
                    one.high.iter().for_each(|high| of_expr(high, see));
                }
                arms.iter().for_each(|(_, body)| of_statements(body, see));
                of_statements(otherwise, see);
            }
            StatementKind::For(own) => {
                of_expr(&own.from, see);
                of_expr(&own.to, see);
                of_write(&own.variable, see);
                of_statements(&own.body, see);
            }
            StatementKind::While(condition, body) | StatementKind::Repeat(body, condition) => {
                of_expr(condition, see);
                of_statements(body, see);
            }
            StatementKind::Either(_, one, other) => {
                of_statements(one, see);
                of_statements(other, see);
            }
            StatementKind::Exit
            | StatementKind::Continue
            | StatementKind::Label(_)
            | StatementKind::Nothing
            | StatementKind::Fault(_) => {}
        }
    }
}

/// Visits an expression with its operands and indices.
pub fn of_expr(one: &Expr, see: &mut dyn Accesses) {
    match &one.kind {
        ExprKind::Read(place) => of_read(place, see),
        ExprKind::Address(place) => {
            of_indices(place, see);
            see.takes_address(place);
        }
        ExprKind::Step(flag) => {
            of_indices(&flag.owner, see);
            see.asks(flag);
        }
        ExprKind::Call(call) => of_call(call, see),
        ExprKind::After(both) => {
            of_call(&both.0, see);
            of_expr(&both.1, see);
        }
        ExprKind::Standard(applied) => of_applied(applied, see),
        ExprKind::Not(_)
        | ExprKind::Negate(_)
        | ExprKind::Convert(_)
        | ExprKind::Binary(..)
        | ExprKind::List(_)
        | ExprKind::Either(_)
        | ExprKind::Bool(_)
        | ExprKind::Whole(_)
        | ExprKind::Typed(_)
        | ExprKind::Named(_)
        | ExprKind::Real(_)
        | ExprKind::Time(_)
        | ExprKind::Opaque
        | ExprKind::Text(_)
        | ExprKind::Null
        | ExprKind::Fault(_) => one.each_operand(&mut |inner| of_expr(inner, see)),
    }
}

fn of_indices(place: &Place, see: &mut dyn Accesses) {
    place.indices().for_each(|index| of_expr(index, see));
}

fn of_read(place: &Place, see: &mut dyn Accesses) {
    of_indices(place, see);
    see.reads(place);
}

fn of_write(place: &Place, see: &mut dyn Accesses) {
    of_indices(place, see);
    see.writes(place);
}

fn of_applied(of: &Applied, see: &mut dyn Accesses) {
    of.inputs.iter().for_each(|one| of_expr(one, see));
    of.outputs.iter().for_each(|place| of_write(place, see));
    of_enable(&of.enable, see);
}

fn of_enable(enable: &Enable, see: &mut dyn Accesses) {
    enable.condition.iter().for_each(|one| of_expr(one, see));
    enable.result.iter().for_each(|(place, _)| of_write(place, see));
}

/// Visits a call's arguments, `EN` and `ENO`, the indices of its target, then the call itself.
pub fn of_call(call: &Call, see: &mut dyn Accesses) {
    for (_, passed) in &call.passed {
        match passed {
            Passed::ByValue(one) => of_expr(one, see),
            Passed::InOut(one) => {
                of_expr(one, see);
                if let ExprKind::Read(place) = &one.unconverted().kind {
                    of_write(place, see);
                }
            }
            Passed::Output(place, _) => of_write(place, see),
            Passed::Dropped => {}
        }
    }
    of_enable(&call.enable, see);
    match &call.target {
        Target::Instance(place, _)
        | Target::Standard(place, _)
        | Target::Action(place, _)
        | Target::Method(place, _)
        | Target::Program(place, _) => of_indices(place, see),
        Target::Function(_) | Target::BaseMethod(_) | Target::BaseBody(_) => {}
    }
    see.calls(call);
}
