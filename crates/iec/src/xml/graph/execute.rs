//! EXECUTE boxes: structured text in a drawing, as CODESYS, TwinCAT and OpenPLC write it.

use super::pins::{name_of, pins};
use super::{Graph, called};
use crate::ast::{Expr, Kind, visit};
use crate::fault::Fault;
use crate::parse;
use crate::xml::allowed::data_name;
use crate::xml::node::{child, children, elements};
use roxmltree::Node;
use scanbound_base::code::Code;

/// The elements with the text of an EXECUTE box; other blocks have none.
fn codes<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let data = child(node, "addData").into_iter().flat_map(|all| children(all, "data"));
    data.filter(|one| data_name(*one) == Some("stcode")).flat_map(elements)
}

/// The first of them.
pub(super) fn code<'a, 'i>(node: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    codes(node).next()
}

/// Whether a block is an EXECUTE box.
pub(super) fn is_box(node: Node<'_, '_>) -> bool {
    code(node).is_some()
}

impl<'a, 'i> Graph<'a, 'i> {
    /// Carries out the text of a box where it is enabled.
    pub(super) fn execute(
        &mut self,
        node: Node<'a, 'i>,
        code: Node<'a, 'i>,
        enable: Expr,
    ) -> Result<(), Fault> {
        let refused = |what: &str| {
            let message = format!("{}: {what}", called(node));
            let help = "draw the box as its editor does: EXECUTE with EN and ENO alone, and statements in it";
            Err(self.text.fault(node, message).code(Code::NotModelled).help(help))
        };
        let is_execute =
            node.attribute("typeName").is_some_and(|of| of.eq_ignore_ascii_case("EXECUTE"))
                && node.attribute("instanceName").is_none_or(str::is_empty);
        if !is_execute {
            return refused("it holds structured text and is no EXECUTE box");
        }
        if codes(node).nth(1).is_some() {
            return refused("it holds structured text twice");
        }
        let lists = ["inputVariables", "inOutVariables", "outputVariables"].into_iter();
        let mut others = lists.flat_map(|list| pins(node, list)).filter(|pin| {
            !["EN", "ENO", ""].iter().any(|own| name_of(*pin).eq_ignore_ascii_case(own))
        });
        if others.next().is_some() {
            return refused("a box with structured text has other pins than EN and ENO");
        }
        let (written, line) = self.text.content(code);
        let statements = parse::statements(&written, line)?;
        let mut leaves = false;
        visit(&statements, &mut |one| {
            leaves |= matches!(one.kind, Kind::Return(_) | Kind::Jump(..) | Kind::Label(_));
        });
        if leaves {
            return refused("whether RETURN in it ends the box or the unit is not known");
        }
        // It may write anything that it names.
        let begin = self.statements.len();
        match enable.is(true) {
            true => statements.into_iter().for_each(|one| self.carried(one)),
            false => self.add(node, Kind::If(vec![(enable, statements)], Vec::new())),
        }
        self.foreign.extend(begin..self.statements.len());
        Ok(())
    }
}
