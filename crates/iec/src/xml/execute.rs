//! EXECUTE boxes: structured text in a drawing, as written by CODESYS, TwinCAT and OpenPLC.

use super::allowed::data_name;
use super::node::{Text, child, children, elements, name_of, pins};
use crate::ast::{Kind, Statement, visit};
use crate::fault::Fault;
use crate::parse;
use roxmltree::Node;
use scanbound_base::code::Code;

/// The statements of an EXECUTE box, or the fault in it; `None` if the block contains no structured text.
pub(super) fn code(text: &Text, node: Node<'_, '_>) -> Option<Result<Vec<Statement>, Fault>> {
    let data = child(node, "addData").into_iter().flat_map(|all| children(all, "data"));
    let mut codes = data.filter(|one| data_name(*one) == Some("stcode")).flat_map(elements);
    let code = codes.next()?;
    let refused = |what: &str| {
        let id = node.attribute("localId").unwrap_or("?");
        let message = format!("block with localId {id}: {what}");
        let help =
            "draw the box as its editor does: EXECUTE with EN and ENO alone, and statements in it";
        Some(Err(text.fault(node, message).code(Code::NotModelled).help(help)))
    };
    let is_execute =
        node.attribute("typeName").is_some_and(|of| of.eq_ignore_ascii_case("EXECUTE"))
            && node.attribute("instanceName").is_none_or(str::is_empty);
    if !is_execute {
        return refused("it holds structured text and is not an EXECUTE box");
    }
    if codes.next().is_some() {
        return refused("it holds structured text twice");
    }
    let lists = ["inputVariables", "inOutVariables", "outputVariables"].into_iter();
    let mut others = lists
        .flat_map(|list| pins(node, list))
        .filter(|pin| !["EN", "ENO", ""].iter().any(|own| name_of(*pin).eq_ignore_ascii_case(own)));
    if others.next().is_some() {
        return refused("a box with structured text has other pins than EN and ENO");
    }
    let (written, line) = text.content(code);
    let statements = match parse::statements(&written, line) {
        Ok(statements) => statements,
        Err(fault) => return Some(Err(fault)),
    };
    let mut leaves = false;
    visit(&statements, &mut |one| {
        leaves |= matches!(one.kind, Kind::Return(_) | Kind::Jump(..) | Kind::Label(_));
    });
    if leaves {
        return refused("whether RETURN in it ends the box or the unit is not known");
    }
    Some(Ok(statements))
}
