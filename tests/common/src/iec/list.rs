//! Instruction lists as trees of their own, which write themselves and are run instruction by instruction: by the
//! standard alone, and by no line of what they are held against.

use super::machine::{BOOL, Expr, Machine, Scope, Ty};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    Always,
    True,
    False,
}

#[derive(Debug, Clone)]
pub enum Instruction {
    Load(Expr, bool),
    /// AND, OR, XOR, with N.
    Logic(&'static str, bool, Expr),
    /// The same with a list in brackets.
    Group(&'static str, bool, Vec<Instruction>),
    /// ADD and so on, or a comparison.
    Number(&'static str, Expr),
    /// A function whose first input is the result.
    Function(&'static str, Vec<Expr>),
    Not,
    Store(&'static str, bool),
    Set(&'static str),
    Reset(&'static str),
    Jump(When, &'static str),
    Label(&'static str),
    Call(When, &'static str, &'static str, Vec<(&'static str, Expr)>),
    /// An input of a block takes the result, and the block is carried out.
    Hand(&'static str, &'static str, &'static str),
    Return(When),
}

fn word(of: &str, when: When) -> String {
    let end = match when {
        When::Always => "",
        When::True => "C",
        When::False => "CN",
    };
    format!("{of}{end}")
}

pub fn text(list: &[Instruction]) -> String {
    use Instruction as I;
    let n = |negated: &bool| if *negated { "N" } else { "" };
    let all = |given: &[Expr]| given.iter().map(Expr::text).collect::<Vec<_>>().join(", ");
    list.iter()
        .map(|one| match one {
            I::Load(value, negated) => format!("LD{} {}\n", n(negated), value.text()),
            I::Logic(of, negated, value) => format!("{of}{} {}\n", n(negated), value.text()),
            I::Group(of, negated, inner) => match &inner[..] {
                [I::Load(first, false), rest @ ..] => {
                    format!("{of}{}( {}\n{})\n", n(negated), first.text(), text(rest))
                }
                _ => format!("{of}{}(\n{})\n", n(negated), text(inner)),
            },
            I::Number(of, value) => format!("{of} {}\n", value.text()),
            I::Function(of, given) => format!("{of} {}\n", all(given)),
            I::Not => "NOT\n".to_owned(),
            I::Store(target, negated) => format!("ST{} {target}\n", n(negated)),
            I::Set(target) => format!("S {target}\n"),
            I::Reset(target) => format!("R {target}\n"),
            I::Jump(when, label) => format!("{} {label}\n", word("JMP", *when)),
            I::Label(label) => format!("{label}:\n"),
            I::Call(when, instance, _, given) => {
                let given: Vec<String> = given
                    .iter()
                    .map(|(name, value)| format!("{name} := {}", value.text()))
                    .collect();
                format!("{} {instance}({})\n", word("CAL", *when), given.join(", "))
            }
            I::Hand(input, instance, _) => format!("{input} {instance}\n"),
            I::Return(when) => format!("{}\n", word("RET", *when)),
        })
        .collect()
}

/// The result that a list has come to.
#[derive(Debug, Clone, Copy)]
struct Result {
    value: i64,
    ty: Ty,
}

fn worked(of: &str, one: Result, two: i64) -> Result {
    let (a, b) = (one.value, two);
    let told = |is: bool| Result { value: i64::from(is), ty: BOOL };
    let number = |value: i64| Result { value: one.ty.wrap(value), ty: one.ty };
    match of {
        "AND" => number(a & b),
        "OR" => number(a | b),
        "XOR" => number(a ^ b),
        "ADD" => number(a + b),
        "SUB" => number(a - b),
        "MUL" => number(a * b),
        "DIV" => number(a / b),
        "MOD" => number(a % b),
        "GT" => told(a > b),
        "GE" => told(a >= b),
        "EQ" => told(a == b),
        "NE" => told(a != b),
        "LE" => told(a <= b),
        _ => told(a < b),
    }
}

/// One scan of a list: what it takes, 1 for each value that is stored or handed to a block, but 3 for S and 2 for R,
/// where they do something; and the last result.
pub fn scan(list: &[Instruction], machine: &mut Machine<'_>) -> (u64, Option<i64>) {
    use Instruction as I;
    let scope = Scope::default();
    let mut result: Option<Result> = None;
    let (mut at, mut cost) = (0, 0);
    while at < list.len() {
        let now = |result: Option<Result>| result.expect("a result");
        let is = |when: When, result: Option<Result>| match when {
            When::Always => true,
            When::True => now(result).value == 1,
            When::False => now(result).value == 0,
        };
        match &list[at] {
            I::Load(value, negated) => {
                let found = machine.value(&scope, value);
                let found = if *negated { 1 - found } else { found };
                result = Some(Result { value: found, ty: value.ty });
            }
            I::Logic(of, negated, value) => {
                let found = machine.value(&scope, value);
                let found = if *negated { 1 - found } else { found };
                result = Some(worked(of, now(result), found));
            }
            I::Group(of, negated, inner) => {
                let found = scan(inner, machine).1.expect("a result");
                let found = if *negated { 1 - found } else { found };
                result = Some(worked(of, now(result), found));
            }
            I::Number(of, value) => {
                let found = machine.value(&scope, value);
                result = Some(worked(of, now(result), found));
            }
            I::Function(of, given) => {
                let first = now(result);
                let given: Vec<i64> = given.iter().map(|one| machine.value(&scope, one)).collect();
                let value = match *of {
                    "MAX" => first.value.max(given[0]),
                    "MIN" => first.value.min(given[0]),
                    "ABS" => first.ty.wrap(first.value.abs()),
                    _ => given[0].max(first.value).min(given[1]),
                };
                result = Some(Result { value, ..first });
            }
            I::Not => {
                let first = now(result);
                result = Some(Result { value: 1 - first.value, ..first });
            }
            I::Store(target, negated) => {
                let value = now(result).value;
                cost += 1;
                machine.set((*target).to_owned(), if *negated { 1 - value } else { value });
            }
            I::Set(target) if now(result).value == 1 => {
                cost += 3;
                machine.set((*target).to_owned(), 1);
            }
            I::Reset(target) if now(result).value == 1 => {
                cost += 2;
                machine.set((*target).to_owned(), 0);
            }
            I::Set(_) | I::Reset(_) => {}
            I::Jump(when, label) if is(*when, result) => {
                let target = |one: &I| matches!(one, I::Label(own) if own == label);
                at = list.iter().position(target).expect("the label");
            }
            I::Return(when) if is(*when, result) => break,
            I::Jump(..) | I::Return(_) | I::Label(_) => {}
            I::Call(when, instance, kind, given) if is(*when, result) => {
                for (name, value) in given {
                    let value = machine.value(&scope, value);
                    cost += 1;
                    machine.state.insert(format!("{instance}.{name}"), value);
                }
                machine.standard(kind, &format!("{instance}."));
            }
            I::Call(..) => {}
            I::Hand(input, instance, kind) => {
                cost += 1;
                machine.state.insert(format!("{instance}.{input}"), now(result).value);
                machine.standard(kind, &format!("{instance}."));
            }
        }
        at += 1;
    }
    (cost, result.map(|one| one.value))
}
