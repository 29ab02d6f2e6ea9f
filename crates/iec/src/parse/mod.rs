//! The parser of the textual languages of IEC 61131-3: ST, IL, textual charts and declarations.

mod chart;
mod cursor;
mod declaration;
mod expression;
mod il;
mod statement;
mod unit;

use super::ast::{Expr, Statement};
use super::fault::{Fault, foreign};
use super::lexer::{Token, tokens};
use super::{TypeRef, Variable};
use cursor::Cursor;
pub(crate) use declaration::{MAX_LISTED, values_in};
pub use expression::duration;
use scanbound_base::code::Code;
pub(crate) use unit::{apart, file_stem};
pub use unit::{begins as is_units, file};

/// Parses a whole text; its first line has the number `line`.
fn whole<T>(
    text: &str,
    line: u32,
    read: impl FnOnce(&mut Cursor) -> Result<T, Fault>,
) -> Result<T, Fault> {
    let mut cursor = Cursor::new(text, line)?;
    let found = read(&mut cursor)?;
    cursor.end()?;
    Ok(found)
}

/// Parses an expression, which a semicolon may follow. The text's first line has the number `line`.
///
/// # Errors
/// Its first fault.
pub fn expression(text: &str, line: u32) -> Result<Expr, Fault> {
    whole(text, line, |cursor| {
        let expr = expression::expression(cursor)?;
        cursor.take_sign(";");
        Ok(expr)
    })
}

/// Parses statements in structured text. The text's first line has the number `line`.
///
/// # Errors
/// Their first fault.
pub fn statements(text: &str, line: u32) -> Result<Vec<Statement>, Fault> {
    whole(text, line, |cursor| statement::statements(cursor, &[]))
}

/// Parses an instruction list. The text's first line has the number `line`.
///
/// # Errors
/// Its first fault.
pub fn instruction_list(text: &str, line: u32) -> Result<Vec<Statement>, Fault> {
    whole(text, line, il::instructions)
}

/// The expression for the value that an instruction list leaves in the accumulator, as for a transition's condition.
///
/// # Errors
/// Its first fault.
pub fn instruction_list_value(text: &str, line: u32) -> Result<Expr, Fault> {
    whole(text, line, |cursor| il::value(cursor, &[]))
}

/// Parses the variables of all sections (`VAR ... END_VAR`) in the text of a unit's declaration; other text is skipped.
///
/// # Errors
/// Their first fault.
pub fn declarations(text: &str, line: u32) -> Result<Vec<Variable>, Fault> {
    let mut cursor = Cursor::new(text, line)?;
    let mut found = Vec::new();
    loop {
        match declaration::section(&mut cursor) {
            Some(section) => found.extend(declaration::variables(&mut cursor, section)?),
            None if cursor.next() == Token::End => return Ok(found),
            None => {}
        }
    }
}

/// Checks the pragmas and comments in the text of a declaration.
///
/// # Errors
/// The fault of a pragma that may change the meaning of the declaration, or of a comment that is ambiguous.
pub(super) fn pragmas(text: &str) -> Result<(), Fault> {
    match tokens(text, 1, false) {
        Err(fault) if matches!(fault.code, Code::Pragma | Code::Comments) => Err(fault),
        Err(_) => Ok(()),
        Ok(found) => found.into_iter().try_for_each(|one| match one.token {
            Token::Pragma(text) => Err(foreign(&text, one.line)),
            _ => Ok(()),
        }),
    }
}

/// Whether two decodings of the same bytes give the same tokens, apart from non-ASCII characters.
pub fn reads_alike(one: &str, other: &str) -> bool {
    let plain = |text: &str| -> String {
        text.split(|c: char| !c.is_ascii())
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join("?")
    };
    let shown = |text: &str| {
        let found = tokens(text, 1, true).map_err(|fault| fault.code)?;
        Ok::<_, Code>(
            found.into_iter().map(|one| plain(&format!("{:?}", one.token))).collect::<Vec<_>>(),
        )
    };
    shown(one) == shown(other)
}

/// Parses a type, as written after a variable's colon. The text's first line has the number `line`.
///
/// # Errors
/// Its first fault.
pub fn type_ref(text: &str, line: u32) -> Result<TypeRef, Fault> {
    whole(text, line, declaration::type_ref)
}
