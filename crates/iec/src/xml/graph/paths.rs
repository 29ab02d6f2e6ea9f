//! Whether generators look at each contact of an expression once: they write one way after the other, and take what ways end
//! with alike out of them (Beremiz: `FactorizePaths` of `PLCGenerator.py`).

use super::value::DEPTH;
use super::{Graph, is_called};
use crate::xml::node::inputs;
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// More elements than this are not visited for one expression.
const VISITS: usize = 5_000;

/// A way: what it goes through, beginning at the end.
type Way<'a> = Vec<Part<'a>>;

/// A part of a way.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Part<'a> {
    /// A contact, or what begins a way.
    One(&'a str, String),
    /// Ways beside each other.
    Several(Vec<Way<'a>>),
}

impl<'a> Graph<'a, '_> {
    /// Whether a value that is asked for twice within one expression is written once: so it is where ways fork and join in
    /// pairs, and no edge is looked at by several of them.
    pub(super) fn is_written_once(&self, from: &[(&str, Option<&str>)]) -> bool {
        let mut known = BTreeMap::new();
        let mut seen = BTreeSet::new();
        let mut visits = VISITS;
        let Some(ways) = self.ways(from, &mut known, &mut visits, 0) else { return false };
        factored(ways).iter().all(|way| counted(way, &mut seen))
            && self.edges_are_met_once(from, visits)
    }

    /// The ways that lead in; none where there are too many.
    fn ways(
        &self,
        from: &[(&str, Option<&str>)],
        known: &mut BTreeMap<(&'a str, String), Vec<Way<'a>>>,
        visits: &mut usize,
        depth: usize,
    ) -> Option<Vec<Way<'a>>> {
        let mut found = Vec::new();
        for (id, output) in from {
            let Some((&id, &node)) = self.nodes.get_key_value(*id) else { continue };
            let key = (id, output.unwrap_or_default().to_owned());
            if let Some(ways) = known.get(&key) {
                found.extend(ways.iter().cloned());
                continue;
            }
            *visits = visits.checked_sub(1)?;
            if depth > DEPTH {
                return None;
            }
            // What leads back to itself is told elsewhere.
            known.insert(key.clone(), Vec::new());
            let ways = match node.tag_name().name() {
                "leftPowerRail" => vec![Vec::new()],
                "contact" => {
                    let one = Part::One(id, String::new());
                    let mut behind =
                        factored(self.ways(&inputs(node), known, visits, depth + 1)?);
                    let mut way = vec![one];
                    match behind.len() {
                        0 => {}
                        1 => way.extend(behind.remove(0)),
                        _ => way.push(Part::Several(behind)),
                    }
                    vec![way]
                }
                "coil" | "rightPowerRail" => self.ways(&inputs(node), known, visits, depth + 1)?,
                _ => vec![vec![Part::One(id, key.1.clone())]],
            };
            known.insert(key, ways.clone());
            found.extend(ways);
        }
        Some(found)
    }

    /// Whether no edge is looked at by two ways.
    fn edges_are_met_once(&self, from: &[(&str, Option<&str>)], mut visits: usize) -> bool {
        let mut met = BTreeSet::new();
        let mut open: Vec<&str> = from.iter().map(|(id, _)| *id).collect();
        while let Some(id) = open.pop() {
            if !self.behind_edges.contains(id) {
                continue;
            }
            let node = self.nodes[id];
            if has_edge(node) && !met.insert(id) {
                return false;
            }
            let Some(left) = visits.checked_sub(1) else { return false };
            visits = left;
            open.extend(inputs(node).into_iter().map(|(id, _)| id));
        }
        true
    }
}

fn has_edge(node: Node<'_, '_>) -> bool {
    is_called(node, "contact") && node.attribute("edge").is_some_and(|edge| edge != "none")
}

/// Contacts that look at edges, and what they lead to within one expression.
pub(super) fn behind_edges<'a>(nodes: &BTreeMap<&'a str, Node<'a, '_>>) -> BTreeSet<&'a str> {
    let leads_on = |node: Node<'_, '_>| {
        ["contact", "coil", "rightPowerRail"].contains(&node.tag_name().name())
    };
    let mut ahead: BTreeMap<&str, Vec<&'a str>> = BTreeMap::new();
    for (&id, &node) in nodes.iter().filter(|(_, node)| leads_on(**node)) {
        inputs(node).into_iter().for_each(|(from, _)| ahead.entry(from).or_default().push(id));
    }
    let edges = nodes.iter().filter(|(_, node)| has_edge(**node));
    let mut open: Vec<&'a str> = edges.map(|(&id, _)| id).collect();
    let mut found = BTreeSet::new();
    while let Some(id) = open.pop() {
        if found.insert(id) {
            open.extend(ahead.get(id).into_iter().flatten());
        }
    }
    found
}

/// Ways of which those that end alike are joined.
fn factored(ways: Vec<Way<'_>>) -> Vec<Way<'_>> {
    let mut found: Vec<Way<'_>> = Vec::new();
    let mut alike: BTreeMap<Part<'_>, Vec<Way<'_>>> = BTreeMap::new();
    for mut way in ways {
        match way.pop() {
            Some(last) if !way.is_empty() => alike.entry(last).or_default().push(way),
            Some(last) => found.push(vec![last]),
            None => {}
        }
    }
    for (last, mut fronts) in alike {
        let mut way = match fronts.len() {
            1 => fronts.remove(0),
            _ => {
                let mut joined = factored(fronts);
                match joined.len() {
                    1 => joined.remove(0),
                    _ => vec![Part::Several(joined)],
                }
            }
        };
        way.push(last);
        found.push(way);
    }
    found
}

/// Whether nothing stands in a way that has been seen.
fn counted<'a>(way: &Way<'a>, seen: &mut BTreeSet<(&'a str, String)>) -> bool {
    way.iter().all(|part| match part {
        Part::One(id, output) => seen.insert((id, output.clone())),
        Part::Several(ways) => ways.iter().all(|way| counted(way, seen)),
    })
}
