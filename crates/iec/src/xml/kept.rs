//! Finds the parts of a chart in a file that are kept when a rewritten chart replaces it.
//!
//! Rewriting changes the connections of steps and transitions and extends conditions. Everything else is copied as it
//! stands in the file, in any language: bodies of actions, conditions with the elements that draw them, comments,
//! documentation, and vendors' data.

use super::node::{BESIDE, ELEMENTS, Text, child, children, elements, inputs, sources};
use super::reading::language;
use crate::chart::{Block, Chart, Step, Target, Transition};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// A number that identifies an element within its file.
pub(super) fn number(node: Node<'_, '_>) -> usize {
    node.id().get_usize()
}

/// The chart's element in the file, and the chart read from it.
pub(super) struct Kept<'a, 'i> {
    file: &'a str,
    lines: &'a Text,
    element: Node<'a, 'i>,
    before: &'a Chart,
    /// Steps and transitions by `localId` and line. Charts of macro steps have their own numbering, so an ambiguous key
    /// has `None`.
    known: BTreeMap<(&'a str, u32), Option<Node<'a, 'i>>>,
    /// The transitions as read, by `localId` and line.
    transitions: BTreeMap<(&'a str, u32), &'a Transition>,
    /// The action blocks by line, with their elements.
    actions: BTreeMap<u32, Vec<(&'a Block, Node<'a, 'i>)>>,
}

impl<'a, 'i> Kept<'a, 'i> {
    pub(super) fn new(
        file: &'a str,
        lines: &'a Text,
        element: Node<'a, 'i>,
        before: &'a Chart,
    ) -> Kept<'a, 'i> {
        let mut known = BTreeMap::new();
        let mut blocks: BTreeMap<(usize, &str), Vec<Node<'_, '_>>> = BTreeMap::new();
        for node in element.descendants().filter(Node::is_element) {
            match (node.tag_name().name(), node.attribute("localId")) {
                ("step" | "macroStep" | "transition", Some(id)) => {
                    let place = (id, lines.line(node));
                    known.entry(place).and_modify(|one| *one = None).or_insert(Some(node));
                }
                ("actionBlock", _) => {
                    let around = number(node.parent().unwrap_or(element));
                    for (id, _) in inputs(node) {
                        blocks.entry((around, id)).or_default().push(node);
                    }
                }
                _ => {}
            }
        }
        let ways = before.transitions.iter();
        let ways = ways.filter_map(|one| Some(((one.id.as_deref()?, one.line), one)));
        let mut kept = Kept {
            file,
            lines,
            element,
            before,
            known,
            transitions: ways.collect(),
            actions: BTreeMap::new(),
        };
        kept.actions = kept.actions(&blocks);
        kept
    }

    fn actions(
        &self,
        blocks: &BTreeMap<(usize, &str), Vec<Node<'a, 'i>>>,
    ) -> BTreeMap<u32, Vec<(&'a Block, Node<'a, 'i>)>> {
        let mut found: BTreeMap<u32, Vec<(&Block, Node<'_, '_>)>> = BTreeMap::new();
        for step in &self.before.steps {
            let Some(node) = self.step(step) else { continue };
            let (Some(around), Some(id)) = (node.parent(), node.attribute("localId")) else {
                continue;
            };
            let own = blocks.get(&(number(around), id)).into_iter().flatten();
            let names = |action: &Node<'_, '_>| {
                child(*action, "reference").is_some()
                    || child(*action, "inline").is_some_and(|inline| language(inline).is_some())
            };
            let own = own.flat_map(|block| children(*block, "action")).filter(names);
            let own: Vec<Node<'_, '_>> = own.collect();
            // The blocks of an enclosing macro step come first.
            let first = step.blocks.len().saturating_sub(own.len());
            for (block, node) in step.blocks[first..].iter().zip(own) {
                if self.lines.line(node) == block.line {
                    found.entry(block.line).or_default().push((block, node));
                }
            }
        }
        found
    }

    fn slice(&self, node: Node<'_, '_>) -> &'a str {
        &self.file[node.range()]
    }

    /// The text of the element's start tag with its declarations.
    pub(super) fn opening(&self) -> Option<&'a str> {
        let first = self.element.first_child()?;
        self.file.get(self.element.range().start..first.range().start)
    }

    fn known(&self, id: Option<&String>, line: u32) -> Option<Node<'a, 'i>> {
        *self.known.get(&(id?.as_str(), line))?
    }

    /// The element of a step; `None` if it is new or ambiguous.
    pub(super) fn step(&self, step: &Step) -> Option<Node<'a, 'i>> {
        self.known(step.id.as_ref(), step.line)
    }

    /// The element of a transition; `None` if it is new or ambiguous.
    pub(super) fn transition(&self, one: &Transition) -> Option<Node<'a, 'i>> {
        self.known(one.id.as_ref(), one.line)
    }

    /// The element of an action block; `None` if it is new.
    pub(super) fn action(&self, block: &Block) -> Option<Node<'a, 'i>> {
        let plain = |name: &str| name.replace('.', "_");
        let is_it = |one: &Block| match (&one.target, &block.target) {
            (Target::Inline(name, body), Target::Inline(now, other)) => {
                plain(name) == plain(now) && body == other
            }
            (target, now) => target == now,
        };
        let all = self.actions.get(&block.line)?;
        all.iter().find(|(one, _)| is_it(one)).map(|(_, node)| *node)
    }

    /// The attributes of an element as text, except `besides`.
    pub(super) fn attributes(&self, node: Node<'a, 'i>, besides: &[&str]) -> String {
        let own = node.attributes().filter(|one| !besides.contains(&one.name()));
        own.map(|one| format!(" {}", &self.file[one.range()])).collect()
    }

    /// The text of the child elements of these names.
    pub(super) fn written(&self, node: Node<'a, 'i>, names: &[&str]) -> Vec<&'a str> {
        let own = elements(node).filter(|one| names.contains(&one.tag_name().name()));
        own.map(|one| self.slice(one)).collect()
    }

