//! The parser of instruction lists, which translates them to statements. The accumulator ("result") is kept as an
//! expression until an instruction stores or uses it.

use super::cursor::Cursor;
use super::expression::{argument, arguments, path, unary};
use crate::ast::{Argument, Expr, Kind, Operator, Path, Statement, Temp};
use crate::fault::Fault;
use crate::lexer::Token;
use crate::same;
use std::collections::{BTreeMap, BTreeSet};

/// Instructions that distinguish an instruction list from structured text.
const WORDS: &[&str] = &[
    "LD", "LDN", "ST", "STN", "AND", "ANDN", "OR", "ORN", "XOR", "XORN", "JMP", "JMPC", "JMPCN",
    "CAL", "CALC", "CALCN", "RET", "RETC", "RETCN",
];

/// Whether an instruction list begins at the cursor.
pub(super) fn begins(cursor: &mut Cursor) -> bool {
    let start = cursor.place();
    while cursor.take_pragma().is_some() {}
    // Labels may precede the first instruction.
    while matches!(cursor.peek(), Token::Word(_)) && matches!(cursor.second(), Token::Sign(":")) {
        cursor.next();
        cursor.next();
    }
    let operand = !matches!(cursor.second(), Token::Sign(":=" | "." | "[" | "=>"));
    let is_instruction = cursor.is_one_of(WORDS) && operand;
    cursor.back_to(start);
    is_instruction
}

/// Instructions that pass the result to an input of a function block and call the block.
const INPUTS: &[&str] = &["CLK", "IN", "PT", "CU", "CD", "PV", "S1", "R1"];

/// After this many operators the result is stored in a temporary, to limit the depth of expressions.
const ROW: usize = 100;
/// The maximum number of operators in a condition, where nothing can be stored.
const LONGEST: usize = 400;

/// The state while a list is read: the current result and the statements so far.
#[derive(Default)]
struct List {
    result: Option<Expr>,
    statements: Vec<Statement>,
    kept: u32,
    /// Whether the list is a condition, which must not store anything.
    is_condition: bool,
    /// The number of operators so far.
    operators: usize,
    /// The labels that jumps lead to, in capitals, and whether every such jump carries a result.
    jumps: BTreeMap<String, bool>,
    /// For each label, in capitals, the temporary for the result of the paths that meet there.
    merged: BTreeMap<String, Temp>,
    /// The labels after which the result is used.
    asked: BTreeSet<String>,
}

impl List {
    fn within(outer: &List, result: Option<Expr>) -> List {
        let is_condition = outer.is_condition;
        let merged = outer.merged.clone();
        List { result, kept: outer.kept, merged, is_condition, ..List::default() }
    }

    fn add(&mut self, line: u32, kind: Kind) {
        self.statements.push(Statement { line, kind });
    }

    fn result(&self, line: u32) -> Result<Expr, Fault> {
        let none = || Fault::new(line, "there is no result yet").help("begin with LD");
        self.result.clone().ok_or_else(none)
    }

    /// Stores the result in a temporary, because its operands may change, and returns the new result.
    fn keep(&mut self, line: u32) -> Result<Expr, Fault> {
        let result = self.result(line)?;
        let at = self.statements.len();
        let kept = self.keep_at(line, at, result);
        self.result = Some(kept.clone());
        Ok(kept)
    }

    /// Inserts the storage of a value before the statement at index `at`. Literals and temporaries are returned
    /// unchanged.
    fn keep_at(&mut self, line: u32, at: usize, value: Expr) -> Expr {
        if matches!(&value, Expr::Literal(_) | Expr::Kept(_)) {
            return value;
        }
        let kept = self.temp(false, format!("the result of line {line}"));
        let kind = Kind::Keep(kept.clone(), value);
        self.statements.insert(at, Statement { line, kind });
        Expr::Kept(kept)
    }

    fn temp(&mut self, merges: bool, text: String) -> Temp {
        self.kept += 1;
        Temp { number: self.kept, merges, text }
    }

