//! All markings that a net can reach, up to a limit: which places are marked together, what is never reached, where the
//! net deadlocks.
//!
//! A place that would get a second token keeps one, because a step of a chart is either active or not. The first such
//! firing is kept as evidence that the net is unsafe. In a safe net without read or inhibitor arcs, transitions fire
//! one after the other, which also reaches everything that simultaneous firing reaches. If transitions test places from
//! which others take tokens, they fire in sets.

use super::{Bits, Net};
use rustc_hash::{FxHashMap, FxHashSet};

/// Evidence that the net is not safe: a place that gets a second token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SecondToken {
    /// The place.
    pub place: usize,
    /// The transitions from the initial marking; the last one puts the second token.
    pub path: Vec<usize>,
}

/// A reachable marking in which no transition can fire.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Deadlock {
    /// The marking.
    pub marking: Bits,
    /// The transitions that lead to it from the initial marking.
    pub path: Vec<usize>,
}

/// The result of the search.
#[derive(Debug, Clone)]
pub struct Reachability {
    /// The number of markings that were visited.
    pub markings: usize,
    /// Whether all reachable markings were visited.
    pub complete: bool,
    /// For each place, the places that are marked together with it in some marking.
    pub together: Vec<Bits>,
    /// For each place, the first marking found in which it is marked.
    first: Vec<Option<usize>>,
    /// For each pair of places (smaller number first), the first marking found in which both are marked.
    both: FxHashMap<(usize, usize), usize>,
    /// The transitions that are enabled in some marking.
    pub enabled: Bits,
    /// For each place that can get a second token, one piece of evidence.
    pub unsafe_places: Vec<SecondToken>,
    /// The deadlocks that were found.
    pub deadlocks: Vec<Deadlock>,
    nodes: Vec<Node>,
}

#[derive(Debug, Clone)]
struct Node {
    marking: Bits,
    from: Option<(usize, Vec<usize>)>,
}

impl Reachability {
    /// Whether a place is never marked. Valid only if the search is complete.
    #[must_use]
    pub fn is_unreachable(&self, place: usize) -> bool {
        self.complete && self.first[place].is_none()
    }

    /// Whether the net is proved safe: no place ever gets a second token.
    #[must_use]
    pub fn is_safe(&self) -> bool {
        self.complete && self.unsafe_places.is_empty()
    }

    /// The shortest path to a marking in which all these places are marked.
    #[must_use]
    pub fn path_to(&self, places: &[usize]) -> Option<Vec<usize>> {
        let node = match *places {
            [one] => self.first[one]?,
            [one, other] if one != other => *self.both.get(&(one.min(other), one.max(other)))?,
            _ => self
                .nodes
                .iter()
                .position(|node| places.iter().all(|&p| node.marking.contains(p)))?,
        };
        Some(self.path(node))
    }

    /// The visited markings, by increasing distance from the initial marking.
    pub fn visited(&self) -> impl Iterator<Item = &Bits> {
        self.nodes.iter().map(|node| &node.marking)
    }

    fn path(&self, mut node: usize) -> Vec<usize> {
        let mut path = Vec::new();
        while let Some((before, set)) = &self.nodes[node].from {
            path.extend(set.iter().rev());
            node = *before;
        }
        path.reverse();
        path
    }
}

