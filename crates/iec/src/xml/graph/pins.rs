//! The pins of a block.

use super::is_called;
use crate::ast::RESULT;
use crate::xml::node::{child, children};
use crate::xml::reading::Reading;
use roxmltree::Node;

/// The pins of a block in one of its lists.
pub(super) fn pins<'a, 'i: 'a>(
    node: Node<'a, 'i>,
    list: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    child(node, list).into_iter().flat_map(|list| children(list, "variable"))
}

pub(super) fn name_of<'a>(pin: Node<'a, '_>) -> &'a str {
    pin.attribute("formalParameter").unwrap_or_default()
}

/// Whether an element is a block that remembers.
pub(super) fn is_instance(node: Node<'_, '_>) -> bool {
    is_called(node, "block") && node.attribute("instanceName").is_some_and(|name| !name.is_empty())
}

/// The variable that holds what a function gives.
pub(super) fn result(reading: &mut Reading<'_, '_>, id: &str) -> String {
    format!("{RESULT}{}", reading.hidden(&format!("n{id}"), "", 0).trim_start_matches('~'))
}