    /// The temporary that each path to a label assigns.
    fn merged(&mut self, label: &str) -> Temp {
        let key = label.to_ascii_uppercase();
        if let Some(known) = self.merged.get(&key) {
            return known.clone();
        }
        let own = self.temp(true, format!("the result at label {label}"));
        self.merged.insert(key, own.clone());
        own
    }

    /// Discards or carries away the result: its evaluation is still emitted, since the controller performs it.
    fn leave(&mut self, line: u32) {
        if self.result.is_some() {
            let _ = self.keep(line);
        }
    }

    /// Assigns the result, if there is one, to the temporary of a label.
    fn lead(&mut self, line: u32, label: &str) {
        if let Some(result) = self.result.clone() {
            let kept = self.merged(label);
            self.add(line, Kind::Keep(kept, result));
        }
    }

    /// The statements, without assignments to temporaries of labels after which the result is not used.
    fn finish(self) -> Vec<Statement> {
        let asked: BTreeSet<u32> =
            self.asked.iter().filter_map(|label| Some(self.merged.get(label)?.number)).collect();
        let is_needed = |one: &Statement| match &one.kind {
            Kind::Keep(kept, _) => !kept.merges || asked.contains(&kept.number),
            _ => true,
        };
        self.statements.into_iter().filter(is_needed).collect()
    }
}

/// Parses a list up to the end of a body.
pub(super) fn instructions(cursor: &mut Cursor) -> Result<Vec<Statement>, Fault> {
    let mut list = List::default();
    read(cursor, &mut list, &[])?;
    let line = cursor.line();
    list.leave(line);
    Ok(list.finish())
}

/// Parses a list that is a condition, up to one of these words; returns its result.
pub(super) fn value(cursor: &mut Cursor, ends: &[&str]) -> Result<Expr, Fault> {
    let line = cursor.line();
    let mut list = List { is_condition: true, ..List::default() };
    read(cursor, &mut list, ends)?;
    if let Some(first) = list.statements.first() {
        return Err(Fault::new(first.line, "a condition must not store anything"));
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
        if let Some(text) = cursor.take_pragma() {
            // The pragma leaves an unknown result.
            list.leave(line);
            list.result = None;
            list.add(line, Kind::Foreign(text));
            continue;
        }
        let word = match cursor.take_sign("&") {
            false => cursor.name("an instruction")?,
            // `&` and `&N` are other spellings of AND and ANDN.
            true => {
                let start = cursor.place();
                let negates = !cursor.is_line_end() && cursor.take_word("N");
                match negates && !cursor.is_line_end() {
                    true => "ANDN".to_owned(),
                    false => {
                        cursor.back_to(start);
                        "AND".to_owned()
                    }
                }
            }
        };
        // An instruction's operand never stands on the next line.
        if !cursor.is_line_end() && cursor.take_sign(":") {
            label(cursor, list, word, line)?;
            continue;
        }
        instruction(cursor, list, &word.to_ascii_uppercase(), line)?;
        cursor.take_sign(";");
    }
}

/// Handles a label, where paths with different results may meet.
fn label(cursor: &mut Cursor, list: &mut List, label: String, line: u32) -> Result<(), Fault> {
    list.leave(line);
    let is_same = |one: &Statement| matches!(&one.kind, Kind::Label(own) if same(own, &label));
    if list.statements.iter().any(is_same) {
        return Err(Fault::new(line, format!("there are two labels {label}")));
    }
    let has_result = list.jumps.get(&label.to_ascii_uppercase()).copied();
    // If LD or the end of the list follows, the result of the paths is not used.
    let is_left =
        cursor.is_one_of(&["LD", "LDN"]) || cursor.is_one_of(ENDS) || *cursor.peek() == Token::End;
    if let (Some(has_result), false) = (has_result, is_left) {
        list.lead(line, &label);
        let is_known = has_result && list.result.is_some();
        let merged = list.merged(&label);
        list.result = is_known.then_some(Expr::Kept(merged));
        list.asked.insert(label.to_ascii_uppercase());
    }
    list.add(line, Kind::Label(label));
    Ok(())
}

