//! Bodies in any language.

use super::checked::single;
use super::drawn::drawing;
use super::reading::{Reading, language};
use crate::ast::{Expr, Kind, Statement};
use crate::fault::Fault;
use crate::{Body, Language, parse};
use roxmltree::Node;
use scanbound_base::code::Code;

/// What a body does.
pub(super) fn body(reading: &mut Reading<'_, '_>, node: Node<'_, '_>) -> Body {
    let Some((language, inner)) = language(node) else { return Body::empty() };
    if let Err(fault) = single(reading.text, node) {
        reading.refuse(fault.clone());
        return Body::Unread(language, fault);
    }
    if language == Language::Sfc {
        return match super::chart::chart(reading, inner) {
            Ok(chart) => Body::Chart(Box::new(chart)),
            Err(fault) => {
                reading.refuse(fault.clone());
                Body::Unread(language, fault)
            }
        };
    }
    match statements(reading, language, inner) {
        Ok(statements) => Body::Code(language, statements),
        Err(fault) => {
            // What is wrong with the drawing itself is refused; what is only not understood is listed.
            if matches!(fault.code, Code::Connection | Code::Xml) {
                reading.refuse(fault.clone());
            }
            Body::Unread(language, fault.within(&reading.place))
        }
    }
}

fn statements(
    reading: &mut Reading<'_, '_>,
    language: Language,
    inner: Node<'_, '_>,
) -> Result<Vec<Statement>, Fault> {
    let (written, line) = reading.text.content(inner);
    match language {
        Language::St => parse::statements(&written, line),
        Language::Il => parse::instruction_list(&written, line),
        _ => {
            let drawing = drawing(reading.text, inner)?;
            let kind = drawing.acts().then(|| Kind::Drawn(Box::new(drawing)));
            let line = reading.text.line(inner);
            Ok(kind.into_iter().map(|kind| Statement { line, kind }).collect())
        }
    }
}

/// The body of a condition, as a return under it.
pub(super) fn condition_body(reading: &mut Reading<'_, '_>, node: Node<'_, '_>) -> Body {
    let language = language(node).map_or(Language::St, |(language, _)| language);
    match condition(reading, node) {
        Ok(condition) => {
            let kind = Kind::Return(condition);
            Body::Code(language, vec![Statement { line: reading.text.line(node), kind }])
        }
        Err(fault) => {
            if matches!(fault.code, Code::Connection | Code::Xml) {
                reading.refuse(fault.clone());
            }
            Body::Unread(language, fault)
        }
    }
}

/// The value that a condition has, whose body stands in an element.
pub(super) fn condition(reading: &mut Reading<'_, '_>, node: Node<'_, '_>) -> Result<Expr, Fault> {
    let Some((language, inner)) = language(node) else {
        return Err(reading.text.fault(node, "the condition is empty"));
    };
    single(reading.text, node)?;
    let (written, line) = reading.text.content(inner);
    match language {
        Language::St => {
            let first = parse::expression(&written, line);
            first.or_else(|fault| {
                // Beremiz writes what stands behind the name of the transition: `:= condition;`.
                let behind_name = format!("_ {written}\n;");
                let read = parse::statements(&written, line);
                let read = read.or_else(|_| parse::statements(&behind_name, line));
                match &read.map_err(|_| fault.clone())?[..] {
                    [Statement { kind: Kind::Assign(_, value), .. }] => Ok(value.clone()),
                    _ => Err(fault),
                }
            })
        }
        Language::Il => parse::instruction_list_value(&written, line),
        _ => super::condition::of_body(reading, inner),
    }
}
