//! The parser of textual charts: steps, transitions and actions.

use super::cursor::Cursor;
use super::expression::expression;
use super::il;
use crate::Named;
use crate::ast::Path;
use crate::chart::draft::{Draft, DraftTransition};
use crate::chart::{Block, Chart, Qualifier, Step, Target};
use crate::fault::Fault;
use crate::lexer::Token;

const ELEMENTS: &[&str] = &["INITIAL_STEP", "STEP", "TRANSITION"];

/// Whether a chart begins at the cursor.
pub(super) fn begins(cursor: &mut Cursor) -> bool {
    cursor.is_one_of(ELEMENTS) && matches!(cursor.second(), Token::Word(_) | Token::Sign("("))
}

/// Parses a chart and the actions between its elements, for which it calls `action`.
pub(super) fn chart(
    cursor: &mut Cursor,
    action: fn(&mut Cursor) -> Result<Named, Fault>,
) -> Result<(Chart, Vec<Named>), Fault> {
    let line = cursor.line();
    let mut draft = Draft::new(line);
    let mut actions = Vec::new();
    loop {
        if cursor.is_one_of(&["INITIAL_STEP", "STEP"]) {
            step(cursor, &mut draft)?;
        } else if cursor.is_word("TRANSITION") {
            let transition = transition(cursor)?;
            draft.transitions.push(transition);
        } else if cursor.is_word("ACTION") {
            actions.push(action(cursor)?);
        } else if !cursor.take_sign(";") {
            return Ok((draft.finish()?, actions));
        }
    }
}

fn step(cursor: &mut Cursor, draft: &mut Draft) -> Result<(), Fault> {
    let line = cursor.line();
    let initial = cursor.is_word("INITIAL_STEP");
    cursor.next();
    let name = cursor.name("a step's name")?;
    cursor.take_sign(":");
    let mut step = Step::new(name, initial, line);
    while !cursor.take_word("END_STEP") {
        if cursor.take_sign(";") {
            continue;
        }
        step.blocks.push(block(cursor)?);
    }
    draft.steps.push(step);
    Ok(())
}

/// `action(qualifier, time, indicator);`
fn block(cursor: &mut Cursor) -> Result<Block, Fault> {
    let line = cursor.line();
    let name = cursor.name("an action's name or END_STEP")?;
    let mut target = Path::name(name);
    while cursor.take_sign(".") {
        let part = cursor.name("an action's name")?;
        target = target.with(&part);
    }
    let target = Target::Path(target);
    let mut block =
        Block { qualifier: Qualifier::N, is_qualified: false, time: None, target, line };
    if cursor.take_sign("(") {
        if !cursor.is_sign(")") {
            let at = cursor.line();
            let word = cursor.name("a qualifier")?;
            let unknown = || {
                Fault::new(at, format!("'{word}' is not an action qualifier"))
                    .help("the qualifiers are N, R, S, L, D, P, P0, P1, SD, DS and SL")
            };
            block.qualifier = Qualifier::named(&word).ok_or_else(unknown)?;
            block.is_qualified = true;
            if cursor.take_sign(",") {
                let first = expression(cursor)?;
                if block.qualifier.is_timed() {
                    block.time = Some(first);
                }
                // Indicator variables only affect the display, so they are skipped.
                while cursor.take_sign(",") {
                    expression(cursor)?;
                }
            }
            if block.time.is_none() && block.qualifier.is_timed() {
                let message = format!("the qualifier {word} has no time");
                return Err(Fault::new(at, message).help("say how long: A(L, T#2s)"));
            }
        }
        cursor.sign(")")?;
    }
    cursor.take_sign(";");
    Ok(block)
}

fn names(cursor: &mut Cursor) -> Result<Vec<String>, Fault> {
    if !cursor.take_sign("(") {
        return Ok(vec![cursor.name("a step's name")?]);
    }
    let mut found = vec![cursor.name("a step's name")?];
    while cursor.take_sign(",") {
        found.push(cursor.name("a step's name")?);
    }
    cursor.sign(")")?;
    Ok(found)
}

fn transition(cursor: &mut Cursor) -> Result<DraftTransition, Fault> {
    let line = cursor.line();
    cursor.word("TRANSITION")?;
    let name = if cursor.is_word("FROM") || cursor.is_sign("(") {
        None
    } else {
        Some(cursor.name("a transition's name or FROM")?)
    };
    let mut priority = None;
    if cursor.take_sign("(") {
        cursor.word("PRIORITY")?;
        cursor.sign(":=")?;
        priority = match cursor.next() {
            Token::Number(text) => text.parse().ok(),
            _ => None,
        };
        if priority.is_none() {
            return Err(Fault::new(line, "the priority must be a number"));
        }
        cursor.sign(")")?;
    }
    cursor.word("FROM")?;
    let from = names(cursor)?;
    cursor.word("TO")?;
    let to = names(cursor)?;
    let condition = if cursor.take_sign(":=") {
        let condition = expression(cursor)?;
        cursor.take_sign(";");
        condition
    } else {
        cursor.sign(":")?;
        il::value(cursor, &["END_TRANSITION"])?
    };
    cursor.word("END_TRANSITION")?;
    Ok(DraftTransition { name, from, to, condition, priority, line, id: None })
}