fn instruction(cursor: &mut Cursor, list: &mut List, word: &str, line: u32) -> Result<(), Fault> {
    match word {
        "LD" | "LDN" => {
            list.leave(line);
            let value = operand(cursor, list)?;
            list.result = Some(if word == "LDN" { value.not() } else { value });
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
            list.leave(line);
            let condition = condition(list, &word[3..], line)?;
            let has_result = list.jumps.entry(label.to_ascii_uppercase()).or_insert(true);
            *has_result &= list.result.is_some();
            list.lead(line, &label);
            list.add(line, Kind::Jump(condition, label));
        }
        "RET" | "RETC" | "RETCN" => {
            list.leave(line);
            let condition = condition(list, &word[3..], line)?;
            list.add(line, Kind::Return(condition));
        }
        "CAL" | "CALC" | "CALCN" => {
            let condition = condition(list, &word[3..], line)?;
            let target = path(cursor)?;
            let given = if cursor.is_sign("(") { given(cursor, list)? } else { Vec::new() };
            // The call may change the operands of the result.
            list.leave(line);
            list.add(line, Kind::CallIf(condition, target, given));
        }
        _ if INPUTS.contains(&word) && !cursor.is_line_end() && !cursor.is_sign("(") => {
            let value = list.keep(line)?;
            let target = path(cursor)?;
            let given = Argument { name: Some(word.to_owned()), is_output: false, value };
            list.add(line, Kind::Call(target, vec![given]));
        }
        _ => match operator(word) {
            Some((operator, negated)) => {
                let mut left = list.result(line)?;
                let before = list.statements.len();
                let right = operand(cursor, list)?;
                if list.statements.len() > before {
                    left = list.keep_at(line, before, left);
                }
                let right = if negated { right.not() } else { right };
                list.result = Some(Expr::Binary(operator, Box::new(left), Box::new(right)));
                list.operators += 1;
                if list.operators.is_multiple_of(ROW) && !list.is_condition {
                    list.keep(line)?;
                } else if list.is_condition && list.operators > LONGEST {
                    let message =
                        format!("a condition of more than {LONGEST} operators is not followed");
                    return Err(Fault::new(line, message).help("store parts of it in variables"));
                }
            }
            None => function(cursor, list, word, line)?,
        },
    }
    Ok(())
}

/// A call of a function: the result is its first input, and the others follow on the line.
fn function(cursor: &mut Cursor, list: &mut List, word: &str, line: u32) -> Result<(), Fault> {
    let first = list.result.clone();
    let mut given: Vec<Argument> = first.into_iter().map(unnamed).collect();
    if !cursor.is_line_end() && cursor.is_sign("(") {
        // The result is not an input here, but the controller has computed it.
        list.leave(line);
        given = arguments(cursor)?;
    } else {
        while !cursor.is_line_end() {
            // Only a single operand, because an operator would be the next instruction.
            given.push(unnamed(unary(cursor)?));
            if !cursor.take_sign(",") {
                break;
            }
        }
    }
    if given.is_empty() {
        return Err(Fault::new(line, format!("'{word}' is not an instruction")));
    }
    list.result = Some(Expr::Call(Path::name(word), given));
    Ok(())
}

/// Parses the arguments of an instance's call; an input may have an instruction list in brackets.
fn given(cursor: &mut Cursor, list: &mut List) -> Result<Vec<Argument>, Fault> {
    cursor.sign("(")?;
    let mut found = Vec::new();
    while !cursor.take_sign(")") {
        let start = cursor.place();
        let name = cursor.next();
        let is_list = cursor.take_sign(":=") && cursor.take_sign("(") && begins(cursor);
        cursor.back_to(start);
        found.push(match name {
            Token::Word(name) if is_list => {
                cursor.next();
                cursor.next();
                Argument { name: Some(name), is_output: false, value: operand(cursor, list)? }
            }
            _ => cursor.deeper(argument)?,
        });
        if !cursor.take_sign(",") {
            cursor.sign(")")?;
            break;
        }
    }
    Ok(found)
}

fn unnamed(value: Expr) -> Argument {
    Argument { name: None, is_output: false, value }
}

