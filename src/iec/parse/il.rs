//! Instruction lists, as statements that they come down to: the current result is an expression until something is done
//! with it.

use super::cursor::Cursor;
use super::expression::{arguments, expression, path, unary};
use crate::iec::ast::{Argument, Expr, Kind, Operator, Path, Statement};
use crate::iec::fault::Fault;
use crate::iec::lexer::Token;
use crate::iec::same;

/// Words that begin an instruction, to tell a list from structured text.
const WORDS: &[&str] = &[
    "LD", "LDN", "ST", "STN", "AND", "ANDN", "OR", "ORN", "XOR", "XORN", "JMP", "JMPC", "JMPCN",
    "CAL", "CALC", "CALCN", "RET", "RETC", "RETCN",
];

/// Whether an instruction list begins here.
pub(super) fn begins(cursor: &mut Cursor) -> bool {
    let operand = !matches!(cursor.second(), Token::Sign(":=" | "." | "[" | "=>"));
    cursor.is_one_of(WORDS) && operand
}

/// Inputs of the standard's blocks that are instructions, too. (S, R and LD are others besides.)
const INPUTS: &[&str] = &["S1", "R1", "CLK", "CU", "CD", "PV", "IN", "PT"];

/// What a list has come to.
#[derive(Default)]
struct List {
    result: Option<Expr>,
    /// Whether the result was worked out and nothing was done with it yet.
    is_new: bool,
    statements: Vec<Statement>,
    kept: usize,
}

impl List {
    fn add(&mut self, line: u32, kind: Kind) {
        self.statements.push(Statement { line, kind });
    }

    fn result(&self, line: u32) -> Result<Expr, Fault> {
        let none = || {
            let told = match self.statements.last().map(|one| &one.kind) {
                Some(Kind::Label(label)) => {
                    format!("the result with which jumps come to {label} is not followed")
                }
                _ => "no result is there yet".to_owned(),
            };
            Fault::new(line, told).help("begin with LD")
        };
        self.result.clone().ok_or_else(none)
    }

    /// A function of the result alone.
    fn apply(&mut self, function: &str) {
        let given = self.result.take().into_iter().map(unnamed).collect();
        self.result = Some(Expr::Call(Path::name(function), given));
        self.is_new = true;
    }

    /// Keeps a result that nothing was done with, so that what it takes is not lost.
    fn leave(&mut self, line: u32) -> Result<(), Fault> {
        if self.is_new { self.keep(line).map(|_| ()) } else { Ok(()) }
    }

    /// Keeps the result in a variable of its own, since what it is made of may change.
    fn keep(&mut self, line: u32) -> Result<Expr, Fault> {
        let result = self.result(line)?;
        self.is_new = false;
        if matches!(&result, Expr::Literal(_)) || is_kept(&result) {
            return Ok(result);
        }
        self.kept += 1;
        let kept = Path::name(format!("~il{line}.{}", self.kept).replace('.', "_"));
        self.add(line, Kind::Assign(kept.clone(), result));
        self.result = Some(Expr::Variable(kept.clone()));
        Ok(Expr::Variable(kept))
    }
}

fn is_kept(result: &Expr) -> bool {
    matches!(result, Expr::Variable(path) if path.first.starts_with('~'))
}

/// Reads a list up to the end of a body.
pub(super) fn instructions(cursor: &mut Cursor) -> Result<Vec<Statement>, Fault> {
    let mut list = List::default();
    read(cursor, &mut list, &[])?;
    list.leave(cursor.line())?;
    Ok(list.statements)
}

/// Reads a list that stores nothing, up to one of these words: its result.
pub(super) fn value(cursor: &mut Cursor, ends: &[&str]) -> Result<Expr, Fault> {
    let line = cursor.line();
    let mut list = List::default();
    read(cursor, &mut list, ends)?;
    if let Some(first) = list.statements.first() {
        return Err(Fault::new(first.line, "a condition stores nothing"));
    }
    list.result(line)
}

