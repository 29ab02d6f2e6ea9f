//! Typed expressions and statements as structured text, for reports about drawings.

use crate::tree::{Call, Expr, ExprKind, Passed, StatementKind, Target, Tree};

/// An expression as structured text. Implicit conversions and calls that run before it are left out.
#[must_use]
pub fn expr(tree: &Tree, one: &Expr) -> String {
    let all = |values: &mut dyn Iterator<Item = &Expr>| {
        let shown: Vec<String> = values.map(|one| expr(tree, one)).collect();
        shown.join(", ")
    };
    match &one.kind {
        ExprKind::Bool(value) => if *value { "TRUE" } else { "FALSE" }.to_owned(),
        ExprKind::Whole(value) | ExprKind::Typed(value) | ExprKind::Named(value) => {
            value.to_string()
        }
        ExprKind::Real(text) => text.clone(),
        ExprKind::Time(time) => format!("T#{}ms", time / 1_000_000),
        ExprKind::Opaque => "a value".to_owned(),
        ExprKind::Text(text) => format!("'{text}'"),
        ExprKind::Read(place) => place.text.to_string(),
        ExprKind::Address(place) => format!("ADR({})", place.text),
        ExprKind::Null => "NULL".to_owned(),
        ExprKind::Not(inner) => format!("NOT {}", bracketed(tree, inner, 9)),
        ExprKind::Negate(inner) => format!("-{}", bracketed(tree, inner, 9)),
        ExprKind::Binary(operator, left, right) => {
            let own = operator.binding();
            let is_same = matches!(&right.kind, ExprKind::Binary(inner, ..) if inner == operator);
            let more = u8::from(!(is_same && operator.is_of_bits()));
            let (left, right) = (bracketed(tree, left, own), bracketed(tree, right, own + more));
            format!("{left} {} {right}", operator.symbol())
        }
        ExprKind::Convert(inner) => expr(tree, inner),
        ExprKind::Call(called) => call(tree, called),
        ExprKind::Standard(applied) => {
            format!("{}({})", applied.name, all(&mut applied.inputs.iter()))
        }
        ExprKind::List(values) => all(&mut values.iter()),
        ExprKind::Step(flag) => {
            format!("a step's {}", if flag.is_time { "time" } else { "flag" })
        }
        ExprKind::After(both) => expr(tree, &both.1),
        ExprKind::Either(None) => "any value".to_owned(),
        ExprKind::Either(Some(both)) => {
            format!("either({}, {})", expr(tree, &both.0), expr(tree, &both.1))
        }
        ExprKind::Fault(fault) => fault.text.clone(),
    }
}

/// The expression as text, in brackets if its precedence is below `least`.
fn bracketed(tree: &Tree, one: &Expr, least: u8) -> String {
    let binds = match &one.unconverted().kind {
        ExprKind::Binary(operator, ..) => operator.binding(),
        ExprKind::Not(_) | ExprKind::Negate(_) if least > 4 => 0,
        _ => u8::MAX,
    };
    if binds < least { format!("({})", expr(tree, one)) } else { expr(tree, one) }
}

fn call(tree: &Tree, call: &Call) -> String {
    let target = match &call.target {
        Target::Function(unit) | Target::BaseBody(unit) => tree.unit(*unit).name.clone(),
        Target::Instance(place, _) | Target::Standard(place, _) | Target::Program(place, _) => {
            place.text.to_string()
        }
        Target::Action(_, routine) | Target::Method(_, routine) | Target::BaseMethod(routine) => {
            tree.routine(*routine).name.clone()
        }
    };
    let passed = call.passed.iter().filter_map(|(_, passed)| match passed {
        Passed::ByValue(value) | Passed::InOut(value) => Some(expr(tree, value)),
        Passed::Output(..) | Passed::Dropped => None,
    });
    let passed: Vec<String> = passed.collect();
    format!("{target}({})", passed.join(", "))
}

/// A statement that writes a variable, as structured text; `target` is the text of the variable. Other statements give
/// `target` alone.
#[must_use]
pub fn statement(tree: &Tree, kind: &StatementKind, target: &str) -> String {
    match kind {
        StatementKind::Assign(_, value) | StatementKind::Keep(_, value) => {
            format!("{target} := {};", expr(tree, value))
        }
        StatementKind::Latch(_, set, condition) => {
            let value = if *set { "TRUE" } else { "FALSE" };
            format!("IF {} THEN {target} := {value}; END_IF;", expr(tree, condition))
        }
        StatementKind::Copy(_, from) => format!("{target} := {};", from.text),
        _ => target.to_owned(),
    }
}
