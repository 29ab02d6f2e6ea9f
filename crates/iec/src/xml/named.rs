//! Which element of a drawing asks for a name: for faults that are found when the drawing is statements.

use super::node::{Text, child, elements};
use roxmltree::{Document, Node};

/// Finds elements of a file by the line on which they begin and the name that they have, and tells each with its unit: `p: block
/// with localId 4 (TON)`.
#[must_use]
pub fn named(text: &str, all: &[(u32, &str)]) -> Vec<Option<String>> {
    let text = text.trim_start_matches('\u{feff}');
    let Ok(document) = Document::parse(text) else { return vec![None; all.len()] };
    let lines = Text::new(text, &document, None);
    let numbered = || document.descendants().filter(|node| node.has_attribute("localId"));
    let of = |&(line, name): &(u32, &str)| {
        let mut own = numbered().filter(|&node| lines.lines(node).contains(&line));
        own.rfind(|&node| asks_for(&lines, node, name)).map(told)
    };
    all.iter().map(of).collect()
}

/// Whether an element itself has this name: its variable, its expression, its instance.
fn asks_for(lines: &Text, node: Node<'_, '_>, name: &str) -> bool {
    let parts = ["variable", "expression"].into_iter().filter_map(|part| child(node, part));
    let written = parts.map(|part| lines.content(part).0);
    let references = elements(node).filter_map(|one| one.attribute("name").map(str::to_owned));
    let instance = node.attribute("instanceName").map(str::to_owned);
    let condition = child(node, "condition").map(|one| lines.content(one).0);
    let reference = child(node, "condition").and_then(|one| child(one, "reference"));
    let reference = reference.and_then(|one| one.attribute("name").map(str::to_owned));
    let mut all = written.chain(references).chain(instance).chain(condition).chain(reference);
    all.any(|own| words(&own).any(|word| word.eq_ignore_ascii_case(name)))
}

/// The names in a text, and the paths that begin it.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let path = |c: char| !c.is_alphanumeric() && c != '_' && c != '.';
    let name = |c: char| !c.is_alphanumeric() && c != '_';
    text.split(path).chain(text.split(name)).filter(|word| !word.is_empty())
}

fn told(node: Node<'_, '_>) -> String {
    let id = node.attribute("localId").unwrap_or_default();
    let kind = node.attribute("typeName").map(|of| format!(" ({of})")).unwrap_or_default();
    let unit = node.ancestors().find(|one| one.tag_name().name() == "pou");
    let unit = unit.and_then(|one| one.attribute("name")).map(|name| format!("{name}: "));
    format!("{}{} with localId {id}{kind}", unit.unwrap_or_default(), node.tag_name().name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_found_by_line_and_name() {
        let text = "<project><pou name=\"p\"><coil localId=\"3\">\n<variable>a.b</variable></coil>\n\
            <block localId=\"4\" typeName=\"FOO\" instanceName=\"f\"/></pou></project>";
        let found = named(text, &[(1, "a.b"), (3, "f"), (3, "g"), (2, "a")]);
        let told = |text: &str| Some(text.to_owned());
        assert_eq!(found[0], told("p: coil with localId 3"));
        assert_eq!(found[1], told("p: block with localId 4 (FOO)"));
        assert_eq!(found[2..], [None, told("p: coil with localId 3")]);
    }
}
