//! Changes of the start of a run, as far as they do not contradict each other.

use scanbound_ir::{Cell, ChoiceKey};
use std::collections::BTreeMap;

/// Changes of the start of a run: the mask and the values of the bits that change.
#[derive(Clone, Default, PartialEq, Eq)]
pub(super) struct Changes {
    /// Of cells at the start of the scan.
    pub(super) start: BTreeMap<Cell, (u16, u16)>,
    /// Of values that come from outside the program.
    pub(super) outside: BTreeMap<ChoiceKey, (u16, u16)>,
}

impl Changes {
    /// Whether nothing changes.
    pub(super) fn is_empty(&self) -> bool {
        self.start.is_empty() && self.outside.is_empty()
    }

    /// Whether these changes and others want different values of a bit.
    pub(super) fn contradicts(&self, other: &Changes) -> bool {
        let differ = |held: Option<&(u16, u16)>, wanted: &(u16, u16)| {
            held.is_some_and(|held| (held.1 ^ wanted.1) & held.0 & wanted.0 != 0)
        };
        other.start.iter().any(|(cell, one)| differ(self.start.get(cell), one))
            || other.outside.iter().any(|(key, one)| differ(self.outside.get(key), one))
    }

    /// Adds other changes if they do not contradict these. Returns whether it did.
    pub(super) fn add(&mut self, other: &Changes) -> bool {
        let fits = !self.contradicts(other);
        if fits {
            for (&cell, &(mask, value)) in &other.start {
                self.set(cell, mask, value);
            }
            for (key, &(mask, value)) in &other.outside {
                self.set_outside(key, mask, value);
            }
        }
        fits
    }

    /// Adds bits of a cell. Returns false if they contradict these changes.
    pub(super) fn set(&mut self, cell: Cell, mask: u16, value: u16) -> bool {
        join(self.start.entry(cell).or_default(), mask, value)
    }

    /// As [`Self::set`], for a value from outside.
    pub(super) fn set_outside(&mut self, key: &ChoiceKey, mask: u16, value: u16) -> bool {
        join(self.outside.entry(key.clone()).or_default(), mask, value)
    }
}

/// Adds wanted bits to others. Returns whether they do not contradict each other.
fn join(held: &mut (u16, u16), mask: u16, value: u16) -> bool {
    let agrees = (held.1 ^ value) & held.0 & mask == 0;
    *held = (held.0 | mask, held.1 & !mask | value & mask);
    agrees
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_that_contradict_each_other_are_not_joined() {
        let cell = Cell { area: scanbound_ir::AreaId(0), index: 0 };
        let mut one = Changes::default();
        assert!(one.set(cell, 3, 1) && one.set(cell, 6, 4) && !one.set(cell, 4, 0));
    }
}
