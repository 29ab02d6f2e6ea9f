//! The expressions that generators write for the inputs of a drawing's elements (Beremiz and OpenPLC: `GeneratePaths`,
//! `FactorizePaths` and `ComputePaths` of `PLCGenerator.py`). Paths are visited one after another; a common end of
//! several paths is written once.

use crate::drawing::{Connection, Drawing, Element, ElementId, ElementKind};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// The maximum number of elements visited for one expression, and the limit of its length in operands.
pub const VISITS: usize = 5_000;

/// The maximum depth to which paths are followed.
pub const DEPTH: usize = 150;

/// An operand: a contact without the elements before it, or an output of another element. The number distinguishes
/// repeated visits of a contact with an edge, which is evaluated each time; otherwise it is 0.
pub type Operand<'d> = ((ElementId, &'d str), usize);

/// An expression or a part of it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Path<'d> {
    /// `TRUE`, from the left power rail.
    Power,
    /// A single operand.
    One(Operand<'d>),
    /// Operands joined by AND; the element nearest to the rail is the last.
    Row(Vec<Rc<Path<'d>>>),
    /// Paths joined by OR.
    Fork(Vec<Rc<Path<'d>>>),
}

/// The expression that a generator writes.
pub struct Written<'d> {
    /// The expression; `None` if the element has no incoming connection.
    pub path: Option<Rc<Path<'d>>>,
    /// The visited operands, and the coils in the middle of a rung, in order of visit.
    pub visited: Vec<Operand<'d>>,
}

impl Written<'_> {
    /// Whether no operand occurs twice in the expression.
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

/// Contacts with edges, and the contacts, coils and right rails after them within one expression.
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

/// Whether it is a contact that detects an edge.
fn has_edge(one: &Element) -> bool {
    one.kind == ElementKind::Contact && one.edge.is_some()
}

/// The expression that arrives through connections; `None` if it is too long or too deep. `first`: contacts are
/// evaluated before the elements in front of them, as generators do.
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

/// Whether the expression has fewer operands than `length`, which is decreased.
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
    /// The paths of contacts and coils that neither have an edge nor follow one.
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
        let one = self.drawing.element(id);
        if one.kind == ElementKind::LeftRail {
            return Some(Rc::new(Path::Power));
        }
        self.visits = self.visits.checked_sub(1)?;
        if depth > DEPTH {
            return None;
        }
        // Generators look at no edge of what is negated.
        let looks_at_edge = has_edge(one) && !(self.first && one.negated_in);
        let visit = if looks_at_edge { self.visits } else { 0 };
        let own = ((id, ""), visit);
        let path = match &one.kind {
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
            // A coil with several incoming connections is handled by the caller, because tools join these differently.
            ElementKind::Coil if one.inputs.len() == 1 => {
                self.visited.push(own);
                Rc::new(Path::Row(self.ways(&one.inputs, depth + 1)?))
            }
            // The expression of a connector is written once for each of its continuations. That of a single operand is
            // the same text as the operand itself.
            ElementKind::Continuation(connector) => {
                return match &self.drawing.element(*connector).inputs[..] {
                    [only] if self.is_operand(only.from) => self.way(only, depth + 1),
                    _ => Some(self.operand((*connector, ""))),
                };
            }
            _ => return Some(self.operand((id, &from.output))),
        };
        // Paths are compared when they are joined, and that takes as long as they are.
        if !is_short(Some(&path), &mut { VISITS }) {
            return None;
        }
        if !self.behind_edges.contains(&id) {
            self.known.insert(id, path.clone());
        }
        Some(path)
    }

    /// Whether the expression of an element is a single operand without an edge.
    fn is_operand(&self, id: ElementId) -> bool {
        let one = self.drawing.element(id);
        match (&one.kind, &one.inputs[..]) {
            (ElementKind::Block(_) | ElementKind::In | ElementKind::InOut, _) => true,
            (ElementKind::Contact, [only]) => {
                one.edge.is_none() && self.drawing.element(only.from).kind == ElementKind::LeftRail
            }
            _ => false,
        }
    }

    fn operand(&mut self, output: (ElementId, &'d str)) -> Rc<Path<'d>> {
        self.visited.push((output, 0));
        Rc::new(Path::One((output, 0)))
    }
}

/// Joins several paths by OR, after factoring out common ends. `None` if there is none.
fn joined(ways: Vec<Rc<Path<'_>>>) -> Option<Rc<Path<'_>>> {
    let mut ways = if ways.len() > 1 { factored(ways) } else { ways };
    match ways.len() {
        0 | 1 => ways.pop(),
        _ => Some(Rc::new(Path::Fork(ways))),
    }
}

/// Factors out the common ends of paths. Generators sort what remains, so that forks of the same paths are alike in
/// whatever order their connections stand in the file.
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
    found.sort();
    found
}
