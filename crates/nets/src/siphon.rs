//! Siphons (sets of places that stay empty once they are empty) and traps (sets that stay marked once they are marked).

use super::{Bits, Net};

/// The minimal siphons or traps that were found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MinimalSets {
    /// The sets of places.
    pub sets: Vec<Vec<usize>>,
    /// Whether the list is complete.
    pub complete: bool,
}

/// The minimal siphons. Every transition that puts a token into a siphon also takes one from it, so an empty siphon
/// stays empty. At most `limit` sets.
#[must_use]
pub fn siphons(net: &Net, limit: usize) -> MinimalSets {
    let of = |places: fn(&super::Transition) -> &Vec<usize>| -> Vec<Bits> {
        net.transitions.iter().map(|one| Bits::of(net.places, places(one))).collect()
    };
    minimal(net.places, &of(|one| &one.outputs), &of(|one| &one.inputs), limit)
}

/// The minimal traps. Every transition that takes a token from a trap also puts one into it, so a marked trap stays
/// marked. At most `limit` sets.
#[must_use]
pub fn traps(net: &Net, limit: usize) -> MinimalSets {
    let of = |places: fn(&super::Transition) -> &Vec<usize>| -> Vec<Bits> {
        net.transitions.iter().map(|one| Bits::of(net.places, places(one))).collect()
    };
    minimal(net.places, &of(|one| &one.inputs), &of(|one| &one.outputs), limit)
}

/// Whether a marked trap lies within these places; if so, they are never all empty.
#[must_use]
pub fn has_marked_trap(net: &Net, places: &[usize]) -> bool {
    // Remove places from which a transition takes without putting back into the set, until there are none. What remains
    // is the largest trap.
    let mut left = Bits::of(net.places, places);
    loop {
        let leaves = |place: &usize| {
            let mut takers = net.transitions.iter().filter(|one| one.inputs.contains(place));
            takers.any(|one| !one.outputs.iter().any(|&other| left.contains(other)))
        };
        let Some(place) = left.iter().find(leaves) else { break };
        left.remove(place);
    }
    net.initial.iter().any(|&place| left.contains(place))
}

/// Finds minimal sets of places with this property: every transition with a place of the set on its `from` side also
/// has one on its `to` side.
fn minimal(places: usize, from: &[Bits], to: &[Bits], limit: usize) -> MinimalSets {
    let mut search = Search { from, to, limit, steps: 0, found: Vec::new() };
    for place in 0..places {
        // Search the sets whose smallest place is this one.
        let banned: Vec<usize> = (0..place).collect();
        search.grow(&Bits::of(places, &[place]), &Bits::of(places, &banned));
    }
    let complete = search.steps < limit;
    let all = search.found;
    let is_minimal = |one: &&Bits| {
        !all.iter().any(|other| other != *one && other.iter().all(|place| one.contains(place)))
    };
    let mut sets: Vec<Vec<usize>> =
        all.iter().filter(is_minimal).map(|one| one.iter().collect()).collect();
    sets.sort_by_key(|set| (set.len(), set.clone()));
    sets.dedup();
    MinimalSets { sets, complete }
}

struct Search<'a> {
    from: &'a [Bits],
    to: &'a [Bits],
    limit: usize,
    steps: usize,
    found: Vec<Bits>,
}

impl Search<'_> {
    fn grow(&mut self, set: &Bits, banned: &Bits) {
        self.steps += 1;
        if self.steps >= self.limit
            || self.found.iter().any(|one| one.iter().all(|p| set.contains(p)))
        {
            return;
        }
        let meets = |one: &Bits| one.iter().any(|place| set.contains(place));
        let open = (0..self.from.len()).find(|&at| meets(&self.from[at]) && !meets(&self.to[at]));
        let Some(open) = open else {
            self.found.push(set.clone());
            return;
        };
        let mut banned = banned.clone();
        for place in self.to[open].iter().collect::<Vec<_>>() {
            if banned.contains(place) {
                continue;
            }
            let mut more = set.clone();
            more.insert(place);
            self.grow(&more, &banned);
            // The next branches exclude this place.
            banned.insert(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::net;

    /// All minimal siphons (or traps), found by testing every set of places. For tests.
    fn brute(net: &Net, is_siphon: bool) -> Vec<Vec<usize>> {
        let is_one = |set: u32| {
            net.transitions.iter().all(|one| {
                let hits = |places: &[usize]| places.iter().any(|&place| set >> place & 1 == 1);
                let (from, to) = if is_siphon {
                    (&one.outputs, &one.inputs)
                } else {
                    (&one.inputs, &one.outputs)
                };
                !hits(from) || hits(to)
            })
        };
        let all: Vec<u32> = (1..1 << net.places).filter(|&set| is_one(set)).collect();
        let minimal = all.iter().filter(|&&one| !all.iter().any(|&o| o != one && o & one == o));
        let mut sets: Vec<Vec<usize>> = minimal
            .map(|&set| (0..net.places).filter(|&place| set >> place & 1 == 1).collect())
            .collect();
        sets.sort_by_key(|set| (set.len(), set.clone()));
        sets
    }

    #[test]
    fn minimal_siphons_and_traps_are_those_of_all_sets() {
        let nets = [
            net(5, &[0], &[(&[0], &[1, 2]), (&[1], &[3]), (&[2, 3], &[4]), (&[4], &[0])]),
            net(4, &[0, 3], &[(&[0, 3], &[1]), (&[1], &[2, 3]), (&[2], &[0])]),
            net(
                6,
                &[0, 3, 5],
                &[
                    (&[0, 5], &[1]),
                    (&[1], &[0, 5]),
                    (&[3, 5], &[4]),
                    (&[4, 2], &[3, 5]),
                    (&[], &[2]),
                ],
            ),
            net(3, &[], &[(&[], &[0]), (&[0], &[1]), (&[1], &[])]),
        ];
        for net in nets {
            assert_eq!(siphons(&net, 10_000).sets, brute(&net, true), "{net:?}");
            assert_eq!(traps(&net, 10_000).sets, brute(&net, false), "{net:?}");
        }
    }

    #[test]
    fn a_marked_trap_keeps_its_siphon_from_getting_empty() {
        let cycle = net(2, &[0], &[(&[0], &[1]), (&[1], &[0])]);
        assert!(has_marked_trap(&cycle, &[0, 1]) && !has_marked_trap(&cycle, &[0]));
        assert!(!has_marked_trap(&net(1, &[0], &[(&[0], &[])]), &[0]));
    }
}
