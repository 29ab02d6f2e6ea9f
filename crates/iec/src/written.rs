//! What leads to an element of a drawing, as generators of text write it (Beremiz and OpenPLC: `GeneratePaths`,
//! `FactorizePaths` and `ComputePaths` of `PLCGenerator.py`): one way after the other; what ways end with alike is
//! written once.

use crate::drawing::{Connection, Drawing, Element, ElementId, ElementKind};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// More elements than this are not visited for one expression, and no longer one is written.
const VISITS: usize = 5_000;

/// How deep ways may be followed.
pub const DEPTH: usize = 150;

/// An operand: a contact without what leads to it, or an output of another element. Edges are looked at anew with each
/// visit, which the number tells.
pub type Operand<'d> = ((ElementId, &'d str), usize);

/// An expression, or a part of it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Path<'d> {
    /// Power from the rail.
    Power,
    /// An operand.
    One(Operand<'d>),
    /// Operands that are joined by AND; the last one is the first on the way.
    Row(Vec<Rc<Path<'d>>>),
    /// Ways that are joined by OR.
    Fork(Vec<Rc<Path<'d>>>),
}

/// An expression as it is written.
pub struct Written<'d> {
    /// The expression; none, if nothing leads to the element.
    pub path: Option<Rc<Path<'d>>>,
    /// What is visited, in order: operands, and coils that stand on the way.
    pub visited: Vec<Operand<'d>>,
}

impl Written<'_> {
    /// Whether no operand stands in it twice.
    #[must_use]
    pub fn is_written_once(&self) -> bool {
        let mut seen = BTreeSet::new();
        let mut open: Vec<&Path<'_>> = self.path.as_deref().into_iter().collect();
        while let Some(path) = open.pop() {
            match path {
                Path::Power => {}
                Path::One((output, _)) if !seen.insert(output) => return false,
                Path::One(_) => {}
                Path::Row(all) | Path::Fork(all) => open.extend(all.iter().map(|one| &**one)),
            }
        }
        true
    }
}

/// Contacts that look at edges, and what they lead to within one expression.
#[must_use]
pub fn behind_edges(drawing: &Drawing) -> BTreeSet<ElementId> {
    let mut ahead: BTreeMap<ElementId, Vec<ElementId>> = BTreeMap::new();
    for (id, one) in drawing.all() {
        if matches!(one.kind, ElementKind::Contact | ElementKind::Coil | ElementKind::RightRail) {
            one.inputs.iter().for_each(|input| ahead.entry(input.from).or_default().push(id));
        }
    }
    let edges = drawing.all().filter(|(_, one)| has_edge(one));
    let mut open: Vec<ElementId> = edges.map(|(id, _)| id).collect();
    let mut found = BTreeSet::new();
    while let Some(id) = open.pop() {
        if found.insert(id) {
            open.extend(ahead.get(&id).into_iter().flatten());
        }
    }
    found
}

/// Whether a contact looks at an edge.
fn has_edge(one: &Element) -> bool {
    one.kind == ElementKind::Contact && one.edge.is_some()
}

/// What leads in through connections, as it is written; none, if that is too long. `first` says whether contacts are
/// looked at before what leads to them, as generators do.
#[must_use]
pub fn written<'d>(
    drawing: &'d Drawing,
    behind_edges: &BTreeSet<ElementId>,
    from: &'d [Connection],
    first: bool,
) -> Option<Written<'d>> {
    let known = BTreeMap::new();
    let mut walk =
        Walk { drawing, behind_edges, first, known, visited: Vec::new(), visits: VISITS };
    let path = joined(walk.ways(from, 0)?);
    let mut length = VISITS;
    is_short(path.as_deref(), &mut length).then_some(Written { path, visited: walk.visited })
}

/// Whether no more operands are written than these.
fn is_short(path: Option<&Path<'_>>, length: &mut usize) -> bool {
    match path {
        None | Some(Path::Power) => true,
        Some(Path::One(_)) => {
            *length = length.saturating_sub(1);
            *length > 0
        }
        Some(Path::Row(all) | Path::Fork(all)) => all.iter().all(|one| is_short(Some(one), length)),
    }
}

