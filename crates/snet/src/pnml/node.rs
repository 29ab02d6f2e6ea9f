//! XML elements with their line numbers.

use roxmltree::Node;

/// The text of a file, for line numbers.
pub(super) struct Text<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> Text<'t> {
    pub(super) fn new(text: &'t str) -> Text<'t> {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let starts = std::iter::once(0).chain(breaks.map(|(at, _)| at + 1)).collect();
        Text { text, starts }
    }

    /// The line of an element.
    pub(super) fn line(&self, node: Node<'_, '_>) -> u32 {
        let at = node.range().start;
        u32::try_from(self.starts.partition_point(|&start| start <= at)).unwrap_or(u32::MAX)
    }

    /// The text of a line.
    pub(super) fn shown(&self, line: u32) -> &'t str {
        self.text.lines().nth(line as usize - 1).unwrap_or_default().trim()
    }
}

/// The children of this name.
pub(super) fn children<'a, 'i>(
    node: Node<'a, 'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// The text in `<NAME><text>`, trimmed.
pub(super) fn text_of(node: Node<'_, '_>, name: &'static str) -> Option<String> {
    let inner = children(node, name).next()?;
    let text = children(inner, "text").next()?;
    Some(text.text().unwrap_or_default().trim().to_owned())
}

/// An element for this tool only.
pub(super) fn own<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(node, "toolspecific")
        .filter(|one| one.attribute("tool") == Some(super::TOOL))
        .find_map(|one| children(one, name).next())
}
