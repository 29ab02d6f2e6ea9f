//! Feedback loops between blocks of a drawing, and the blocks at which they start.

use scanbound_iec::drawing::ElementId;
use std::collections::{BTreeMap, BTreeSet};

/// The feedback loops of a drawing: groups of elements that feed themselves through blocks.
#[derive(Clone, Default)]
pub(super) struct Loops {
    /// For each element in a loop: the loop's number, and the element's position in the execution order.
    pub(super) places: BTreeMap<ElementId, (usize, usize)>,
    /// The start blocks of each loop, in order of execution: its instances, or its functions if it has no instance.
    pub(super) instances: BTreeMap<usize, Vec<ElementId>>,
    /// Whether a loop starts with its first instance in order; `false`: with the one that is evaluated first.
    pub(super) begin_first: bool,
}

impl Loops {
    /// Whether the element is in a loop.
    pub(super) fn holds(&self, id: ElementId) -> bool {
        self.places.contains_key(&id)
    }

    /// Whether the element is a start block of its loop and comes after one of the start blocks in `open`. Always
    /// `false` if `begin_first` is not set.
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

    /// The start blocks to run before this element is evaluated, if its loop has not started yet: those before it in
    /// order; if there are none and it is not a start block itself, the first.
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