/// Parses an operand, or an instruction list in brackets.
fn operand(cursor: &mut Cursor, list: &mut List) -> Result<Expr, Fault> {
    if !cursor.take_sign("(") {
        return unary(cursor);
    }
    let line = cursor.line();
    let first = if begins(cursor) { None } else { Some(unary(cursor)?) };
    let mut inner = List::within(list, first);
    cursor.deeper(|cursor| read(cursor, &mut inner, &[]))?;
    list.kept = inner.kept;
    list.merged.clone_from(&inner.merged);
    list.statements.extend(inner.statements.clone());
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
    let plain = |word: &str| Operator::named(word).filter(|own| *own != Operator::Power);
    match word {
        "ANDN" | "ORN" | "XORN" => plain(&word[..word.len() - 1]).map(|own| (own, true)),
        word => plain(word).map(|own| (own, false)),
    }
}

#[cfg(test)]
mod tests {
    use crate::ast::{Expr, Kind, Statement};
    use crate::parse::{instruction_list, instruction_list_value};
    use crate::show;

    #[test]
    fn lists_come_down_to_statements() {
        let text = "LD a\nANDN b\nOR( c\nAND d\n)\nST e\nR f\nCALC t(IN := a)\nLD x\nADD 1\nST x\nMAX 5\nST y\nJMPC out\nout:\nLD 1\n";
        let read = instruction_list(text, 1).expect("a list");
        assert_eq!(
            show::statements(&read, 0),
            "the result of line 6 := a AND NOT b OR c AND d;\ne := the result of line 6;\nIF the result of line 6 THEN f := FALSE; END_IF;\n\
             IF the result of line 6 THEN t(IN := a); END_IF;\nthe result of line 11 := x + 1;\nx := the result of line 11;\nthe result of line 13 := MAX(the result of line 11, 5);\n\
             y := the result of line 13;\nIF the result of line 13 THEN JMP out; END_IF;\nout:\n"
        );
    }

    #[test]
    fn ways_that_meet_at_a_label_bring_their_results() {
        let text = "LD a\nJMPC out\nLD b\nout:\nST c\n";
        let read = instruction_list(text, 1).expect("a list");
        assert_eq!(
            show::statements(&read, 0),
            "the result of line 2 := a;\nthe result at label out := the result of line 2;\nIF the result of line 2 THEN JMP out; END_IF;\nthe result of line 4 := b;\nthe result at label out := the result of line 4;\nout:\nc := the result at label out;\n"
        );
        // On one of the paths nothing was loaded.
        assert!(instruction_list("JMP out\nLD b\nout:\nST c\n", 1).is_err());
    }

    #[test]
    fn what_is_called_is_called_whoever_asks_for_its_result() {
        let read = instruction_list("LD a\nF\nLD b\nST c\n", 1).expect("a list");
        assert_eq!(
            show::statements(&read, 0),
            "the result of line 3 := F(a);\nthe result of line 4 := b;\nc := the result of line 4;\n"
        );
        let read = instruction_list("LD a\nCAL f(x := 1)\nST c\nLD b\nIN t\n", 1).expect("a list");
        assert_eq!(
            show::statements(&read, 0),
            "the result of line 2 := a;\nf(x := 1);\nc := the result of line 2;\nthe result of line 5 := b;\nt(IN := the result of line 5);\n"
        );
    }

    #[test]
    fn a_condition_is_a_value() {
        let read = instruction_list("LD a\nF\nF(i := b)\nST c\n", 1).expect("a list");
        let is_call = |one: &&Statement| matches!(&one.kind, Kind::Keep(_, Expr::Call(..)));
        assert_eq!(read.iter().filter(is_call).count(), 2, "{read:?}");
        let long = format!("LD a\n{}ST c\n", "AND b\n".repeat(5_000));
        assert!(instruction_list(&long, 1).is_ok());
        let value = instruction_list_value("LD a\nAND b\nGT 3", 1).expect("a value");
        assert_eq!(show::expr(&value), "(a AND b) > 3");
        assert!(instruction_list_value("LD a\nST b", 1).is_err());
        assert!(instruction_list("AND a", 1).is_err());
    }
}
