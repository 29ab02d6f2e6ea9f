//! The pins of a block.

use crate::iec::xml::node::{child, children};
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
