//! In which order the elements of a drawing are carried out.

use crate::xml::node::child;
use roxmltree::Node;

/// Where an element comes: by its number of execution, if it has one, else from top to bottom and from left to right, else
/// as it stands in the file.
pub(in crate::xml) fn rank(node: Node<'_, '_>, at: usize) -> (u64, i64, i64, usize) {
    let (y, x) = position(node);
    (order(node).unwrap_or(u64::MAX), y, x, at)
}

/// How far down and how far to the right an element stands, in tenths of the file's unit.
pub(super) fn position(node: Node<'_, '_>) -> (i64, i64) {
    let position = child(node, "position");
    let coordinate =
        |name: &str| position.and_then(|one| tenths(one.attribute(name)?)).unwrap_or(0);
    (coordinate("y"), coordinate("x"))
}

/// An element's number of execution, if it has one.
pub(in crate::xml) fn order(node: Node<'_, '_>) -> Option<u64> {
    let number = node.attribute("executionOrderId")?.parse().ok();
    number.filter(|&order| order > 0)
}

/// A coordinate in tenths of its unit.
fn tenths(text: &str) -> Option<i64> {
    let (whole, part) = text.trim().split_once('.').unwrap_or((text.trim(), ""));
    let tenth = part.chars().next().and_then(|digit| digit.to_digit(10)).map_or(0, i64::from);
    let sign = if whole.starts_with('-') { -1 } else { 1 };
    whole.parse::<i64>().ok()?.checked_mul(10)?.checked_add(sign * tenth)
}
