//! Access to XML elements and their lines.

use crate::comment::{Comments, without_comments};
use crate::fault::Fault;
use roxmltree::{Document, Node};
use scanbound_base::code::Code;

/// The name of CODESYS's additional data of chart elements, and the GUIDs of a step's own actions in it.
pub(super) const ELEMENT: &str = "http://www.3s-software.com/plcopenxml/sfc/element";
pub(super) const ACTIVE: &str = "700a583f-b4d4-43e4-8c14-629c7cd3bec8";
pub(super) const ENTRY: &str = "a6b08bd8-b696-47e3-9cbf-7408b61c9ff8";
pub(super) const EXIT: &str = "a2621e18-7de3-4ea6-ae6d-89e9e0b7befd";
/// The GUIDs of a step's further attributes: excluded, minimum time, maximum time.
pub(super) const EXCLUDED: &str = "01580b27-6378-448b-8ecb-0e4b795b58d6";
pub(super) const LEAST: &str = "cacf1a68-236e-47c2-b7b1-1cf9199718cb";
pub(super) const MOST: &str = "b693554c-1b01-4a8d-afde-9e3a46f7465d";

/// The elements that make up a chart.
pub(super) const ELEMENTS: &[&str] = &[
    "step",
    "macroStep",
    "transition",
    "jumpStep",
    "actionBlock",
    "selectionDivergence",
    "selectionConvergence",
    "simultaneousDivergence",
    "simultaneousConvergence",
];

/// Elements that are not connected to others.
pub(super) const BESIDE: &[&str] = &["comment", "vendorElement", "addData", "documentation"];

/// Elements of text that begin and end lines.
const LINES: &[&str] = &["br", "xhtml", "html", "body", "p", "div", "pre"];

/// The text of a file, for computing line numbers.
pub(super) struct Text {
    starts: Vec<usize>,
    /// Whether CODESYS or TwinCAT wrote the file.
    pub(super) is_codesys: bool,
    /// The rule for nested comments, if it is stated.
    comments: Option<Comments>,
}

/// Whether a text names CODESYS or TwinCAT.
fn names_codesys(text: &str) -> bool {
    let text = text.to_ascii_lowercase();
    ["codesys", "twincat"].iter().any(|name| text.contains(name))
}

/// The fault about a file with charts or drawings that only its header's product name ascribes to CODESYS or TwinCAT.
/// `None` if there is none.
pub(super) fn is_ascribed(text: &Text, document: &Document<'_>) -> Option<Fault> {
    let elements = || document.descendants().filter(Node::is_element);
    let is_drawn = |one: &Node<'_, '_>| ["SFC", "FBD", "LD"].contains(&one.tag_name().name());
    elements().find(is_drawn)?;
    let header = elements().find(|one| one.tag_name().name() == "fileHeader")?;
    let product =
        header.attribute("productName").filter(|name| !text.is_codesys && names_codesys(name))?;
    let what = format!(
        "the product is '{product}', but the file has no data of CODESYS: its charts and drawings may be executed otherwise"
    );
    let help =
        "export the project again; if another tool wrote the file, give it another productName";
    Some(text.fault(header, what).code(Code::NotModelled).help(help))
}

/// The elements in an element's additional data.
pub(super) fn added<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let data = child(node, "addData").into_iter();
    data.flat_map(|data| children(data, "data")).flat_map(elements)
}

impl Text {
    pub(super) fn new(text: &str, document: &Document<'_>, comments: Option<Comments>) -> Text {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let elements = || document.descendants().filter(Node::is_element);
        let is_theirs = |name: &str| name.contains("3s-software.com");
        let is_codesys = elements().any(|one| {
            one.tag_name().name() == "data" && one.attribute("name").is_some_and(is_theirs)
        });
        Text {
            comments,
            starts: std::iter::once(0).chain(breaks.map(|(at, _)| at + 1)).collect(),
            is_codesys,
        }
    }

    /// The expression written at a connection point in place of a connection, and its line; `None` if there is none.
    pub(super) fn written(&self, point: Node<'_, '_>) -> Option<(String, u32)> {
        let written = child(point, "expression").map(|one| self.content(one));
        written.filter(|(text, _)| !text.trim().is_empty())
    }

    /// The line of a node, from 1.
    pub(super) fn line(&self, node: Node<'_, '_>) -> u32 {
        let at = node.range().start;
        u32::try_from(self.starts.partition_point(|&start| start <= at)).unwrap_or(u32::MAX)
    }