const ENDS: &[&str] =
    &["END_PROGRAM", "END_FUNCTION", "END_FUNCTION_BLOCK", "END_ACTION", "END_TRANSITION"];

fn read(cursor: &mut Cursor, list: &mut List, ends: &[&str]) -> Result<(), Fault> {
    loop {
        if *cursor.peek() == Token::End
            || cursor.is_one_of(ends)
            || cursor.is_one_of(ENDS)
            || cursor.is_sign(")")
        {
            return Ok(());
        }
        let line = cursor.line();
        let word = cursor.name("an instruction")?;
        // What stands in the next line is no operand.
        let is_alone = cursor.is_line_end();
        if !is_alone && cursor.take_sign(":") {
            list.leave(line)?;
            // Jumps bring results of their own.
            list.result = None;
            list.add(line, Kind::Label(word));
            continue;
        }
        if is_alone && list.result.is_some() && is_function(&word) {
            list.apply(&word);
            continue;
        }
        instruction(cursor, list, &word.to_ascii_uppercase(), line)?;
        cursor.take_sign(";");
    }
}

fn instruction(cursor: &mut Cursor, list: &mut List, word: &str, line: u32) -> Result<(), Fault> {
    match word {
        "LD" | "LDN" => {
            list.leave(line)?;
            let value = operand(cursor, list)?;
            list.result = Some(if word == "LDN" { value.not() } else { value });
            list.is_new = true;
        }
        "ST" | "STN" => {
            let result = list.keep(line)?;
            let target = path(cursor)?;
            list.add(line, Kind::Assign(target, if word == "STN" { result.not() } else { result }));
        }
        "S" | "R" => {
            let result = list.keep(line)?;
            let target = path(cursor)?;
            list.add(line, Kind::Latch(target, word == "S", result));
        }
        "NOT" => list.result = Some(list.result(line)?.not()),
        "JMP" | "JMPC" | "JMPCN" => {
            let label = cursor.name("a label")?;
            list.leave(line)?;
            let condition = condition(list, &word[3..], line)?;
            list.add(line, Kind::Jump(condition, label));
        }
        "RET" | "RETC" | "RETCN" => {
            list.leave(line)?;
            let condition = condition(list, &word[3..], line)?;
            list.add(line, Kind::Return(condition));
        }
        "CAL" | "CALC" | "CALCN" => {
            list.leave(line)?;
            let condition = condition(list, &word[3..], line)?;
            let target = path(cursor)?;
            let given = if cursor.is_sign("(") { arguments(cursor)? } else { Vec::new() };
            list.add(line, Kind::CallIf(condition, target, given));
        }
        _ => match operator(word) {
            Some((operator, negated)) => {
                let left = list.result(line)?;
                let right = operand(cursor, list)?;
                let right = if negated { right.not() } else { right };
                list.result = Some(Expr::Binary(operator, Box::new(left), Box::new(right)));
                list.is_new = true;
            }
            // The input of an instance's: it is called with it.
            None if INPUTS.contains(&word) && !cursor.is_sign("(") => {
                let value = list.keep(line)?;
                let target = path(cursor)?;
                let given = Argument { name: Some(word.to_owned()), is_output: false, value };
                list.add(line, Kind::Call(target, vec![given]));
            }
            None => function(cursor, list, word, line)?,
        },
    }
    Ok(())
}

/// Whether a word is no instruction: then it names a function.
fn is_function(word: &str) -> bool {
    let word = word.to_ascii_uppercase();
    let is_instruction = [WORDS, INPUTS, &["NOT", "S", "R"]].concat().contains(&word.as_str());
    !is_instruction && operator(&word).is_none()
}

