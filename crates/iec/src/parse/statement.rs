//! The parser of statements in structured text.

use super::cursor::Cursor;
use super::expression::{arguments, expression, is_keyword, path};
use crate::ast::{Expr, Kind, Selector, Statement};
use crate::fault::Fault;
use crate::lexer::Token;

/// Parses statements up to one of these words or the end of the text, which is not consumed.
pub(super) fn statements(cursor: &mut Cursor, ends: &[&str]) -> Result<Vec<Statement>, Fault> {
    let mut found = Vec::new();
    loop {
        while cursor.take_sign(";") {}
        if *cursor.peek() == Token::End || cursor.is_one_of(ends) {
            return Ok(found);
        }
        let line = cursor.line();
        let kinds = cursor.deeper(statement)?;
        found.extend(kinds.into_iter().map(|kind| Statement { line, kind }));
    }
}

/// Parses a statement. A chained assignment gives several statements.
fn statement(cursor: &mut Cursor) -> Result<Vec<Kind>, Fault> {
    let kind = single(cursor)?;
    let Kind::Assign(_, Expr::Variable(_)) = &kind else { return Ok(vec![kind]) };
    if !cursor.take_sign(":=") {
        cursor.sign(";")?;
        return Ok(vec![kind]);
    }
    // `a := b := c;` assigns c to b, and b to a.
    let mut found = vec![kind];
    loop {
        let Some(Kind::Assign(target, Expr::Variable(variable))) = found.first().cloned() else {
            return Err(cursor.unexpected("';'"));
        };
        found[0] = Kind::Chained(target, Expr::Variable(variable.clone()));
        found.insert(0, Kind::Assign(variable, expression(cursor)?));
        if !cursor.take_sign(":=") {
            cursor.sign(";")?;
            return Ok(found);
        }
    }
}

/// Consumes the closing word of a block, and a semicolon if there is one.
fn close(cursor: &mut Cursor, word: &str) -> Result<(), Fault> {
    cursor.word(word)?;
    cursor.take_sign(";");
    Ok(())
}

fn single(cursor: &mut Cursor) -> Result<Kind, Fault> {
    if let Some(text) = cursor.take_pragma() {
        return Ok(Kind::Foreign(text));
    }
    let Token::Word(word) = cursor.peek().clone() else {
        if matches!(cursor.peek(), Token::Direct(_)) {
            return assignment(cursor);
        }
        return Err(cursor.unexpected("a statement"));
    };
    match word.to_ascii_uppercase().as_str() {
        "IF" => conditional(cursor),
        "CASE" => case(cursor),
        "FOR" => counted(cursor),
        "WHILE" => {
            cursor.next();
            let condition = expression(cursor)?;
            cursor.word("DO")?;
            let body = statements(cursor, &["END_WHILE"])?;
            close(cursor, "END_WHILE")?;
            Ok(Kind::While(condition, body))
        }
        "REPEAT" => {
            cursor.next();
            let body = statements(cursor, &["UNTIL"])?;
            cursor.word("UNTIL")?;
            let until = expression(cursor)?;
            cursor.take_sign(";");
            close(cursor, "END_REPEAT")?;
            Ok(Kind::Repeat(body, until))
        }
        "EXIT" => plain(cursor, Kind::Exit),
        "CONTINUE" => plain(cursor, Kind::Continue),
        "RETURN" => plain(cursor, Kind::Return(Expr::bool(true))),
        _ if is_keyword(&word) => Err(cursor.unexpected("a statement")),
        _ => assignment(cursor),
    }
}

fn plain(cursor: &mut Cursor, kind: Kind) -> Result<Kind, Fault> {
    cursor.next();
    cursor.sign(";")?;
    Ok(kind)
}

fn assignment(cursor: &mut Cursor) -> Result<Kind, Fault> {
    let target = path(cursor)?;
    if cursor.is_sign("(") {
        let arguments = arguments(cursor)?;
        cursor.sign(";")?;
        return Ok(Kind::Call(target, arguments));
    }
    if cursor.take_sign(":=") {
        let value = expression(cursor)?;
        // After a variable, another `:=` may follow.
        if !matches!(value, Expr::Variable(_)) {
            cursor.sign(";")?;
        }
        return Ok(Kind::Assign(target, value));
    }
    // `r REF= a;`
    if cursor.is_word("REF") && matches!(cursor.second(), Token::Sign("=")) {
        cursor.next();
        cursor.next();
        let value = expression(cursor)?;
        cursor.sign(";")?;
        return Ok(Kind::Refer(target, value));
    }
    for (word, set) in [("S", true), ("R", false)] {
        // CODESYS: `a S= b;`
        if cursor.is_word(word) && matches!(cursor.second(), Token::Sign("=")) {
            cursor.next();
            cursor.next();
            let value = expression(cursor)?;
            cursor.sign(";")?;
            return Ok(Kind::Latch(target, set, value));
        }
    }
    // A name that stands alone is read as a call without arguments.
    if cursor.take_sign(";") {
        return Ok(Kind::Call(target, Vec::new()));
    }
    Err(cursor.unexpected("':='"))
}

