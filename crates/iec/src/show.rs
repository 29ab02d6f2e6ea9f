//! Prints expressions and statements as structured text.

use super::ast::{Argument, Expr, Kind, Listing, Literal, Operator, Part, Path, Statement};
use super::fault::short;
use std::fmt::Write;

/// A duration as a literal, such as `T#1s500ms`.
#[must_use]
pub fn time(nanoseconds: i64) -> String {
    let sign = if nanoseconds < 0 { "-" } else { "" };
    let mut rest = nanoseconds.unsigned_abs();
    if rest == 0 {
        return "T#0s".to_owned();
    }
    let mut text = format!("T#{sign}");
    for (unit, each) in [("s", 1_000_000_000), ("ms", 1_000_000), ("us", 1_000), ("ns", 1)] {
        if rest >= each {
            let _ = write!(text, "{}{unit}", rest / each);
            rest %= each;
        }
    }
    text
}

/// A path as text, such as `Axes[2].Delay.Q`.
#[must_use]
pub fn path(path: &Path) -> String {
    let mut text = path.first.clone();
    for part in &path.rest {
        match part {
            Part::Name(name) => {
                let _ = write!(text, ".{name}");
            }
            Part::Index(indices) => {
                let indices: Vec<String> = indices.iter().map(expr).collect();
                let _ = write!(text, "[{}]", indices.join(", "));
            }
            Part::Bit(bit) => {
                let _ = write!(text, ".{bit}");
            }
            Part::Dereference => text.push('^'),
        }
    }
    text
}

fn literal(literal: &Literal) -> String {
    match literal {
        Literal::Bool(value) => if *value { "TRUE" } else { "FALSE" }.to_owned(),
        Literal::Int(value, Some(of)) => format!("{of}#{value}"),
        Literal::Int(value, None) => value.to_string(),
        Literal::Real(text, Some(of)) => format!("{of}#{text}"),
        Literal::Real(text, None) | Literal::Date(text) => text.clone(),
        Literal::Time(value) => time(*value),
        Literal::Text(text) => format!("'{text}'"),
    }
}

/// An expression as structured text. For temporaries and unreadable parts it gives a description.
#[must_use]
pub fn expr(one: &Expr) -> String {
    match one {
        Expr::Literal(value) => literal(value),
        Expr::Variable(name) => path(name),
        Expr::Not(inner) => format!("NOT {}", bracketed(inner, 9)),
        Expr::Negate(inner) => format!("-{}", bracketed(inner, 9)),
        Expr::Binary(operator, left, right) => {
            let own = operator.binding();
            let is_same = matches!(&**right, Expr::Binary(inner, ..) if inner == operator);
            let more = u8::from(!(is_same && operator.is_of_bits()));
            format!(
                "{} {} {}",
                bracketed(left, own),
                operator.symbol(),
                bracketed(right, own + more)
            )
        }
        Expr::Call(function, given) => operation(function, given)
            .unwrap_or_else(|| format!("{}({})", path(function), arguments(given))),
        Expr::List(Listing::Elements, given) => format!("[{}]", arguments(given)),
        Expr::List(_, given) => format!("({})", arguments(given)),
        Expr::Kept(kept) => kept.text.clone(),
        Expr::Held(held) => match &held.output {
            Some(output) => format!("output {output} of block {} in {}", held.local_id, held.part),
            None => format!("edge at {} in {}", held.local_id, held.part),
        },
        Expr::Unread(why) => format!("what cannot be read ({why})"),
    }
}

/// The reason why an expression cannot be written as text: it uses a temporary, a drawn block with state, or an
/// unreadable part. `None` if it can be written.
#[must_use]
pub fn formless(one: &Expr) -> Option<String> {
    let hidden = |path: &Path| {
        path.rest.iter().find_map(|part| match part {
            Part::Index(indices) => indices.iter().find_map(formless),
            _ => None,
        })
    };
    match one {
        Expr::Literal(_) => None,
        Expr::Variable(path) => hidden(path),
        Expr::Not(inner) | Expr::Negate(inner) => formless(inner),
        Expr::Binary(_, left, right) => formless(left).or_else(|| formless(right)),
        Expr::Call(function, given) => {
            hidden(function).or_else(|| given.iter().find_map(|one| formless(&one.value)))
        }
        Expr::List(_, given) => given.iter().find_map(|one| formless(&one.value)),
        Expr::Kept(_) | Expr::Held(_) => {
            Some("a part of it uses a temporary result, which cannot be written as text".to_owned())
        }
        Expr::Unread(why) => Some(format!("it cannot be read: {why}")),
    }
}

/// AND, OR, XOR and NOT drawn as blocks, in operator form. `None` for other calls, or if an argument is not an input
/// `IN...`.
fn operation(function: &Path, given: &[Argument]) -> Option<String> {
    let is_input = |one: &Argument| {
        let name = one.name.as_deref().unwrap_or("IN");
        !one.is_output && name.get(..2).is_some_and(|begin| begin.eq_ignore_ascii_case("IN"))
    };
    let name = path(function).to_ascii_uppercase();
    if !given.iter().all(is_input) {
        return None;
    }
    let values: Vec<String> = given.iter().map(|one| bracketed(&one.value, u8::MAX)).collect();
    match (name.as_str(), values.len()) {
        ("AND" | "OR" | "XOR", 2..) => Some(format!("({})", values.join(&format!(" {name} ")))),
        ("NOT", 1) => Some(format!("(NOT {})", values[0])),
        _ => None,
    }
}