struct Walk<'d, 'e> {
    drawing: &'d Drawing,
    behind_edges: &'e BTreeSet<ElementId>,
    first: bool,
    /// Contacts and coils that look at no edge, nor anything that leads to them.
    known: BTreeMap<ElementId, Rc<Path<'d>>>,
    visited: Vec<Operand<'d>>,
    visits: usize,
}

impl<'d> Walk<'d, '_> {
    fn ways(&mut self, from: &'d [Connection], depth: usize) -> Option<Vec<Rc<Path<'d>>>> {
        from.iter().map(|one| self.way(one, depth)).collect()
    }

    fn way(&mut self, from: &'d Connection, depth: usize) -> Option<Rc<Path<'d>>> {
        let id = from.from;
        if let Some(known) = self.known.get(&id) {
            return Some(known.clone());
        }
        self.visits = self.visits.checked_sub(1)?;
        if depth > DEPTH {
            return None;
        }
        let one = self.drawing.element(id);
        // Generators look at no edge of what is negated.
        let looks_at_edge = has_edge(one) && !(self.first && one.negated_in);
        let visit = if looks_at_edge { self.visits } else { 0 };
        let own = ((id, ""), visit);
        let path = match &one.kind {
            ElementKind::LeftRail => return Some(Rc::new(Path::Power)),
            ElementKind::Contact => {
                if self.first {
                    self.visited.push(own);
                }
                let ways = self.ways(&one.inputs, depth + 1)?;
                if !self.first {
                    self.visited.push(own);
                }
                let mut row = vec![Rc::new(Path::One(own))];
                match &ways[..] {
                    [only] => match &**only {
                        Path::Power => {}
                        Path::Row(behind) => row.extend(behind.iter().cloned()),
                        _ => row.push(only.clone()),
                    },
                    _ => row.extend(joined(ways)),
                }
                if row.len() == 1 { row.remove(0) } else { Rc::new(Path::Row(row)) }
            }
            // How several ways to a coil on the way are joined is told elsewhere.
            ElementKind::Coil if one.inputs.len() == 1 => {
                self.visited.push(own);
                Rc::new(Path::Row(self.ways(&one.inputs, depth + 1)?))
            }
            // What leads to a connector is written for each of its continuations.
            ElementKind::Continuation(connector) => return Some(self.operand((*connector, ""))),
            _ => return Some(self.operand((id, &from.output))),
        };
        if !self.behind_edges.contains(&id) {
            self.known.insert(id, path.clone());
        }
        Some(path)
    }

    fn operand(&mut self, output: (ElementId, &'d str)) -> Rc<Path<'d>> {
        self.visited.push((output, 0));
        Rc::new(Path::One((output, 0)))
    }
}

/// Ways as one expression.
fn joined(ways: Vec<Rc<Path<'_>>>) -> Option<Rc<Path<'_>>> {
    let mut ways = if ways.len() > 1 { factored(ways) } else { ways };
    match ways.len() {
        0 | 1 => ways.pop(),
        _ => Some(Rc::new(Path::Fork(ways))),
    }
}

/// Ways of which those that end alike are joined.
fn factored(ways: Vec<Rc<Path<'_>>>) -> Vec<Rc<Path<'_>>> {
    let mut found = Vec::new();
    let mut alike: BTreeMap<Rc<Path<'_>>, Vec<Rc<Path<'_>>>> = BTreeMap::new();
    for way in ways {
        match &*way {
            Path::Row(parts) if parts.len() > 1 => {
                let (front, last) = parts.split_at(parts.len() - 1);
                alike.entry(last[0].clone()).or_default().push(Rc::new(Path::Row(front.to_vec())));
            }
            _ => found.push(way),
        }
    }
    for (last, fronts) in alike {
        let mut row = match &fronts[..] {
            [only] => match &**only {
                Path::Row(parts) => parts.clone(),
                _ => vec![only.clone()],
            },
            _ => joined(fronts).into_iter().collect(),
        };
        row.push(last);
        found.push(Rc::new(Path::Row(row)));
    }
    found
}
