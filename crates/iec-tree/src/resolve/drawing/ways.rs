//! Whether generators look at each contact of an expression once: they write one way after the other, and take what
//! ways end with alike out of them (Beremiz: `FactorizePaths` of `PLCGenerator.py`).

use super::edges::has_edge;
use super::state::{Output, Sheet};
use super::worth::DEPTH;
use scanbound_iec::drawing::{Connection, ElementId, ElementKind};
use std::collections::{BTreeMap, BTreeSet};

/// More elements than this are not visited for one expression.
const VISITS: usize = 5_000;

/// A way: what it goes through, beginning at the end.
type Way<'d> = Vec<Part<'d>>;

/// A part of a way.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Part<'d> {
    /// A contact, or what begins a way.
    One(Output<'d>),
    /// Ways beside each other.
    Several(Vec<Way<'d>>),
}

impl<'d> Sheet<'d> {
    /// Whether a value that is asked for twice within one expression is written once: so it is where ways fork and join
    /// in pairs, and no edge is looked at by several of them.
    pub(super) fn is_written_once(&self, from: &'d [Connection]) -> bool {
        let mut visits = VISITS;
        let Some(ways) = self.ways(from, &mut BTreeMap::new(), &mut visits, 0) else {
            return false;
        };
        let mut seen = BTreeSet::new();
        factored(ways).iter().all(|way| counted(way, &mut seen))
            && self.edges_are_met_once(from, visits)
    }

    /// The ways that lead in; none where there are too many.
    fn ways(
        &self,
        from: &'d [Connection],
        known: &mut BTreeMap<Output<'d>, Vec<Way<'d>>>,
        visits: &mut usize,
        depth: usize,
    ) -> Option<Vec<Way<'d>>> {
        let mut found = Vec::new();
        for connection in from {
            let key = (connection.from, connection.output.as_str());
            if let Some(ways) = known.get(&key) {
                found.extend(ways.iter().cloned());
                continue;
            }
            *visits = visits.checked_sub(1)?;
            if depth > DEPTH {
                return None;
            }
            // What leads back to itself is a fault that is found elsewhere.
            known.insert(key, Vec::new());
            let one = self.drawing.element(connection.from);
            let ways = match one.kind {
                ElementKind::LeftRail => vec![Vec::new()],
                ElementKind::Contact => {
                    let behind = self.ways(&one.inputs, known, visits, depth + 1)?;
                    let mut behind = factored(behind);
                    let mut way = vec![Part::One((connection.from, ""))];
                    match behind.len() {
                        0 => {}
                        1 => way.extend(behind.remove(0)),
                        _ => way.push(Part::Several(behind)),
                    }
                    vec![way]
                }
                ElementKind::Coil | ElementKind::RightRail => {
                    self.ways(&one.inputs, known, visits, depth + 1)?
                }
                // What leads to a connector is written for each of its continuations.
                ElementKind::Continuation(from) => {
                    let inputs = &self.drawing.element(from).inputs;
                    vec![vec![Part::Several(self.ways(inputs, known, visits, depth + 1)?)]]
                }
                _ => vec![vec![Part::One(key)]],
            };
            known.insert(key, ways.clone());
            found.extend(ways);
        }
        Some(found)
    }

    /// Whether no edge is looked at by two ways.
    fn edges_are_met_once(&self, from: &[Connection], mut visits: usize) -> bool {
        let mut met = BTreeSet::new();
        let mut open: Vec<ElementId> = from.iter().map(|one| one.from).collect();
        while let Some(id) = open.pop() {
            if !self.behind_edges.contains(&id) {
                continue;
            }
            let one = self.drawing.element(id);
            if has_edge(one) && !met.insert(id) {
                return false;
            }
            let Some(left) = visits.checked_sub(1) else { return false };
            visits = left;
            open.extend(one.inputs.iter().map(|one| one.from));
        }
        true
    }
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
fn counted<'d>(way: &Way<'d>, seen: &mut BTreeSet<Output<'d>>) -> bool {
    way.iter().all(|part| match part {
        Part::One(output) => seen.insert(*output),
        Part::Several(ways) => ways.iter().all(|way| counted(way, seen)),
    })
}