    /// The text of a transition's condition, if it is unchanged, with the elements that draw it. `None` if it must be
    /// written anew.
    pub(super) fn condition(&self, one: &Transition) -> Option<(&'a str, Vec<Node<'a, 'i>>)> {
        let node = self.transition(one)?;
        let before = self.transitions.get(&(one.id.as_deref()?, one.line))?;
        let own = child(node, "condition").filter(|_| before.condition == one.condition)?;
        let drawn = child(own, "inline").is_none() && child(own, "reference").is_none();
        let mut with = Vec::new();
        if drawn {
            // Elements in a macro step's chart are not copied, because their numbers would clash with others.
            node.parent().filter(|around| *around == self.element)?;
            let point = child(own, "connectionPointIn").unwrap_or(own);
            let mut open: Vec<&str> = sources(point).into_iter().map(|(id, _)| id).collect();
            let mut seen = BTreeSet::new();
            while let Some(id) = open.pop() {
                if !seen.insert(id) {
                    continue;
                }
                let other =
                    elements(self.element).find(|one| one.attribute("localId") == Some(id))?;
                if ELEMENTS.contains(&other.tag_name().name()) {
                    return None;
                }
                let ways = other.descendants().filter(|one| one.tag_name().name() == "connection");
                open.extend(ways.filter_map(|way| way.attribute("refLocalId")));
                with.push(other);
            }
        }
        Some((self.slice(own), with))
    }

    /// The numbers of the elements that may be copied.
    pub(super) fn numbers(&self) -> BTreeSet<u32> {
        let own = elements(self.element).filter(|one| !ELEMENTS.contains(&one.tag_name().name()));
        own.filter_map(|one| one.attribute("localId")?.trim().parse().ok()).collect()
    }

    /// The text of comments and other elements outside of steps and transitions, and of the elements in `drawn`, in the
    /// order of the file.
    pub(super) fn beside(&self, drawn: &BTreeSet<usize>) -> Vec<&'a str> {
        let is_kept = |node: &Node<'_, '_>| {
            node.is_comment()
                || drawn.contains(&number(*node))
                || node.is_element() && BESIDE.contains(&node.tag_name().name())
        };
        self.element.children().filter(is_kept).map(|node| self.slice(node)).collect()
    }
}