/// The expression as text, in brackets if its precedence is below `least`.
fn bracketed(one: &Expr, least: u8) -> String {
    let binds = match one {
        Expr::Binary(operator, ..) => operator.binding(),
        // Some tools read `NOT a = b` as `NOT (a = b)`, so brackets are needed.
        Expr::Not(_) | Expr::Negate(_) if least > Operator::And.binding() + 1 => 0,
        _ => u8::MAX,
    };
    if binds < least { format!("({})", expr(one)) } else { expr(one) }
}

fn arguments(given: &[Argument]) -> String {
    let one = |argument: &Argument| {
        let value = expr(&argument.value);
        match (&argument.name, argument.is_output, &argument.value) {
            (Some(name), true, Expr::Not(inner)) => format!("NOT {name} => {}", expr(inner)),
            (Some(name), true, _) => format!("{name} => {value}"),
            (Some(name), false, _) => format!("{name} := {value}"),
            (None, ..) => value,
        }
    };
    given.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Statements, one per line, indented by `level` times two blanks.
#[must_use]
pub fn statements(all: &[Statement], level: usize) -> String {
    let mut text = String::new();
    all.iter().for_each(|one| statement(&mut text, &one.kind, level));
    text
}

fn statement(text: &mut String, kind: &Kind, level: usize) {
    let pad = "  ".repeat(level);
    let under = |text: &mut String, condition: &Expr, what: &str| {
        if condition.is(true) {
            let _ = writeln!(text, "{pad}{what}");
        } else {
            let _ = writeln!(text, "{pad}IF {} THEN {what} END_IF;", expr(condition));
        }
    };
    match kind {
        Kind::Keep(kept, value) => {
            let _ = writeln!(text, "{pad}{} := {};", kept.text, expr(value));
        }
        Kind::Assign(target, value) | Kind::Chained(target, value) => {
            let _ = writeln!(text, "{pad}{} := {};", path(target), expr(value));
        }
        Kind::Call(target, given) => {
            let _ = writeln!(text, "{pad}{}({});", path(target), arguments(given));
        }
        Kind::CallIf(condition, target, given) => {
            under(text, condition, &format!("{}({});", path(target), arguments(given)));
        }
        Kind::If(arms, otherwise) => {
            for (at, (condition, body)) in arms.iter().enumerate() {
                let word = if at == 0 { "IF" } else { "ELSIF" };
                let _ = writeln!(text, "{pad}{word} {} THEN", expr(condition));
                *text += &statements(body, level + 1);
            }
            if !otherwise.is_empty() {
                let _ = writeln!(text, "{pad}ELSE");
                *text += &statements(otherwise, level + 1);
            }
            let _ = writeln!(text, "{pad}END_IF;");
        }
        Kind::Case(of, arms, otherwise) => {
            let _ = writeln!(text, "{pad}CASE {} OF", expr(of));
            for (selectors, body) in arms {
                let one = |selector: &super::ast::Selector| match &selector.high {
                    Some(high) => format!("{}..{}", expr(&selector.low), expr(high)),
                    None => expr(&selector.low),
                };
                let values: Vec<String> = selectors.iter().map(one).collect();
                let _ = writeln!(text, "{pad}  {}:", values.join(", "));
                *text += &statements(body, level + 2);
            }
            if !otherwise.is_empty() {
                let _ = writeln!(text, "{pad}ELSE");
                *text += &statements(otherwise, level + 1);
            }
            let _ = writeln!(text, "{pad}END_CASE;");
        }
        Kind::For(variable, from, to, by, body) => {
            let by = by.as_ref().map(|by| format!(" BY {}", expr(by))).unwrap_or_default();
            let _ = writeln!(
                text,
                "{pad}FOR {} := {} TO {}{by} DO",
                path(variable),
                expr(from),
                expr(to)
            );
            *text += &statements(body, level + 1);
            let _ = writeln!(text, "{pad}END_FOR;");
        }
        Kind::While(condition, body) => {
            let _ = writeln!(text, "{pad}WHILE {} DO", expr(condition));
            *text += &statements(body, level + 1);
            let _ = writeln!(text, "{pad}END_WHILE;");
        }
        Kind::Repeat(body, until) => {
            let _ = writeln!(text, "{pad}REPEAT");
            *text += &statements(body, level + 1);
            let _ = writeln!(text, "{pad}UNTIL {} END_REPEAT;", expr(until));
        }
        Kind::Exit => {
            let _ = writeln!(text, "{pad}EXIT;");
        }
        Kind::Continue => {
            let _ = writeln!(text, "{pad}CONTINUE;");
        }
        Kind::Return(condition) => under(text, condition, "RETURN;"),
        Kind::Jump(condition, label) => under(text, condition, &format!("JMP {label};")),
        Kind::Label(label) => {
            let _ = writeln!(text, "{pad}{label}:");
        }
        Kind::Refer(target, value) => {
            let _ = writeln!(text, "{pad}{} REF= {};", path(target), expr(value));
        }
        Kind::Latch(target, value, condition) => {
            let value = if *value { "TRUE" } else { "FALSE" };
            under(text, condition, &format!("{} := {value};", path(target)));
        }
        Kind::Foreign(code) => {
            let _ = writeln!(text, "{pad}{}", short(code));
        }
        Kind::Unread(what) => {
            let _ = writeln!(text, "{pad}(* {what} *)");
        }
    }
}