    /// A fault at an element, with its line and `localId`.
    pub(super) fn fault(&self, node: Node<'_, '_>, message: impl Into<String>) -> Fault {
        let shown = match node.attribute("localId") {
            Some(id) => format!("<{} localId=\"{id}\">", node.tag_name().name()),
            None => format!("<{}>", node.tag_name().name()),
        };
        Fault::new(self.line(node), message)
            .code(Code::Xml)
            .text(shown)
            .help("export it again as PLCopen XML, or mend it in its editor")
    }

    /// The text in an element, and the line where it begins. Paragraphs and `<br/>` become line ends; comments are
    /// blanked if a rule for nesting is stated.
    pub(super) fn content(&self, node: Node<'_, '_>) -> (String, u32) {
        let mut written = String::new();
        let mut open = vec![(node, false)];
        while let Some((one, is_end)) = open.pop() {
            if one.is_text() {
                written += one.text().unwrap_or_default();
                continue;
            }
            if one != node && is_line(one) && !written.is_empty() && !written.ends_with('\n') {
                written.push('\n');
            }
            if !is_end {
                open.push((one, true));
                open.extend(one.children().rev().map(|inner| (inner, false)));
            }
        }
        let first = node.descendants().find(Node::is_text).unwrap_or(node);
        let written = match self.comments {
            Some(reading) => without_comments(&written, reading).into_owned(),
            None => written,
        };
        (written, self.line(first))
    }
}

/// Whether an element of text begins and ends a line.
fn is_line(node: Node<'_, '_>) -> bool {
    LINES.contains(&node.tag_name().name())
}

/// The child elements of this name.
pub(super) fn children<'a, 'i>(
    node: Node<'a, 'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// The first child element of this name.
pub(super) fn child<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

/// All child elements.
pub(super) fn elements<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(Node::is_element)
}

/// Whether an attribute is `true` or `1`.
pub(super) fn is(node: Node<'_, '_>, attribute: &str) -> bool {
    matches!(node.attribute(attribute), Some("true" | "1"))
}

/// For each connection at a point, the `localId` of its source and the name of the source's output, if one is stated.
pub(super) fn sources<'a>(point: Node<'a, '_>) -> Vec<(&'a str, Option<&'a str>)> {
    let connections = children(point, "connection");
    connections
        .filter_map(|one| {
            let output = one.attribute("formalParameter").filter(|output| !output.is_empty());
            Some((one.attribute("refLocalId")?, output))
        })
        .collect()
}

/// The connections at all input points of an element, in the form of [`sources`].
pub(super) fn inputs<'a>(node: Node<'a, '_>) -> Vec<(&'a str, Option<&'a str>)> {
    children(node, "connectionPointIn").flat_map(sources).collect()
}

/// The pins in one of the lists of a block, such as `inputVariables`.
pub(super) fn pins<'a, 'i: 'a>(
    node: Node<'a, 'i>,
    list: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    child(node, list).into_iter().flat_map(|list| children(list, "variable"))
}

/// The name of a pin; empty if it has none.
pub(super) fn name_of<'a>(pin: Node<'a, '_>) -> &'a str {
    pin.attribute("formalParameter").unwrap_or_default()
}

/// The position (down, right) of an element in tenths of the file's unit; 0 for a missing coordinate.
pub(super) fn position(node: Node<'_, '_>) -> (i64, i64) {
    let position = child(node, "position");
    let coordinate =
        |name: &str| position.and_then(|one| tenths(one.attribute(name)?)).unwrap_or(0);
    (coordinate("y"), coordinate("x"))
}

/// Whether the position can be read; true if the element has none.
pub(super) fn has_place(node: Node<'_, '_>) -> bool {
    let coordinates = child(node, "position").map(|one| [one.attribute("y"), one.attribute("x")]);
    coordinates.is_none_or(|all| all.iter().all(|one| one.is_some_and(|one| tenths(one).is_some())))
}

/// The execution order number; `None` if it is missing, 0 or not a number.
pub(super) fn order(node: Node<'_, '_>) -> Option<u64> {
    let number = node.attribute("executionOrderId")?.parse().ok();
    number.filter(|&order| order > 0)
}

/// A coordinate in tenths; further decimals are dropped. `None` if it is not a number.
fn tenths(text: &str) -> Option<i64> {
    let (whole, part) = text.trim().split_once('.').unwrap_or((text.trim(), ""));
    let tenth = part.chars().next().and_then(|digit| digit.to_digit(10)).map_or(0, i64::from);
    let sign = if whole.starts_with('-') { -1 } else { 1 };
    whole.parse::<i64>().ok()?.checked_mul(10)?.checked_add(sign * tenth)
}