fn conditional(cursor: &mut Cursor) -> Result<Kind, Fault> {
    cursor.next();
    let ends = ["ELSIF", "ELSE", "END_IF"];
    let mut arms = Vec::new();
    let condition = expression(cursor)?;
    cursor.word("THEN")?;
    arms.push((condition, statements(cursor, &ends)?));
    while cursor.take_word("ELSIF") {
        let condition = expression(cursor)?;
        cursor.word("THEN")?;
        arms.push((condition, statements(cursor, &ends)?));
    }
    let otherwise =
        if cursor.take_word("ELSE") { statements(cursor, &["END_IF"])? } else { Vec::new() };
    close(cursor, "END_IF")?;
    Ok(Kind::If(arms, otherwise))
}

fn case(cursor: &mut Cursor) -> Result<Kind, Fault> {
    cursor.next();
    let of = expression(cursor)?;
    cursor.word("OF")?;
    let mut arms = Vec::new();
    let mut otherwise = Vec::new();
    loop {
        while cursor.take_sign(";") {}
        if cursor.take_word("ELSE") {
            cursor.take_sign(":");
            otherwise = statements(cursor, &["END_CASE"])?;
        }
        if cursor.is_word("END_CASE") {
            close(cursor, "END_CASE")?;
            return Ok(Kind::Case(of, arms, otherwise));
        }
        let selectors = selectors(cursor)?;
        let mut body = Vec::new();
        while !cursor.is_one_of(&["ELSE", "END_CASE"]) && !begins_arm(cursor) {
            if cursor.take_sign(";") {
                continue;
            }
            let line = cursor.line();
            let kinds = cursor.deeper(statement)?;
            body.extend(kinds.into_iter().map(|kind| Statement { line, kind }));
        }
        arms.push((selectors, body));
    }
}

fn selectors(cursor: &mut Cursor) -> Result<Vec<Selector>, Fault> {
    let mut found = Vec::new();
    loop {
        let low = cursor.deeper(expression)?;
        let high = if cursor.take_sign("..") { Some(cursor.deeper(expression)?) } else { None };
        found.push(Selector { low, high });
        if !cursor.take_sign(",") {
            cursor.sign(":")?;
            return Ok(found);
        }
    }
}

/// Whether the labels of a `CASE` arm, with their colon, come next.
fn begins_arm(cursor: &mut Cursor) -> bool {
    let place = cursor.place();
    let is = selectors(cursor).is_ok();
    cursor.back_to(place);
    is
}

fn counted(cursor: &mut Cursor) -> Result<Kind, Fault> {
    cursor.next();
    let variable = path(cursor)?;
    cursor.sign(":=")?;
    let from = expression(cursor)?;
    cursor.word("TO")?;
    let to = expression(cursor)?;
    let by = if cursor.take_word("BY") { Some(expression(cursor)?) } else { None };
    cursor.word("DO")?;
    let body = statements(cursor, &["END_FOR"])?;
    close(cursor, "END_FOR")?;
    Ok(Kind::For(variable, from, to, by, body))
}

#[cfg(test)]
mod tests {
    use crate::parse::statements;
    use crate::show;

    #[test]
    fn statements_are_read_and_shown_again() {
        let text = "\
IF (a) THEN
  b := 1;
ELSIF NOT c THEN
  t(IN := TRUE, PT := T#5s, Q => d);
ELSE
  ;
END_IF
CASE x.y OF
  1, 3..5:
    b := 2;
  red:
    EXIT;
ELSE
  RETURN;
END_CASE;
FOR i := 0 TO 9 BY 2 DO
  a[i] := i;
END_FOR;
WHILE a DO
  b := b - 1;
END_WHILE;
REPEAT
  CONTINUE;
UNTIL b > 3 END_REPEAT;
";
        let read = statements(text, 1).expect("statements");
        assert_eq!(read.len(), 5);
        let shown = show::statements(&read, 0);
        assert_eq!(show::statements(&statements(&shown, 1).expect("again"), 0), shown);
        assert!(shown.contains("3..5:") && shown.contains("Q => d") && shown.contains("BY 2"));
    }

    #[test]
    fn faults_have_their_line() {
        let fault = statements("a := 1;\nb := ;\n", 10).expect_err("a fault");
        assert_eq!(
            (fault.line, fault.message.as_str()),
            (11, "an expression was expected, but ';' was found")
        );
        for text in [
            "a := 1",
            "IF a b := 1; END_IF",
            "a + 1;",
            "FOR i TO 3 DO END_FOR",
            "CASE a OF b := 1; END_CASE",
        ] {
            assert!(statements(text, 1).is_err(), "{text}");
        }
    }
}
