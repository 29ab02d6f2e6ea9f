//! Assigns relays and numbers to elements that have none.

use crate::address::{Address, TIMERS};
use crate::{Diagram, Kind};
use std::collections::BTreeSet;

/// Assigns free relays and numbers: to outer gates from 00000 on, to other elements from 03000 on, to timers and
/// counters numbers from 000 on. If there are not enough, some elements stay without.
pub fn assign(diagram: &mut Diagram) {
    let mut taken: BTreeSet<Address> = (diagram.outers.iter().map(|one| &one.head))
        .chain(diagram.transitions.iter().map(|one| &one.head))
        .chain(diagram.places.iter().map(|one| &one.head))
        .filter_map(|head| head.address)
        .collect();
    let mut free = |begin: Address| -> Option<Address> {
        let mut all = std::iter::successors(Some(begin), |address| address.next());
        let found = all.find(|address| address.is_writable() && !taken.contains(address))?;
        taken.insert(found);
        Some(found)
    };
    for outer in diagram.outers.iter_mut().filter(|one| one.head.address.is_none()) {
        outer.head.address = free(Address::internal(0, 0));
    }
    let heads = (diagram.transitions.iter_mut().map(|one| &mut one.head))
        .chain(diagram.places.iter_mut().map(|one| &mut one.head));
    for head in heads.filter(|head| head.address.is_none()) {
        head.address = free(Address::internal(30, 0));
    }
    let number = |kind: &Kind| match *kind {
        Kind::Timer { number, .. } | Kind::Counter { number, .. } => number,
        Kind::Box => None,
    };
    let used: BTreeSet<u16> =
        diagram.places.iter().filter_map(|place| number(&place.kind)).collect();
    let mut numbers = (0..TIMERS).filter(|number| !used.contains(number));
    for place in &mut diagram.places {
        if let Kind::Timer { number, .. } | Kind::Counter { number, .. } = &mut place.kind
            && number.is_none()
        {
            *number = numbers.next();
        }
    }
}
