//! Siphons and traps: sets of places that stay empty once they are, and that stay marked once they are.

use super::{Bits, Net};

/// Minimal sets of places, found one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Minimal {
    /// The sets.
    pub sets: Vec<Vec<usize>>,
    /// Whether these are all.
    pub complete: bool,
}

/// Minimal siphons: whatever puts into such a set takes from it, so once it is empty it stays so.
#[must_use]
pub fn siphons(net: &Net, limit: usize) -> Minimal {
    let of = |places: fn(&super::Transition) -> &Vec<usize>| -> Vec<Bits> {
        net.transitions.iter().map(|one| Bits::of(net.places, places(one))).collect()
    };
    minimal(net.places, &of(|one| &one.puts), &of(|one| &one.takes), limit)
}

/// Minimal traps: whatever takes from such a set puts into it, so once it is marked it stays so.
#[must_use]
pub fn traps(net: &Net, limit: usize) -> Minimal {
    let of = |places: fn(&super::Transition) -> &Vec<usize>| -> Vec<Bits> {
        net.transitions.iter().map(|one| Bits::of(net.places, places(one))).collect()
    };
    minimal(net.places, &of(|one| &one.takes), &of(|one| &one.puts), limit)
}

/// Whether a marked trap lies within the places: then they never get empty.
#[must_use]
pub fn has_marked_trap(net: &Net, places: &[usize]) -> bool {
    // What is left when places are taken away as long as something takes from them without putting back is the largest
    // trap.
    let mut left = Bits::of(net.places, places);
    loop {
        let leaves = |place: &usize| {
            let mut takers = net.transitions.iter().filter(|one| one.takes.contains(place));
            takers.any(|one| !one.puts.iter().any(|&other| left.has(other)))
        };
        let Some(place) = left.iter().find(leaves) else { break };
        left.remove(place);
    }
    net.initial.iter().any(|&place| left.has(place))
}

/// Minimal sets of which every transition that has a place on its `from` side has one on its `to` side.
fn minimal(places: usize, from: &[Bits], to: &[Bits], limit: usize) -> Minimal {
    let mut search = Search { from, to, limit, steps: 0, found: Vec::new() };
    for place in 0..places {
        // Sets that have this place and none before it.
        let banned: Vec<usize> = (0..place).collect();
        search.grow(&Bits::of(places, &[place]), &Bits::of(places, &banned));
    }
    let complete = search.steps < limit;
    let all = search.found;
    let is_minimal = |one: &&Bits| {
        !all.iter().any(|other| other != *one && other.iter().all(|place| one.has(place)))
    };
    let mut sets: Vec<Vec<usize>> =
        all.iter().filter(is_minimal).map(|one| one.iter().collect()).collect();
    sets.sort_by_key(|set| (set.len(), set.clone()));
    sets.dedup();
    Minimal { sets, complete }
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
        if self.steps >= self.limit || self.found.iter().any(|one| one.iter().all(|p| set.has(p))) {
            return;
        }
        let meets = |one: &Bits| one.iter().any(|place| set.has(place));
        let open = (0..self.from.len()).find(|&at| meets(&self.from[at]) && !meets(&self.to[at]));
        let Some(open) = open else {
            self.found.push(set.clone());
            return;
        };
        let mut banned = banned.clone();
        for place in self.to[open].iter().collect::<Vec<_>>() {
            if banned.has(place) {
                continue;
            }
            let mut more = set.clone();
            more.insert(place);
            self.grow(&more, &banned);
            // The next ones are looked at without it.
            banned.insert(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::net;

    /// All sets that are siphons (or traps) and have no smaller one in them, by looking at every set.
    fn brute(net: &Net, is_siphon: bool) -> Vec<Vec<usize>> {
        let is_one = |set: u32| {
            net.transitions.iter().all(|one| {
                let hits = |places: &[usize]| places.iter().any(|&place| set >> place & 1 == 1);
                let (from, to) =
                    if is_siphon { (&one.puts, &one.takes) } else { (&one.takes, &one.puts) };
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