/// Explores a net from its initial marking, up to `budget` markings.
#[must_use]
pub fn reach(net: &Net, budget: usize) -> Reachability {
    let mut found = Reachability {
        markings: 0,
        complete: true,
        together: vec![Bits::new(net.places); net.places],
        first: vec![None; net.places],
        both: FxHashMap::default(),
        enabled: Bits::new(net.transitions.len()),
        unsafe_places: Vec::new(),
        deadlocks: Vec::new(),
        nodes: vec![Node { marking: net.start(), from: None }],
    };
    let firing = net.enabled_index();
    let mut known = FxHashSet::from_iter([net.start()]);
    let mut at = 0;
    while at < found.nodes.len() {
        let marking = found.nodes[at].marking.clone();
        for place in marking.iter() {
            found.first[place].get_or_insert(at);
            if !found.together[place].is_superset(&marking) {
                for other in marking.iter().filter(|other| *other > place) {
                    found.both.entry((place, other)).or_insert(at);
                }
                found.together[place].union_with(&marking);
            }
        }
        let Some(moves) = firing.next_steps(&marking) else {
            found.complete = false;
            at += 1;
            continue;
        };
        let is_dead = moves.is_empty();
        for set in moves {
            set.iter().for_each(|&transition| found.enabled.insert(transition));
            let (next, twice) = net.fire(&set, &marking);
            if let Some(place) = twice
                && found.unsafe_places.iter().all(|one| one.place != place)
            {
                let mut path = found.path(at);
                path.extend(&set);
                found.unsafe_places.push(SecondToken { place, path });
            }
            if known.contains(&next) {
                continue;
            }
            if found.nodes.len() >= budget {
                found.complete = false;
                continue;
            }
            known.insert(next.clone());
            found.nodes.push(Node { marking: next, from: Some((at, set)) });
        }
        if is_dead {
            let path = found.path(at);
            found.deadlocks.push(Deadlock { marking, path });
        }
        at += 1;
    }
    found.markings = found.nodes.len();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Transition;
    use crate::testing::net;
    use std::collections::BTreeSet;

    #[test]
    fn what_is_marked_together_is_found_with_a_way() {
        // 0 -> 1 and 2; 1 -> 3; 2 and 3 -> 0
        let found = reach(&net(4, &[0], &[(&[0], &[1, 2]), (&[1], &[3]), (&[2, 3], &[0])]), 100);
        assert!(found.is_safe() && found.deadlocks.is_empty());
        assert_eq!(found.markings, 3);
        assert!(
            found.together[2].contains(1)
                && found.together[2].contains(3)
                && !found.together[0].contains(2)
        );
        assert_eq!(found.path_to(&[2, 3]), Some(vec![0, 1]));
        assert_eq!(found.path_to(&[0, 1]), None);
    }

    #[test]
    fn second_tokens_dead_ends_and_places_never_reached_are_found() {
        // A selection that leads to a join: only one of 1 and 2 is ever marked.
        let stuck = reach(&net(4, &[0], &[(&[0], &[1]), (&[0], &[2]), (&[1, 2], &[3])]), 100);
        assert_eq!(
            stuck.deadlocks.iter().map(|one| one.path.clone()).collect::<Vec<_>>(),
            [[0], [1]]
        );
        assert!(stuck.is_unreachable(3) && !stuck.enabled.contains(2));
        // A parallel branch that is left before the other branch ends.
        let twice = reach(&net(3, &[0], &[(&[0], &[1, 2]), (&[1], &[0]), (&[2], &[0])]), 100);
        assert!(!twice.is_safe());
        assert!(twice.unsafe_places.contains(&SecondToken { place: 0, path: vec![0, 1, 2] }));
    }

    #[test]
    fn transitions_that_ask_for_places_fire_in_sets() {
        // 0 -> 2 while 1 is marked, 1 -> 3 while 0 is marked: they can fire together, but not one after the other.
        let mut net = net(4, &[0, 1], &[(&[0], &[2]), (&[1], &[3])]);
        net.transitions[0].tested = vec![1];
        net.transitions[1].tested = vec![0];
        let found = reach(&net, 100);
        assert_eq!(found.path_to(&[2, 3]), Some(vec![0, 1]));
        net.transitions[1].inhibitors = vec![0];
        assert_eq!(reach(&net, 100).path_to(&[3]), None);
    }

    /// All markings that are reached if every conflict-free set of enabled transitions may fire.
    fn by_sets(net: &Net) -> BTreeSet<Bits> {
        let mut known = BTreeSet::from([net.start()]);
        let mut open = vec![net.start()];
        while let Some(marking) = open.pop() {
            let all = 0..net.transitions.len();
            let enabled: Vec<usize> = all.filter(|&at| net.is_enabled(at, &marking)).collect();
            for mask in 1..1_usize << enabled.len() {
                let members = enabled.iter().enumerate().filter(|(bit, _)| mask >> bit & 1 == 1);
                let set: Vec<usize> = members.map(|(_, &at)| at).collect();
                let mut taken: Vec<usize> =
                    set.iter().flat_map(|&at| net.transitions[at].inputs.clone()).collect();
                taken.sort_unstable();
                if taken.windows(2).any(|pair| pair[0] == pair[1]) {
                    continue;
                }
                let next = net.fire(&set, &marking).0;
                if known.insert(next.clone()) {
                    open.push(next);
                }
            }
        }
        known
    }

    #[test]
    fn one_after_the_other_reaches_what_sets_do() {
        let mut seed = 1_u64;
        let mut below = move |limit: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
            (seed >> 33) as usize % limit
        };
        let (mut seen, mut asking) = (0, 0);
        for _ in 0..3_000 {
            // Random nets: rings of three places with one token each, whose transitions test places of other rings.
            let rings = 2 + below(3);
            let (mut net, places) = (Net::default(), 3 * rings);
            net.places = places;
            for ring in 0..rings {
                net.initial.push(3 * ring + below(3));
                for at in 0..3 {
                    let (from, to) = (3 * ring + at, 3 * ring + (at + 1) % 3);
                    let mut one = Transition {
                        inputs: vec![from],
                        outputs: vec![to],
                        ..Transition::default()
                    };
                    for _ in 0..below(3) {
                        let place = below(places);
                        let side =
                            if below(2) == 0 { &mut one.tested } else { &mut one.inhibitors };
                        side.push(place);
                    }
                    net.transitions.push(one);
                }
            }
            let found = reach(&net, 100_000);
            assert!(found.is_safe());
            let markings: BTreeSet<Bits> = found.visited().cloned().collect();
            assert_eq!(markings, by_sets(&net), "{net:?}");
            seen += usize::from(markings.len() > 3);
            asking += net
                .transitions
                .iter()
                .filter(|one| one.tested.len() + one.inhibitors.len() > 1)
                .count();
        }
        assert!(seen > 200 && asking > 1_000, "{seen} {asking}");
    }

    #[test]
    fn a_budget_that_is_used_up_is_told() {
        let chain: Vec<(Vec<usize>, Vec<usize>)> = (0..9).map(|n| (vec![n], vec![n + 1])).collect();
        let moves: Vec<(&[usize], &[usize])> =
            chain.iter().map(|(takes, puts)| (&takes[..], &puts[..])).collect();
        let found = reach(&net(10, &[0], &moves), 5);
        assert!(!found.complete && !found.is_unreachable(9) && found.markings == 5);
    }
}
