//! Contacts that look at edges.

use scanbound_iec::drawing::{Drawing, Element, ElementId, ElementKind};
use std::collections::{BTreeMap, BTreeSet};

/// Whether a contact looks at an edge.
pub(super) fn has_edge(one: &Element) -> bool {
    one.kind == ElementKind::Contact && one.edge.is_some()
}

/// Contacts that look at edges, and what they lead to within one expression.
pub(super) fn behind_edges(drawing: &Drawing) -> BTreeSet<ElementId> {
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