/// A function's name: the result is its first input, the others follow in the line.
fn function(cursor: &mut Cursor, list: &mut List, word: &str, line: u32) -> Result<(), Fault> {
    let first = list.result.clone();
    let mut given: Vec<Argument> = first.into_iter().map(unnamed).collect();
    if cursor.is_sign("(") {
        given = arguments(cursor)?;
    } else {
        while !cursor.is_line_end() {
            given.push(unnamed(expression(cursor)?));
            if !cursor.take_sign(",") {
                break;
            }
        }
    }
    if given.is_empty() {
        return Err(Fault::new(line, format!("'{word}' is no instruction")));
    }
    list.result = Some(Expr::Call(Path::name(word), given));
    list.is_new = true;
    Ok(())
}

fn unnamed(value: Expr) -> Argument {
    Argument { name: None, is_output: false, value }
}

/// An operand, or a list in brackets.
fn operand(cursor: &mut Cursor, list: &mut List) -> Result<Expr, Fault> {
    if !cursor.take_sign("(") {
        return unary(cursor);
    }
    let line = cursor.line();
    let inner = if begins(cursor) {
        let mut inner = List { kept: list.kept, ..List::default() };
        cursor.deeper(|cursor| read(cursor, &mut inner, &[]))?;
        list.kept = inner.kept;
        list.statements.extend(inner.statements.clone());
        inner
    } else {
        let first = unary(cursor)?;
        let mut inner = List { result: Some(first), kept: list.kept, ..List::default() };
        cursor.deeper(|cursor| read(cursor, &mut inner, &[]))?;
        list.kept = inner.kept;
        list.statements.extend(inner.statements.clone());
        inner
    };
    cursor.sign(")")?;
    inner.result(line)
}

fn condition(list: &mut List, modifier: &str, line: u32) -> Result<Expr, Fault> {
    match modifier {
        "" => Ok(Expr::bool(true)),
        "C" => list.keep(line),
        _ => Ok(list.keep(line)?.not()),
    }
}

fn operator(word: &str) -> Option<(Operator, bool)> {
    let plain = |word: &str| {
        Some(match word {
            "AND" | "&" => Operator::And,
            "OR" => Operator::Or,
            "XOR" => Operator::Xor,
            "ADD" => Operator::Add,
            "SUB" => Operator::Subtract,
            "MUL" => Operator::Multiply,
            "DIV" => Operator::Divide,
            "MOD" => Operator::Modulo,
            "GT" => Operator::Greater,
            "GE" => Operator::GreaterOrEqual,
            "EQ" => Operator::Equal,
            "NE" => Operator::NotEqual,
            "LE" => Operator::LessOrEqual,
            "LT" => Operator::Less,
            _ => return None,
        })
    };
    let negated = ["ANDN", "ORN", "XORN"].iter().any(|own| same(own, word));
    if negated {
        plain(&word[..word.len() - 1]).map(|own| (own, true))
    } else {
        plain(word).map(|own| (own, false))
    }
}

#[cfg(test)]
mod tests {
    use crate::iec::parse::{instruction_list, instruction_list_value};
    use crate::iec::show;

    #[test]
    fn lists_come_down_to_statements() {
        let text = "LD a\nANDN b\nOR( c\nAND d\n)\nST e\nR f\nCALC t(IN := a)\nLD x\nADD 1\nST x\nMAX 5\nST y\nJMPC out\nout:\nLD 1\n";
        let read = instruction_list(text, 1).expect("a list");
        assert_eq!(
            show::statements(&read, 0),
            "~il6_1 := a AND NOT b OR c AND d;\ne := ~il6_1;\nIF ~il6_1 THEN f := FALSE; END_IF;\n\
             IF ~il6_1 THEN t(IN := a); END_IF;\n~il11_2 := x + 1;\nx := ~il11_2;\n~il13_3 := MAX(~il11_2, 5);\n\
             y := ~il13_3;\nIF ~il13_3 THEN JMP out; END_IF;\nout:\n"
        );
    }

    #[test]
    fn a_condition_is_a_value() {
        let value = instruction_list_value("LD a\nAND b\nGT 3", 1).expect("a value");
        assert_eq!(show::expr(&value), "(a AND b) > 3");
        assert!(instruction_list_value("LD a\nST b", 1).is_err());
        assert!(instruction_list("AND a", 1).is_err());
    }
}
