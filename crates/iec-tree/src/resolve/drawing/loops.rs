//! Blocks of a drawing that feed each other, and which of them begin.

use scanbound_iec::drawing::ElementId;
use std::collections::{BTreeMap, BTreeSet};

/// Elements that lead back to themselves by way of blocks.
#[derive(Clone, Default)]
pub(super) struct Loops {
    /// The number of the loop in which an element stands, and its place in it.
    pub(super) places: BTreeMap<ElementId, (usize, usize)>,
    /// The instances of each loop, in their places; its functions, where it has no instance.
    pub(super) instances: BTreeMap<usize, Vec<ElementId>>,
    /// Whether loops begin with their first instance, not with the one that is asked for.
    pub(super) begin_first: bool,
}

impl Loops {
    /// Whether an element stands in a loop.
    pub(super) fn holds(&self, id: ElementId) -> bool {
        self.places.contains_key(&id)
    }

    /// Whether one of the blocks that a loop may begin with comes behind one of these in it.
    pub(super) fn is_behind(&self, id: ElementId, open: &BTreeSet<ElementId>) -> bool {
        let Some((own, place)) = self.places.get(&id).filter(|_| self.begin_first) else {
            return false;
        };
        let Some(instances) = self.instances.get(own).filter(|all| all.contains(&id)) else {
            return false;
        };
        let others = open.iter().filter(|id| instances.contains(id));
        { others }.any(|other| self.places.get(other).is_some_and(|(_, before)| before < place))
    }

    /// The instances that are executed before this element is, where its loop has not been begun: those that come
    /// before it, or the first one.
    pub(super) fn first(
        &self,
        id: ElementId,
        open: &BTreeSet<ElementId>,
        done: &BTreeSet<ElementId>,
    ) -> Vec<ElementId> {
        let Some((own, place)) = self.places.get(&id).filter(|_| self.begin_first) else {
            return Vec::new();
        };
        let Some(instances) = self.instances.get(own) else { return Vec::new() };
        let is_open = open.iter().filter_map(|open| self.places.get(open)).any(|(at, _)| at == own);
        if is_open || instances.iter().any(|one| done.contains(one)) {
            return Vec::new();
        }
        let is_before = |one: &ElementId| self.places[one].1 < *place;
        let before: Vec<ElementId> = instances.iter().copied().filter(is_before).collect();
        match before.is_empty() && !instances.contains(&id) {
            true => instances.first().copied().into_iter().collect(),
            false => before,
        }
    }
}
