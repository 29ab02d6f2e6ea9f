//! What code reads, writes and calls, as one walk through it tells: questions about this differ in what they make of
//! it.

use crate::code::{
    Applied, Call, Enable, Expr, ExprKind, Passed, Place, Statement, StatementKind, StepFlag,
};

/// What is told of code, in its order. Nothing is told of indices.
pub trait Accesses {
    /// A variable is read.
    fn reads(&mut self, place: &Place);
    /// A variable is written.
    fn writes(&mut self, place: &Place);
    /// The address of a variable is taken.
    fn takes_address(&mut self, place: &Place);
    /// A step's flag or time is read.
    fn asks(&mut self, flag: &StepFlag);
    /// Something is called, to which all that it is passed has been told.
    fn calls(&mut self, call: &Call);
    /// A statement comes, before what stands in it is told.
    fn begins(&mut self, _: &Statement) {}
}

/// Tells what statements do.
pub fn of_statements(all: &[Statement], see: &mut dyn Accesses) {
    for one in all {
        see.begins(one);
        match &one.kind {
            StatementKind::Assign(target, value) | StatementKind::Latch(target, _, value) => {
                of_expr(value, see);
                see.writes(target);
            }
            StatementKind::Copy(target, from) => {
                see.reads(from);
                see.writes(target);
            }
            StatementKind::Keep(_, value)
            | StatementKind::Return(value)
            | StatementKind::Jump(value, _) => of_expr(value, see),
            StatementKind::Call(call) => of_call(call, see),
            StatementKind::Standard(applied) => of_applied(applied, see),
            StatementKind::CallIf(condition, inner) => {
                of_expr(condition, see);
                of_statements(std::slice::from_ref(inner), see);
            }
            StatementKind::After(both) => {
                of_call(&both.0, see);
                of_statements(std::slice::from_ref(&both.1), see);
            }
            StatementKind::Foreign(stated) => {
                stated.writes.iter().flatten().for_each(|place| see.writes(place));
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
                see.writes(&own.variable);
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

/// Tells what an expression does.
pub fn of_expr(one: &Expr, see: &mut dyn Accesses) {
    match &one.kind {
        ExprKind::Read(place) => see.reads(place),
        ExprKind::Address(place) => see.takes_address(place),
        ExprKind::Step(flag) => see.asks(flag),
        ExprKind::Not(inner) | ExprKind::Negate(inner) | ExprKind::Convert(inner) => {
            of_expr(inner, see);
        }
        ExprKind::Binary(_, left, right) => {
            of_expr(left, see);
            of_expr(right, see);
        }
        ExprKind::Call(call) => of_call(call, see),
        ExprKind::After(both) => {
            of_call(&both.0, see);
            of_expr(&both.1, see);
        }
        ExprKind::Standard(applied) => of_applied(applied, see),
        ExprKind::List(all) => all.iter().for_each(|one| of_expr(one, see)),
        ExprKind::Either(Some(both)) => {
            of_expr(&both.0, see);
            of_expr(&both.1, see);
        }
        _ => {}
    }
}

fn of_applied(of: &Applied, see: &mut dyn Accesses) {
    of.inputs.iter().for_each(|one| of_expr(one, see));
    of.outputs.iter().for_each(|place| see.writes(place));
    of_enable(&of.enable, see);
}

fn of_enable(enable: &Enable, see: &mut dyn Accesses) {
    enable.condition.iter().for_each(|one| of_expr(one, see));
    enable.result.iter().for_each(|(place, _)| see.writes(place));
}

/// Tells what a call does, and what it is passed.
pub fn of_call(call: &Call, see: &mut dyn Accesses) {
    for (_, passed) in &call.passed {
        match passed {
            Passed::ByValue(one) => of_expr(one, see),
            Passed::InOut(one) => {
                of_expr(one, see);
                if let ExprKind::Read(place) = &one.unconverted().kind {
                    see.writes(place);
                }
            }
            Passed::Output(place, _) => see.writes(place),
            Passed::Dropped => {}
        }
    }
    of_enable(&call.enable, see);
    see.calls(call);
}
